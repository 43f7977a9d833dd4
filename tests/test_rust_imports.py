"""Imports of the Rust core go one way, as its lib.rs says; files of a room use each other in no circle."""

from __future__ import annotations

import re
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent.parent / "rust" / "core" / "src"
PATH = re.compile(r"\b(?:crate|super)(?:::\w+)+")
USE = re.compile(r"\buse ([^;]+);")


def layers() -> list[list[str]]:
    """The layers that lib.rs names, the lowest first."""
    text = (SOURCE / "lib.rs").read_text(encoding="utf-8")
    chain = " ".join(line.removeprefix("//!") for line in text.splitlines() if "<-" in line)
    return [re.findall(r"\w+", layer) for layer in chain.split("<-")]


def rooms() -> dict[str, list[Path]]:
    """The files of each folder or single file below the crate's root."""
    found: dict[str, list[Path]] = {}
    for file in sorted(SOURCE.rglob("*.rs")):
        if file.name != "lib.rs":
            found.setdefault(file.relative_to(SOURCE).parts[0].removesuffix(".rs"), []).append(file)
    return found


def code(file: Path) -> str:
    """A file without its comments and its tests."""
    text = re.sub(r"//.*", "", file.read_text(encoding="utf-8"))
    return text.partition("#[cfg(test)]\nmod tests")[0]


def expanded(tree: str) -> list[str]:
    """The paths of a use-tree: a::{b, c::{d, e}} is a::b, a::c::d, a::c::e."""
    head, brace, rest = tree.partition("{")
    if not brace:
        return [tree]
    items, depth = [""], 0
    for sign in rest.rpartition("}")[0]:
        depth += (sign == "{") - (sign == "}")
        if sign == "," and depth == 0:
            items.append("")
        else:
            items[-1] += sign
    return [head + path for item in items for path in expanded(item.strip()) if path]


def paths(file: Path) -> list[str]:
    """The paths that a file names from the crate's root or from a folder above it, those of use-trees one by one."""
    text = re.sub(r"\s*(::|[{},;])\s*", r"\1", code(file))
    trees = [path for tree in USE.findall(text) for path in expanded(tree)]
    return [path.group() for path in PATH.finditer(" ".join([USE.sub(" ", text), *trees]))]


def used(file: Path) -> Iterator[str]:
    """The rooms that a file names by their path from the crate's root."""
    return (path.split("::")[1] for path in paths(file) if path.startswith("crate::"))


def test_the_paths_of_a_use_tree_are_found() -> None:
    tree = "super::{leapfrog, Options, kick_drift::{End, begin}, rk4::make as make_rk4}"
    found = ["leapfrog", "Options", "kick_drift::End", "kick_drift::begin", "rk4::make as make_rk4"]
    assert expanded(tree) == ["super::" + path for path in found]


def test_lib_names_every_room() -> None:
    assert sorted(name for layer in layers() for name in layer) == sorted(rooms())


def test_imports_go_down_the_layers() -> None:
    level = {name: height for height, layer in enumerate(layers()) for name in layer}
    upward = [
        f"{file.relative_to(SOURCE)} uses {other}"
        for room, files in rooms().items()
        for file in files
        for other in used(file)
        if other != room and level[other] >= level[room]
    ]
    assert upward == []


@pytest.mark.parametrize("room", sorted(name for name, files in rooms().items() if len(files) > 1))
def test_files_of_a_room_use_each_other_in_no_circle(room: str) -> None:
    # A file with a folder of its own name is one with it; mod.rs stands for the room, and its files may use it.
    names = {file.relative_to(SOURCE / room).parts[0].removesuffix(".rs") for file in rooms()[room]} - {"mod"}
    graph: dict[str, set[str]] = {name: set() for name in names}
    for file in rooms()[room]:
        own = file.relative_to(SOURCE / room).parts[0].removesuffix(".rs")
        if own == "mod":
            continue
        depth = len(file.relative_to(SOURCE / room).parts)
        others = paths(file)
        others = [path.removeprefix(f"crate::{room}::") for path in others if path.startswith(f"crate::{room}::")] + [
            path.removeprefix("super::" * depth)
            for path in others
            if path.startswith("super::" * depth) and not path.startswith("super::" * (depth + 1))
        ]
        graph[own] |= {path.partition("::")[0] for path in others} & names - {own}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"{room}: {' -> '.join(error.args[1])}")
