"""The first use of the package from several threads at once, and the rules of `_on_demand` that keep it safe."""

from __future__ import annotations

import ast
import itertools
import os
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import membrane_rs
import pytest

ROOT = Path(membrane_rs.__file__).parent
WITH_CODE = {"membrane_rs.cli"}
"""Packages that one thread enters at one place: their file may import their modules."""
USES = (
    "m.Simulation",
    "m.run",
    "m.RunSettings",
    "m.errors.Interrupted",
    "m.study.sweep",
    "m.check.audit",
    "from membrane_rs.results import peak_stress",
    "import membrane_rs.runs.running",
    "import membrane_rs.simulation.stepper",
)
FRESH = """
import faulthandler, os, sys, threading
import membrane_rs as m
FIRST

def used(code, start, failed):
    start.wait()
    try:
        exec(code, {"m": m})
    except BaseException as error:
        failed.append(f"{code}: {error!r}")

def together(uses):
    faulthandler.dump_traceback_later(60, exit=True)
    sys.setswitchinterval(1e-4)
    start, failed = threading.Barrier(len(uses)), []
    threads = [threading.Thread(target=used, args=(code, start, failed)) for code in uses]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    print(*failed, sep="\\n", end="", flush=True)
    os._exit(bool(failed))

for uses in CASES:
    child = os.fork()
    if child == 0:
        together(uses)
    if os.waitpid(child, 0)[1] != 0:
        sys.exit(f"failed: {uses}")
"""
"""A process that has imported next to nothing: a copy of it for each case, ended after a minute if its threads wait."""


def answers(cases: list[tuple[str, ...]], first: str = "") -> str:
    """What fails where the statements of each case are first run at once, one thread for each."""
    code = FRESH.replace("CASES", repr(cases)).replace("FIRST", first)
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=300)
    return done.stdout + done.stderr


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs copies of a process")
def test_the_first_use_may_come_from_several_threads() -> None:
    assert not answers([*itertools.combinations(USES, 2)], first="import membrane_rs._third_party")
    assert not answers([USES, ("m.run", "m.RunSettings", "m.Simulation"), ("m.Material", "m.units.number", "m.Mesh")])


def packages() -> Iterator[tuple[str, ast.Module]]:
    """The name and the code of the file of each package."""
    for path in sorted(ROOT.rglob("__init__.py")):
        yield ".".join(path.parent.relative_to(ROOT.parent).parts), ast.parse(path.read_text(encoding="utf-8"))


def imported(code: ast.Module) -> set[str]:
    """Modules that are imported while the code is: outside functions, and not for type checkers alone."""
    found: set[str] = set()
    waiting: list[ast.AST] = [*code.body]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.ImportFrom):
            found |= {node.module or "", *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            waiting += node.orelse
        elif not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            waiting += ast.iter_child_nodes(node)
    return found


def test_the_file_of_a_package_imports_none_of_its_modules() -> None:
    wrong = {
        name: own
        for name, code in packages()
        if (own := {one for one in imported(code) if one.startswith(f"{name}.")}) and name not in WITH_CODE
    }
    assert wrong == {"membrane_rs": {"membrane_rs._on_demand", "membrane_rs._on_demand.OnDemand"}}
    on_demand = ast.parse((ROOT / "_on_demand.py").read_text(encoding="utf-8"))
    assert not {one for one in imported(on_demand) if one.startswith("membrane_rs")}


def test_no_module_takes_names_on_demand_from_a_package_that_holds_it() -> None:
    names = {name for name, _ in packages()} - WITH_CODE
    for path in sorted(ROOT.rglob("*.py")):
        module = ".".join(path.with_suffix("").relative_to(ROOT.parent).parts)
        for one in imported(ast.parse(path.read_text(encoding="utf-8"))):
            package, _, name = one.rpartition(".")
            if package in names and module.startswith(f"{package}.") and path.name != "__init__.py":
                places = getattr(vars(import_module(package)).get("_on_demand"), "places", {})
                assert name not in places, f"{module} takes {name} from {package}"


@pytest.mark.parametrize("name", [name for name, _ in packages()])
def test_no_name_on_demand_is_that_of_a_module(name: str) -> None:
    lazily = vars(import_module(name)).get("_on_demand")
    if lazily is not None:
        assert not {*lazily.places} & {*lazily.modules()}
