"""What is imported, and when: drawing waits until something is drawn, and nothing heavy comes with the package."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

DRAWING = ("pyvista", "matplotlib", "PIL", "vtk", "vtkmodules")
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
