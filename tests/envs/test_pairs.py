"""Choices of pairs in the wrappers and in the bundled agent."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from envs_reference import RandomEnv
from gymnasium import spaces
from gymnasium.vector import AutoresetMode, SyncVectorEnv
from pair_policies import true_satisfaction

from ltlc.envs import LTLVectorWrapper, LTLWrapper, VectorGridWorld, labelled_mdp
from ltlc.errors import InvalidArgumentError
from ltlc.mdp import Judge, Product, RewardProduct, max_satisfaction_probability, optimal_return
from ltlc.rewards import get_scheme
from ltlc.task import Task

N = 4
MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP, AutoresetMode.DISABLED]


def choosing() -> Task:
    return Task("FG a | FG b", "zeta-discount", acceptance="transition")


class Masked(RandomEnv):
    """Allows its second action only."""

    def action_masks(self) -> np.ndarray:
        return np.array([False, True])


class Continuous(RandomEnv):
    def __init__(self) -> None:
        super().__init__()
        self.action_space = spaces.Box(-1, 1, (2,))


def test_an_action_can_choose_a_pair_and_then_it_is_chosen() -> None:
    task = choosing()
    env = LTLWrapper(RandomEnv(end=0.0), task)
    assert env.action_space == spaces.Discrete(6)
    _, info = env.reset(seed=0)
    assert info["ltl"]["action_mask"].tolist() == [True] * 6
    observation, _, _, _, info = env.step(2 * 2 + 1)  # pair 1, then the second action
    state = int(task.tables.next_state[task.tables.select_pair[0, 1], info["ltl"]["letter_class"]])
    assert info["ltl"]["state"] == observation["automaton"] == state
    masks = env.action_masks()
    assert masks.tolist() == info["ltl"]["action_mask"].tolist()
    if state != 0:
        assert masks.tolist() == [True, True, False, False, False, False]


def test_a_broken_promise_ends_the_episode() -> None:
    task = choosing()
    env = LTLWrapper(RandomEnv(end=0.0), task)
    lengths = []
    for seed in range(30):
        env.reset(seed=seed)
        action, over = 2, False
        while not over:
            _, reward, over, _, info = env.step(action)
            assert reward == (0.0 if over else 1.0)
            assert not info["ltl"]["violated"]
            action = 0
            lengths.append(over)
    assert 0.3 < np.mean(lengths) < 0.7  # each letter has `a` with probability 1/2


def test_actions_that_do_not_exist_are_refused() -> None:
    env = LTLWrapper(RandomEnv(end=0.0), choosing())
    env.reset(seed=0)
    with pytest.raises(InvalidArgumentError, match="action 6 does not exist"):
        env.step(6)
    for _ in range(50):
        env.reset()
        if env.step(2)[4]["ltl"]["state"] != 0:
            break
    with pytest.raises(InvalidArgumentError, match=r"action 2 does not exist .* action_masks"):
        env.step(2)


def test_without_choices_nothing_changes() -> None:
    env = LTLWrapper(RandomEnv(), Task("G F a", "zeta-discount"))
    assert env.action_space == spaces.Discrete(2)
    assert "action_mask" not in env.reset(seed=0)[1]["ltl"]
    assert "action_mask" not in env.step(0)[4]["ltl"]
    assert env.action_masks().tolist() == [True, True]
    vector = LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N), Task("G F a", "zeta-discount"))
    assert "action_mask" not in vector.reset(seed=0)[1]["ltl"]
    assert vector.action_masks().tolist() == [[True, True]] * N


def test_masks_of_the_environment_are_kept() -> None:
    env = LTLWrapper(Masked(), choosing())
    env.reset(seed=0)
    assert env.action_masks().tolist() == [False, True] * 3


def test_actions_that_are_not_discrete_need_a_scheme_without_choices() -> None:
    with pytest.raises(InvalidArgumentError, match='use the reward scheme "parity"'):
        LTLWrapper(Continuous(), choosing())
    env = LTLWrapper(Continuous(), Task("FG a | FG b", "parity"))
    env.reset(seed=0)
    env.step(np.zeros(2, dtype=np.float32))
    with pytest.raises(InvalidArgumentError, match="cannot be masked"):
        env.action_masks()


@pytest.mark.slow
@pytest.mark.parametrize("mode", MODES)
def test_vector_wrapper_equals_single_wrappers(mode: AutoresetMode) -> None:
    task = choosing()
    one_by_one = SyncVectorEnv([partial(lambda: LTLWrapper(RandomEnv(), task))] * N, autoreset_mode=mode)
    together = LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N, autoreset_mode=mode), task)
    assert together.single_action_space == spaces.Discrete(6)
    assert together.action_space == spaces.MultiDiscrete([6] * N)
    rng = np.random.default_rng(0)
    left: Any = one_by_one.reset(seed=3)
    right: Any = together.reset(seed=3)
    masks = right[1]["ltl"]["action_mask"]
    done, endings = np.zeros(N, dtype=bool), 0
    for _ in range(200):
        assert (together.action_masks() == masks).all()
        actions = np.array([rng.choice(np.flatnonzero(row)) for row in masks])
        left, right = one_by_one.step(actions), together.step(actions)
        for mine, theirs in zip(left[1:4], right[1:4], strict=True):
            assert (mine == theirs).all()
        assert (left[0]["automaton"] == right[0]["automaton"]).all()
        ltl = right[4]["ltl"]
        live = ~done if mode == AutoresetMode.NEXT_STEP else np.ones(N, dtype=bool)
        for key in ("state", "reward", "discount", "accepting"):
            assert (left[4]["ltl"][key] == ltl[key])[live].all()
        done = left[2] | left[3]
        endings += int(done.sum())
        masks = ltl["action_mask"]
        if mode == AutoresetMode.DISABLED and done.any():
            left, right = (env.reset(options={"reset_mask": done.copy()}) for env in (one_by_one, together))
            masks = np.where(done[:, None], right[1]["ltl"]["action_mask"], masks)
            done = np.zeros(N, dtype=bool)
    assert endings > 20


def test_wrong_choices_in_a_batch_are_named() -> None:
    env = LTLVectorWrapper(SyncVectorEnv([RandomEnv] * N), choosing())
    env.reset(seed=0)
    with pytest.raises(InvalidArgumentError, match="action 7 of sub-environment 2"):
        env.step(np.array([0, 1, 7, 0]))


MAP = "S.A\n.C.\nB.."
QUICK: dict[str, Any] = {
    "hidden": (32,), "batch_size": 128, "buffer_size": 10_000, "learning_starts": 256, "epsilon_steps": 1_500,
    "total_steps": 5_000, "log_every": 5_000, "checkpoint_every": 5_000, "learning_rate": 3e-3, "averaging": 0.02,
    "train_frequency": 8, "tau": 0.1,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes", [{}, {"state_input": "one-hot", "counterfactual": False}, {"counterfactual": False}]
)
def test_the_agent_learns_which_pair_to_choose(changes: dict[str, Any]) -> None:
    pytest.importorskip("torch")
    from ltlc.agents import DQNConfig, greedy_policy, train

    task = Task(
        "(FG A | FG B) & G !C", get_scheme("two-discount", gamma_accept=0.9, gamma=0.99), acceptance="transition"
    )
    assert task.tables.n_choices == 2
    env = LTLVectorWrapper(VectorGridWorld(MAP, num_envs=8, max_episode_steps=40), task)
    agent = train(env, DQNConfig(**{**QUICK, **changes})).agent
    assert agent.n_actions * 3 == env.single_action_space.n
    mdp = labelled_mdp(env)
    judge = Judge(mdp, task)
    policy = greedy_policy(agent)
    assert policy.max() >= agent.n_actions  # some pair is chosen somewhere
    assert judge.judge(policy).satisfaction == pytest.approx(1.0)
    assert true_satisfaction(mdp, task.automaton, task.tables, policy) == pytest.approx(1.0)
    assert not np.isfinite(agent.q_values(agent.encoder.all_observations())).all()


def test_the_judge_knows_choices() -> None:
    mdp = labelled_mdp(VectorGridWorld(MAP, num_envs=1, slip=0.2).unwrapped)
    task = Task("(FG A | FG B) & G !C", get_scheme("zeta-discount", zeta=0.999), acceptance="transition")
    judge = Judge(mdp, task)
    best = max_satisfaction_probability(Product(mdp, task.automaton)).probability
    assert judge.maximum.probability == pytest.approx(best, abs=1e-6)
    assert judge.optimum is not None
    assert judge.optimum.satisfaction == pytest.approx(best, abs=1e-4)
    product = RewardProduct(mdp, task.tables)
    assert product.n_actions == 3 * mdp.n_actions
    assert optimal_return(product).policy.max() >= mdp.n_actions
