"""Errors that a function of the package raises, as its source says."""

from __future__ import annotations

import ast
import builtins
import inspect
import textwrap
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import Any

from membrane_rs import errors
from membrane_rs.errors import MembraneError

Errors = frozenset[type[BaseException]]


def raised(function: Any, owner: type | None = None) -> Errors:
    """Those of its own body, and of the functions of this package that it calls directly, but for those it catches.

    `owner` is the class of a method: `self` and `cls` are of it.
    """
    return _raised(function, owner, depth=1)


@cache
def _raised(function: Any, owner: Any, depth: int) -> Errors:
    if isinstance(function, type):
        made = [getattr(function, name, None) for name in ("__init__", "__post_init__")]
        own: Any = function
        return frozenset().union(*(_raised(one, own, depth) for one in made if _is_own(one)))
    function = inspect.unwrap(getattr(function, "__func__", function))
    if not _is_own(function):
        return frozenset()
    names = {**vars(builtins), **vars(import_module(function.__module__)), "self": owner, "cls": owner}
    tree = ast.parse(textwrap.dedent(inspect.getsource(function))).body[0]
    return frozenset(_Reader(names, depth).of(tree))


def _is_own(function: Any) -> bool:
    """Whether it is a function of the package, with a source: not what `dataclass` makes."""
    if not inspect.isfunction(function) or not function.__module__.startswith("membrane_rs"):
        return False
    return not inspect.unwrap(function).__code__.co_filename.startswith("<")


class _Reader:
    """Reads a tree with the names that its module has."""

    def __init__(self, names: dict[str, Any], depth: int) -> None:
        self._names, self._depth = names, depth

    def of(self, node: ast.AST) -> Iterator[type[BaseException]]:
        """Errors that leave this node."""
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("membrane_rs"):
            module = import_module(node.module)
            self._names |= {alias.asname or alias.name: getattr(module, alias.name, None) for alias in node.names}
        if isinstance(node, ast.Raise) and node.exc is not None:
            yield from self._of_raise(node.exc)
        if isinstance(node, ast.Call) and self._depth:
            called, owner = self._value(node.func), self._owner(node.func)
            if called is not None:
                yield from _raised(called, owner, self._depth - 1)
        caught: tuple[type[BaseException], ...] = ()
        inside: list[ast.AST] = []
        if isinstance(node, ast.Try):
            inside, caught = list(node.body), self._caught(node)
        elif isinstance(node, ast.With) and any(self._is_suppression(item.context_expr) for item in node.items):
            inside, caught = list(node.body), (BaseException,)
        for child in ast.iter_child_nodes(node):
            found = self.of(child)
            yield from found if child not in inside else (one for one in found if not issubclass(one, caught))

    def _of_raise(self, raised: ast.AST) -> Iterator[type[BaseException]]:
        value = self._value(raised.func if isinstance(raised, ast.Call) else raised)
        if inspect.isroutine(value):  # a function that gives an error
            value = self._names.get(str(inspect.signature(value).return_annotation))
        if inspect.isclass(value) and issubclass(value, MembraneError):
            yield next(kind for kind in value.__mro__ if vars(errors).get(kind.__name__) is kind)  # a public one

    def _value(self, node: ast.AST) -> Any:
        """What a name, or an attribute of a class of this package, stands for."""
        if isinstance(node, ast.Name):
            return self._names.get(node.id)
        if isinstance(node, ast.Attribute) and (owner := self._owner(node)) is not None:
            value = inspect.getattr_static(owner, node.attr, None)
            return getattr(value, "__func__", value)
        return None

    def _owner(self, node: ast.AST) -> type | None:
        """The class whose attribute a node is."""
        if not isinstance(node, ast.Attribute):
            return None
        value = node.value
        if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id == "super":
            own = self._names["self"]
            return None if own is None else own.__mro__[1]
        found = self._value(value) if isinstance(value, ast.Name) else None
        return found if inspect.isclass(found) else None

    def _caught(self, node: ast.Try) -> tuple[type[BaseException], ...]:
        """Errors that the handlers of a `try` catch, but for those that they raise again."""
        found: list[Any] = []
        for handler in node.handlers:
            if not any(isinstance(inner, ast.Raise) and inner.exc is None for inner in ast.walk(handler)):
                kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
                values = [BaseException if kind is None else self._value(kind) for kind in kinds]
                found += [value for value in values if inspect.isclass(value)]
        return tuple(found)

    def _is_suppression(self, node: ast.AST) -> bool:
        return isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "suppress"
