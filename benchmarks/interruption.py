"""Kills runs of model 1, resumes them, and compares their results with those of a run that nobody stopped.

`make kill` writes the table into docs/interruption.md. Each run is a process of its own, forked from this one, which
has imported the package and nothing else. The moments are drawn from a fixed seed; what a run does then depends on the
machine. Compared are the bytes of all files but summary.json, which holds times of the clock.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from shutil import rmtree

from membrane_rs._markdown import table
from membrane_rs.cli import app
from membrane_rs.results import read_summary
from page import DOCS, MarkedPart

PART = MarkedPart(DOCS / "interruption.md", "interruption.md")
SECONDS = 600.0
"""After which a process that neither ends nor comes to where it is to be killed is an error."""
ENDING = (signal.SIGKILL, signal.SIGTERM)
COMMAND = ["run", "okuizumi-model-1", "--integrator", "leapfrog"]
COMMAND += ["--until", "0.004", "--frames", "41", "--checkpoint", "0.05"]


@dataclass(frozen=True)
class Moment:
    """When a run is killed: after some of its life, drawn evenly, and then as soon as a file is there."""

    name: str
    kills: int
    file: str = ""
    """Pattern of the file, in the folder of the run; empty: at once."""
    in_a_row: int = 1
    """Kills of one run, each after it was resumed."""
    words: tuple[str, ...] = ("--no-pictures",)


MOMENTS = (
    Moment("at any moment", 80),
    Moment("while a frame is written", 40, "frames/*.part"),
    Moment("while a checkpoint is written", 40, "state.npz.part"),
    Moment("five times in a row", 20, "summary.json", in_a_row=5),
    Moment("while pictures are drawn", 20, "snapshots/*.png", words=()),
)


@dataclass
class Tally:
    """What was found of one moment and signal."""

    kills: int = 0
    before: int = 0
    """Killed before the folder held a run, which was begun again."""
    ended: int = 0
    """Ended before the signal came."""
    runs: int = 0
    equal: int = 0
    differing: list[str] = field(default_factory=list)


Found = dict[tuple[str, str], Tally]
"""By the name of the moment and that of the signal."""


def begin(words: Sequence[object]) -> int:
    """Begin a command in a process of its own. Returns its pid."""
    sys.stdout.flush()
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        with Path(os.devnull).open("r+b") as nothing:
            for stream in (1, 2):
                os.dup2(nothing.fileno(), stream)
        app([str(word) for word in words], standalone_mode=True)
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 1
    finally:
        os._exit(code)


def end_of(pid: int) -> int:
    """Wait for a process. Returns its exit code, or minus the number of the signal that killed it."""
    return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])


def is_over(pid: int) -> bool:
    """Whether a process has ended; it is not waited for."""
    return os.waitid(os.P_PID, pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None


def kill(pid: int, signum: int, delay: float, folder: Path, file: str) -> int:
    """Send a signal after `delay` [s], once `file` is there. Returns the exit code of the process."""
    deadline = time.monotonic() + SECONDS
    until = time.monotonic() + delay
    while not is_over(pid) and (time.monotonic() < until or not (any(folder.glob(file)) if file else True)):
        if time.monotonic() > deadline:
            os.kill(pid, signal.SIGKILL)
            raise SystemExit(f"{folder}: the run did not come to {file}")
        time.sleep(0.0 if time.monotonic() > until else 0.001)
    os.kill(pid, signum)
    return end_of(pid)


def contents(folder: Path) -> dict[str, bytes]:
    """The bytes of all files of a run but its summary."""
    files = (file for file in folder.rglob("*") if file.is_file() and file.name != "summary.json")
    return {str(file.relative_to(folder)): file.read_bytes() for file in files}


def differences(folder: Path, reference: Path) -> list[str]:
    """Files that differ, or are there in one folder alone; and a summary that does not say "finished"."""
    found, wanted = contents(folder), contents(reference)
    different = [name for name in sorted(found.keys() | wanted.keys()) if found.get(name) != wanted.get(name)]
    outcome = read_summary(folder)["outcome"]
    return different + ([] if outcome == "finished" else [f"summary.json: {outcome}"])


@dataclass
class Trial:
    """Runs of one command, killed at one moment by one signal."""

    command: Sequence[object]
    """Without its folder."""
    moment: Moment
    signum: int
    begun: float
    """After what time the folder of the run that nobody stops holds a run [s]; half of it is the first moment."""
    life: float
    """After what time that run ends [s]."""
    chance: random.Random
    tally: Tally = field(default_factory=Tally)

    def interrupt(self, folder: Path) -> None:
        """Run into `folder`, kill, resume, until the run has ended. Raises SystemExit where that fails."""
        moment, tally = self.moment, self.tally
        command = [*self.command, folder]
        pid = begin(command)
        for _ in range(moment.in_a_row):
            span = (self.life - self.begun / 2) * min(1.0, 2.0 / moment.in_a_row)
            delay = self.begun / 2 + self.chance.uniform(0.0, span)
            code = kill(pid, self.signum, delay, folder, moment.file)
            tally.kills += 1
            tally.ended += code == 0
            if not (folder / "summary.json").is_file():
                tally.before += 1
                pid = begin([*command, "--overwrite"])
            else:
                pid = begin(["resume", folder])
        if (code := end_of(pid)) != 0:
            raise SystemExit(f"{folder}: the run that was killed {moment.name} ended with code {code} when resumed")


def measured(moments: Sequence[Moment], command: Sequence[object], place: Path, seed: int) -> Found:
    """Kill runs at all moments by all signals, in turn, and compare each with one that nobody stopped."""
    chance, found = random.Random(seed), {}
    for moment in moments:
        whole = [*command, *moment.words, "--out"]
        reference, folder = place / f"reference {moment.name}", place / "run"
        start = time.monotonic()
        pid = begin([*whole, reference])
        while not is_over(pid) and not (reference / "summary.json").exists():
            time.sleep(0.001)
        begun = time.monotonic() - start
        if (code := end_of(pid)) != 0:
            raise SystemExit(f"the run that nobody stops ended with code {code}")
        life = time.monotonic() - start
        for signum in ENDING:
            trial = Trial(whole, moment, signum, begun, life, chance)
            tally = found[moment.name, signal.Signals(signum).name] = trial.tally
            while tally.kills < moment.kills // len(ENDING):
                rmtree(folder, ignore_errors=True)
                trial.interrupt(folder)
                different = differences(folder, reference)
                tally.runs += 1
                tally.equal += not different
                tally.differing += different
            print(f"{moment.name}, {signal.Signals(signum).name}: {tally}", file=sys.stderr, flush=True)
    return found


def page(tallies: Found) -> str:
    """The table, and what differs."""
    head = ("killed", "by", "kills", "before the folder held a run", "after the end", "runs resumed", "same bits")
    rows = [
        (*where, tally.kills, tally.before, tally.ended, tally.runs, tally.equal) for where, tally in tallies.items()
    ]
    columns = list(zip(*(row[2:] for row in rows), strict=True))
    total = ("all", "", *(sum(column) for column in columns))
    differing = sorted({name for tally in tallies.values() for name in tally.differing})
    text = f"Different files: {', '.join(differing) or 'none'}.\n"
    return table(head, [tuple(map(str, row)) for row in (*rows, total)], words=(0, 1)) + "\n" + text


def main() -> None:
    """Kill, resume, compare; exit code 1 where a bit differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--write", action="store_true", help="put the table into docs/interruption.md")
    parser.add_argument("--quick", action="store_true", help="few kills of a small scene, without pictures")
    parser.add_argument("--share", type=float, default=1.0, help="share of the kills, where time is short")
    parser.add_argument("--seed", type=int, default=1, help="of the moments")
    chosen = parser.parse_args()
    moments = [replace(m, kills=max(2 * m.in_a_row, round(m.kills * chosen.share))) for m in MOMENTS]
    command = COMMAND
    if chosen.quick:
        moments = [replace(m, kills=2 * m.in_a_row) for m in MOMENTS[:4]]
        command = ["run", "single-crease", *COMMAND[4:]]
    with tempfile.TemporaryDirectory() as place:
        found = measured(moments, command, Path(place), chosen.seed)
    text = page(found)
    print(text)
    if chosen.write:
        PART.write(text)
    if any(tally.equal < tally.runs for tally in found.values()):
        raise SystemExit("some results differ from those of the run that nobody stopped")


if __name__ == "__main__":
    main()
