"""Train TorchRL's DQN (`pip install torchrl`) on a task, with the discount of each step, and judge what it learned."""

import sys

import torch
from tensordict.nn import TensorDictSequential
from torchrl.data import LazyTensorStorage, TensorDictReplayBuffer
from torchrl.envs import ExplorationType, GymWrapper, StepCounter, TransformedEnv, set_exploration_type
from torchrl.envs.transforms import CatTensors, Compose
from torchrl.modules import MLP, EGreedyModule, QValueActor
from torchrl.objectives import DQNLoss, SoftUpdate

import ltlc
from ltlc.bridges.torchrl import LTLTransform, with_discounts
from ltlc.envs import GridWorld

MAP, LABELS, GAMMA = ("S..k", ".##.", "..x.", "...g"), {"k": "key", "g": "goal", "x": "pit"}, 0.99
FLAT = "".join(MAP)


def labels(one_hot):
    return {LABELS[c] for c in FLAT[int(one_hot.argmax())] if c in LABELS}


def main(total=8_000, task="!pit U (key & (!pit U goal))"):
    torch.manual_seed(0)
    torch.set_num_threads(1)
    task = ltlc.Task(task).for_horizon(50)
    world = GridWorld(MAP, labels=LABELS, slip=0.1, actions=4)
    transform = LTLTransform(task, labels, warn_discount=False)  # with_discounts honours them
    both = CatTensors(["observation", "automaton"], "seen", del_keys=False, sort=False)
    env = TransformedEnv(GymWrapper(world), Compose(transform, both, StepCounter(50)))
    network = MLP(in_features=16 + task.tables.n_states, out_features=4, num_cells=[64], activation_class=torch.nn.ReLU)
    actor = QValueActor(network, in_keys=["seen"], spec=env.action_spec)
    explore = EGreedyModule(env.action_spec, eps_init=1.0, eps_end=0.05, annealing_num_steps=int(0.7 * total))
    loss = DQNLoss(actor, delay_value=True, double_dqn=True)
    loss.make_value_estimator(gamma=GAMMA)
    update = SoftUpdate(loss, eps=0.98)
    optimizer = torch.optim.Adam(loss.parameters(), lr=2e-3)
    buffer = TensorDictReplayBuffer(storage=LazyTensorStorage(20_000), batch_size=256)
    policy = TensorDictSequential(actor, explore)
    steps = 0
    while steps < total:
        with set_exploration_type(ExplorationType.RANDOM):
            rows = env.rollout(50, policy)
        buffer.extend(rows)
        steps += len(rows)
        explore.step(len(rows))
        for _ in range(len(rows) // 4 if steps > 500 else 0):
            found = loss(with_discounts(buffer.sample(), GAMMA))["loss"]
            optimizer.zero_grad()
            found.backward()
            optimizer.step()
            update.step()
    print(found := ltlc.judge(network, world, task))
    return found


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
