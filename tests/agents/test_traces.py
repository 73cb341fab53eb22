"""Targets of segments against a slow recursion, outputs within their bounds, curiosity, whims, horizons."""

import dataclasses
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import spaces
from small_tables import small_tables

from ltlc.agents import DoubleDQN, DQNConfig
from ltlc.agents.double_dqn.exploration import ExploringStarts, Whims
from ltlc.agents.double_dqn.fitting import fitted_horizon
from ltlc.agents.double_dqn.networks import near_best
from ltlc.agents.double_dqn.replay import Segments
from ltlc.agents.tensor_tables import TensorTables
from ltlc.agents.training.collect import Interface
from ltlc.agents.transitions import TransitionBatch
from ltlc.envs import LTLVectorWrapper, VectorFlatWorld, VectorGridWorld, VectorZoneWorld
from ltlc.errors import InvalidArgumentError
from ltlc.rewards import RewardTables, get_scheme, value_bounds
from ltlc.rewards.two_discount import TwoDiscount
from ltlc.task import Task

CHOICE = Task("(FG a | FG b) & G !c", acceptance="transition").tables


SEQUENCE = Task("F(a & F(b & F c)) & G !d").tables
N_OBSERVATIONS, N_ACTIONS = 5, 3


def agent(tables: RewardTables, **changes: Any) -> DoubleDQN:
    config = DQNConfig(**({"hidden": (8,), "batch_size": 16, "reward_scale": 10.0} | changes))
    return DoubleDQN(spaces.Discrete(N_OBSERVATIONS), N_ACTIONS, tables, config)


def segments(count: int, length: int, n_classes: int, seed: int = 0, repeat: int = 1) -> Segments:
    g = torch.Generator().manual_seed(seed)
    real = torch.rand((count, length + 1), generator=g) < 0.9
    return Segments(
        observation=torch.randint(N_OBSERVATIONS, (count, length + 1, 1), generator=g),
        action=torch.randint(N_ACTIONS, (count, length + 1), generator=g),
        letter_class=torch.randint(n_classes, (count, length, repeat), generator=g),
        base_reward=torch.randint(3, (count, length, repeat), generator=g).float(),
        terminated=torch.rand((count, length, repeat), generator=g) < 0.1,
        made=torch.arange(repeat) < torch.randint(1, repeat + 1, (count, length, 1), generator=g),
        real=real,
        place=torch.randint(N_OBSERVATIONS, (count, length + 1), generator=g),
    )


@pytest.mark.parametrize("tables", [small_tables(), CHOICE], ids=["plain", "choices"])
@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("repeat", [1, 3])
def test_targets_equal_a_recursion_over_steps_and_states(tables: RewardTables, double: bool, repeat: int) -> None:
    learner = agent(tables, double=double, trace_decay=0.75, output="linear")
    found = segments(6, 5, tables.n_classes, repeat=repeat)
    g = torch.Generator().manual_seed(1)
    shape = (6, 5, tables.n_states, N_ACTIONS)
    worth, online = torch.randn(shape, generator=g), torch.randn(shape, generator=g)
    targets = learner.trace_loss.targets(found, worth, online if double else worth)
    options = [[q, *(int(i) for i in row if i >= 0)] for q, row in enumerate(tables.select_pair)]

    def target(i: int, t: int, q: int, k: int = 0) -> float:
        c = int(found.letter_class[i, t, k])
        after = int(tables.next_state[q, c])
        if not found.made[i, t, k]:
            after = q
        if found.made[i, t, k] and found.terminated[i, t, k]:
            following = tables.final_value[q, c] / 10
        elif k < repeat - 1:
            following = target(i, t, after, k + 1)
        else:
            each = [(o, a) for o in options[after] for a in range(N_ACTIONS)]
            best, action = max(each, key=lambda pair: float((online if double else worth)[i, t, pair[0], pair[1]]))
            following = float(worth[i, t, best, action])
            if t < 4 and found.real[i, t + 1] and action == int(found.action[i, t + 1]):
                following += 0.75 * (target(i, t + 1, best) - following)
        if not found.made[i, t, k]:
            return following
        reward = tables.expected_reward[q, c] + float(found.base_reward[i, t, k])
        return float(reward / 10 + tables.expected_discount[q, c] * following)

    for i in range(6):
        for t in range(5):
            for q in range(tables.n_states):
                assert targets[i, t, q].item() == pytest.approx(target(i, t, q), abs=1e-4)


def test_single_steps_have_the_targets_of_single_steps() -> None:
    learner, found = agent(small_tables(), trace_decay=1.0), segments(12, 1, 2)
    steps = TransitionBatch(
        observation=found.observation[:, 0], state=found.action[:, 0] % 2, action=found.action[:, 0],
        letter_class=found.letter_class[:, 0, 0], base_reward=found.base_reward[:, 0, 0],
        terminated=found.terminated[:, 0, 0], next_observation=found.observation[:, 1],
    )  # fmt: skip
    features = learner.encoder.features(steps.next_observation)
    worth, online = learner.target_network(features)[:, None], learner.q_network(features)[:, None]
    targets = learner.trace_loss.targets(found, worth, online)[:, 0, :2]
    assert torch.allclose(targets, learner.loss.targets(learner.q_network, learner.target_network, steps), atol=1e-6)


def test_values_never_leave_what_values_can_be() -> None:
    tables = Task("F a & G !b").tables
    learner = DoubleDQN(spaces.Box(-1, 1, (2,)), 3, tables, DQNConfig(hidden=(8,)))
    with torch.no_grad():
        for weights in learner.q_network.parameters():
            weights.mul_(1e3)
    learner.policy_network.load_state_dict(learner.q_network.state_dict())
    values = learner.q_values(np.random.default_rng(0).uniform(-1, 1, (50, 2)).astype(np.float32))
    bounds = value_bounds(tables)
    assert (values >= bounds.least[:, None] - 1e-6).all() and (values <= bounds.largest[:, None] + 1e-6).all()
    assert values[:, tables.initial_state].max() > 0.99 and values[:, tables.initial_state].min() < 0.01
    decided = DoubleDQN(spaces.Discrete(3), 2, Task("!b U a").tables, DQNConfig(hidden=(8,))).tensor_tables
    assert decided.open.tolist() == [Task("!b U a").tables.initial_state]  # all else is decided


def test_costs_are_learned_with_plain_outputs() -> None:
    learner = DoubleDQN(spaces.Discrete(3), 2, Task("F a", "thesis").tables, DQNConfig(hidden=(8,)))
    assert learner.q_network.bounds is None
    assert learner.update(small_segments(learner), 1e-3) >= 0


def test_an_action_behind_the_best_one_is_pushed_further_behind() -> None:
    learner, plain = (agent(CHOICE, advantage_learning=part, curiosity=0.0) for part in (0.5, 0.0))
    found, part = segments(4, 3, CHOICE.n_classes), 0.5
    features = learner.encoder.features(found.observation.flatten(0, 1))
    values = learner.q_network(features).view(4, 4, CHOICE.n_states, N_ACTIONS).detach()
    targets = plain.trace_loss.targets(found, values[:, 1:], values[:, 1:])
    loss = torch.zeros(())
    for i, t in np.ndindex(4, 3):
        for q in learner.tensor_tables.open.tolist():
            value = values[i, t, q]
            chosen = value[found.action[i, t]]
            target = (targets[i, t, q] - part * (value.max() - chosen)).clamp(0, 1)  # bounds of these tables
            if found.real[i, t]:
                loss -= target * chosen.log() + (1 - target) * (1 - chosen).log()
    loss /= found.real[:, :-1].sum()
    assert torch.allclose(learner.trace_loss(learner.q_network, learner.q_network, found), loss)
    assert not torch.allclose(plain.trace_loss(plain.q_network, plain.q_network, found), loss)


def test_distances_grow_in_the_second_half() -> None:
    config = DQNConfig(total_steps=1000, advantage_learning=0.9, final_advantage_learning=0.98)
    gaps = [1 / (1 - config.advantage_learning_at(steps)) for steps in (0, 500, 750, 1000, 2000)]
    assert gaps == pytest.approx([10, 10, 30, 50, 50])
    ends = [DQNConfig(**changes).filled(numbered=False).advantage_learning_at(300_000)
            for changes in ({}, {"advantage_learning": 0.99}, {"advantage_learning": 0.0})]  # fmt: skip
    assert ends == pytest.approx([0.97, 0.99, 0.0])
    with pytest.raises(InvalidArgumentError, match="final_advantage_learning is 1"):
        DQNConfig(final_advantage_learning=1)


def test_an_observation_that_is_numbered_passes_the_network_once(monkeypatch: pytest.MonkeyPatch) -> None:
    learner, found = agent(SEQUENCE), segments(6, 5, SEQUENCE.n_classes)
    seen: list[int] = []
    inputs = learner.q_network.inputs
    monkeypatch.setattr(learner.q_network, "inputs", lambda rows: (seen.append(len(rows)), inputs(rows))[1])

    def loss_and_gradient() -> tuple[float, torch.Tensor]:
        loss = learner.trace_loss(learner.q_network, learner.target_network, found)
        (gradient,) = torch.autograd.grad(loss, learner.q_network.layers[0].weight)
        return float(loss.detach()), gradient

    loss, gradient = loss_and_gradient()
    monkeypatch.setattr(learner.trace_loss, "_distinct", lambda rows: (rows, None))
    whole, expected = loss_and_gradient()
    assert seen == [N_OBSERVATIONS, 6 * 6] and loss == pytest.approx(whole, rel=1e-5)
    assert torch.allclose(gradient, expected, atol=1e-6)


def small_segments(learner: DoubleDQN) -> Segments:
    found = segments(4, 3, learner.tables.n_classes)
    small = {name: getattr(found, name) % 2 for name in ("observation", "action", "place")}
    return dataclasses.replace(found, **small)


def test_waiting_with_a_choice_is_never_better_than_next_to_nothing() -> None:
    learner = DoubleDQN(spaces.Discrete(4), 2, CHOICE, DQNConfig(hidden=(8,), curiosity=0.0, temperature=0.0))
    state = np.array([CHOICE.initial_state])
    assert learner.tensor_tables.n_options == 3
    for layer in learner.policy_network.layers:
        if isinstance(layer, torch.nn.Linear):
            last = layer
    with torch.no_grad():
        last.weight.zero_()
        last.bias.copy_(torch.linspace(0, 1, len(last.bias)).flip(0) / 100)  # the state itself is best, by a hair
    assert learner.policy(np.array([0]), state)[0] >= 2
    with torch.no_grad():
        last.bias.view(-1, 2)[CHOICE.initial_state] = 3.0  # by far
    assert learner.policy(np.array([0]), state)[0] < 2


def test_nearly_equal_actions_are_drawn_by_their_outputs_and_others_never() -> None:
    g = np.random.default_rng(0)
    for _ in range(200):
        low, width, temperature = g.uniform(-2, 0), g.uniform(0.5, 3), g.uniform(0.05, 1)
        values = low + width * g.uniform(0.001, 0.999, size=4)
        values[g.integers(4)] = -np.inf if g.random() < 0.5 else low
        weights = []
        for value in values:
            part = min(max((value - low) / width, 1e-6), 1 - 1e-6)
            weights.append(0.0 if np.isinf(value) else (part / (1 - part)) ** (1 / temperature))
        kept = [weight if weight >= max(weights) / 1000 else 0.0 for weight in weights]
        found = near_best(torch.tensor(values), low, width, temperature).numpy()
        assert found == pytest.approx(np.array(kept) / sum(kept), abs=1e-9)


def test_curiosity_looks_for_what_was_not_tried() -> None:
    learner = agent(Task("F a").tables, curiosity=1.0, epsilon_start=0.0)
    packed = learner.encoder.pack(np.arange(N_OBSERVATIONS))
    learner._tries[:] = 50
    learner._tries[0, np.arange(N_OBSERVATIONS), [2, 0, 1, 1, 2]] = 0
    states = np.zeros(N_OBSERVATIONS, dtype=np.int64)
    chosen = learner.explore(packed, states, 0.0, torch.Generator().manual_seed(0))
    assert chosen.tolist() == [2, 0, 1, 1, 2]
    found = segments(5, 4, learner.tables.n_classes)
    sought = torch.full((5, 4, learner.tables.n_states, N_ACTIONS), -20.0)
    near = learner.trace_loss.novelty(found, sought)
    open_step = (learner.tables.next_state[0, found.letter_class.numpy()] == 0) & ~found.terminated.numpy()
    open_step = open_step[..., 0]
    assert torch.allclose(near[..., 0][torch.from_numpy(open_step)], torch.tensor(0.98))
    assert not near[..., 0][torch.from_numpy(~open_step)].any()


@pytest.mark.parametrize("changes", [{}, {"persistence": 1, "ladder": 0.0}])
def test_whims_are_as_frequent_as_epsilon_says(changes: dict[str, Any]) -> None:
    config = DQNConfig(**({"persistence": 20} | changes))
    whims, g = Whims(config, 3), torch.Generator().manual_seed(0)
    everywhere = torch.ones(8, dtype=torch.bool)
    odd = torch.stack([whims.draw(everywhere, 0.3, g) >= 0 for _ in range(4_000)]).double().mean(dim=0)
    if changes:
        assert torch.allclose(odd, torch.tensor(0.3).double(), atol=0.03)
    else:  # every second one goes on with what it has begun
        assert (odd[1::2] > 1.2 * odd[::2])[:3].all() and odd[7] < 0.1
        assert (odd[::2].diff() < 0.02).all() and (odd[1::2].diff() < 0.02).all()
        assert odd[0] == pytest.approx(0.3, abs=0.03)
    whims.clear()
    assert (whims.draw(everywhere, 0.0, g) < 0).all()


def test_episodes_act_as_if_the_automaton_were_in_any_open_state() -> None:
    tables = TensorTables.of(SEQUENCE, bounds=value_bounds(SEQUENCE))
    n, g, rng = 50, torch.Generator().manual_seed(0), np.random.default_rng(0)
    own = torch.full((n,), SEQUENCE.initial_state)
    assert ExploringStarts(DQNConfig(exploring_starts=0.0), tables).states(own, g) is own
    starts = ExploringStarts(DQNConfig(exploring_starts=0.5), tables)
    first = starts.states(own, g)
    assert {*first.tolist()} == {*tables.open.tolist()}  # all of them, and none that is decided
    copies, state = torch.arange(n), first
    for _ in range(20):
        letters = torch.from_numpy(rng.integers(SEQUENCE.n_classes, size=n))
        starts.advance(copies, letters, torch.zeros(n, dtype=torch.bool))
        following = tables.next_state[state, letters]
        state = starts.states(own, g)
        imagined = (first != own) & torch.isin(following, tables.open)
        assert (state == following)[imagined].all() and torch.isin(state, tables.open).all()
    decided = torch.full((n,), int(np.setdiff1d(np.arange(SEQUENCE.n_states), tables.open)[0]))
    assert torch.isin(starts.states(decided, g), tables.open).all()
    starts.advance(copies[:1], letters[:1], torch.ones(1, dtype=torch.bool))
    starts.clear()
    assert 10 < (starts.states(own, g) == own).sum() < n


def test_the_horizon_follows_from_the_environment_unless_somebody_says_so() -> None:
    def ahead(limit: int | None, formula: str = "F red") -> int:
        env = LTLVectorWrapper(VectorFlatWorld(2, max_episode_steps=limit), Task(formula), extra_labels="ignore")
        return fitted_horizon(DQNConfig(), Interface.of(env))

    limits = (None, 75, 300, 5000)
    for formula in ("F red", "!blue U red", "F red & G !blue", "G !blue", "FG red", "F blue | G red"):
        assert [ahead(limit, formula) for limit in limits] == [100, 20, 60, 200]
    for formula in ("GF red", "GF red & GF blue & G !outside", "G(red -> F blue)", "FG red | GF blue"):
        assert [ahead(limit, formula) for limit in limits] == [100, 30, 120, 200]

    def fitted(task: Task, **changes: Any) -> tuple[int | None, RewardTables | None]:
        env = LTLVectorWrapper(VectorGridWorld("S.A", 2), task)
        config, tables = DoubleDQN.fitted(DQNConfig(**changes), Interface.of(env))
        return config.horizon, tables

    plain = Task("F A")
    horizon, tables = fitted(plain)
    assert horizon == 2000 and tables is not None and tables.discount[0, 0] == 1 - 1 / 2000
    assert fitted(plain, horizon=0) == (0, plain.tables)
    told = Task("F A", get_scheme("two-discount", gamma=0.5))
    assert fitted(told) == (2000, told.tables)
    assert TwoDiscount().for_horizon(50) == TwoDiscount(gamma_accept=0.9, gamma=0.98)


def test_the_horizon_grows_where_observations_are_numbered() -> None:
    def learner(world: Any, **changes: Any) -> DoubleDQN:
        interface = Interface.of(
            LTLVectorWrapper(world, Task("F A" if isinstance(world, VectorGridWorld) else "F red"))
        )
        config, tables = DoubleDQN.fitted(DQNConfig(total_steps=1000, **changes), interface)
        made = DoubleDQN(interface.space, interface.n_actions, tables, config)
        made.learn_in(interface)
        return made

    grid, flat = VectorGridWorld("S.A", 2), VectorFlatWorld(2, max_episode_steps=300)
    one = learner(grid)
    horizons = [one.config.horizon_at(steps) for steps in range(0, 1000, 10)]
    assert horizons == sorted(horizons) and len({*horizons}) == 21
    assert horizons[:10] == [100] * 10 and horizons[70:] == [2000] * 30 and horizons[40] == round(100 * 20**0.5)
    for steps, horizon in ((0, 100), (400, 447), (700, 2000), (400, 447)):  # a resumed run begins anywhere
        found, wanted = one._ahead.tables_at(steps), Task("F A").for_horizon(horizon).tables
        for ours, theirs in (
            (found.reward * found.scale, wanted.expected_reward), (found.discount, wanted.expected_discount),
            (found.final_value * found.scale, wanted.final_value), (found.next_state, wanted.next_state),
        ):  # fmt: skip
            assert torch.allclose(ours, torch.tensor(np.array(theirs), dtype=ours.dtype))
    assert learner(flat).config.horizon_at(0) == 60
    assert learner(grid, horizon=50).config.horizon_at(0) == 50 and learner(grid, horizon=0).config.horizon_at(0) == 0
    assert learner(grid, initial_horizon=20).config.horizon_at(0) == 20
    with pytest.raises(InvalidArgumentError, match="initial_horizon is 1"):
        DQNConfig(initial_horizon=1)


def test_actions_are_held_where_the_world_forgives_random_ones_for_long() -> None:
    def held(world: Any, formula: str, **changes: Any) -> int:
        config, _ = DoubleDQN.fitted(DQNConfig(**changes), Interface.of(LTLVectorWrapper(world, Task(formula))))
        return config.held

    def zones(limit: int | None) -> VectorZoneWorld:
        return VectorZoneWorld(4, max_episode_steps=limit)

    assert [held(zones(limit), "F red") for limit in (None, 499, 500, 999, 1000, 1100)] == [1, 1, 2, 3, 4, 4]
    assert held(VectorFlatWorld(4, max_episode_steps=1000), "F red") == 1  # which they leave
    assert held(zones(1000), "G red") == 1 and held(zones(1000), "F red", curiosity=0.5) == 1
    assert held(zones(1000), "F red", action_repeat=7) == 7 and held(zones(1000), "F red", trace_length=1) == 1
    assert held(VectorGridWorld("S.A", 2, max_episode_steps=1000), "F A") == 1
    with pytest.raises(InvalidArgumentError, match="set action_repeat to 1"):
        held(VectorGridWorld("S.A", 2), "F A", action_repeat=2)
    with pytest.raises(InvalidArgumentError, match="curiosity counts single steps"):
        DQNConfig(action_repeat=2, curiosity=0.5)
    with pytest.raises(InvalidArgumentError, match="action_repeat is 256; it must be at most 255"):
        DQNConfig(action_repeat=256)
