"""Plain command lines are read as typer reads them."""

from __future__ import annotations

import random
from collections.abc import Callable
from functools import wraps
from typing import Any, get_args

import pytest
import typer

from ltlc.cli.app import run
from ltlc.cli.commands import COMMANDS, command_of
from ltlc.cli.options import parameters_of, read
from ltlc.cli.typer_app import _for_typer

WORDS = ("a", "F a", "-", "--", "-1", "0", "1", "2.5", "1_0", "nan", "", " ", "x.json", "-h", "--help", "--nonsense")


def recorder(command: Callable[..., object], calls: list[dict[str, Any]]) -> Callable[..., object]:
    """A command that only notes what it is called with."""

    @wraps(command)
    def called(**values: Any) -> None:
        calls.append(values)

    return called


def by_typer(command: Callable[..., object]) -> Callable[[list[str]], dict[str, Any] | None]:
    calls: list[dict[str, Any]] = []
    app = typer.Typer()
    app.command()(_for_typer(recorder(command, calls)))
    group = typer.main.get_command(app)

    def values(words: list[str]) -> dict[str, Any] | None:
        calls.clear()
        try:
            group.main(words, prog_name="ltlc", standalone_mode=False)
        except Exception:
            return None
        return calls[0] if calls else None

    return values


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_as_typer(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    command = command_of(name)
    options, choices = [], []
    for _, kind, description in parameters_of(command):
        options += [(kind, each) for each in getattr(description, "names", ())]
        choices += [each for part in (kind, *get_args(kind)) for each in get_args(part) if isinstance(each, str)]
    expected, rng, understood = by_typer(command), random.Random(name), 0
    for _ in range(150):
        words: list[str] = []
        for _ in range(rng.randint(0, 4)):
            if options and rng.random() < 0.6:
                kind, option = rng.choice(options)
                value = [] if kind is bool and rng.random() < 0.9 else [rng.choice((*WORDS, *choices))]
                words += [f"{option}={value[0]}"] if value and rng.random() < 0.1 else [option, *value]
            else:
                words.append(rng.choice((*WORDS, *choices)))
        found = read(command, words)
        if found is not None:
            understood += 1
            said = expected(words)
            assert repr(found) == repr(said), words  # nan is not nan
    assert understood
    capsys.readouterr()


def test_what_is_plain() -> None:
    compile_ = command_of("compile")
    given = read(compile_, ["F a", "-o", "x.json", "-o", "-", "--max-states", "7", "--finite"])
    assert given is not None
    assert (given["formula"], given["output"], given["max_states"], given["finite"]) == (
        "F a",
        ["x.json", "-"],
        7,
        True,
    )
    assert (given["form_"], given["timeout"]) == ("rabin", None)


@pytest.mark.parametrize("words", [
    ["F a", "G a"],
    ["F a", "--form"],
    ["F a", "--form", "none"],
    ["F a", "--form=buchi"],
    ["F a", "--max-states", "many"],
    ["F a", "-o", ""],
    ["F a", "--help"],
    ["-ox.json", "F a"],
    ["--", "F a"],
])  # fmt: skip
def test_what_typer_has_to_say(words: list[str]) -> None:
    assert read(command_of("compile"), words) is None


def test_numbers_have_a_least_one_and_some_values_are_needed() -> None:
    sweep = command_of("sweep")
    assert read(sweep, ["grid.toml", "-j", "1"]) is not None
    assert read(sweep, ["grid.toml", "-j", "0"]) is None
    assert read(sweep, ["-j", "1"]) is None


def test_the_errors_are_those_of_typer(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "F a", "--max-states", "many"]) == 2
    assert "'many' is not a valid int" in capsys.readouterr().err
    assert run(["compile", "F a", "-o", " "]) == 2
    assert "--output is empty; give a path" in capsys.readouterr().err
