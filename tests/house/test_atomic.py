"""Files that are complete or not there: what kills, full disks, devices and closed streams leave behind."""

from __future__ import annotations

import os
import signal
import stat
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from ltlc import atomic
from ltlc.atomic import atomic_write, atomic_write_all, is_at, lock_file, remove_leftovers
from ltlc.cli.app import run

ROOT = Path(__file__).parents[2]
posix = pytest.mark.skipif(sys.platform == "win32", reason="POSIX files and signals")


@pytest.fixture(params=["unnamed", "named", "unlinkable"])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """The ways to a temporary file: of systems with files that have no name, without, and where naming them fails."""
    way: str = request.param

    def link(*_: object, **__: object) -> None:
        raise OSError(1, "no links here")

    if way == "named":
        monkeypatch.setattr(atomic, "_open_temporary", atomic._open_named)
    if way == "unlinkable":
        monkeypatch.setattr(os, "link", link)
    return way


def test_every_way_writes_the_same(way: str, tmp_path: Path) -> None:
    target = tmp_path / "a file, ü"
    for content in (b"one", b"two and more"):
        assert atomic_write(target, content) == target
        assert target.read_bytes() == content
        assert list(tmp_path.iterdir()) == [target]


@posix
@pytest.mark.parametrize("moment", ["fsync", "replace"])
def test_a_killed_write_leaves_nothing_after_the_next(way: str, moment: str, tmp_path: Path) -> None:
    (tmp_path / "old").write_text("old")
    child = os.fork()
    if child == 0:
        setattr(os, moment, lambda *_: os.kill(os.getpid(), signal.SIGKILL))
        atomic_write(tmp_path / "old", "new")
    _, status = os.waitpid(child, 0)
    assert os.WTERMSIG(status) == signal.SIGKILL
    left = {path.name for path in tmp_path.iterdir()} - {"old"}
    assert len(left) <= 1 and (tmp_path / "old").read_text() == "old"
    if way == "unnamed" and moment == "fsync" and sys.platform == "linux":
        assert not left
    atomic_write(tmp_path / "other", "other")
    assert {path.name for path in tmp_path.iterdir()} == {"old", "other"}


@posix
def test_the_temporary_file_of_a_living_process_stays(tmp_path: Path) -> None:
    handle, name = atomic._open_named(tmp_path)
    (tmp_path / ".ltlc-0123456789abcdef.tmp").touch()
    (tmp_path / ".ltlc-of-the-user.tmp").touch()
    remove_leftovers(tmp_path)
    assert {str(path) for path in tmp_path.iterdir()} == {name, str(tmp_path / ".ltlc-of-the-user.tmp")}
    os.close(handle)
    remove_leftovers(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [".ltlc-of-the-user.tmp"]
    remove_leftovers(tmp_path / "nowhere")


@posix
def test_a_lock_ends_with_its_process(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    script = f"""
        import os, sys
        from ltlc.atomic import lock_file
        print(lock_file(os.open({str(path)!r}, os.O_RDWR | os.O_CREAT)), flush=True)
        sys.stdin.read()
    """
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None and process.stdout.readline() == "True\n"
        handle = os.open(path, os.O_RDWR)
        assert not lock_file(handle)
        process.kill()
        process.wait()
    assert lock_file(handle) and is_at(handle, path)
    path.unlink()
    assert not is_at(handle, path)
    os.close(handle)


def test_of_several_files_none_is_written_if_one_fails(way: str, tmp_path: Path) -> None:
    old, gone = tmp_path / "old", tmp_path / "gone"
    old.write_text("old")
    gone.write_text("gone")
    with pytest.raises(FileNotFoundError) as failure:
        atomic_write_all({old: "new", tmp_path / "no" / "b": "new"}, instead_of=[gone])
    assert failure.value.filename == str(tmp_path / "no" / "b")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old": "old", "gone": "gone"}
    atomic_write_all({old: "new", tmp_path / "b": b"new"}, instead_of=[gone, tmp_path / "never"])
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old": "new", "b": "new"}


@posix
def test_a_pipe_or_a_device_is_written_to(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.hoa")
    reader = os.open(tmp_path / "pipe.hoa", os.O_RDONLY | os.O_NONBLOCK)
    atomic_write(tmp_path / "pipe.hoa", "content")
    assert os.read(reader, 100) == b"content"
    os.close(reader)
    assert stat.S_ISFIFO((tmp_path / "pipe.hoa").stat().st_mode)
    (tmp_path / "null").symlink_to(os.devnull)
    atomic_write(tmp_path / "null", "content")
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)
    with pytest.raises(IsADirectoryError) as failure:
        atomic_write(tmp_path, "content")
    assert failure.value.filename == str(tmp_path)


@posix
def test_a_full_disk(way: str, tmp_path: Path) -> None:
    import resource

    (tmp_path / "old").write_text("old")
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match="too large") as failure:
            atomic_write_all({tmp_path / "new": "new", tmp_path / "old": "x" * 2000})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert failure.value.filename == str(tmp_path / "old")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"old": "old"}


def command(line: str, cwd: Path) -> tuple[int, str]:
    """Exit code and standard error of `ltlc`, run by a shell."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        f"{sys.executable} -m ltlc {line}",
        shell=True,
        cwd=cwd,
        env=environment,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    return done.returncode, done.stderr


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="/dev/full")
@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("compile 'F a' --format hoa >/dev/full", "standard output: No space left on device; free some space"),
        ("compile 'F a' >/dev/full", "standard output: No space left on device; free some space"),
        ("--help >/dev/full", "standard output: No space left on device; free some space"),
        ("compile 'F a' >&-", "standard output: Bad file descriptor"),
        ("compile - <&-", "standard input: Bad file descriptor"),
        ("compile -F - <&-", "standard input: Bad file descriptor"),
        ("check 'F a' -w - <&-", "standard input: Bad file descriptor"),
        ("compile 'F a' -o a.json -o full.hoa", "full.hoa: No space left on device; free some space"),
        ("compile -F formulas -o full.hoa", "full.hoa: No space left on device; free some space"),
    ],
)
def test_streams_that_are_closed_or_full(line: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "full.hoa").symlink_to("/dev/full")
    (tmp_path / "formulas").write_text("F a\nG b\n")
    code, error = command(line, tmp_path)
    assert code == 2 and error.startswith(f"ltlc: {message}") and error.count("\n") == 1


@pytest.mark.slow
@posix
def test_closed_standard_error_stays_out_of_other_files(tmp_path: Path) -> None:
    code, _ = command("compile 'F (' -o a.json >out 2>&-", tmp_path)
    assert code == 2 and (tmp_path / "out").read_text() == ""


@pytest.mark.parametrize(
    "arguments",
    [
        ["compile", "F a", "-o", ""],
        ["compile", "F a", "-o", "a.json", "-o", " "],
        ["compile", "-F", ""],
        ["train", "F a", "--env", "ltlc/Thesis5x5-v0", "--out", ""],
        ["train", "--resume", "--out", ""],
        ["evaluate", ""],
        ["solve", "F A", "--env", "ltlc/Thesis5x5-v0", "--prism", ""],
        ["solve", "F A", "--env", "ltlc/Thesis5x5-v0", "-o", ""],
        ["faithful", "F A", "--env", "ltlc/Thesis5x5-v0", "-o", ""],
        ["reproduce", "case1", "--out", ""],
    ],
)
def test_an_empty_path_is_no_default(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(arguments) == 2
    assert "is empty; give a path" in capsys.readouterr().err
    assert not any(tmp_path.iterdir())
