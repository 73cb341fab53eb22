"""PRISM's explicit files and module language: models out and in, so that PRISM or Storm can check an answer again.

A state of PRISM has its labels surely, and a run starts in one state. `with_sure_labels` and `with_one_start` make both
so. States that their names give coordinates, such as the cells of a grid world, `(4, 1)`, get a variable for each.

References:
    M. Kwiatkowska, G. Norman, D. Parker, PRISM 4.0: verification of probabilistic real-time systems, CAV 2011, DOI
    10.1007/978-3-642-22110-1_47; file formats: the manual, https://www.prismmodelchecker.org/manual/Appendices.
    C. Hensel, S. Junges, J.-P. Katoen, T. Quatmann, M. Volk, The probabilistic model checker Storm, STTT 2022, DOI
    10.1007/s10009-021-00633-z.
"""

from __future__ import annotations

import io
import os
import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from scipy import sparse

from ltlc.atomic import atomic_write
from ltlc.errors import InvalidArgumentError
from ltlc.mdp.explicit import FloatArray, IntArray
from ltlc.mdp.model import LabelledMDP, split_by_letter
from ltlc.mdp.product import Product

Style = Literal["prism", "storm"]
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_RESERVED = (
    "A bool clock const ctmc C double dtmc E endinit endinvariant endmodule endobservables endrewards endsystem false "
    "formula filter func F global G init invariant I int label max mdp min module X nondeterministic observable "
    "observables of P Pmin Pmax pomdp popta probabilistic prob pta rate rewards Rmin Rmax R S smg stochastic system "
    "true U W"
)
"""words that PRISM does not take as names of actions."""
_STATE = re.compile(r"(?:\((?P<row>\d+), ?(?P<column>\d+)\)|(?P<s>\d+))(?:, letter (?P<letter>\d+))?(?:, q(?P<q>\d+))?")
"""names of states that say their variables: a cell or a number, the letter drawn there, the state of an automaton."""


def with_sure_labels(mdp: LabelledMDP) -> tuple[LabelledMDP, IntArray]:
    """The same process with states (state, letter), each of which has its label surely, and the state behind each.

    See `ltlc.mdp.model.split_by_letter`. A process whose labels are sure already is given back as it is.
    """
    return split_by_letter(mdp, np.ones(mdp.n_states, dtype=np.bool_))


def with_one_start(mdp: LabelledMDP) -> tuple[LabelledMDP, bool]:
    """The same process with one first state, and whether there is now a step before the first one.

    A random start becomes a state without label, the last one, from which every action leads to where it started.
    """
    if np.count_nonzero(mdp.start) == 1:
        return mdp, False
    first = sparse.csr_array(mdp.start[None, :])
    letters = mdp.letters if (mdp.letters == 0).any() else np.append(mdp.letters, 0)
    extra = len(letters) - len(mdp.letters)
    unlabelled = sparse.csr_array(((letters == 0).astype(np.float64))[None, :])
    n = mdp.n_states
    return LabelledMDP(
        aps=mdp.aps,
        transitions=tuple(
            sparse.hstack((sparse.vstack((matrix, first)), sparse.csr_array((n + 1, 1))), format="csr")
            for matrix in mdp.transitions
        ),
        letters=letters,
        label_probability=sparse.vstack(
            (sparse.hstack((mdp.label_probability, sparse.csr_array((n, extra)))), unlabelled), format="csr"
        ),
        initial_state=n,
        terminal=None if mdp.terminal is None else np.append(mdp.terminal, False),
        action_names=mdp.action_names,
    ), True


def product_process(product: Product) -> LabelledMDP:
    """A product as a process of its own, with the labels of the MDP.

    Raises:
        InvalidArgumentError: labels are random (see `with_sure_labels`).
    """
    shape = (product.n_states, product.n_choices)
    transitions = []
    for action in range(product.n_actions):
        rows = np.flatnonzero(product.choice_action == action)
        pick = sparse.csr_array((np.ones(len(rows)), (product.choice_state[rows], rows)), shape=shape)
        transitions.append(pick @ product.matrix)
    return _with_labels_of(product, tuple(transitions), product.mdp.action_names)


def induced_process(product: Product, policy: npt.ArrayLike) -> LabelledMDP:
    """The Markov chain of a policy on product states, as a process with one action and the labels of the MDP.

    Its states are those of the product, so its words are those of the policy: model checking the formula on it gives
    the probability that the policy satisfies it, without any automaton of ours.

    Raises:
        InvalidArgumentError: the policy does not fit, or labels are random (see `with_sure_labels`).
    """
    return _with_labels_of(product, (product.policy_matrix(policy) @ product.matrix,), None)


def _with_labels_of(
    product: Product, transitions: tuple[Any, ...], action_names: tuple[str, ...] | None
) -> LabelledMDP:
    n, names = product.n_states, product.mdp.state_names
    letters, column = np.unique(_sure_letters(product.mdp)[product.mdp_state], return_inverse=True)
    return LabelledMDP(
        aps=product.mdp.aps,
        transitions=transitions,
        letters=letters,
        label_probability=sparse.csr_array((np.ones(n), column, np.arange(n + 1)), shape=(n, len(letters))),
        initial_state=int(np.argmax(product.initial)),
        initial_distribution=product.initial,
        state_names=tuple(
            f"{state if names is None else names[state]}, q{q}"
            for state, q in zip(product.mdp_state.tolist(), product.machine_state.tolist(), strict=True)
        ),
        action_names=action_names,
    )


def write_explicit(
    mdp: LabelledMDP,
    stem: str | os.PathLike[str],
    *,
    style: Style = "prism",
    state_reward: FloatArray | None = None,
) -> tuple[Path, ...]:
    """Write `stem`.tra, .lab, .sta and, with a reward per state, .srew; a process with one action is a dtmc.

    Args:
        mdp: the process; labels must be sure, and there must be one initial state.
        stem: path without suffix.
        style: "storm" writes .tra and .lab as Storm's explicit engine reads them, which differs in headers.
        state_reward: shape (n_states,).

    Raises:
        InvalidArgumentError: labels or the start are random, a name cannot be written, or the style is unknown.
        OSError: a file cannot be written.
    """
    if style not in ("prism", "storm"):
        raise InvalidArgumentError(f'style is {style!r}, expected "prism" or "storm"')
    letters, start = _sure_letters(mdp), _one_start(mdp)
    _check_labels(mdp.aps)
    if state_reward is not None and np.shape(state_reward) != (mdp.n_states,):
        raise InvalidArgumentError(f"state_reward has shape {np.shape(state_reward)}, expected ({mdp.n_states},)")
    texts = {
        ".tra": _transitions_text(mdp, style),
        ".lab": _labels_text(mdp, letters, start, style),
        ".sta": _states_text(*_variables(mdp)),
    }
    if state_reward is not None:
        paid = np.flatnonzero(state_reward)
        rows = "".join(f"{state} {state_reward[state]:.17g}\n" for state in paid.tolist())
        texts[".srew"] = f"{mdp.n_states} {len(paid)}\n{rows}" if style == "prism" else rows
    return tuple(atomic_write(Path(f"{os.fspath(stem)}{suffix}"), text) for suffix, text in texts.items())


def to_prism_language(mdp: LabelledMDP) -> str:
    """The process in PRISM's module language: a command per choice, a label per proposition.

    Variables are what the names of the states say, such as row, column and q; else there is one, s.

    Raises:
        InvalidArgumentError: labels or the start are random, or a name cannot be written.
    """
    letters, start = _sure_letters(mdp), _one_start(mdp)
    _check_labels(mdp.aps)
    base, matrix = mdp.explicit, mdp.explicit.matrix
    actions = _action_identifiers(mdp) if mdp.n_actions > 1 else [""]
    lines = ["mdp" if mdp.n_actions > 1 else "dtmc", "", "module model"]
    names, values = _variables(mdp)
    highest = np.maximum(values.max(axis=0), 1).tolist()
    lines += [
        f"  {name} : [0..{high}] init {first};" for name, high, first in zip(names, highest, values[start], strict=True)
    ]
    rows = values.tolist()
    here = [" & ".join(f"{name}={v}" for name, v in zip(names, row, strict=True)) for row in rows]
    for choice, (state, action) in enumerate(zip(base.choice_state.tolist(), base.choice_action.tolist(), strict=True)):
        entries = slice(matrix.indptr[choice], matrix.indptr[choice + 1])
        to = zip(matrix.indices[entries].tolist(), matrix.data[entries].tolist(), strict=True)
        branches = " + ".join(f"{p!r} : {_update(names, rows[state], rows[target])}" for target, p in to)
        lines.append(f"  [{actions[action]}] {here[state]} -> {branches};")
    lines += ["endmodule", ""]
    for bit, name in enumerate(mdp.aps):
        states = np.flatnonzero(letters >> bit & 1).tolist()
        holds = " | ".join(here[state] if len(names) == 1 else f"({here[state]})" for state in states)
        lines.append(f'label "{name}" = {holds or "false"};')
    return "\n".join(lines) + "\n"


def _check_labels(aps: tuple[str, ...]) -> None:
    for name in aps:
        if not _NAME.fullmatch(name) or name in ("init", "deadlock"):
            raise InvalidArgumentError(f"proposition {name!r} cannot be the name of a label in PRISM; rename it")


def _variables(mdp: LabelledMDP) -> tuple[tuple[str, ...], IntArray]:
    """Names of variables, and the value of each in each state, shape (n_states, n_variables)."""
    found = [_STATE.fullmatch(name) for name in mdp.state_names or ()]
    if found and all(found):
        groups = [match.groupdict() for match in found if match]
        names = tuple(name for name, value in groups[0].items() if value is not None)
        if all(tuple(name for name, value in group.items() if value is not None) == names for group in groups):
            values = np.array([[int(group[name]) for name in names] for group in groups])
            if len(np.unique(values, axis=0)) == mdp.n_states:
                return names, values
    return ("s",), np.arange(mdp.n_states)[:, None]


def _update(names: tuple[str, ...], before: list[int], after: list[int]) -> str:
    """What changes from one state to the next, as PRISM writes it."""
    changes = [f"({name}'={new})" for name, old, new in zip(names, before, after, strict=True) if old != new]
    return " & ".join(changes) or "true"


def _states_text(names: tuple[str, ...], values: IntArray) -> str:
    rows = "".join(f"{state}:({','.join(map(str, row))})\n" for state, row in enumerate(values.tolist()))
    return f"({','.join(names)})\n{rows}"


def _transitions_text(mdp: LabelledMDP, style: Style) -> str:
    base, matrix = mdp.explicit, mdp.explicit.matrix
    length = np.diff(matrix.indptr)
    choice = np.repeat(np.arange(base.n_choices), length)
    state = base.choice_state[choice]
    chain = mdp.n_actions == 1
    if style == "storm":
        head = "dtmc" if chain else "mdp"
    else:
        head = f"{mdp.n_states} {matrix.nnz}" if chain else f"{mdp.n_states} {base.n_choices} {matrix.nnz}"
    columns = [state.tolist(), matrix.indices.tolist(), matrix.data.tolist()]
    out = io.StringIO()
    out.write(head + "\n")
    if chain:
        out.writelines(f"{s} {t} {p!r}\n" for s, t, p in zip(*columns, strict=True))
        return out.getvalue()
    local = (choice - base.choice_start[state]).tolist()
    names = _action_identifiers(mdp)
    tail = [""] * matrix.nnz if style == "storm" else [f" {names[a]}" for a in base.choice_action[choice].tolist()]
    out.writelines(
        f"{s} {c} {t} {p!r}{a}\n" for (s, t, p), c, a in zip(zip(*columns, strict=True), local, tail, strict=True)
    )
    return out.getvalue()


def _labels_text(mdp: LabelledMDP, letters: IntArray, start: int, style: Style) -> str:
    labelled = {start: [0]}
    for state in np.flatnonzero(letters).tolist():
        bits = [bit + 2 for bit in range(len(mdp.aps)) if letters[state] >> bit & 1]
        labelled[state] = labelled.get(state, []) + bits
    names = ["init", "deadlock", *mdp.aps]
    rows = sorted(labelled.items())
    if style == "prism":
        head = " ".join(f'{number}="{name}"' for number, name in enumerate(names))
        return head + "\n" + "".join(f"{state}: {' '.join(map(str, has))}\n" for state, has in rows)
    body = "".join(f"{state} {' '.join(names[i] for i in has)}\n" for state, has in rows)
    return f"#DECLARATION\n{' '.join(names)}\n#END\n{body}"


def _sure_letters(mdp: LabelledMDP) -> IntArray:
    """The letter of each state."""
    probability = mdp.label_probability
    if probability.nnz != mdp.n_states:
        state = mdp.state_name(np.flatnonzero(np.diff(probability.indptr) > 1)[0])
        raise InvalidArgumentError(
            f"the label of state {state} is random, which PRISM cannot say; use with_sure_labels"
        )
    return np.asarray(mdp.letters[probability.indices])


def _one_start(mdp: LabelledMDP) -> int:
    start = np.flatnonzero(mdp.start)
    if len(start) != 1:
        raise InvalidArgumentError(f"the first state is one of {len(start)} at random; PRISM wants a single one")
    return int(start[0])


def _action_identifiers(mdp: LabelledMDP) -> list[str]:
    """A name for each action that PRISM can read; the actions' own, where they are such and differ."""
    names = list(mdp.action_names or ())
    if len(set(names)) < mdp.n_actions or not all(
        _NAME.fullmatch(name) and name not in _RESERVED.split() for name in names
    ):
        return [f"a{a}" for a in range(mdp.n_actions)]
    return names
