"""The list of frames grows in place at a cost that does not depend on its length, and is read wherever it ends."""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from membrane_rs import OutputError
from membrane_rs.results import read_pvd, write_pvd
from membrane_rs.results.pvd import PvdWriter

FRAMES = [(0.1 * k, f"frames/a & b-{k:04d}.vtu") for k in range(200)]


def test_grown_line_by_line_it_is_the_same_file(tmp_path: Path) -> None:
    grown = PvdWriter(tmp_path / "grown.pvd")
    for count, frame in enumerate(FRAMES, start=1):
        grown.append(*frame)
        assert [time for time, _ in read_pvd(grown.path)] == [time for time, _ in FRAMES[:count]]
    write_pvd(tmp_path / "whole.pvd", FRAMES)
    assert grown.path.read_bytes() == (tmp_path / "whole.pvd").read_bytes()
    entries = ElementTree.parse(grown.path).getroot().iter("DataSet")
    assert [entry.attrib["file"] for entry in entries] == [file for _, file in FRAMES]


def test_a_frame_costs_one_write_of_its_own_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    grown = PvdWriter(tmp_path / "grown.pvd", [(0.1 * k, f"frames/frame-{k:05d}.vtu") for k in range(50_000)])
    grown.write()
    written: list[int] = []
    opened = Path.open

    class Counted:
        def __init__(self, stream: Any) -> None:
            self._stream = stream

        def __enter__(self) -> Counted:
            return self

        def __exit__(self, *_: object) -> None:
            self._stream.close()

        def seek(self, place: int) -> None:
            self._stream.seek(place)

        def write(self, content: bytes) -> None:
            written.append(len(content))
            self._stream.write(content)

    monkeypatch.setattr(Path, "open", lambda path, *words, **named: Counted(opened(path, *words, **named)))
    grown.append(5000.0, "frames/frame-50000.vtu")
    assert len(written) == 1
    assert written[0] < 200
    monkeypatch.undo()
    assert len(read_pvd(grown.path)) == 50_001


def test_wherever_a_write_is_cut_the_frames_before_it_are_read(tmp_path: Path) -> None:
    path = tmp_path / "frames.pvd"
    grown = PvdWriter(path, FRAMES[:3])
    grown.write()
    before = path.read_bytes()
    grown.append(*FRAMES[3])
    after = path.read_bytes()
    start = next(place for place, (old, new) in enumerate(zip(before, after, strict=False)) if old != new)
    for end in range(start, len(after) + 1):
        # What is written replaces what stands there, and may be longer.
        path.write_bytes(after[:end] + before[end:])
        assert [time for time, _ in read_pvd(path)] in ([0.0, 0.1, 0.2], [0.1 * k for k in range(4)])


def test_what_is_read_while_a_line_comes_in_are_the_frames_before_it(tmp_path: Path) -> None:
    path = tmp_path / "frames.pvd"
    grown = PvdWriter(path, FRAMES[:3])
    grown.write()
    before = path.read_bytes()
    grown.append(*FRAMES[3])
    after = path.read_bytes()
    for seen in range(before.rfind(b"/>"), len(before) + 1):
        path.write_bytes(before[:seen] + after[seen:])
        assert [time for time, _ in read_pvd(path)] in ([0.0, 0.1, 0.2], [0.1 * k for k in range(4)])


@pytest.mark.parametrize("text", ["", "<VTKFile>", "<VTKFile><DataSet/></VTKFile>", "\x00/>\n"])
def test_what_is_no_list_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "frames.pvd"
    path.write_text(text)
    with pytest.raises(OutputError, match="is no PVD file"):
        read_pvd(path)
