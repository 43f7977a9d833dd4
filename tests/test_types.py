"""Nothing asks for the class of a law, a part or a pattern, or for the name of a law: the classes have the answers."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import membrane_rs
from membrane_rs.folding import PATTERNS
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS

SOURCE = Path(membrane_rs.__file__).parent
FILES = sorted(SOURCE.rglob("*.py"))
CLASSES = {kind.__name__ for kinds in (LAWS, PARTS, PATTERNS) for kind in kinds.values()} | {"Law", "Part"}


def names(tree: ast.AST, imported: dict[str, str]) -> set[str]:
    """Classes of the lists that stand in an expression, by their own names, in a module or under another name."""
    found = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
    found |= {node.attr for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
    return {imported.get(name, name) for name in found} & CLASSES


def sites(text: str) -> Iterator[tuple[int, str]]:
    """(line, class) for each question of that kind: `isinstance`, `issubclass`, `type(x) is`, a `match` by class."""
    tree = ast.parse(text)
    imports = [alias for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names]
    imported = {alias.asname: alias.name for alias in imports if alias.asname}
    for node in ast.walk(tree):
        asked: list[ast.expr] = []
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "issubclass"):
            asked = node.args[1:]
        elif isinstance(node, ast.MatchClass):
            asked = [node.cls]
        elif isinstance(node, ast.Compare) and ast.unparse(node.left).startswith("type("):
            asked = node.comparators
        for one in asked:
            yield from ((one.lineno, name) for name in sorted(names(one, imported)))


def named(text: str) -> Iterator[tuple[int, str]]:
    """(line, law) for each law that is looked up or compared by a name in quotes."""
    for node in ast.walk(ast.parse(text)):
        asked: list[ast.expr] = []
        if isinstance(node, ast.Call) and ast.unparse(node.func).endswith(".law"):
            asked = node.args
        elif isinstance(node, ast.Compare):
            asked = [node.left, *node.comparators]
        for one in asked:
            if isinstance(one, ast.Constant) and one.value in LAWS:
                yield one.lineno, str(one.value)


def test_names_are_found() -> None:
    text = """
scene.law("triangles") is None
"springs" in kinds or kind == "spin"
readings("springs"), scene.law(Springs), "film" in kinds
"""
    assert sorted(named(text)) == [(2, "triangles"), (3, "spin"), (3, "springs")]


def test_questions_are_found() -> None:
    text = """
from membrane_rs.scene import laws, parts
from membrane_rs import Tether as Cord
isinstance(x, (laws.Springs, Cord))
type(x) is parts.Fixed
match x:
    case laws.Spin() | Cord(): pass
isinstance(x, str)
"""
    assert sorted(name for _, name in sites(text)) == ["Fixed", "Spin", "Springs", "Tether", "Tether"]


def test_no_caller_asks_for_the_class_of_a_law_a_part_or_a_pattern() -> None:
    found = [f"{file.relative_to(SOURCE)}:{line}: {name}" for file in FILES for line, name in sites(file.read_text())]
    assert found == []
    assert len(FILES) > len(CLASSES)


def test_no_caller_asks_for_the_name_of_a_law() -> None:
    found = [f"{file.relative_to(SOURCE)}:{line}: {name}" for file in FILES for line, name in named(file.read_text())]
    assert found == []
