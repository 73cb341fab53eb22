"""Run folders: one training at a time, parts that belong together, and nothing left of what failed or was replaced."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import warnings
from pathlib import Path

import pytest

from ltlc.agents import FittedQConfig
from ltlc.agents.training import folder_lock
from ltlc.agents.training.contents import Content, tables_of
from ltlc.agents.training.folder_lock import LOCK_FILE, locked_folder
from ltlc.agents.training.loop import train
from ltlc.agents.training.run_config import RunConfig
from ltlc.agents.training.run_folder import RunFolder
from ltlc.agents.training.storage import same_tables, tables_to_tensors
from ltlc.cli.app import run
from ltlc.compiler import compile
from ltlc.envs.spec import EnvSpec
from ltlc.errors import FileFormatError, InvalidArgumentError
from ltlc.task import Task

ROOT = Path(__file__).parents[2]
TASK = ("F A", "--env", "ltlc/Thesis5x5-v0", "--steps", "300", "--num-envs", "2", "--quiet", "--out", "here")
posix = pytest.mark.skipif(sys.platform == "win32", reason="POSIX files and signals")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Every test runs in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path / "here"


def a_config(seed: int = 0) -> RunConfig:
    hyperparameters = FittedQConfig(total_steps=200, seed=seed)
    return RunConfig(env_spec=EnvSpec(env="ltlc/Thesis5x5-v0"), num_envs=2, hyperparameters=hyperparameters)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.suffix != ".png"}


class TestLock:
    @pytest.mark.slow
    def test_a_second_training_is_refused(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        automaton = compile("F A")
        with RunFolder.create(folder, a_config(), automaton) as first:
            before = contents(folder)
            for attempt in ([*TASK, "--force", "--seed", "2"], ["--resume", "--out", "here"]):
                assert run(["train", *attempt]) == 2
                error = capsys.readouterr().err
                assert f"here is in use: process {os.getpid()} on " in error and " since 2" in error
            with pytest.raises(InvalidArgumentError, match="in use"):
                RunFolder.create(folder, a_config(1), automaton, force=True)
            with pytest.raises(InvalidArgumentError, match="in use"):
                train(first.vector_env(), FittedQConfig(total_steps=100), folder=folder)
            assert contents(folder) == before
            assert RunFolder.open(folder).id == first.id  # reading is free
        assert not (folder / LOCK_FILE).exists()
        assert run(["train", "--resume", "--out", "here", "--quiet"]) == 0
        assert not (folder / LOCK_FILE).exists()

    @pytest.mark.slow
    @posix
    def test_the_lock_of_a_killed_process_is_none(self, folder: Path) -> None:
        script = "import sys, pathlib\nfrom ltlc.agents.training.folder_lock import locked_folder\n"
        script += "with locked_folder(pathlib.Path('here')): print('locked', flush=True), sys.stdin.read()"
        process = subprocess.Popen(
            [sys.executable, "-c", script],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert process.stdout is not None and process.stdin is not None
        assert process.stdout.readline() == b"locked\n"
        with pytest.raises(InvalidArgumentError, match=f"process {process.pid} on"), locked_folder(folder):
            pass
        process.send_signal(signal.SIGKILL)
        process.communicate()
        assert (folder / LOCK_FILE).exists()
        assert run(["train", *TASK]) == 0
        assert not (folder / LOCK_FILE).exists()

    def test_of_many_at_a_time_one_gets_it(self, folder: Path) -> None:
        held, most = [0], [0]
        refused = []

        def work() -> None:
            for _ in range(50):
                try:
                    with locked_folder(folder):
                        held[0] += 1
                        most[0] = max(most[0], held[0])
                        held[0] -= 1
                except InvalidArgumentError:
                    refused.append(1)

        folder.mkdir()
        workers = [threading.Thread(target=work) for _ in range(8)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        assert most == [1] and held == [0] and len(refused) < 400
        assert list(folder.iterdir()) == []

    def test_a_file_system_without_locks_is_named(self, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        def no_locks(handle: int) -> bool:
            raise OSError(95, "not supported")

        monkeypatch.setattr(folder_lock, "lock_file", no_locks)
        with pytest.warns(UserWarning, match="has no locks"), locked_folder(folder):
            (folder / "file").touch()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            with locked_folder(folder):
                pass
        assert [path.name for path in folder.iterdir()] == ["file"]


class TestParts:
    @pytest.mark.slow
    def test_parts_of_two_runs_are_refused(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["train", *TASK]) == 0
        assert run(["train", *TASK[:-1], "there", "--seed", "1"]) == 0
        assert run(["train", "F B", *TASK[1:-1], "other"]) == 0
        good = contents(folder)
        assert RunFolder.open("here").id != RunFolder.open("there").id
        for source, name in [
            ("there", "policy.ltlc"),
            ("there", "checkpoint.ltlc"),
            ("there", "result.json"),
            ("there", "config.json"),
            ("other", "dra.json"),
        ]:
            (folder / name).write_bytes(Path(source, name).read_bytes())
            for command in (["evaluate", "here"], ["train", "--resume", "--out", "here"], ["train", *TASK, "--resume"]):
                assert run(command) == 2
                assert "do not belong together" in capsys.readouterr().err
            (folder / name).write_bytes(good[name])
        assert run(["evaluate", "here"]) == 0
        assert run(["train", *TASK, "--resume"]) == 0
        assert contents(folder) == good

    def test_a_changed_configuration_is_refused(self, folder: Path) -> None:
        RunFolder.create(folder, a_config(), compile("F A")).close()
        text = (folder / "config.json").read_text()
        (folder / "config.json").write_text(text.replace('"total_steps": 200', '"total_steps": 100'))
        with pytest.raises(FileFormatError, match="one was changed after the run had begun"):
            RunFolder.open(folder)
        (folder / "config.json").write_text(text)
        (folder / "result.json").write_text("[")
        with pytest.raises(FileFormatError, match=r"result\.json is not the verdict of a run"):
            RunFolder.open(folder)

    def test_device_and_threads_are_no_part_of_the_identity(self, folder: Path) -> None:
        with RunFolder.create(folder, a_config(), compile("F A")) as first:
            values = json.loads((folder / "config.json").read_text())
        values["hyperparameters"]["threads"] = 1
        (folder / "config.json").write_text(json.dumps(values))
        assert RunFolder.open(folder).id == first.id


class TestReplacing:
    @pytest.mark.slow
    def test_force_leaves_nothing_of_the_old_run(self, folder: Path) -> None:
        assert run(["train", *TASK]) == 0
        (folder / "events.out.tfevents.1").touch()
        (folder / "notes.txt").touch()
        with RunFolder.create(folder, a_config(), compile("F B"), force=True):
            assert set(contents(folder)) == {"config.json", "dra.json", "notes.txt", LOCK_FILE}

    @pytest.mark.slow
    @posix
    def test_a_kill_while_replacing_leaves_a_run_or_none(self, folder: Path) -> None:
        with RunFolder.create(folder, a_config(), compile("F A")) as first:
            first.train()
        for count in range(12):
            child = os.fork()
            if child == 0:
                calls = [0]

                def counted(original, calls=calls, count=count):  # type: ignore[no-untyped-def]
                    def call(*arguments, **options):  # type: ignore[no-untyped-def]
                        calls[0] += 1
                        if calls[0] > count:
                            os.kill(os.getpid(), signal.SIGKILL)
                        return original(*arguments, **options)

                    return call

                os.unlink, os.replace = counted(os.unlink), counted(os.replace)
                Path.unlink = counted(Path.unlink)  # type: ignore[method-assign]
                RunFolder.create(folder, a_config(7), compile("F B"), force=True)
                os._exit(0)
            _, status = os.waitpid(child, 0)
            assert os.WIFSIGNALED(status) or count >= 10
            try:
                found = RunFolder.open(folder)
            except InvalidArgumentError as error:
                assert "is no run folder" in str(error)  # then nothing of the old run is there but its automaton
                assert set(contents(folder)) <= {"dra.json", LOCK_FILE} | {p.name for p in folder.glob(".ltlc-*")}
            else:
                assert found.config.hyperparameters.seed in (0, 7)
        with RunFolder.create(folder, a_config(7), compile("F B"), force=True):
            assert set(contents(folder)) == {"config.json", "dra.json", LOCK_FILE}

    @posix
    def test_a_full_disk_leaves_the_old_run(self, folder: Path) -> None:
        import resource

        RunFolder.create(folder, a_config(), compile("F A")).close()
        before = contents(folder)
        limit = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(resource.RLIMIT_FSIZE, (300, limit[1]))
        try:
            with pytest.raises(OSError, match="too large") as failure:
                RunFolder.create(folder, a_config(), compile("F A"), force=True)
            assert str(failure.value.filename).startswith(str(folder))
            with pytest.raises(OSError, match="too large"):
                RunFolder.create(folder.with_name("fresh") / "one", a_config(), compile("F A"))
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        assert contents(folder) == before
        assert not folder.with_name("fresh").exists()

    @pytest.mark.slow
    def test_files_of_others_are_not_overwritten(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        folder.mkdir()
        for name in ("metrics.csv", "dra.json"):
            (folder / name).write_text("mine")
            assert run(["train", *TASK]) == 2
            assert f"here holds no training run, but {name}" in capsys.readouterr().err
            assert contents(folder) == {name: b"mine"}
            (folder / name).unlink()
        compile("F A").save(folder / "dra.json")  # as a kill right after the beginning leaves it
        (folder / "notes.txt").touch()
        assert run(["train", *TASK]) == 0


class TestPlaces:
    @pytest.mark.slow
    @pytest.mark.parametrize("name", ["with blanks", "größer ∧ schöner", "a/b/c", "-x"])
    def test_names(self, name: str) -> None:
        assert run(["train", *TASK[:-2], f"--out={name}"]) == 0
        assert run(["evaluate", "--", name]) == 0
        assert run(["train", "--resume", f"--out={name}", "--quiet"]) == 0

    @pytest.mark.slow
    @posix
    def test_links(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        folder.symlink_to("nowhere")
        assert run(["train", *TASK]) == 2
        assert "here is a link that leads nowhere" in capsys.readouterr().err
        Path("nowhere").mkdir()
        assert run(["train", *TASK]) == 0
        assert folder.is_symlink() and Path("nowhere/policy.ltlc").exists()

    @pytest.mark.skipif(not Path("/proc/self").exists(), reason="a place where nothing can be made")
    def test_a_read_only_place(self, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["train", *TASK[:-1], "/proc/self/here"]) == 2
        assert "ltlc: /proc/self/here: " in capsys.readouterr().err

    @pytest.mark.slow
    def test_resume_with_nothing(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        assert run(["train", "--resume", "--out", "here"]) == 2
        assert "here is no run folder" in capsys.readouterr().err
        assert not folder.exists()
        assert run(["train", "--resume"]) == 2
        assert run(["train", *TASK, "--resume"]) == 0
        assert "here holds no run to go on with; a new one begins" in capsys.readouterr().err
        assert RunFolder.open("here").load() is not None


@pytest.mark.slow
@posix
def test_killed_commands_end_in_the_same_bytes(tmp_path: Path) -> None:
    """The benchmark, with few kills; it runs apart, since it forks."""
    script = ROOT / "benchmarks" / "kill.py"
    command = [sys.executable, str(script), "--kills", "5", "--only", "table", "batch", "--json", str(tmp_path / "out")]
    done = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    counts = json.loads((tmp_path / "out").read_text())
    assert sum(count["kills"] for count in counts) == 5


def test_tables_in_files_of_earlier_versions_are_read() -> None:
    tables = Task("F G a | F G b", reward="eventual").tables
    assert tables.n_choices == 1
    values = tables_to_tensors(tables)
    values["commit"] = values.pop("select_pair")
    assert same_tables(tables_of(Content(values, "policy.pt")), tables)
