"""Kill commands at random moments, and compare what they leave and end in with a run that nobody killed.

    python benchmarks/kill.py [--kills 100] [--seed 0] [--only compile batch table network q-learning] [--json FILE]

Training is killed, resumed, killed again, until it gets to its end; every file but the seconds must then have the bytes
of the run that was never killed. After every kill each file must be absent or complete. POSIX only: processes are
forked, so that moments are spread over the work and not over the start of Python.
"""

from __future__ import annotations

import argparse
import importlib
import json
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # forks and threads do not go together

import ltlc
from ltlc.agents.training.folder_lock import LOCK_FILE
from ltlc.agents.training.metrics import TIMES_FILE
from ltlc.agents.training.run_folder import RunFolder
from ltlc.agents.training.storage import read_file
from ltlc.cli.app import run
from ltlc.errors import InvalidArgumentError

_WORLD = ("!C U (A & (!C U B))", "--env", "ltlc/Thesis5x5-v0", "--quiet")
_PACE = ("--num-envs", "4", "--episode-steps", "50", "--hyper", "checkpoint_every=250", "--hyper", "log_every=100")
_NETWORK = ("--hyper", "hidden=[16]", "--hyper", "batch_size=32", "--hyper", "learning_starts=64")
TRAINING = {
    "table": (*_WORLD, *_PACE, "--steps", "3000"),
    "network": (*_WORLD, *_PACE, *_NETWORK, "--steps", "2000", "--hyper", "buffer_size=1000"),
    "q-learning": (*_WORLD, "--agent", "q-learning", "--steps", "4000"),
}
_FORMULA = "G(a -> F b) & G(c -> F d) & (F e | G h)"
_FORMULAS = "".join(f"F (a{i} & F b) & G (c -> F a{i})\n" for i in range(60))
_AT_ONCE = 6
"""kills before a training is left alone until its end."""


@dataclass
class Count:
    """What became of the kills of one command."""

    command: str
    kills: int = 0
    """processes that were killed at work; the others had ended before."""
    half_files: int = 0
    """files that were neither absent nor complete after a kill."""
    leftovers: int = 0
    """files that should not be there at the end, or after the next run of the same command."""
    leftovers_at_once: int = 0
    """temporary files right after a kill, which the next write removes."""
    ends: int = 0
    """runs that came to their end in spite of kills."""
    other_bytes: int = 0
    """files at the end that differ from those of a run that nobody killed."""

    @property
    def good(self) -> bool:
        """Whether nothing was lost."""
        return self.half_files == self.leftovers == self.other_bytes == 0 and self.ends > 0


def begin(arguments: Sequence[str]) -> int:
    """Run a command in a process of its own, silently; gives its id."""
    child = os.fork()
    if child:
        return child
    code = 70
    try:
        silence = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silence, 1)
        os.dup2(silence, 2)
        code = run(arguments)
    finally:
        os._exit(code)


def finish(arguments: Sequence[str]) -> float:
    """Run a command to its end; gives the seconds it took.

    Raises:
        RuntimeError: it failed.
    """
    since = time.perf_counter()
    _, status = os.waitpid(begin(arguments), 0)
    if status:
        raise RuntimeError(f"ltlc {' '.join(arguments)} ended with {os.waitstatus_to_exitcode(status)}")
    return time.perf_counter() - since


def kill(arguments: Sequence[str], seconds: float) -> bool:
    """Run a command and kill it after some seconds; False if it ended before.

    Raises:
        RuntimeError: it failed.
    """
    child = begin(arguments)
    time.sleep(seconds)
    os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    if not os.WIFSIGNALED(status) and os.waitstatus_to_exitcode(status):
        raise RuntimeError(f"ltlc {' '.join(arguments)} ended with {os.waitstatus_to_exitcode(status)}")
    return os.WIFSIGNALED(status)


def files(folder: Path) -> dict[str, bytes]:
    """The contents of a folder."""
    return {path.name: path.read_bytes() for path in folder.iterdir()} if folder.exists() else {}


def kill_training(name: str, kills: int, rng: random.Random, place: Path) -> Count:
    """Kill and resume `ltlc train`."""
    count, command = Count(f"train ({name})"), ("train", *TRAINING[name])
    longest = finish([*command, "--out", str(place / "whole")])
    whole = files(place / "whole")
    while count.kills < kills:
        folder = place / f"cut-{count.ends}"
        again = [*command, "--resume", "--out", str(folder)]
        for _ in range(min(_AT_ONCE, kills - count.kills)):
            count.kills += kill(again, rng.uniform(0, longest))
            count.half_files += _half_files_of_run(folder)
            count.leftovers_at_once += len(list(folder.glob(".ltlc-*")))
        finish(again)
        ended = files(folder)
        count.ends += 1
        count.leftovers += len(ended.keys() - whole.keys())
        count.other_bytes += sum(ended.get(file) != whole[file] for file in whole if file != TIMES_FILE)
    return count


def _half_files_of_run(folder: Path) -> int:
    """Files of a run folder that cannot be read; of a run that has not begun, none is to be there but the automaton."""
    try:
        RunFolder.open(folder).metrics()
    except InvalidArgumentError:
        return len(files(folder).keys() - {"dra.json", LOCK_FILE} - {path.name for path in folder.glob(".ltlc-*")})
    except FileNotFoundError:  # no metrics yet
        pass
    except ltlc.LtlcError:
        return 1
    bad = 0
    for path in folder.glob("*.ltlc"):
        kind = path.read_bytes().split(b" ", 2)[1].decode()
        try:
            read_file(path, kind)
        except ltlc.LtlcError:
            bad += 1
    return bad


def kill_writing(
    name: str, arguments: Sequence[str], targets: Sequence[str], kills: int, rng: random.Random, place: Path
) -> Count:
    """Kill a command that writes files, some of which are there already with other contents."""
    count = Count(name)
    outputs = {target: place / target for target in targets}
    command = [*arguments, *(f"-o{path}" for path in outputs.values())]
    longest = max(finish(command) for _ in range(3))
    whole = files(place)
    old = whole[targets[0]].swapcase()
    while count.kills < kills:
        for path in outputs.values():
            path.unlink(missing_ok=True)
        outputs[targets[0]].write_bytes(old)
        killed = kill(command, rng.uniform(0, 1.1 * longest))
        count.kills += killed
        left = files(place)
        temporary = {file for file in left if file.startswith(".ltlc-")}
        count.leftovers_at_once += len(temporary)
        count.leftovers += len(left.keys() - whole.keys() - temporary)
        allowed = {target: {None, whole[target]} for target in targets} | {targets[0]: {old, whole[targets[0]]}}
        count.half_files += sum(left.get(target) not in allowed[target] for target in targets)
        if killed:
            finish(command)
            ended = files(place)
            count.ends += 1
            count.leftovers += len(ended.keys() - whole.keys())
            count.other_bytes += sum(ended.get(file) != whole[file] for file in whole)
    return count


def kill_compile(kills: int, rng: random.Random, place: Path) -> Count:
    """Kill `ltlc compile` with several outputs."""
    targets = ("dra.json", "dra.hoa", "dra.dot", "dra.md")
    return kill_writing("compile -o", ["compile", _FORMULA, "--json"], targets, kills, rng, place)


def kill_batch(kills: int, rng: random.Random, place: Path) -> Count:
    """Kill `ltlc compile -F`."""
    (place / "formulas.txt").write_text(_FORMULAS)
    arguments = ["compile", "-F", str(place / "formulas.txt"), "--effort", "fast"]
    return kill_writing("compile -F", arguments, ("automata.hoa", "copy.hoa"), kills, rng, place)


COMMANDS: dict[str, Callable[[int, random.Random, Path], Count]] = {
    "compile": kill_compile,
    "batch": kill_batch,
    **{
        name: lambda kills, rng, place, name=name: kill_training(name, kills, rng, place)  # type: ignore[misc]
        for name in TRAINING
    },
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=100, help="in all")
    parser.add_argument("--seed", type=int, default=0, help="of the moments")
    parser.add_argument("--only", choices=COMMANDS, nargs="+", default=list(COMMANDS))
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the counts too")
    options = parser.parse_args()

    for module in (
        "ltlc.agents.training.artifacts",
        "ltlc.translate",
        "matplotlib.figure",
        "matplotlib.backends.backend_agg",
    ):
        importlib.import_module(module)  # once, and not in each process
    print("command             kills  half files  leftovers  (at once)  ends  other bytes", flush=True)
    counts = []
    for number, name in enumerate(options.only):
        share = options.kills // len(options.only) + (number < options.kills % len(options.only))
        with tempfile.TemporaryDirectory() as folder:
            count = COMMANDS[name](share, random.Random(f"{options.seed} {name}"), Path(folder))
        counts.append(count)
        figures = f"{count.kills:6} {count.half_files:11} {count.leftovers:10} {count.leftovers_at_once:10}"
        print(f"{count.command:18} {figures} {count.ends:5} {count.other_bytes:12}", flush=True)
    if options.json:
        options.json.write_text(json.dumps([asdict(count) for count in counts], indent=2) + "\n", encoding="utf-8")
    sys.exit(not all(count.good for count in counts))


if __name__ == "__main__":
    main()
