"""How a learned policy fails where nothing exact is known: the words of sampled episodes."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from ltlc.envs import LTLVectorWrapper
from ltlc.envs.success import accepted_forever
from ltlc.mdp.estimate import Estimate, probability
from ltlc.pictures.policy import waits_for

from ..agent import Agent
from .collect import Collector, Interface

Letter = frozenset[str]


@dataclass(frozen=True)
class FailedEpisodes:
    """Sampled episodes that do not satisfy the formula, by what became of them.

    An episode counts as satisfied if its word would be, were its last letter repeated for ever.

    Attributes:
        failed: the part of the episodes that fail, with an interval.
        kinds: what became of them, and how many each.
        examples: of each kind, the word of the shortest episode, repeated letters left out.
    """

    failed: Estimate
    kinds: tuple[tuple[str, int], ...]
    examples: dict[str, tuple[Letter, ...]]

    def lines(self) -> list[str]:
        """What there is to say, for a person."""
        n = sum(count for _, count in self.kinds)
        lines = [
            f"{n} episodes fail: {self.failed.value:.4g} of them ({self.failed.low:.4g} to {self.failed.high:.4g})"
        ]
        for kind, count in self.kinds:
            word = "; ".join(" & ".join(sorted(letter)) or "1" for letter in self.examples[kind])
            lines.append(f"  {count}  {kind}; the shortest: {word}")
        return lines

    def to_dict(self) -> dict[str, Any]:
        """All of it as JSON values."""
        return {
            "failed": {"value": self.failed.value, "low": self.failed.low, "high": self.failed.high},
            "kinds": [
                {"kind": kind, "episodes": count, "word": [sorted(letter) for letter in self.examples[kind]]}
                for kind, count in self.kinds
            ],
        }


class _Watcher(Collector):
    """A collector that remembers what was read last."""

    def _see(self, observations: Any, infos: dict[str, Any]) -> None:
        super()._see(observations, infos)
        self.labels: list[Letter] = infos["ltl"]["label_names"].tolist()


def failed_episodes(
    agent: Agent, env: LTLVectorWrapper, *, episodes: int, max_steps: int, seed: int = 0
) -> FailedEpisodes:
    """Run a policy until so many episodes have ended, and look at the words of those that fail.

    Args:
        agent: what acts.
        env: the environments with the task.
        episodes: how many, at least.
        max_steps: after which an episode counts as it is.
        seed: of the environments and of what is random in the policy.
    """
    watcher = _Watcher(Interface.of(env), agent.encoder)
    watcher.reset(seed)
    agent.reseed(seed)
    words: list[list[Letter]] = [[letter] for letter in watcher.labels]
    done: list[list[Letter]] = []
    for _ in range(max_steps * (episodes // env.num_envs + 2)):
        watcher.follow(agent)
        ended = {i for i, _ in watcher.take_episodes()}
        for i, letter in enumerate(watcher.labels):
            if i in ended:
                done.append([*words[i], letter])
                words[i] = []
            else:
                words[i].append(letter)
        if len(done) >= episodes:
            break
    done += [word for word in words if len(word) >= max_steps]
    return _sorted(done, env)


def _sorted(words: list[list[Letter]], env: LTLVectorWrapper) -> FailedEpisodes:
    automaton = env.task.automaton
    holds = accepted_forever(automaton)
    waits = waits_for(automaton, np.arange(automaton.n_classes))
    lost, counts = set(automaton.deadlocks), Counter[str]()
    examples: dict[str, tuple[Letter, ...]] = {}
    for word in words:
        state, column = automaton.initial_state, 0
        for letter in word[env.initial_label == "skip" :]:
            column = int(automaton.letter_class[automaton.letter(letter)])
            state = int(automaton.delta[state, column])
            if state in lost:
                break
        if holds[state, column]:
            continue
        last = " & ".join(sorted(word[-1])) or "nothing holds"
        kind = f"violated, in the end {last}" if state in lost else f"in the end {waits[state]}"
        counts[kind] += 1
        short = tuple(letter for k, letter in enumerate(word) if not k or letter != word[k - 1])
        if kind not in examples or len(short) < len(examples[kind]):
            examples[kind] = short
    n = sum(counts.values())
    return FailedEpisodes(probability(n, len(words)), tuple(counts.most_common()), examples)
