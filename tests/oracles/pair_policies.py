"""What a policy that chooses pairs really satisfies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ltlc.automata import DRA
from ltlc.mdp import LabelledMDP, Product, satisfaction_probability
from ltlc.rewards import RewardTables


def true_satisfaction(mdp: LabelledMDP, automaton: DRA, tables: RewardTables, policy: np.ndarray) -> float:
    """P(sat) of a policy on (MDP state, table state), when the run goes on after the episode.

    The automaton is that of the task with the table's states; a violation is final.
    """
    behind, n = tables.automaton_state, tables.n_states
    delta = np.vstack((np.where(tables.violated, n, tables.next_state), np.full((1, tables.n_classes), n)))
    none = np.zeros((automaton.n_pairs, 1, tables.n_classes), dtype=bool)
    refined = replace(
        automaton,
        delta=delta,
        fin=np.concatenate((automaton.edge_fin[:, behind], none), axis=1),
        inf=np.concatenate((automaton.edge_inf[:, behind] & ~tables.violated, none), axis=1),
        initial_state=tables.initial_state,
        acceptance="transition",
        state_names=None,
    )
    product = Product(mdp, refined, select_pair=np.vstack((tables.select_pair, np.full((1, tables.n_choices), -1))))
    policy = np.hstack((policy, np.zeros((mdp.n_states, 1), dtype=int)))
    lifted = product.lift(policy)
    available = [a if a in product.actions_in(s) else product.actions_in(s)[0] for s, a in enumerate(lifted)]
    return satisfaction_probability(product, np.array(available)).probability
