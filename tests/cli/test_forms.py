"""`ltlc compile --form`."""

from __future__ import annotations

import pytest

from ltlc.cli.app import run


@pytest.mark.parametrize(
    ("form", "name"), [("parity", "parity max odd 2"), ("buchi", "Buchi"), ("rabin", "Rabin 1"), ("co-buchi", None)]
)
def test_forms(form: str, name: str | None, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "G F a", "--form", form, "--format", "hoa"]) == (2 if name is None else 0)
    out, err = capsys.readouterr()
    assert f"acc-name: {name}\n" in out or "it is no persistence property" in err


def test_errors(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compile", "F a", "--finite", "--form", "buchi"]) == 2
    assert "--form is about infinite words" in capsys.readouterr().err
    assert run(["compile", "F a", "--form", "streett"]) == 2
    assert "'streett'" in capsys.readouterr().err
