"""PRISM's explicit files and module language: models out and in, so that PRISM or Storm can check an answer again.

A state of PRISM has its labels surely, and a run starts in one state. `with_sure_labels` makes the first so.

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
from ltlc.mdp.model import LabelledMDP
from ltlc.mdp.product import Product

Style = Literal["prism", "storm"]
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


def with_sure_labels(mdp: LabelledMDP) -> tuple[LabelledMDP, IntArray]:
    """The same process with states (state, letter), each of which has its label surely, and the state behind each.

    The letter is drawn on entering, as before. A process whose labels are sure already is given back as it is.
    """
    probability = mdp.label_probability
    if probability.nnz == mdp.n_states:
        return mdp, np.arange(mdp.n_states)
    origin = np.repeat(np.arange(mdp.n_states), np.diff(probability.indptr))
    n = len(origin)
    # old state -> new states, weighted by its letters; and new state -> the old one behind it
    drawn = sparse.csr_array((probability.data, np.arange(n), probability.indptr), shape=(mdp.n_states, n))
    behind = sparse.csr_array((np.ones(n), origin, np.arange(n + 1)), shape=(n, mdp.n_states))
    start = np.asarray(mdp.start @ drawn)
    names = mdp.state_names
    sure = LabelledMDP(
        aps=mdp.aps,
        transitions=tuple(behind @ matrix @ drawn for matrix in mdp.transitions),
        letters=mdp.letters,
        label_probability=sparse.csr_array(
            (np.ones(n), probability.indices, np.arange(n + 1)), shape=(n, len(mdp.letters))
        ),
        initial_state=int(np.argmax(start)),
        initial_distribution=start,
        state_names=None if names is None else tuple(names[state] for state in origin),
        action_names=mdp.action_names,
    )
    return sure, origin


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
    n = product.n_states
    letters, column = np.unique(_sure_letters(product.mdp)[product.mdp_state], return_inverse=True)
    return LabelledMDP(
        aps=product.mdp.aps,
        transitions=transitions,
        letters=letters,
        label_probability=sparse.csr_array((np.ones(n), column, np.arange(n + 1)), shape=(n, len(letters))),
        initial_state=int(np.argmax(product.initial)),
        initial_distribution=product.initial,
        state_names=tuple(product.describe(state).partition("(")[2][:-1] for state in range(n)),
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
    for name in mdp.aps:
        if not _NAME.fullmatch(name) or name in ("init", "deadlock"):
            raise InvalidArgumentError(f"proposition {name!r} cannot be the name of a label in PRISM's files")
    if state_reward is not None and np.shape(state_reward) != (mdp.n_states,):
        raise InvalidArgumentError(f"state_reward has shape {np.shape(state_reward)}, expected ({mdp.n_states},)")
    texts = {
        ".tra": _transitions_text(mdp, style),
        ".lab": _labels_text(mdp, letters, start, style),
        ".sta": "(s)\n" + "".join(f"{state}:({state})\n" for state in range(mdp.n_states)),
    }
    if state_reward is not None:
        paid = np.flatnonzero(state_reward)
        rows = "".join(f"{state} {state_reward[state]:.17g}\n" for state in paid.tolist())
        texts[".srew"] = f"{mdp.n_states} {len(paid)}\n{rows}" if style == "prism" else rows
    return tuple(atomic_write(Path(f"{os.fspath(stem)}{suffix}"), text) for suffix, text in texts.items())


def to_prism_language(mdp: LabelledMDP) -> str:
    """The process in PRISM's module language: one variable, a command per choice, a label per proposition.

    Raises:
        InvalidArgumentError: labels or the start are random, or a name cannot be written.
    """
    letters, start = _sure_letters(mdp), _one_start(mdp)
    base, matrix = mdp.explicit, mdp.explicit.matrix
    actions = _action_identifiers(mdp)
    lines = ["mdp" if mdp.n_actions > 1 else "dtmc", "", "module model"]
    lines += [f"  s : [0..{max(1, mdp.n_states - 1)}] init {start};"]
    for choice, (state, action) in enumerate(zip(base.choice_state.tolist(), base.choice_action.tolist(), strict=True)):
        entries = slice(matrix.indptr[choice], matrix.indptr[choice + 1])
        to = zip(matrix.indices[entries].tolist(), matrix.data[entries].tolist(), strict=True)
        branches = " + ".join(f"{p!r} : (s'={target})" for target, p in to)
        lines.append(f"  [{actions[action]}] s={state} -> {branches};")
    lines += ["endmodule", ""]
    for bit, name in enumerate(mdp.aps):
        if not _NAME.fullmatch(name):
            raise InvalidArgumentError(f"proposition {name!r} cannot be the name of a label in PRISM's language")
        states = np.flatnonzero(letters >> bit & 1).tolist()
        lines.append(f'label "{name}" = {" | ".join(f"s={state}" for state in states) or "false"};')
    return "\n".join(lines) + "\n"


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
    if len(set(names)) < mdp.n_actions or not all(_NAME.fullmatch(name) for name in names):
        return [f"a{a}" for a in range(mdp.n_actions)]
    return names
