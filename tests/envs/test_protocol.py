"""Environments that offer an exact model and a map, from this package, from Gymnasium, and from users."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from envs_reference import newest

import ltlc
from ltlc.board import DIRECTIONS, Board
from ltlc.cli.app import run
from ltlc.envs import GridWorld, MappedEnv, ModelledEnv, VectorGridWorld, board_of, labelled_mdp
from ltlc.envs.spec import EnvSpec
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import LabelledMDP

CORRIDOR = '''
import gymnasium as gym
import numpy as np
from ltlc.board import Board
from ltlc.mdp import LabelledMDP

NAMES = ("start", "", "", "goal")


class Corridor(gym.Env):
    """Four cells in a row; a step to the right fails one time in five."""

    observation_space, action_space = gym.spaces.Discrete(4), gym.spaces.Discrete(2)
    propositions = ("start", "goal")

    def __init__(self, own_labels=True):
        self.own_labels = own_labels

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.cell = 0
        return 0, self.info()

    def step(self, action):
        if action == 0:
            self.cell = max(self.cell - 1, 0)
        elif self.np_random.random() < 0.8:
            self.cell = min(self.cell + 1, 3)
        return self.cell, 0.0, False, False, self.info()

    def info(self):
        return {"labels": {NAMES[self.cell]} - {""}} if self.own_labels else {}

    def labelled_mdp(self):
        left, right = np.eye(4, k=-1), 0.8 * np.eye(4, k=1) + 0.2 * np.eye(4)
        left[0, 0] = right[3, 3] = 1
        labels = {"aps": self.propositions, "labels": [{name} - {""} for name in NAMES]} if self.own_labels else {}
        return LabelledMDP.from_arrays([left, right], **labels)

    def board(self):
        return Board(("...G",), 0, ("LEFT", "RIGHT"), {"G": "goal"})


gym.register("Corridor-v0", Corridor)
goal = {"goal": lambda cell: bool(cell == 3)}
'''


@pytest.fixture
def corridor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """The name of a user's environment, in a module in the current folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.delitem(sys.modules, "corridor", raising=False)
    gym.registry.pop("Corridor-v0", None)
    Path("corridor.py").write_text(CORRIDOR)
    return "corridor:Corridor-v0"


@pytest.mark.slow
def test_an_environment_of_the_user_has_verdicts_and_pictures(
    corridor: str, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("torch")
    assert run(["solve", "F goal & FG start", "--env", corridor, "-o", "policy.png"]) == 0
    assert "∞" in (out := capsys.readouterr().out)
    assert "P(formula satisfied)" in out
    assert Path("policy.png").read_bytes().startswith(b"\x89PNG")
    learner = ["--agent", "q-learning", "--steps", "3000", "--out", "learned"]
    assert run(["train", "F goal", "--env", corridor, *learner]) == 0, capsys.readouterr()
    assert Path("learned/policy.png").exists()
    assert run(["evaluate", "learned", "--json"]) == 0
    assert '"satisfaction": 1.0' in capsys.readouterr().out


def test_models_take_the_labels_that_are_given(corridor: str) -> None:
    spec = EnvSpec(env=corridor, arguments={"own_labels": False}, labels="corridor:goal")
    assert spec.model is not None and spec.model.aps == ("goal",)
    assert ltlc.Judge(spec.model, ltlc.Task("F goal")).maximum.probability == 1
    own = EnvSpec(env=corridor, labels="corridor:goal")
    assert own.model is not None and own.model.aps == ("goal",)
    itself = EnvSpec(env=corridor).model
    assert itself is not None and itself.aps == ("start", "goal")


def test_wrappers_are_looked_through(corridor: str) -> None:
    env = gym.wrappers.TimeLimit(gym.make(corridor), 10)
    assert isinstance(env.unwrapped, ModelledEnv) and isinstance(env.unwrapped, MappedEnv)
    assert labelled_mdp(env).n_states == 4
    board = board_of(env)
    assert board is not None and board.columns == 4


@pytest.mark.parametrize("world", [GridWorld("S.\n#g"), VectorGridWorld("S.\n#g", num_envs=3)])
def test_grid_worlds(world: Any) -> None:
    assert labelled_mdp(world).aps == ("g",)
    board = board_of(world)
    assert board is not None
    assert (board.text, board.start, board.meaning) == (("..", "#g"), 0, {"g": "g"})


@pytest.mark.parametrize(("name", "start", "marks"), [
    ("FrozenLake", 0, {5: "H", 7: "H", 11: "H", 12: "H", 15: "G"}),
    ("CliffWalking", 36, {**dict.fromkeys(range(37, 47), "C"), 47: "G"}),
])  # fmt: skip
def test_boards_of_toy_texts_move_as_the_environment_does(name: str, start: int, marks: dict[int, str]) -> None:
    options = {"is_slippery": False} if name == "FrozenLake" else {}
    env = gym.make(newest(name), **options)
    board = board_of(env)
    assert board is not None
    assert board.start == start
    assert {cell: c for cell, c in enumerate(board.cells) if c != "."} == marks
    table: Any = env.unwrapped
    for cell in set(range(len(board.cells))) - board.final:
        row, column = divmod(cell, board.columns)
        for action, direction in enumerate(board.actions):
            right, down = DIRECTIONS[direction]
            there = np.clip(row + down, 0, board.rows - 1) * board.columns + np.clip(
                column + right, 0, board.columns - 1
            )
            reached = table.P[cell][action][0][1]
            assert reached == there or (board.cells[there] == "C" and reached == start)


def test_worlds_without_a_map_or_a_model() -> None:
    taxi = gym.make(newest("Taxi"))
    assert board_of(taxi) is None
    assert labelled_mdp(taxi, {"far": lambda state: state == 0}).n_states == 500
    pole = gym.make("CartPole-v1")
    assert board_of(pole) is None
    with pytest.raises(InvalidArgumentError, match="the dynamics of CartPoleEnv are not known"):
        labelled_mdp(pole)


class Wrong(GridWorld):
    """Says something else than what is asked."""

    def labelled_mdp(self) -> Any:
        return {"states": 4}

    def board(self) -> Any:
        return "....\n"


def test_what_a_user_returns_is_checked() -> None:
    with pytest.raises(InvalidArgumentError, match=r"Wrong\.labelled_mdp\(\)"):
        labelled_mdp(Wrong("S.\n.g"))
    with pytest.raises(InvalidArgumentError, match=r"Wrong\.board\(\)"):
        board_of(Wrong("S.\n.g"))
    for fields in ({"text": ("..", ".")}, {"text": ()}, {"start": 4}, {"actions": ("NORTH",)}):
        given: dict[str, Any] = {"text": ("..", ".."), "start": 0, "actions": ("UP",), **fields}
        with pytest.raises(InvalidArgumentError, match="board"):
            Board(**given)


@pytest.mark.slow
@pytest.mark.parametrize("code", [
    "from ltlc.envs import GridWorld, labelled_mdp, board_of; import ltlc\n"
    "w = GridWorld('S.\\n.g', render_mode='ansi'); w.reset(); w.render(); board_of(w)\n"
    "ltlc.Judge(labelled_mdp(w), ltlc.Task('F g')).optimum",
    "import ltlc.agents, ltlc.faithful\n"
    "from ltlc.pictures import curves, faithfulness, grid, policy, runtime",
])  # fmt: skip
def test_nothing_heavy_is_loaded_where_nothing_is_drawn_or_learned(code: str) -> None:
    code += "\nimport sys; print(*[name for name in ('matplotlib', 'torch') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


@pytest.mark.parametrize("table", [{0: {0: [(1.0, 0, 0.0, False)]}}, np.eye(2)])
def test_the_model_of_an_environment_itself_comes_before_its_table(table: Any) -> None:
    class Own(gym.Env[Any, Any]):
        observation_space, action_space, P = gym.spaces.Discrete(2), gym.spaces.Discrete(1), table

        def labelled_mdp(self) -> LabelledMDP:
            return LabelledMDP.from_arrays([[[0, 1], [0, 1]]])

    assert labelled_mdp(Own(), lambda state: {"on"} if state else set()).n_states == 2


def test_what_is_called_p_need_not_be_a_table() -> None:
    class Odd(gym.Env[Any, Any]):
        observation_space, action_space, P = gym.spaces.Discrete(2), gym.spaces.Discrete(1), np.eye(2)

    with pytest.raises(InvalidArgumentError, match="the dynamics of Odd are not known"):
        labelled_mdp(Odd(), lambda state: set())
