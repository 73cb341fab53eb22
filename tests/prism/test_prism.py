"""PRISM's files: out and in again, wrong ones, and Storm's answers to what was written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mdp_cases import thesis_world

from ltlc import compile, parse
from ltlc.envs import GridWorld, grid_map, labelled_mdp
from ltlc.errors import AlphabetLimitExceeded, FileFormatError, InvalidArgumentError, StateLimitExceeded
from ltlc.mdp import LabelledMDP, Product, max_satisfaction_probability, satisfaction_probability
from ltlc.prism import (
    export_checkable,
    induced_process,
    product_process,
    read_explicit,
    read_state_rewards,
    to_prism_language,
    with_one_start,
    with_sure_labels,
    write_explicit,
)


def random_mdp(seed: int, n: int = 7, n_actions: int = 3, *, random_labels: bool = False) -> LabelledMDP:
    rng = np.random.default_rng(seed)
    p = rng.random((n_actions, n, n)) * (rng.random((n_actions, n, n)) < 0.4)
    p[0, np.arange(n), rng.permutation(n)] += 0.5
    total = p.sum(axis=2, keepdims=True)
    p = np.divide(p, total, out=np.zeros_like(p), where=total > 0)
    labels = [{ap: (rng.random() if random_labels else 1.0) for ap in "ab" if rng.random() < 0.4} for _ in range(n)]
    return LabelledMDP.from_arrays(p, aps="ab", labels=labels, initial_state=int(rng.integers(n)))


@pytest.mark.parametrize("style", ["prism", "storm"])
@pytest.mark.parametrize("seed", range(6))
def test_models_come_back_as_they_were(tmp_path: Path, seed: int, style: str) -> None:
    mdp = random_mdp(seed, n_actions=1 + seed % 3)
    reward = np.random.default_rng(seed).normal(size=mdp.n_states).round(3)
    tra, lab, sta, srew = write_explicit(mdp, tmp_path / "model", style=style, state_reward=reward)
    again = read_explicit(tra, lab, sta)
    assert (again.aps, again.initial_state) == (mdp.aps, mdp.initial_state)
    one, two = mdp.explicit, again.explicit
    assert (one.choice_start == two.choice_start).all()
    assert np.abs(one.matrix - two.matrix).max() <= 1e-15
    assert (with_sure_labels(again)[0].label_probability != mdp.label_probability).nnz == 0
    assert (read_state_rewards(srew, mdp.n_states) == reward).all()


def test_random_labels_become_states() -> None:
    mdp = random_mdp(3, random_labels=True)
    with pytest.raises(InvalidArgumentError, match="with_sure_labels"):
        to_prism_language(mdp)
    sure, origin = with_sure_labels(mdp)
    assert sure.n_states == mdp.label_probability.nnz == len(origin)
    for formula in ("F(a & X b)", "G F a & F G !b", "!a U b"):
        dra = compile(formula)
        values = [max_satisfaction_probability(Product(model, dra)).probability for model in (mdp, sure)]
        assert values[0] == pytest.approx(values[1], abs=1e-9)


def test_the_module_language_reads_like_the_model() -> None:
    p = np.array([[[0, 1.0], [0, 1]], [[0.25, 0.75], [0, 0]]])
    text = to_prism_language(LabelledMDP.from_arrays(p, aps="g", labels={1: "g"}, action_names=("go", "try")))
    assert text == (
        "mdp\n\nmodule model\n  s : [0..1] init 0;\n  [go] s=0 -> 1.0 : (s'=1);\n  [try] s=0 -> 0.25 : true + 0.75 "
        ': (s\'=1);\n  [go] s=1 -> 1.0 : true;\nendmodule\n\nlabel "g" = s=1;\n'
    )


def test_cells_and_automaton_states_are_variables(tmp_path: Path) -> None:
    world = labelled_mdp(GridWorld(grid_map(["S.", ".g"], actions=4)))
    text = to_prism_language(world)
    assert "  row : [0..1] init 0;\n  column : [0..1] init 0;\n" in text
    assert "  [RIGHT] row=0 & column=0 -> 1.0 : (column'=1);" in text
    assert 'label "g" = (row=1 & column=1);' in text
    product = Product(world, compile("F g"))
    chain = to_prism_language(induced_process(product, np.full(product.n_states, 1)))
    assert chain.startswith("dtmc") and "  [] row=0 & column=0 & q=0 -> 1.0 : (column'=1);" in chain
    (sta,) = [path for path in write_explicit(product_process(product), tmp_path / "m") if path.suffix == ".sta"]
    assert sta.read_text().startswith("(row,column,q)\n0:(0,0,0)\n")
    hidden = labelled_mdp(GridWorld(grid_map(["S.", ".g"], actions=4, labels={"g": 0.5})))
    assert "row=1 & column=1 & letter=1" in to_prism_language(with_sure_labels(hidden)[0])


def test_names_that_mean_something_to_prism() -> None:
    p = np.eye(2)[None].repeat(2, axis=0)
    assert "[a0] s=0" in to_prism_language(LabelledMDP.from_arrays(p, action_names=("F", "max")))
    with pytest.raises(InvalidArgumentError, match="name of a label"):
        to_prism_language(LabelledMDP.from_arrays(p, aps=["init"]))


def test_a_random_start_becomes_a_state() -> None:
    mdp = random_mdp(1)
    assert with_one_start(mdp) == (mdp, False)
    scattered = LabelledMDP.from_arrays(
        mdp.transitions, aps="ab", labels={0: ["a"], 1: ["a", "b"], 2: ["b"]}, initial_distribution=np.full(7, 1 / 7)
    )
    one, later = with_one_start(scattered)
    assert later and one.n_states == 8 and one.initial_state == 7
    for formula in ("a U b", "F(a & X !a)"):
        before = max_satisfaction_probability(Product(scattered, compile(formula))).probability
        after = max_satisfaction_probability(Product(one, compile(f"X({formula})"))).probability
        # the first action is chosen before it is known where it starts, which changes nothing: it has no effect
        assert after == pytest.approx(before, abs=1e-9)


@pytest.mark.parametrize(("tra", "message"), [
    ("", "empty"),
    ("2 2\n0 1 1\n", "header promises"),
    ("zwei\n", "line 1"),
    ("2 2\n0 1 1\n1 1\n", "line 3: 2 entries"),
    ("2 2\n0 1 one\n1 1 1\n", "line 2, column 5: 'one' is not a probability"),
    ("2 2\n0 1 1.5\n1 1 1\n", "line 2, column 5: 1.5 is not a probability"),
    ("2 2\n0 1 nan\n1 1 1\n", "line 2, column 5: nan is not a probability"),
    ("2 2\n0 5 1\n1 1 1\n", "line 2, column 3: state 5, but there are 2"),
    ("2 2\n0 -1 1\n1 1 1\n", "line 2, column 3: '-1' is not state"),
    ("2 2\n0 1 0.5\n1 1 1\n", "sum to 0.5"),
    ("mdp\n0 0 0 0.5 go\n0 0 1 0.5 stay\n", "two actions"),
    ("mdp\n", "no transitions"),
    ("mdp\n0 0 1 1\n", "state 1 has no available action"),
    ("mdp\n0 99999999999999999999 0 1\n", "line 2, column 3: choice '99999999999999999999': numbers are below"),
    ("mdp\n0 2000000000 0 1\n", "choice 2000000000 of state 0, which has 1"),
    ("dtmc\n0 2000000000 1\n", "state 1 has no available action"),
    ("2000000000 1\n0 0 1\n", "state 1 has no available action"),
    ("99999999999999999999 1\n0 0 1\n", "line 1, column 1: a number '99999999999999999999'"),
    ("\u00b2 1\n0 0 1\n", "line 1, column 1: '\u00b2' is not a number"),
    (f"{'9' * 5_000} 1\n0 0 1\n", r"line 1, column 1: a number '9{37}\.\.\.'"),
    (f"1 1\n0 0 {'x' * 5_000}\n", r"line 2, column 5: 'x{37}\.\.\.' is not"),
    ("1 1\n0 0 1_0\n", "column 5: '1_0' is not a probability"),
    ("1 1\n0 0 1/0\n", "column 5: '1/0' is not a probability"),
    ("# Transitions (CTMC)\n1 1\n0 0 1\n", "line 1: this is a continuous-time Markov chain"),
    ("2 2\n0 1 45\n1 0 45\n", "line 2, column 5: 45.0 is not a probability; if it is a rate"),
    ("ctmc\n0 0 1\n", "line 1, column 1: this is a continuous-time"),
    ("# Transitions (LTS)\n1 1 1\n0 0 0\n", "line 1: this is a labelled transition system"),
    ("2 2 2\n0 0 1\n1 0 0\n", "line 2: this seems to be a labelled transition system"),
    ("# Transitions (IMDP)\n1 1 1\n0 0 0 [1,1]\n", "line 1: this is an MDP whose probabilities are intervals"),
    ("1 1 1\n0 0 0 [1,1]\n", "line 2: this seems to be an MDP whose probabilities are intervals"),
    ("1 1\n0 0 [1,1]\n", "line 2: this seems to be a Markov chain whose probabilities are intervals"),
    ("1 1 1 1\n0 0 0 1 0\n", "line 1: four numbers in the first line mean a partially observable MDP"),
    ("6 10 16\n0 0.1:1 0.9:3 south\n", "line 2: this seems to be an export by rows"),
    ("# Labels\n0=\"init\"\n0: 0\n", "line 1: this file has labels; expected transitions"),
])  # fmt: skip
def test_malformed_transitions(tmp_path: Path, tra: str, message: str) -> None:
    path = tmp_path / "wrong.tra"
    path.write_text(tra)
    with pytest.raises(FileFormatError, match=message) as caught:
        read_explicit(path)
    assert "wrong.tra" in str(caught.value)


@pytest.mark.parametrize(("lab", "message"), [
    ("", "empty"), ("init goal\n", "line 1"), ('0="init" 1="goal"\n0: 2\n', "line 2, column 4: label '2'"),
    ('0="init"\n9: 0\n', "line 2, column 1: state 9"), ('0="init"\n0: 0\n1: 0\n', "2 states are labelled init"),
    ("#DECLARATION\ninit\n0 init\n", "#END"), ('0="a" 1="a"\n0: 0\n', "line 1: a label is declared twice"),
    ("\u00b2=\"a\"\n", "line 1: expected labels"), ('0="init"\n\u00b2: 0\n', "line 2, column 1: '\u00b2' is not state"),
    ("# States\n(s)\n0:(0)\n", "line 1: this file has states; expected labels"),
])  # fmt: skip
def test_malformed_labels(tmp_path: Path, lab: str, message: str) -> None:
    (tmp_path / "m.tra").write_text("2 2\n0 1 1\n1 1 1\n")
    (tmp_path / "m.lab").write_text(lab)
    with pytest.raises(FileFormatError, match=message) as caught:
        read_explicit(tmp_path / "m.tra", tmp_path / "m.lab")
    assert "m.lab" in str(caught.value)


def test_files_of_todays_prism(tmp_path: Path) -> None:
    (tmp_path / "m.tra").write_text(
        "# Transitions (MDP)\n2 3 4\n0 0 0 1/3 go\n0 0 1 2/3 go\n0 1 0 1 stay\n1 0 1 1 stay\n"
    )
    (tmp_path / "m.lab").write_text('# Labels\n0="init" 1="deadlock" 2="goal"\n0: 0\n# a remark\n1: 2\n')
    (tmp_path / "m.sta").write_text("# States\n(x)\n0:(3)\n1:(4)\n")
    (tmp_path / "m.srew").write_text('# Reward structure "time"\n# State rewards\n2 1\n1 2.5\n')
    mdp = read_explicit(tmp_path / "m.tra", tmp_path / "m.lab", tmp_path / "m.sta")
    assert (mdp.n_states, mdp.action_names, mdp.aps, mdp.state_names) == (2, ("go", "stay"), ("goal",), ("(3)", "(4)"))
    assert mdp.transitions[0][0, 1] == pytest.approx(2 / 3)
    assert read_state_rewards(tmp_path / "m.srew", 2).tolist() == [0, 2.5]
    (tmp_path / "m.srew").write_text("# Transition rewards\n2 1\n1 2.5\n")
    with pytest.raises(FileFormatError, match="line 1: this file has transition rewards; expected state rewards"):
        read_state_rewards(tmp_path / "m.srew", 2)


def test_binary_and_huge_files(tmp_path: Path) -> None:
    (tmp_path / "m.tra").write_bytes(b"1 1\n0 0 \xff\n")
    with pytest.raises(FileFormatError, match=r"m\.tra: not UTF-8 text"):
        read_explicit(tmp_path / "m.tra")
    (tmp_path / "m.tra").write_text("1 1\n0 0 1\n")
    (tmp_path / "m.lab").write_text(" ".join(f'{i}="l{i}"' for i in range(63)) + "\n0: 62\n")
    with pytest.raises(AlphabetLimitExceeded, match=r"m\.lab: 63 labels"):
        read_explicit(tmp_path / "m.tra", tmp_path / "m.lab")
    n = 6_000  # an action of its own in every state goes by number; that many choices in one state do not fit
    (tmp_path / "m.tra").write_text(f"{n} {n} {n}\n" + "".join(f"{s} 0 {s} 1 a{s}\n" for s in range(n)))
    assert read_explicit(tmp_path / "m.tra").n_actions == 1
    rows = "".join(f"0 {i} 0 1\n" for i in range(n)) + "".join(f"{s} 0 {s} 1\n" for s in range(1, n))
    (tmp_path / "m.tra").write_text(f"mdp\n{rows}")
    with pytest.raises(StateLimitExceeded, match="6000 states and 6000 actions"):
        read_explicit(tmp_path / "m.tra")


def test_malformed_rewards_and_states(tmp_path: Path) -> None:
    (tmp_path / "m.tra").write_text("2 2\n0 1 1\n1 1 1\n")
    (tmp_path / "m.srew").write_text("2 1\n0 much\n")
    with pytest.raises(FileFormatError, match=r"m\.srew, line 2"):
        read_state_rewards(tmp_path / "m.srew", 2)
    (tmp_path / "m.sta").write_text("(x)\n0:(1)\nx(2)\n")
    with pytest.raises(FileFormatError, match=r"m\.sta, line 3"):
        read_explicit(tmp_path / "m.tra", sta=tmp_path / "m.sta")


def test_what_cannot_be_written(tmp_path: Path) -> None:
    loop = [np.eye(2)]
    with pytest.raises(InvalidArgumentError, match="at random"):
        to_prism_language(LabelledMDP.from_arrays(loop, initial_distribution=np.array([0.5, 0.5])))
    with pytest.raises(InvalidArgumentError, match="name of a label"):
        write_explicit(LabelledMDP.from_arrays(loop, aps=["x > 1"]), tmp_path / "m")
    with pytest.raises(InvalidArgumentError, match="style"):
        write_explicit(LabelledMDP.from_arrays(loop), tmp_path / "m", style="nusmv")  # type: ignore[arg-type]


def storm_says(stormpy, model, text: str) -> float:
    result = stormpy.model_checking(model, stormpy.parse_properties(text)[0])
    state = model.initial_states[0]
    return result.get_value(state) if hasattr(result, "get_value") else result.at(state)


FORMULAS = [("F(a & X b)", 'F ("a" & X "b")'), ("G F a & F G !b", '(G F "a") & (F G !"b")'), ("!a U b", '!"a" U "b"')]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.peer
def test_storm_agrees_on_models_and_on_policies(tmp_path: Path, seed: int) -> None:
    stormpy = pytest.importorskip("stormpy")
    mdp = random_mdp(seed, n=9, n_actions=2)
    build = getattr(stormpy, "build_model_from_explicit", None) or stormpy.build_sparse_model_from_explicit

    def explicit(model: LabelledMDP):
        tra, lab, *_ = write_explicit(model, tmp_path / "model", style="storm")
        return build(str(tra), str(lab))

    (tmp_path / "model.prism").write_text(to_prism_language(mdp))
    symbolic = stormpy.build_model(stormpy.parse_prism_program(str(tmp_path / "model.prism")))
    for formula, text in FORMULAS:
        best = max_satisfaction_probability(product := Product(mdp, compile(formula)))
        assert storm_says(stormpy, explicit(mdp), f"Pmax=? [{text}]") == pytest.approx(best.probability, abs=1e-5)
        if text.startswith("!"):  # PRISM states that are not reached are not built, so their labels may be missing
            assert storm_says(stormpy, symbolic, f"Pmax=? [{text}]") == pytest.approx(best.probability, abs=1e-5)
        again = storm_says(stormpy, explicit(product_process(product)), f"Pmax=? [{text}]")
        assert again == pytest.approx(best.probability, abs=1e-5)
        policy = product.choice_action[product.choice_start[:-1]]
        ours = satisfaction_probability(product, policy).probability
        chain = explicit(induced_process(product, policy))
        assert storm_says(stormpy, chain, f"P=? [{text}]") == pytest.approx(ours, abs=1e-5)


@pytest.mark.peer
def test_the_thesis_grid_in_the_module_language(tmp_path: Path) -> None:
    stormpy = pytest.importorskip("stormpy")
    (tmp_path / "grid.prism").write_text(to_prism_language(thesis_world(10)))
    model = stormpy.build_model(stormpy.parse_prism_program(str(tmp_path / "grid.prism")))
    text = 'Pmax=? [!"C" U ("A" & (!"C" U ("B" & (!"C" U "T"))))]'
    assert storm_says(stormpy, model, text) == pytest.approx(0.923638, abs=1e-4)


@pytest.mark.parametrize("initial_label", ["read", "skip"])
@pytest.mark.parametrize("scattered", [False, True])
@pytest.mark.peer
def test_storm_agrees_on_what_is_exported(tmp_path: Path, initial_label: str, scattered: bool) -> None:
    stormpy = pytest.importorskip("stormpy")
    mdp = random_mdp(5, n=6, n_actions=2, random_labels=True)
    if scattered:
        mdp = replace(mdp, initial_distribution=np.full(6, 1 / 6))
    formula = "(!a U b) | G F a & F G !b"
    sure, _ = with_sure_labels(mdp)
    product = Product(sure, compile(formula), initial_label=initial_label)
    policy = product.choice_action[product.choice_start[:-1]]
    ours = {
        "model": max_satisfaction_probability(product).probability,
        "policy": satisfaction_probability(product, policy).probability,
    }
    for stem, process in (("model", mdp), ("policy", induced_process(product, policy))):
        files = export_checkable(process, parse(formula), tmp_path, stem, initial_label=initial_label)
        program = stormpy.parse_prism_program(str(files.model))
        (wanted,) = stormpy.parse_properties(files.properties.read_text(), program)
        value = storm_says(stormpy, stormpy.build_model(program, [wanted]), files.properties.read_text())
        assert value == pytest.approx(ours[stem], abs=1e-5)
        assert files.prism == f"prism {files.model} {files.properties}"
