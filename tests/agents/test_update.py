"""Targets by hand, counterfactuals against a true rollout, and the gradient against finite differences."""

import dataclasses
from typing import Any

import numpy as np
import pytest
import torch
from gymnasium import spaces
from small_tables import small_tables

from ltlc.agents import DoubleDQN, DQNConfig
from ltlc.agents.double_dqn.networks import Follower, QNetwork
from ltlc.agents.double_dqn.update import policy_values
from ltlc.agents.tensor_tables import reachable_states
from ltlc.agents.transitions import TransitionBatch
from ltlc.envs import recorded_automaton
from ltlc.errors import InvalidArgumentError, TrainingDiverged
from ltlc.rewards import RewardTables, get_scheme, value_bounds

N_OBSERVATIONS, N_ACTIONS = 5, 3
SMALL: dict[str, Any] = {"hidden": (8,), "batch_size": 16, "reward_scale": 10.0, "output": "linear"}


def agent(tables: RewardTables | None = None, n_observations: int = N_OBSERVATIONS, **changes: Any) -> DoubleDQN:
    config = DQNConfig(**(SMALL | changes))
    return DoubleDQN(spaces.Discrete(n_observations), N_ACTIONS, tables or small_tables(), config)


def batch(size: int, n_observations: int = N_OBSERVATIONS, n_classes: int = 2, seed: int = 0) -> TransitionBatch:
    g = torch.Generator().manual_seed(seed)

    def draw(high: int, *shape: int) -> torch.Tensor:
        return torch.randint(high, shape or (size,), generator=g)

    return TransitionBatch(
        observation=draw(n_observations, size, 1),
        state=draw(2),
        action=draw(N_ACTIONS),
        letter_class=draw(n_classes),
        base_reward=draw(3).float(),
        terminated=draw(4) == 0,
        next_observation=draw(n_observations, size, 1),
    )


def test_double_and_single_values_by_hand() -> None:
    target = torch.tensor([[1.0, 5.0, 2.0]])
    online = torch.tensor([[0.0, 3.0, 9.0]])
    assert policy_values(target, online, double=False).tolist() == [5.0]  # the best by the target network
    assert policy_values(target, online, double=True).tolist() == [2.0]  # the target's value of the online choice


def test_states_entered_only_at_the_end_are_not_learned() -> None:
    assert reachable_states(small_tables()).tolist() == [0, 1]


@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("state_input", ["heads", "one-hot", "raw"])
@pytest.mark.parametrize("batch_size", [2, 16])  # below and above the number of observations
def test_targets_equal_a_loop_over_steps_and_states(double: bool, state_input: str, batch_size: int) -> None:
    tables = small_tables()
    learner = agent(double=double, state_input=state_input, batch_size=batch_size)
    Follower(learner.target_network, agent(seed=9, state_input=state_input).q_network).move(1.0)
    steps = batch(12)
    found = learner.loss.targets(learner.q_network, learner.target_network, steps)
    for i in range(12):
        features = learner.encoder.features(steps.next_observation[i : i + 1])
        online, target = learner.q_network(features)[0], learner.target_network(features)[0]
        for k, q in enumerate([0, 1]):
            c = int(steps.letter_class[i])
            after = tables.next_state[q, c]
            best = int((online if double else target)[after].argmax())
            following = tables.closing[after, c] / 10 if steps.terminated[i] else target[after, best].item()
            reward = tables.reward[q, c] + tables.stop[q, c] * tables.stop_reward[q, c] + steps.base_reward[i]
            expected = reward / 10 + tables.discount[q, c] * (1 - tables.stop[q, c]) * following
            assert found[i, k].item() == pytest.approx(float(expected), abs=1e-5)


def test_targets_are_kept_within_what_values_can_be() -> None:
    tables, steps = dataclasses.replace(small_tables(), discount=np.full((3, 2), 0.5)), batch(12)
    bounds = value_bounds(tables)
    learner, free = agent(tables, output="bounded"), agent(tables)
    for network in (learner.target_network, free.target_network):
        with torch.no_grad():
            network.layers[-1].bias.add_(100.0)
    found, wild = (one.loss.targets(one.q_network, one.target_network, steps) for one in (learner, free))
    largest = torch.as_tensor(bounds.largest[[0, 1]] / 10, dtype=torch.float32)
    assert (wild > largest).any() and torch.allclose(found, torch.minimum(wild, largest))


@pytest.mark.parametrize("state_input", ["heads", "one-hot", "raw"])
def test_loss_is_the_same_whether_observations_are_enumerated_or_not(state_input: str) -> None:
    steps = batch(12)
    losses = []
    for batch_size in (2, 16):
        learner = agent(state_input=state_input, batch_size=batch_size, l2=0.01)
        losses.append(learner.loss(learner.q_network, learner.target_network, steps).item())
    assert losses[0] == pytest.approx(losses[1], rel=1e-5)


def test_without_counterfactuals_only_the_own_state_counts() -> None:
    steps = batch(12)
    everywhere = agent(counterfactual=True)
    own = agent(counterfactual=False)
    all_targets = everywhere.loss.targets(everywhere.q_network, everywhere.target_network, steps)
    own_targets = own.loss.targets(own.q_network, own.target_network, steps)
    assert torch.allclose(own_targets[:, 0], all_targets[torch.arange(12), steps.state])


def test_counterfactual_tuples_equal_a_true_rollout() -> None:
    automaton = recorded_automaton("phi_1")
    tables = get_scheme("thesis").compile(automaton)
    learner = agent(tables, reward_scale=1.0)
    steps = batch(40, n_classes=tables.n_classes)
    steps = dataclasses.replace(steps, base_reward=torch.zeros(40), terminated=torch.zeros(40, dtype=torch.bool))
    found = learner.loss.targets(learner.q_network, learner.target_network, steps).numpy()
    letter_of = {int(c): letter for letter, c in reversed(list(enumerate(automaton.letter_class)))}
    features = learner.encoder.features(steps.next_observation)
    with torch.no_grad():
        following = learner.target_network(features).numpy().max(axis=2)
    for k, q in enumerate(learner.tensor_tables.learned.tolist()):
        for i in range(40):
            letter = letter_of[int(steps.letter_class[i])]
            names = {name for bit, name in enumerate(automaton.aps) if letter >> bit & 1}
            entered = automaton.step(q, names)  # what the wrapper would do from q
            if entered in automaton.deadlocks:
                expected = -100 + 0.99 * following[i, q]
            elif entered == 5:
                expected = -1.0
            else:
                expected = -10 + 0.99 * following[i, entered]
            assert found[i, k] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("state_input", ["heads", "raw"])
@pytest.mark.parametrize("l2", [0.0, 0.05])
def test_gradient_of_the_loss_equals_finite_differences(state_input: str, l2: float) -> None:
    learner = agent(state_input=state_input, l2=l2, hidden=(4,), double=False)
    network, target = learner.q_network.double(), learner.target_network.double()
    everything = learner.encoder.features
    learner.encoder.features = lambda packed: everything(packed).double()  # type: ignore[method-assign]
    learner.loss._all_features = None
    steps = batch(6)

    def loss() -> torch.Tensor:
        return learner.loss(network, target, steps)

    loss().backward()  # type: ignore[no-untyped-call]
    for weights in network.parameters():
        assert weights.grad is not None
        flat, gradient = weights.data.view(-1), weights.grad.view(-1)
        for i in range(0, len(flat), 3):
            middle = flat[i].item()
            flat[i] = middle + 1e-6
            above = loss().item()
            flat[i] = middle - 1e-6
            below = loss().item()
            flat[i] = middle
            assert (above - below) / 2e-6 == pytest.approx(gradient[i].item(), rel=1e-4, abs=1e-7)


def test_loss_is_half_the_mean_square_plus_weight_decay() -> None:
    learner = agent(l2=0.25, hidden=())
    steps = batch(3)
    with torch.no_grad():
        targets = learner.loss.targets(learner.q_network, learner.target_network, steps)
        values = learner.q_network(learner.encoder.features(steps.observation))
        chosen = values[torch.arange(3)[:, None], torch.arange(2), steps.action[:, None]]
        decay = sum(weights.square().sum().item() for weights in learner.q_network.parameters())
    expected = (targets - chosen).square().mean().item() / 2 + 0.25 * decay
    assert learner.loss(learner.q_network, learner.target_network, steps).item() == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("config", [DQNConfig(hidden=(8,)), DQNConfig.thesis(hidden=(8, 6))], ids=["default", "thesis"])
def test_target_and_policy_networks_start_as_copies(config: DQNConfig) -> None:
    learner = DoubleDQN(spaces.Discrete(4), 2, small_tables(), config)
    for network in (learner.target_network, learner.policy_network):
        for ours, theirs in zip(network.state_dict().values(), learner.q_network.state_dict().values(), strict=True):
            assert torch.equal(ours, theirs) and ours.data_ptr() != theirs.data_ptr()


def test_thesis_initialization_is_uniform_and_positive() -> None:
    learner = DoubleDQN(spaces.MultiDiscrete([10, 10]), 5, small_tables(), DQNConfig.thesis())
    linear = [layer for layer in learner.q_network.layers if isinstance(layer, torch.nn.Linear)]
    assert [(layer.in_features, layer.out_features) for layer in linear] == [(3, 400), (400, 300), (300, 5)]
    for layer, high in zip(linear, (0.1, 0.1, 0.01), strict=True):
        assert layer.weight.min() >= 0 and 0.9 * high < layer.weight.max() <= high
        assert not layer.bias.any()
    assert sum(isinstance(layer, torch.nn.BatchNorm1d) for layer in learner.q_network.layers) == 2


def test_product_state_of_the_thesis_is_row_column_and_automaton_state() -> None:
    learner = DoubleDQN(spaces.MultiDiscrete([10, 10]), 5, small_tables(), DQNConfig.thesis())
    inputs: list[torch.Tensor] = []
    learner.q_network.layers[0].register_forward_pre_hook(lambda _, arguments: inputs.append(arguments[0]))
    features = learner.encoder.features(torch.from_numpy(learner.encoder.pack(np.array([[4, 1]]))))
    learner.q_network(features, torch.tensor([2]))
    assert inputs[0].tolist() == [[4.0, 1.0, 2.0]]


def test_target_moves_by_tau_of_the_way() -> None:
    learner = agent(tau=0.25, averaging=0.5)
    before = [weights.clone() for weights in learner.target_network.parameters()]
    learner.update(batch(16), 0.01)
    networks = (learner.target_network, learner.policy_network, learner.q_network)
    for old, target, average, new in zip(before, *(network.parameters() for network in networks), strict=True):
        assert torch.allclose(target, old + 0.25 * (new - old))
        assert torch.allclose(average, old + 0.5 * (new - old))


def test_target_waits_for_its_interval() -> None:
    learner = agent(tau=1.0, target_update_interval=3)
    first = learner.target_network.state_dict()["layers.0.weight"].clone()
    for update in (1, 2, 3):
        learner.update(batch(16, seed=update), 0.01)
        unchanged = torch.equal(learner.target_network.state_dict()["layers.0.weight"], first)
        assert unchanged == (update < 3)


def test_running_statistics_move_with_the_weights() -> None:
    config = DQNConfig(hidden=(4,), batch_norm=True)
    networks = [QNetwork(2, 1, 2, config, torch.Generator().manual_seed(seed)) for seed in (0, 1)]
    networks[1].train()
    networks[1](torch.randn(10, 2, generator=torch.Generator().manual_seed(0)))
    Follower(*networks).move(0.5)
    moved, goal = (network.state_dict()["layers.2.running_mean"] for network in networks)
    assert torch.allclose(moved, goal / 2)
    assert networks[0].state_dict()["layers.2.num_batches_tracked"] == 1


def test_a_loss_that_is_not_finite_says_what_to_try() -> None:
    learner = agent()
    good = batch(16)
    before = learner.q_network.state_dict()["layers.0.weight"].clone()
    poisoned = dataclasses.replace(good, base_reward=torch.full((16,), torch.nan))
    with pytest.raises(TrainingDiverged, match=r"loss is nan at update 0 .*16 of them with a reward.*repair"):
        learner.update(poisoned, 0.01)
    assert torch.equal(learner.q_network.state_dict()["layers.0.weight"], before)
    with torch.no_grad():
        next(learner.q_network.parameters()).fill_(torch.inf)
    with pytest.raises(TrainingDiverged, match=r"weights not finite in layers\.0\.weight\. Try a learning_rate below"):
        learner.update(good, 0.01)


def test_a_device_that_is_not_there_is_refused() -> None:
    with pytest.raises(InvalidArgumentError, match=r"cannot use the device 'cuda:77'"):
        agent(device="cuda:77")


def test_initial_weights_leave_the_global_generator_alone() -> None:
    torch.manual_seed(0)
    before = torch.get_rng_state()
    agent()
    assert torch.equal(torch.get_rng_state(), before)
