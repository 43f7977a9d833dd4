"""What is imported, and when: drawing waits until something is drawn, and nothing heavy comes with the package."""

from __future__ import annotations

import ast
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import membrane_rs
import pytest
from membrane_rs._on_demand import OnDemand

DRAWING = ("pyvista", "matplotlib", "PIL", "vtk", "vtkmodules")
ON_DEMAND = [
    import_module(f"membrane_rs{name}")
    for name in (
        "",
        ".check",
        ".folding",
        ".mesh",
        ".plotting",
        ".plotting.viewer",
        ".report",
        ".results",
        ".runs",
        ".scene",
        ".scene.laws",
        ".simulation",
        ".study",
    )
]
"""Packages whose names are imported when one is first used."""
HEAVY = ("scipy", "meshio", "typer", "rich", *DRAWING)


def loaded(code: str, names: tuple[str, ...]) -> set[str]:
    """Those of some modules that a fresh process has after this code."""
    code += f"\nimport sys\nprint(*[name for name in {names!r} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=300)
    return set(done.stdout.split())


def test_the_package_comes_with_nothing_heavy() -> None:
    assert not loaded("import membrane_rs", HEAVY)
    for scene in ("spinning-tether", "okuizumi-model-1"):
        code = f"from membrane_rs import Simulation, scenes; Simulation(scenes.load('{scene}')).step(3)"
        assert not loaded(code, HEAVY)


def test_only_pictures_need_what_draws(tmp_path: Path) -> None:
    code = (
        "from membrane_rs import Simulation, scenes\n"
        "from membrane_rs.runs import RunFolder\n"
        "sim = Simulation(scenes.load('spinning-tether'), dt=1e-5)\n"
        f"folder = RunFolder({str(tmp_path / 'run')!r}, pictures={{}})\n"
        "sim.run(until=1e-3, frames=2, samples=2, observers=(folder,))\n"
    )
    assert not loaded(code.format(False), DRAWING)
    assert (tmp_path / "run" / "history.csv").is_file()
    assert "matplotlib" in loaded(code.format(True).replace("/run", "/drawn"), DRAWING)


def test_the_package_imports_only_what_is_used() -> None:
    modules = ("numpy", "pydantic", "membrane_rs.mesh", "membrane_rs.scene", "membrane_rs.runs.run_folder")
    assert not loaded("import membrane_rs; dir(membrane_rs)", modules)
    assert not loaded("from membrane_rs import Mesh, folding", modules[3:])
    made = "from membrane_rs import Simulation, scenes; Simulation(scenes.load('spinning-tether'))"
    assert loaded(made, modules) == set(modules[:4])


def on_demand(package: ModuleType) -> OnDemand:
    """What a package finds its names with."""
    found = vars(package)["_on_demand"]
    assert isinstance(found, OnDemand)
    return found


@pytest.mark.parametrize("package", ON_DEMAND, ids=lambda package: package.__name__)
def test_names_are_those_that_type_checkers_read(package: ModuleType) -> None:
    assert package.__file__ is not None
    (block,) = [
        node
        for node in ast.parse(Path(package.__file__).read_text(encoding="utf-8")).body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    ]
    read = {alias.name: node.module for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    of_package = {name for name, place in read.items() if place == package.__name__}
    lazily = on_demand(package)
    assert lazily.places == {name: place for name, place in read.items() if name not in of_package}
    assert of_package <= set(lazily.modules())
    assert {*read, *({"__version__"} & {*package.__all__})} == {*package.__all__}


@pytest.mark.parametrize("package", ON_DEMAND, ids=lambda package: package.__name__)
def test_every_name_is_found_listed_and_kept(package: ModuleType) -> None:
    lazily = on_demand(package)
    for name in [*lazily.places, *lazily.modules()]:
        found = lazily(name)
        assert found is getattr(package, name) is vars(package)[name]
        assert name in {*dir(package), *vars(membrane_rs)["_OLD"]}
    for name in package.__all__:
        assert name in dir(package)
        if name not in lazily.modules() and name != "__version__":
            assert getattr(package, name) is getattr(import_module(lazily.places[name]), name)
    for name in ("nothing", "_nothing", "__nothing__"):
        with pytest.raises(AttributeError, match=f"module '{package.__name__}' has no attribute '{name}'"):
            getattr(package, name)


def test_packages_are_imported_when_they_are_named() -> None:
    assert not loaded("import membrane_rs", ("membrane_rs.study",))
    assert loaded("import membrane_rs; membrane_rs.study.sweep", ("membrane_rs.study",))
    words = [sys.executable, "-c", "import membrane_rs; membrane_rs.sweep"]
    failed = subprocess.run(words, check=False, capture_output=True, text=True, timeout=300)
    assert "has no attribute 'sweep'" in failed.stderr


def test_packages_that_are_not_imported_yet_are_listed() -> None:
    words = [sys.executable, "-c", "import membrane_rs; print(*dir(membrane_rs))"]
    listed = subprocess.run(words, check=True, capture_output=True, text=True, timeout=300).stdout.split()
    assert {"study", "report", "units", "run", "Scene", "__version__"} <= set(listed)
    assert "import_module" not in listed


@pytest.mark.parametrize("name", ["errors", "material", "scene.laws", "study.common.vary", "analysis.strain", "laws"])
def test_public_modules_are_reached_from_the_first_statement_on(name: str) -> None:
    words = [sys.executable, "-c", f"import membrane_rs; print(membrane_rs.{name}.__name__)"]
    done = subprocess.run(words, check=False, capture_output=True, text=True, timeout=300)
    assert done.stdout.strip() == f"membrane_rs.{name}", done.stderr


def test_old_places_are_not_listed() -> None:
    old = vars(membrane_rs)["_OLD"]
    assert old <= {*on_demand(membrane_rs).modules()}
    assert not old & {*dir(membrane_rs)}
