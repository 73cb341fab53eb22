"""Train RLlib's DQN (`pip install 'ray[rllib]'`) with the discount of each step, and report P(sat) as a metric."""

import sys

from gymnasium.wrappers import TimeLimit
from ray.rllib.algorithms.dqn import DQNConfig

import ltlc
from ltlc.bridges.rllib import judged, judged_module, register_task, replay
from ltlc.envs import GridWorld

MAP, LABELS = ("S..k", ".##.", "..x.", "...g"), {"k": "key", "g": "goal", "x": "pit"}
TASK = "!pit U (key & (!pit U goal))"  # or an automaton


def main(total=8_000, task=TASK):
    task = ltlc.Task(task).for_horizon(50)

    def make():
        world = GridWorld(MAP, labels=LABELS, slip=0.1, actions=4)
        return TimeLimit(ltlc.LTLWrapper(world, task, observation="flat", warn_discount=False), 50)

    config = (
        DQNConfig()
        .environment(register_task("key-and-goal", make))
        .env_runners(num_env_runners=0, rollout_fragment_length=4)
        .training(
            replay_buffer_config=replay(20_000),
            num_steps_sampled_before_learning_starts=500,
            train_batch_size_per_learner=64,
            target_network_update_freq=200,
            training_intensity=64,
            epsilon=[(0, 1.0), (int(0.7 * total), 0.05)],
            lr=1e-3,
            num_atoms=1,
            double_q=True,
            dueling=False,
        )
        .rl_module(model_config={"fcnet_hiddens": [64], "fcnet_activation": "relu", "head_fcnet_hiddens": []})
        .callbacks(judged(make))
        .reporting(min_sample_timesteps_per_iteration=1000, min_time_s_per_iteration=0)
        .debugging(seed=0, log_level="ERROR")
    )
    algorithm = config.build_algo()
    while True:
        result = algorithm.train()
        steps = int(result["num_env_steps_sampled_lifetime"])
        print(f"{steps} steps: P(sat) {result['ltlc']['satisfaction']:.4f}", flush=True)
        if steps >= total:
            break
    found = judged_module(algorithm.get_module(), make())
    algorithm.stop()
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
