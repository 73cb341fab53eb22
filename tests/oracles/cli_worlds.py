"""Tasks, worlds and labels that the commands which learn and judge are tested with."""

from __future__ import annotations

SMALL = ("--hyper", "hidden=[16]", "--hyper", "batch_size=16", "--hyper", "learning_starts=16")
SENSORS = """
    MAP = "SFFFFHFHFFFHHFFG"

    def labels(observation, info):
        return {"H": {"hole"}, "G": {"goal"}}.get(MAP[observation], set())

    def number(observation, info):
        return float("nan")

    def wrong_type(observation, info):
        return {3.5}

    def fails(observation, info):
        return {info["nothing"]}

    def quits(observation):
        raise SystemExit(0)

    def four(observation, info, env, reward):
        return set()

    def looks(observation, info, env):
        return {"goal"} if env.unwrapped.s == 15 else set()

    either = {"goal": lambda state: state == 15, "hole": quits}

    standing = {"fallen": lambda x: bool(abs(x[2]) > 0.1)}
    broken = {"fallen": lambda x: float("nan")}
    nothing = 3
"""
LAKE = ("F goal & G !hole", "--env", "FrozenLake-v1", "--labels", "sensors.py:labels", "--reward", "zeta-discount")
POLE = ("G !fallen", "--env", "CartPole-v1", "--labels", "sensors.py:standing", "--num-envs", "2")
GRID = ("F goal", "--env", "ltlc/Grid-v0")
