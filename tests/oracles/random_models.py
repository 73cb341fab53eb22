"""Random small MDPs and Rabin automata, and what Storm says of an MDP."""

from __future__ import annotations

import itertools

import numpy as np

from ltlc.automata.rabin import DRA
from ltlc.mdp import LabelledMDP


def random_mdp(rng: np.random.Generator, n: int, n_actions: int, *, labels: bool = True) -> LabelledMDP:
    """Sparse random rows; some actions are missing, some labels are probabilistic."""
    matrices = np.zeros((n_actions, n, n))
    for a, s in itertools.product(range(n_actions), range(n)):
        if a == 0 or rng.random() < 0.7:
            found = rng.choice(n, size=rng.integers(1, 3), replace=False)
            matrices[a, s, found] = rng.dirichlet(np.ones(len(found)))
    chance = [{ap: rng.choice([0.0, 0.5, 1.0], p=[0.5, 0.2, 0.3]) for ap in "ab"} for _ in range(n)]
    return LabelledMDP.from_arrays(matrices, aps="ab", labels=chance if labels else ())


def random_automaton(rng: np.random.Generator, n: int, n_pairs: int) -> DRA:
    acceptance = rng.choice(["state", "transition"])
    shape = (n_pairs, n) if acceptance == "state" else (n_pairs, n, 4)
    fin, inf = rng.random(shape) < 0.3, rng.random(shape) < 0.4
    delta = rng.integers(n, size=(n, 4))
    return DRA(("a", "b"), delta, np.arange(4), fin, inf, acceptance=str(acceptance))


def storm_value(stormpy, folder, mdp: LabelledMDP, text: str) -> float:
    """The answer of Storm for a property, by way of Storm's explicit files; labels must be sure."""
    base = mdp.explicit
    lines = ["mdp"]
    for c, s in enumerate(base.choice_state):
        row = base.matrix[[c]]
        local = c - base.choice_start[s]
        lines += [f"{s} {local} {t} {p:.17g}" for t, p in zip(row.indices, row.data, strict=True)]
    sure = mdp.letters[mdp.label_probability.toarray().argmax(axis=1)]
    names = [" ".join(ap for i, ap in enumerate(mdp.aps) if letter >> i & 1) for letter in sure]
    marked = [f"{s} {'init ' if s == mdp.initial_state else ''}{name}" for s, name in enumerate(names)]
    declared = ["#DECLARATION", " ".join(["init", *mdp.aps]), "#END"]
    (folder / "model.tra").write_text("\n".join(lines) + "\n")
    (folder / "model.lab").write_text("\n".join([*declared, *(m for m in marked if " " in m.strip())]) + "\n")
    build = getattr(stormpy, "build_model_from_explicit", None) or stormpy.build_sparse_model_from_explicit
    model = build(str(folder / "model.tra"), str(folder / "model.lab"))
    result = stormpy.model_checking(model, stormpy.parse_properties(text)[0])
    return result.get_value(0) if hasattr(result, "get_value") else result.at(0)
