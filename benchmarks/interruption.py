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


FRAME, CHECKPOINT = "frames/*.part", "state.npz.part"
"""Files that are there while a frame or a checkpoint is written, in the folder of a run."""
MOST = 20
"""Kills for each that is to hit a run, after which the run counts as too short to be hit."""


@dataclass(frozen=True)
class Moment:
    """When a run is killed: after some time, drawn evenly, and then as soon as a file is there."""

    name: str
    hits: int
    """Kills that hit a run, by all signals together."""
    file: str = ""
    """Pattern of the file, in the folder of the run; empty: at once, and the time counts from the start of the process,
    not from that of the run.
    """
    in_a_row: int = 1
    """Kills of one run, each after it was resumed."""
    words: tuple[str, ...] = ("--no-pictures",)


MOMENTS = (
    Moment("at any moment", 60),
    Moment("while a frame is written", 40, FRAME),
    Moment("while a checkpoint is written", 40, CHECKPOINT),
    Moment("five times in a row", 40, "summary.json", in_a_row=5),
    Moment("while pictures are drawn", 20, "snapshots/*.png", words=()),
)


@dataclass
class Tally:
    """What was found of one moment and signal: kills by what they hit, and the runs that were hit."""

    hits: int = 0
    """That ended a process whose run went on."""
    in_frame: int = 0
    """Of these: a frame was half written when the run was killed, or went on being written after SIGTERM had come."""
    in_checkpoint: int = 0
    """The same of a checkpoint."""
    before: int = 0
    """That ended a process before it had begun the run, or had gone on with it."""
    after: int = 0
    """That came after the end of the run."""
    runs: int = 0
    """That were hit, and resumed until their end."""
    equal: int = 0
    differing: list[str] = field(default_factory=list)

    @property
    def kills(self) -> int:
        """All."""
        return self.hits + self.before + self.after

    def add(self, pid: int, folder: Path, written: Sequence[str]) -> None:
        """Count a kill of the process `pid`, which has ended, by what was being written."""
        if (folder / "summary.json").is_file() and read_summary(folder)["outcome"] == "finished":
            self.after += 1
        elif owner(folder) != pid:
            self.before += 1
        else:
            self.hits += 1
            self.in_frame += FRAME in written
            self.in_checkpoint += CHECKPOINT in written


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


def owner(folder: Path) -> int | None:
    """The pid of the process that goes on, or went on last, with the run in a folder; None without a run."""
    return read_summary(folder)["process"]["pid"] if (folder / "summary.json").is_file() else None


def kill(pid: int, signum: int, delay: float, folder: Path, file: str) -> list[str]:
    """End a process by a signal: after `delay` [s], or where there is a `file` so long after it began or resumed the
    run, once `file` is there. Returns those of `FRAME` and `CHECKPOINT` that were being written: half a file is left,
    or after SIGTERM, which lets it be finished, was still there.
    """
    deadline = time.monotonic() + SECONDS
    while file and owner(folder) != pid and not is_over(pid) and time.monotonic() < deadline:
        time.sleep(0.001)
    until = time.monotonic() + delay
    while not is_over(pid) and (time.monotonic() < until or not (any(folder.glob(file)) if file else True)):
        if time.monotonic() > deadline:
            os.kill(pid, signal.SIGKILL)
            raise SystemExit(f"{folder}: the run did not come to {file}")
        time.sleep(0.0 if time.monotonic() > until else 0.001)
    os.kill(pid, signum)
    if signum == signal.SIGKILL:
        end_of(pid)
    written = [each for each in (FRAME, CHECKPOINT) if any(folder.glob(each))]
    if signum != signal.SIGKILL:
        end_of(pid)
    return written


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
            first, span = (0.0, self.life - self.begun) if moment.file else (self.begun / 2, self.life - self.begun / 2)
            delay = first + self.chance.uniform(0.0, span / moment.in_a_row)
            tally.add(pid, folder, kill(pid, self.signum, delay, folder, moment.file))
            pid = begin(["resume", folder] if (folder / "summary.json").is_file() else [*command, "--overwrite"])
        if (code := end_of(pid)) != 0:
            raise SystemExit(f"{folder}: the run that was killed {moment.name} ended with code {code} when resumed")

    def compare(self, folder: Path, reference: Path) -> None:
        """Interrupt a run, and compare it with the one that nobody stopped. Raises SystemExit where it is too short."""
        tally, wanted = self.tally, self.moment.hits // len(ENDING)
        before = tally.hits
        rmtree(folder, ignore_errors=True)
        self.interrupt(folder)
        different = differences(folder, reference)
        tally.differing += different
        if tally.hits > before:
            tally.runs += 1
            tally.equal += not different
        if tally.kills >= MOST * wanted:
            raise SystemExit(f"{self.moment.name}: {tally.hits} of {tally.kills} kills hit a run; take a longer one")


def uninterrupted(command: Sequence[object], folder: Path) -> tuple[float, float]:
    """After what time a run that nobody stops holds its folder, and after what time it ends [s]."""
    start = time.monotonic()
    pid = begin([*command, folder])
    while not is_over(pid) and not (folder / "summary.json").exists():
        time.sleep(0.001)
    begun = time.monotonic() - start
    if (code := end_of(pid)) != 0:
        raise SystemExit(f"the run that nobody stops ended with code {code}")
    return begun, time.monotonic() - start


def measured(moments: Sequence[Moment], command: Sequence[object], place: Path, seed: int) -> Found:
    """Kill runs at all moments by all signals, in turn, and compare each with one that nobody stopped."""
    chance, found = random.Random(seed), {}
    for moment in moments:
        whole = [*command, *moment.words, "--out"]
        reference, folder = place / f"reference {moment.name}", place / "run"
        uninterrupted(whole, reference)
        begun, life = uninterrupted(whole, place / f"again {moment.name}")  # the first one reads all modules from disk
        for signum in ENDING:
            trial = Trial(whole, moment, signum, begun, life, chance)
            tally = found[moment.name, signal.Signals(signum).name] = trial.tally
            while tally.hits < moment.hits // len(ENDING):
                trial.compare(folder, reference)
            print(f"{moment.name}, {signal.Signals(signum).name}: {tally}", file=sys.stderr, flush=True)
    return found


def page(tallies: Found) -> str:
    """The table, and what differs."""
    hit = ("kills that hit a run", "in the middle of a frame", "of a checkpoint", "runs resumed", "same bits")
    head = ("killed", "by", *hit, "kills before the run", "after its end")
    rows = [
        (*where, one.hits, one.in_frame, one.in_checkpoint, one.runs, one.equal, one.before, one.after)
        for where, one in tallies.items()
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
    moments = [replace(m, hits=max(2 * m.in_a_row, round(m.hits * chosen.share))) for m in MOMENTS]
    command = COMMAND
    if chosen.quick:
        moments = [replace(m, hits=2 * m.in_a_row) for m in MOMENTS[:4]]
        command = ["run", "single-crease", *COMMAND[4:]]
    with tempfile.TemporaryDirectory() as place:
        found = measured(moments, command, Path(place), chosen.seed)
    text = page(found)
    print(text)
    if chosen.write:
        PART.write(text)
    if any(tally.differing for tally in found.values()):
        raise SystemExit("some results differ from those of the run that nobody stopped")


if __name__ == "__main__":
    main()
