"""Text with units: what it means, in files and by dotted keys, and what is refused."""

from __future__ import annotations

import inspect
import math
import re
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest
from membrane_rs import Cylinder, Material, Scene, Schedule, Spin, Stage, scenes, units
from membrane_rs._fields import is_whole, takes_numbers, unit_of
from membrane_rs._quantities import KINDS, USUAL, conversion, to_si, unit_named
from membrane_rs.errors import InputError, InputTypeError, SceneError
from membrane_rs.folding import PATTERNS
from membrane_rs.scene.bodies import BODIES
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS
from membrane_rs.scene.run_settings import RunSettings
from membrane_rs.scene.stage import MEASURE_UNITS, MEASURES
from small_scenes import cord, hanging_strip, refused

CLASSES: list[Any] = [
    Material, RunSettings, Stage, Schedule, *LAWS.values(), *PARTS.values(), *BODIES.values(), *PATTERNS.values()
]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("7.5 um", "m", 7.5e-6),
        ("12.5µm", "m", 12.5e-6),
        ("12.5 μm", "m", 12.5e-6),
        ("1 mil", "m", 25.4e-6),
        (" 45.5 cm\n", "m", 0.455),
        ("-5e-1mm", "m", -0.5e-3),
        ("\u22125 mm", "m", -5e-3),
        ("3.2 GPa", "Pa", 3.2e9),
        ("4.5 N/m^2", "Pa", 4.5),
        ("1 psi", "Pa", 4.4482216152605 / 0.0254**2),
        ("0.36 g", "kg", 0.36e-3),
        ("1.42 g/cm3", "kg/m3", 1420.0),
        ("1420 kg/m**3", "kg/m3", 1420.0),
        ("1420 kg m-3", "kg/m3", 1420.0),
        ("1420 kg·m⁻³", "kg/m3", 1420.0),
        ("0.1004 g/m", "kg/m", 1.004e-4),
        ("25 rpm", "Hz", 25 / 60),
        ("3 Hz", "Hz", 3.0),
        ("1 turn/s", "Hz", 1.0),
        ("360 deg/s", "Hz", 1.0),
        ("1 rad/s", "Hz", 1.0 / math.tau),
        ("10 rpm/s", "Hz/s", 1 / 6),
        ("180 deg", "rad", math.pi),
        ("90°", "rad", 0.5 * math.pi),
        ("0.5 turn", "rad", math.pi),
        ("1 rad", "deg", math.degrees(1.0)),
        ("50 1/s", "1/s", 50.0),
        ("50/s", "1/s", 50.0),
        ("50 ms", "s", 0.05),
        ("2 minutes", "s", 120.0),
        ("50 s^-1", "1/s", 50.0),
        ("20 degC", "K", 293.15),
        ("20 °C", "K", 293.15),
        ("68 degF", "K", 293.15),
        ("981 cm/s2", "m/s2", 9.81),
        ("2 N/cm", "N/m", 200.0),
        ("3 mN m", "N m", 3e-3),
        ("3 mN*m", "N m", 3e-3),
        ("1 Nm", "N m", 1.0),
        ("1 kg m2/(s2)", "J", 1.0),
        ("1 J/(m N)", "", 1.0),
        ("2 %", "", 0.02),
        ("3 mm/m", "", 0.003),
    ],
)
def test_texts_and_their_numbers(text: str, unit: str, value: float) -> None:
    found = to_si(text, unit, "x")
    if unit not in ("Pa", "Hz", "deg"):
        assert found == value, "a decimal text is the very number"
    assert found == pytest.approx(value, rel=1e-15)


HOSTILE = {
    "1e999 m": "must be finite",
    "1e99999999999999999 m": "must be finite",
    "1e300 Gm": "must be finite",
    "1 m**1e9": "is no unit",
    "1 m**999": "an exponent beyond 9",
    "1 m9999999": "is no unit",
    "9**9**9**9 m": "is no unit",
    "1 " + "m " * 25: "too many factors",
    "1 " + "m" * 10**6: "must be a number",
    "1" * 10**6 + " m": "must be a number",
    "1 (((((m)))))": "is no unit",
    "1 __import__('os')": "is no unit",
    "1 m; 2 m": "is no unit",
    "1 m\0": "is no unit",
    "1 m/": "is no unit",
    "1 //m": "is no unit",
    "1 ": "must be a number; write it without quotes",
    "nan m": "must be a number",
    "inf": "must be a number",
    "up": r"must be a number \(m\), or a text with its unit such as '7.5 um'",
    "": "must be a number",
    "7.5e-6": "must be a number; write it without quotes, or with its unit: '7.5e-6 m'",
    "7,5 um": "write a point for the decimals",
    "1 kg": r"^x = '1 kg': is a mass; must be a length \(m\), such as '7.5 um'$",
    "1 m2": r"is an area; must be a length \(m\)",
    "1 kg m5": r"is of dimension .*must be a length \(m\)",
    "1 umm": "unit 'umm' is not known; did you mean 'um'",
    "1 MM": "unit 'MM' is not known; did you mean 'mm'",
    "1 delta_degC": "is not known",
    "1 ums": "unit 'ums' is not known; did you mean",
    "1 parsec": "unit 'parsec' is not known; must be a number",
}


@pytest.mark.parametrize("text", HOSTILE, ids=[re.sub("[^a-z0-9]+", "-", text[:20]) for text in HOSTILE])
def test_texts_that_are_refused_at_once(text: str) -> None:
    unit_named("m")  # which loads pint
    began = time.process_time()
    refused(lambda: to_si(text, "m", "x"), InputError, HOSTILE[text])
    assert time.process_time() - began < 20.0


@pytest.mark.parametrize(
    ("text", "unit", "words"),
    [
        (
            "3 1/s",
            "Hz",
            "is a rate; must be a frequency of turning .*1/s may be turns or radians: write Hz, rpm, rad/s",
        ),
        ("3 Hz", "1/s", r"is a frequency of turning; must be a rate \(1/s\), such as '50 1/s'"),
        ("3 rad/s", "1/s", "is a frequency of turning; must be a rate"),
        ("3 RPM", "Hz", "did you mean 'rpm'"),
        ("3 GPA", "Pa", "did you mean 'GPa'"),
        ("3 pa", "Pa", "did you mean 'Pa'"),
        ("3 gr", "kg", "did you mean 'g'"),
        ("3 Ns", "N", "unit 'Ns' is not known"),
        ("3 N s", "N", "is of dimension"),
        ("3 Pas", "Pa", "unit 'Pas' is not known"),
        ("3 J/kg K", "J", "unit 'J/kg K' has two meanings; put what is below the line in brackets"),
        (
            "20 degC/m",
            "K",
            r"is of dimension \[temperature\] / \[length\]; must be a temperature \(K\), such as '20 degC'",
        ),
        ("20 degC2", "K", "must be a temperature"),
        ("20 degC %", "K", "degC and degF stand alone; in a product write K"),
        ("20", "", "must be a number; write it without quotes$"),
        ("20 m", "", "is a length; must be a plain number, such as '2 %'"),
    ],
)
def test_units_that_do_not_fit(text: str, unit: str, words: str) -> None:
    refused(lambda: to_si(text, unit, "x"), InputError, words)


def test_examples_and_usual_names_are_units() -> None:
    for unit, (what, example) in KINDS.items():
        assert math.isfinite(to_si(example, unit, what))
    assert all(unit_named(name) is not None for name in USUAL)
    assert conversion("km/h", "m/s") == (1000 / 3600, 0.0)
    assert conversion("degC", "K") == (1.0, 273.15)
    refused(lambda: conversion("kg", "s"), InputError, "'kg' is a mass; must be a unit of a time, such as 's'")


def documented(cls: type) -> dict[str, str]:
    """The text of each parameter in the docstrings of a class and its bases."""
    found: dict[str, str] = {}
    for owner in reversed(cls.__mro__):
        doc = inspect.cleandoc(owner.__doc__ or "") + "\n"
        for names, text in re.findall(r"^(\w[\w, ]*) : [^\n]*\n((?:    [^\n]*\n)+)", doc, re.M):
            found |= dict.fromkeys(names.split(", "), " ".join(text.split()))
    return found


@pytest.mark.parametrize("cls", CLASSES, ids=lambda cls: cls.__name__)
def test_every_number_has_its_unit(cls: Any) -> None:
    texts = documented(cls)
    for entry in fields(cls):
        takes_number, _ = takes_numbers(cls, entry.name)
        if not takes_number:
            holds_schedule = "Schedule" in str(cls.__pydantic_fields__[entry.name].annotation)
            unit = unit_of(cls, entry.name)
            assert unit in KINDS if holds_schedule else not unit, f"{entry.name}: a unit of no number"
            continue
        assert not is_whole(cls, entry.name)
        unit = unit_of(cls, entry.name)
        assert unit is None or unit in KINDS, entry.name
        said = set(re.findall(r"\[([^\]\s]+(?: m2?)?)\]", texts[entry.name])) - {"-"}
        assert said == ({unit} if unit else set()), f"{cls.__name__}.{entry.name}: {unit!r}, and its docstring: {said}"


def test_measures_have_units() -> None:
    assert set(MEASURES) == set(MEASURE_UNITS)
    assert set(MEASURE_UNITS.values()) <= set(KINDS)


FILE = """
name = "with units"
[mesh]
pattern = "strip"
length = "10 cm"
width = "40 mm"
columns = 6
creases = ["50 %"]
fold_angle = "2 deg"
[material]
youngs_modulus = "1 MPa"
poisson_ratio = 0.3
density = "1 g/cm3"
thickness = "0.2 mm"
[laws.springs]
[laws.gravity]
acceleration = ["0 m/s2", 0.0, "-981 cm/s2"]
[laws.spin]
schedule = {times = ["0 s", "1 min"], values = ["0 Hz", "25 rpm"], ease = "10 %"}
[laws.mass_damping]
rate = "3 1/s"
[[parts]]
kind = "fixed"
nodes = "start"
[[bodies]]
kind = "cylinder"
name = "bar"
radius = "10 mm"
centre = [0.0, 0.0, "-1 m"]
turn = {times = [0.0, 1.0], values = ["0 deg", "90 deg"]}
[[stages]]
name = "one"
duration = "20 ms"
measure = "kinetic_energy"
above = "5 mJ"
set = {"laws.mass_damping.rate" = "50 1/s", "run.dt" = "5 us", "run.integrator" = "leapfrog"}
[[stages]]
name = "two"
duration = 0.1
set = {"bodies.bar.turn" = {times = [0.0, "2 ms"], values = ["90 deg", 0.0]}, "laws.spin.frequency" = "30 rpm"}
[run]
snapshots = [0.0, "20 ms"]
"""


def test_a_file_with_units_is_one_with_numbers(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(FILE)
    scene = Scene.from_toml(tmp_path / "scene.toml")
    assert scene.material == Material(1e6, 0.3, 1000.0, 2e-4)
    assert scene.mesh is not None
    source: Any = scene.mesh.source
    assert (source.length, source.width, source.creases) == (0.1, 0.04, (0.5,))
    assert source.fold_angle == pytest.approx(math.radians(2))
    spin = scene.law(Spin)
    assert spin is not None
    assert spin.schedule == Schedule((0.0, 60.0), (0.0, 25 / 60), 0.1)
    gravity: Any = scene.law("gravity")
    assert gravity.acceleration == (0.0, 0.0, -9.81)
    (bar,) = scene.bodies
    assert isinstance(bar, Cylinder)
    assert (bar.radius, bar.centre, bar.turn) == (0.01, (0.0, 0.0, -1.0), Schedule((0.0, 1.0), (0.0, math.pi / 2)))
    one, two = scene.stages
    assert (one.duration, one.above) == (0.02, 0.005)
    assert one.set == {"laws.mass_damping.rate": 50.0, "run.dt": 5e-6, "run.integrator": "leapfrog"}
    turn = Schedule((0.0, 0.002), (math.pi / 2, 0.0))
    assert two.set == {"bodies.bar.turn": turn, "laws.spin.frequency": 0.5}
    assert scene.run.snapshots == (0.0, 0.02)
    scene.save(tmp_path / "again")
    text = (tmp_path / "again" / "scene.toml").read_text()
    assert not re.search(r'= "?-?\d[^"\n]*[a-zA-Z%]+"', text), "SI numbers are written"
    again = Scene.from_toml(tmp_path / "again" / "scene.toml")
    assert again.to_toml() == scene.to_toml()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (
            '"1 MPa"',
            '"1 MN"',
            r"material.youngs_modulus = '1 MN': is a force; must be a pressure, a stress or a modulus",
        ),
        ('"40 mm"', '"40"', "mesh.width = '40': must be a number; write it without quotes, or with its unit: '40 m'"),
        ("columns = 6", 'columns = "6"', "mesh.columns = '6': must be a whole number"),
        ('"25 rpm"', '"25 m"', r"laws.spin.schedule.values\[1\] = '25 m': is a length; must be a frequency of turning"),
        ('"1 min"', '"1 kg"', r"laws.spin.schedule.times\[1\] = '1 kg': is a mass; must be a time \(s\)"),
        ('"-1 m"', '"-1 s"', r"bodies\[0\]\.centre\[2\] = '-1 s': is a time; must be a length"),
        ('"5 mJ"', '"5 mN"', r"stages\[0\]\.above = '5 mN': is a force; must be an energy \(J\)"),
        ('measure = "kinetic_energy"', 'measure = "speed"', r"measure = 'speed': no such measure|above = '5 mJ'"),
        ('"50 1/s"', '"50 Hz"', r"stages\[0\]\.set: laws.mass_damping.rate = '50 Hz': is a frequency of turning"),
        (
            '"90 deg", 0.0',
            '"90 s", 0.0',
            r"stages\[1\]\.set: bodies.bar.turn.values\[0\] = '90 s': is a time; must be an",
        ),
        ('"0 m/s2", 0.0', '"0 m/s", 0.0', r"laws.gravity.acceleration\[0\] = '0 m/s': is a speed; must be an accel"),
        ('acceleration = ["0 m/s2", 0.0, "-981 cm/s2"]', 'acceleration = "1 m/s2"', "must be three numbers"),
        ('duration = "20 ms"', 'duration = "20 msc"', "duration = '20 msc': unit 'msc' is not known; did you"),
    ],
)
def test_a_file_with_wrong_units_is_refused(old: str, new: str, words: str, tmp_path: Path) -> None:
    assert old in FILE
    (tmp_path / "scene.toml").write_text(FILE.replace(old, new))
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, words)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"0.2 mm"', "0.2 mm", r": 'thickness = 0.2 mm'; a number with its unit is a text, in quotes: \"12.5 um\"$"),
        ('"0.2 mm"', "2e-4m", "'thickness = 2e-4m'; a number with its unit is a text"),
        ('"0.2 mm"', "0,2e-3", "'thickness = 0,2e-3'; write a point for the decimals$"),
        ('"0.2 mm"', ".2e-3", "'thickness = .2e-3'; write a digit on both sides of the point"),
        ('"0.2 mm"', "1.", "'thickness = 1.'; write a digit on both sides of the point"),
        ('"0.2 mm"', "thin", "'thickness = thin'$"),
    ],
)
def test_common_mistakes_in_a_file_are_named(old: str, new: str, words: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(FILE.replace(old, new))
    refused(lambda: Scene.from_toml(tmp_path / "scene.toml"), SceneError, f"is no valid TOML: .*{words}")


def test_values_by_dotted_keys_take_units() -> None:
    scene = scenes.load("okuizumi-model-1").with_values(
        {
            "material.thickness": "12.5 um",
            "laws.spin.frequency": "25 rpm",
            "parts.0.mass": "0.36 g",
            "run.dt": "2 us",
            "mesh.outer_width": "45.5 cm",
        }
    )
    assert scene.material is not None
    spin: Any = scene.law("spin")
    mass: Any = scene.parts[0]
    assert (scene.material.thickness, spin.frequency, mass.mass, scene.run.dt) == (12.5e-6, 25 / 60, 0.36e-3, 2e-6)
    words = "parts.0.mass = '0.36 mm': is a length; must be a mass"
    refused(lambda: scene.with_values({"parts.0.mass": "0.36 mm"}), InputError, words)
    refused(lambda: scene.with_values({"run.frames": "8"}), InputTypeError, "must be a whole number")
    plain = Scene(None, None, [Spin(1.0)], [cord()], stages=[Stage("one", 0.1)])
    staged = plain.with_values({"stages.one.set.laws.spin.frequency": "25 rpm", "stages.one.duration": "3 ms"})
    assert staged.stages[0] == Stage("one", 0.003, set={"laws.spin.frequency": 25 / 60})
    ramp = {"times": [0, "1 s"], "values": ["1 Hz", "120 rpm"]}
    assert plain.with_values({"laws.spin.schedule": ramp}).law(Spin) == Spin(schedule=Schedule((0, 1), (1, 2)))


def test_many_texts_are_read_quickly(tmp_path: Path) -> None:
    unit_named("m")
    text = ", ".join(f'"{k} ms"' for k in range(50_000))
    (tmp_path / "scene.toml").write_text(FILE.replace('snapshots = [0.0, "20 ms"]', f"snapshots = [{text}]"))
    began = time.process_time()
    assert len(Scene.from_toml(tmp_path / "scene.toml").run.snapshots) == 50_000
    assert time.process_time() - began < 60.0


def test_fields_in_python_take_numbers_alone() -> None:
    refused(lambda: Material("1 MPa", 0.3, 1e3, 1e-4), InputTypeError, "youngs_modulus = '1 MPa': must be a number")  # type: ignore[arg-type]
    refused(lambda: Schedule((0, 1), ("1 rpm", 2)), InputTypeError, "must be a number")  # type: ignore[arg-type]
    scene = replace(hanging_strip(), stages=[Stage("one", 0.1, set={"material.density": "1 g/cm3"})])
    assert scene.stages[0].set == {"material.density": 1000.0}


def test_units_for_scripts() -> None:
    assert units.number("30 rpm", "Hz") == 0.5
    assert units.number(2, "Hz") == 2.0
    assert units.convert([0.0, 100.0], "degC", "K").tolist() == [273.15, 373.15]
    assert units.of(Cylinder, "radius") == "m"
    assert units.of(Stage, "above") == ""
    for unit in KINDS:
        for value in (0.0, 1e-7, 3.25, -4e8):
            text = units.text(value, unit)
            assert units.number(text, unit) == value if unit else text == f"{value:.4g}"
    words: list[tuple[Callable[[], object], str]] = [
        (lambda: units.number(None, "m"), r"value = None: must be a number \(m\)"),  # type: ignore[arg-type]
        (lambda: units.number("1 m", "mm3/x"), "unit = 'mm3/x': unit 'x' is not known"),
        (lambda: units.number("1 m", 3), "unit = 3: must be a text"),  # type: ignore[arg-type]
        (lambda: units.number("1 kg", "mm", "gap"), r"gap = '1 kg': is a mass; must be a number in mm"),
        (lambda: units.convert([1.0], "kg", "s"), "'kg' is a mass"),
        (lambda: units.convert(["much"], "mm", "m"), "values has dtype .*; it must hold numbers"),
        (lambda: units.of(Material, "thicknes"), "Material.thicknes: no such field; known are"),
        (lambda: units.of(int, "real"), "int.real: no such field"),
        (lambda: units.text(math.nan, "m"), "value = nan: must be finite"),
        (lambda: units.text(1.0, "m", 0), "digits = 0: must be a whole number from 1 to 17"),
    ]
    for action, text in words:
        refused(action, InputError, text)


def test_numbers_load_no_units() -> None:
    words = (
        "import sys\nfrom membrane_rs import scenes\nscenes.load('okuizumi-stage-1').with_values({'run.dt': 1e-6})\n"
        "assert 'pint' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", words], check=True)
