"""Registries: built-in, registered, offered by installed packages, and named by module."""

from __future__ import annotations

import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

import ltlc
from ltlc.errors import InvalidArgumentError, UnknownNameError
from ltlc.registry import Registry, import_object, import_plugins


def numbers() -> Registry[int]:
    def check(name: str, part: object) -> int:
        if not isinstance(part, int):
            raise InvalidArgumentError(f"{name} is no number")
        return part

    return Registry[int]("number", "ltlc.test-numbers", check)


def test_parts_keep_their_order_and_are_imported_when_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    parts = numbers()
    parts.register("late", "not_written_yet:five")
    parts.register("one", 1)
    assert list(parts) == ["late", "one"]
    assert len(parts) == 2
    Path("not_written_yet.py").write_text("five = 5\n")
    assert (parts["late"], parts["one"]) == (5, 1)


def test_decorator() -> None:
    parts: Registry[type] = Registry("class", "ltlc.test-classes")

    @parts.register("mine")
    class Mine:
        pass

    assert parts["mine"] is Mine
    parts.remove("mine")
    assert "mine" not in parts


@pytest.mark.parametrize("name", ["", "a:b", " x", "one"])
def test_names_that_cannot_be(name: str) -> None:
    parts = numbers()
    parts.register("one", 1)
    with pytest.raises(InvalidArgumentError):
        parts.register(name, 2)


def test_a_part_is_checked_however_it_comes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("half.py").write_text("x = 0.5\nn = 7\n")
    parts = numbers()
    assert parts["half:n"] == parts["half.py:n"] == 7
    for name in ("half:x", "half.py:x"):
        with pytest.raises(InvalidArgumentError, match="is no number"):
            parts[name]
    with pytest.raises(InvalidArgumentError, match="is no number"):
        parts.register("x", 0.5)  # type: ignore[call-overload]


def test_unknown_names_suggest_the_nearest() -> None:
    parts = numbers()
    parts.register("seven", 7)
    with pytest.raises(UnknownNameError, match="Did you mean seven"):
        parts["sevn"]


def test_entry_points_of_installed_packages(monkeypatch: pytest.MonkeyPatch) -> None:
    offered = [
        EntryPoint("ten", "string:digits.__len__", "ltlc.test-numbers"),
        EntryPoint("broken", "no_such_module:x", "ltlc.test-numbers"),
    ]
    monkeypatch.setattr("importlib.metadata.entry_points", lambda group: offered * (group == "ltlc.test-numbers"))
    parts: Registry[object] = Registry("number", "ltlc.test-numbers")
    assert list(parts) == ["ten", "broken"]
    assert parts["ten"]() == 10  # type: ignore[operator]
    with pytest.raises(InvalidArgumentError, match="no_such_module:x cannot be loaded"):
        parts["broken"]


@pytest.mark.parametrize(
    ("source", "text", "message"),
    [
        ("", "odd", "expected module:name"),
        ("", "no_such_module_here:x", "no module no_such_module_here"),
        ("import no_such_module_here", "odd:x", "importing odd fails"),
        ("raise SystemExit(0)", "odd:x", "importing odd fails"),
        ("1 / 0", "odd.py:x", "ZeroDivisionError"),
        ("labels = 1", "odd.py:lable", "Did you mean labels"),
    ],
)
def test_what_cannot_be_imported(
    source: str, text: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("odd.py").write_text(source + "\n")
    with pytest.raises(InvalidArgumentError, match=message):
        import_object(text, "part")


def test_modules_that_the_environment_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("plugin_one", "plugin_two"):
        Path(f"{name}.py").write_text("")
    monkeypatch.setenv("LTLC_PLUGINS", "plugin_one, plugin_two,")
    import_plugins()
    assert {"plugin_one", "plugin_two"} <= set(sys.modules)
    monkeypatch.setenv("LTLC_PLUGINS", "plugin_three")
    with pytest.raises(InvalidArgumentError, match="LTLC_PLUGINS: there is no module plugin_three"):
        import_plugins()


def test_unknown_names_in_the_library() -> None:
    with pytest.raises(UnknownNameError, match=r"unknown proposition 'goa1'. Did you mean goal"):
        ltlc.compile("F goal").step(0, {"goa1"})
    with pytest.raises(UnknownNameError, match=r"unknown translator 'atuo'. Did you mean auto"):
        ltlc.compile("F goal", translator="atuo")
