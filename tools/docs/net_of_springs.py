"""What a net of springs represents of its film: moduli of the built-in meshes, and both sails of the paper with films
of springs, of equilateral springs and of triangles.

Finished runs are kept in the folder `out` and read again; remove it to repeat them, which takes some minutes. With
`--write` the tables and the picture of docs/net_of_springs.md are replaced.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from threading import Event

import numpy as np
from kept import kept
from marked import DOCS, MarkedPart
from membrane_rs import Material, Mesh, Scene, Simulation, Springs, Triangles, scenes
from membrane_rs._arrays import Floats
from membrane_rs._markdown import table
from membrane_rs.folding import EquilateralLattice, SquareSail, Strip
from membrane_rs.mesh import net_moduli
from membrane_rs.plotting.mesh_study import plot_meshes
from membrane_rs.results.features import curve_features
from membrane_rs.study.common.executor import run_parallel
from membrane_rs.study.common.run import StudyCase, run_case, study_case

PARTS = {name: MarkedPart(DOCS / "net_of_springs.md", name) for name in ("net-moduli", "net-runs")}
PICTURE = "net_of_springs.png"
MODELS = ("okuizumi-model-1", "okuizumi-model-2")
CALIBRATED = "okuizumi-model-1-triangles"
PAPER, EQUILATERAL, SAME, FITTED = (
    "springs, right triangles",
    "springs, equilateral",
    "triangles, same buckling",
    "triangles, calibrated",
)
STARTS = {MODELS[0]: 3, MODELS[1]: 2}
"""Number of starts by model: the unperturbed one and perturbed ones; the calibrated triangles have two."""
INSTANTS = 400
Tables = Mapping[str, Sequence[Mapping[str, Floats]]]


def main() -> None:
    """Make the missing runs; print and write the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--until", type=float, help="a brief run: end here [s]")
    parser.add_argument("--jobs", type=int, help="number of parallel runs; default: one on each core")
    parser.add_argument("--out", type=Path, default=Path("out/net-of-springs"), help="folder of the results")
    parser.add_argument("--write", action="store_true", help="write into docs/")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    found = {model: curves(model, options.until, options.out, options.jobs) for model in MODELS}
    texts = {"net-moduli": moduli(), "net-runs": "\n\n".join(text_of(model, runs) for model, runs in found.items())}
    picture = options.out / PICTURE
    plot_meshes({model: list(runs.items()) for model, runs in found.items()}, picture, legend="film")
    for name, text in texts.items():
        print(f"\n{name}\n\n{text}", flush=True)
        if options.write:
            PARTS[name].write(text)
    if options.write:
        (DOCS / PICTURE).write_bytes(picture.read_bytes())


def meshes() -> list[tuple[str, Mesh, Material]]:
    """Name, mesh and film of each mesh of the table: those of the built-in scenes, and lattices."""
    film = scenes.load(MODELS[0]).material
    assert film is not None
    third = replace(film, poisson_ratio=1 / 3)
    found = [
        ("right isosceles triangles", Strip(0.08, 0.08, 8, 8).mesh(), film),
        ("right isosceles triangles", Strip(0.08, 0.08, 8, 8).mesh(), third),
        ("equilateral triangles", EquilateralLattice(0.01, 8, 8).mesh(), third),
        ("equilateral triangles", EquilateralLattice(0.01, 8, 8).mesh(), film),
    ]
    for name in scenes.names():
        scene = scenes.load(name)
        if scene.mesh and scene.material and name != CALIBRATED and not scene.stages:
            found.append((name, scene.mesh, scene.material))
    return [*found, (f"{MODELS[0]}, equilateral", SquareSail(layout="equilateral").mesh(), film)]


def moduli() -> str:
    """Moduli of each mesh, affine and relaxed."""
    body = []
    for name, mesh, film in meshes():
        for relaxed in (False, True):
            net = net_moduli(mesh, film, relaxed=relaxed)
            if relaxed and net.is_balanced:
                continue
            axis = net.axis
            values = (net.modulus(axis), net.modulus(axis + 45.0), net.shear_modulus(axis), net.poisson_ratio(axis))
            least, greatest = net.local_extremes
            around = "" if relaxed else f"{least:.3f} to {greatest:.3f}"
            numbers = (f"{float(value):.3f}" for value in values)
            body.append((name, "relaxed" if relaxed else "affine", f"{film.poisson_ratio:.3f}", *numbers, around))
    head = ("mesh", "strain", "nu of the film", "E along 0", "E along 45", "G", "nu", "E around a node")
    return table(head, body, words=(0, 1))


def variants(model: str) -> dict[str, Scene]:
    """The scene by film; the calibrated triangles belong to the first model."""
    scene = scenes.load(model)
    scene = replace(scene, run=replace(scene.run, integrator="leapfrog", substeps=4, energy_loss=0.2))
    mesh, springs, fitted = scene.mesh, scene.law("springs"), scenes.load(CALIBRATED).law("triangles")
    assert mesh is not None
    assert isinstance(mesh.source, SquareSail)
    assert isinstance(springs, Springs)
    assert isinstance(fitted, Triangles)
    same = Triangles(buckling=springs.buckling, buckling_on_creases=springs.buckling_on_creases)

    def with_film(law: Triangles) -> Scene:
        return replace(scene, laws=[law if other is springs else other for other in scene.laws])

    films = {
        PAPER: scene,
        EQUILATERAL: replace(scene, mesh=replace(mesh.source, layout="equilateral").mesh()),
        SAME: with_film(same),
    }
    return films | ({FITTED: with_film(fitted)} if model == MODELS[0] else {})


def starts_of(model: str, film: str) -> int:
    """Number of starts of a film."""
    return 2 if film == FITTED else STARTS[model]


def curves(model: str, until: float | None, folder: Path, workers: int | None) -> Tables:
    """Histories of a model by film, from each start."""
    stop = Event()
    names, jobs = [], []
    for film, scene in variants(model).items():
        case = study_case(scene, until, INSTANTS)
        dt = Simulation(case.scene).dt
        for start in range(starts_of(model, film)):
            file = folder / f"{model}-{film.replace(', ', '-').replace(' ', '-')}-{start}-{case.until:g}.npz"
            one = case.perturbed(start) if start else case
            names.append(file.stem)
            jobs.append(lambda one=one, dt=dt, file=file: kept(file, lambda: history(one, dt, stop)))
    tables = run_parallel(jobs, names, stop, workers=workers, tell=lambda words: print(words, flush=True))
    found, ahead = {}, iter(tables)
    for film in variants(model):
        found[film] = [next(ahead) for _ in range(starts_of(model, film))]
    return found


def history(case: StudyCase, dt: float, stop: Event) -> dict[str, Floats]:
    """The curves of one run. Raises KeyboardInterrupt where `stop` ended it early."""
    run = run_case(case, "leapfrog", dt, stop=stop).completed()
    if stop.is_set():
        raise KeyboardInterrupt
    return {"time": run.times, "deployment_rate": run.rate, "phase_difference_deg": run.phase}


def text_of(model: str, runs: Tables) -> str:
    """The table of one model and its reading."""
    columns = (
        ("first peak of the rate", "first_peak_rate", 1.0, 3),
        ("its time [ms]", "first_peak_time", 1e3, 0),
        ("trough of the phase [deg]", "phase_trough_deg", 1.0, 1),
        ("its time [ms]", "phase_trough_time", 1e3, 0),
        ("phase back at zero [ms]", "zero_crossing_time", 1e3, 0),
        ("last rate", "final_rate", 1.0, 3),
    )
    body, apart = [], {}
    paper = mean(runs[PAPER])
    for film, tables in runs.items():
        cells = []
        for _, key, scale, digits in columns:
            values = [features[key] for features in map(curve_features, tables)]
            known = [scale * value for value in values if value is not None]
            cells.append(f"{np.mean(known):.{digits}f} +- {np.std(known):.{digits}f}" if known else "-")
        apart[film] = tuple(rms(mean(tables)[column] - paper[column]) for column in CURVES)
        spread = tuple(rms(np.std([one[column] for one in tables], axis=0)) for column in CURVES)
        distances = f"{apart[film][0]:.4f} ({spread[0]:.4f})", f"{apart[film][1]:.1f} ({spread[1]:.1f})"
        body.append((film, *cells, *(distances if film != PAPER else (f"- ({spread[0]:.4f})", f"- ({spread[1]:.1f})"))))
    head = ("film", *(name for name, *_ in columns), "rate apart (spread)", "phase apart (spread) [deg]")
    return f"### {model}\n\n{table(head, body)}\n\n{reading(runs, apart)}"


CURVES = ("deployment_rate", "phase_difference_deg")


def mean(tables: Sequence[Mapping[str, Floats]]) -> dict[str, Floats]:
    """The mean curves."""
    return {column: np.mean([one[column] for one in tables], axis=0) for column in CURVES}


def rms(values: Floats) -> float:
    """Root mean square over time."""
    return float(np.sqrt(np.mean(values**2)))


def reading(runs: Tables, apart: Mapping[str, tuple[float, ...]]) -> str:
    """What the numbers say."""
    sentences = []
    spread = [rms(np.std([one[column] for one in runs[PAPER]], axis=0)) for column in CURVES]
    whole = float(np.ptp(mean(runs[PAPER])["phase_difference_deg"]))
    for film, (rate, phase) in apart.items():
        if film == PAPER:
            continue
        times = max(rate / spread[0], phase / spread[1])
        words = (
            "within twice the spread of the starts" if times < 2.0 else f"{times:.1f} times the spread of the starts"
        )
        sentences.append(
            f"- {film}: {rate:.4f} in the rate and {phase:.1f} degrees in the phase from the springs of the paper, "
            f"{words}, {100 * phase / whole:.0f} % of the range of the phase."
        )
    return "\n".join(sentences)


if __name__ == "__main__":
    main()
