"""Wrong scene files: what the loader refuses the schema refuses too, wherever a schema can tell; and never more."""

from __future__ import annotations

from pathlib import Path

import pytest
from membrane_rs import Scene
from membrane_rs.errors import InputError, SceneError
from membrane_rs.scene.bodies import BODIES
from membrane_rs.scene.laws import LAWS
from membrane_rs.scene.parts import PARTS
from test_schema import faults
from test_units import FILE

PLAIN = """
[mesh]
pattern = "strip"
length = 0.1
width = 0.04
columns = 4
[material]
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000.0
thickness = 1e-4
"""
FALLING = PLAIN + '[[parts]]\nkind = "fixed"\nnodes = "start"\n'
BAR = '[[bodies]]\nkind = "cylinder"\nname = "bar"\nradius = 0.1\n'
STAGE = '[[stages]]\nname = "a"\nduration = 0.1\n'
CORD = (
    '[[parts]]\nkind = "tether"\nstart = [0, 0, 0]\nend = [0, 0, 1]\nsegments = 1\naxial_stiffness = 1.0\n'
    "linear_density = 1.0\n"
)


def refusal(text: str, folder: Path) -> str:
    """What the loader says of a scene file; empty where it takes it."""
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    try:
        Scene.from_toml(folder / "scene.toml")
    except InputError as error:
        return str(error)
    return ""


BOTH = [
    *((f"{PLAIN}[laws.{kind}]\nnone_such = 1\n", "none_such: no such key") for kind in LAWS),
    *((f'{PLAIN}[[parts]]\nkind = "{kind}"\nnone_such = 1\n', "none_such: no such key") for kind in PARTS),
    *((f'{PLAIN}[[bodies]]\nkind = "{kind}"\nname = "a"\nnone_such = 1\n', "none_such: no") for kind in BODIES),
    (f"{PLAIN}{STAGE}none_such = 1\n", "none_such: no such key"),
    (f"{PLAIN}[run]\nnone_such = 1\n", "none_such: no such key"),
    ("", "a scene needs nodes"),
    ("[run]\nuntil = 0.1\n", "a scene needs nodes"),
    (PLAIN.partition("[material]")[0], "a mesh needs one"),
    (PLAIN.replace("density = 1000.0\n", ""), "density: is missing"),
    (PLAIN.replace("columns = 4", "columns = true"), "must be a whole number"),
    (PLAIN.replace("columns = 4", "columns = 4.5"), "must be a whole number"),
    (PLAIN.replace("1e-4", '"0.1"'), "write it without quotes"),
    (PLAIN.replace("1e-4", '"75,5 um"'), "write a point for the decimals"),
    (PLAIN.replace("1e-4", '"-75 um"'), "must be greater than 0"),
    (PLAIN.replace("1e-4", f'"1{" " * 200}mm"'), "must be a number"),
    (PLAIN.replace('pattern = "strip"', 'file = "a.npz"\npattern = "strip"'), "either pattern"),
    (PLAIN.replace('"strip"', '"square"'), "is not known"),
    (FALLING.replace("[[parts]]", "[parts]"), "must be a list of tables"),
    (FALLING.replace('kind = "fixed"\n', ""), "kind: is missing"),
    (FALLING.replace('"start"', '""'), "must be the name of a node set"),
    (FALLING.replace('"start"', "[]"), "at least one node"),
    (FALLING.replace('"start"', "[-1]"), "none below 0"),
    (FALLING.replace('"start"', "[1, 1]"), "must not name a node twice"),
    (f'{FALLING}name = "a/b"\n', "names a folder"),
    (f'{FALLING}name = ".."\n', "names a folder"),
    (f'{FALLING}name = "springs"\n', "is that of a law"),
    (f"{PLAIN}[laws.springs]\n[laws.triangles]\n", "each is the law of the film"),
    (f"{PLAIN}[laws.gravity]\nacceleration = [0.0, 0.0]\n", "three numbers"),
    (f"{PLAIN}[laws.pressure]\n", "pressure: is missing"),
    (f"{PLAIN}[laws.springs]\nbuckling = -1\n", "must be at least 0"),
    (f"{PLAIN}[laws]\nsprings = true\n", "must be a table"),
    (
        f"{PLAIN}[laws.spin]\nfrequency = 1.0\nschedule = {{times = [0.0], values = [1.0]}}\n",
        "not used with a schedule",
    ),
    (f"{PLAIN}[laws.spin]\nacceleration = 1.0\nschedule = {{times = [0.0], values = [1.0]}}\n", "not used with"),
    (f"{PLAIN}[laws.spin]\nschedule = {{times = [], values = []}}\n", "must be 1 to 10000"),
    (f"{PLAIN}[laws.spin]\nschedule = {{times = [0.0]}}\n", "values: is missing"),
    (BAR.join((PLAIN, "direction = [0, 0, 0.0]\n")), "must not be 0"),
    (BAR.join((PLAIN, "membrane = false\ncords = false\n")), "nothing feels the body"),
    (PLAIN + BAR.replace('"bar"', '"a bar"'), "must be letters, digits and underscores"),
    (PLAIN + BAR.replace('"bar"', '"kinetic"'), "is the name of a term of the energy"),
    (PLAIN + BAR.replace("radius = 0.1\n", ""), "radius: is missing"),
    (f"{PLAIN}[run]\nuntil = 1e13\n", "must be from 1e-15 to 1e"),
    (f'{PLAIN}[run]\nintegrator = "rk5"\n', "is no method"),
    (f"{PLAIN}[run]\nrelax = 0.1\nsettle = 0.1\n", "is the old name of relax, which is there too"),
    (f"{PLAIN}[run]\nuntil = 0.1\n{STAGE}", "the run ends with the last of the stages"),
    (PLAIN + STAGE.replace('"a"', '" "'), "not all blank"),
    (PLAIN + STAGE.replace("0.1", "1e-16"), "must be from 1e-15 to 1e"),
    (f"{PLAIN}{STAGE}below = 1.0\n", "is given without measure"),
    (f'{PLAIN}{STAGE}measure = "hub_angle"\n', "neither below nor above is given"),
    (f'{PLAIN}{STAGE}measure = "hub_angle"\nbelow = 1.0\nabove = 1.0\n', "both below and above"),
    (f'{PLAIN}{STAGE}without = ["a", "a"]\n', "twice"),
    (f'{PLAIN}{STAGE}set = {{"run.until" = 0.1}}\n', "is no setting of a stage"),
    (f'{PLAIN}{STAGE}scale = {{"thickness" = 2.0}}\n', "does not begin with"),
    (PLAIN + STAGE + "set = {laws.springs.buckling = 1.0}\n", "does not begin with"),
    (PLAIN + "".join(STAGE.replace('"a"', f'"{k}"') for k in range(101)), "must be at most 100"),
    (f'name = ".."\n{PLAIN}', "names a folder"),
]


@pytest.mark.parametrize(("text", "words"), BOTH, ids=[words for _, words in BOTH])
def test_both_refuse(text: str, words: str, tmp_path: Path) -> None:
    assert words in refusal(text, tmp_path)
    assert faults(text) != []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (PLAIN.replace("1e-4", '"0.1 kg"'), "is a mass; must be a length"),  # units are without number
        (PLAIN.replace("1e-4", '"0.1 mum"'), "unit 'mum' is not known"),
        (PLAIN.replace("1e-4", "nan"), "must be finite"),  # JSON has no such number
        (PLAIN.replace("columns = 4", "columns = 4.0"), "must be a whole number"),  # which 4.0 is in JSON
        (FALLING.replace('"start"', '"rim"'), "no such node set"),  # names that the scene has
        (f'{PLAIN}{STAGE}without = ["rim"]\n', "no law of that kind"),
        (f"{PLAIN}{STAGE}{STAGE}", "is that of an earlier stage too"),
        (f"{PLAIN}[laws.spin]\nschedule = {{times = [0.0, 1.0], values = [1.0]}}\n", "give one for each"),
    ],
)  # fmt: skip
def test_the_loader_alone_refuses(text: str, words: str, tmp_path: Path) -> None:
    assert words in refusal(text, tmp_path)
    assert faults(text) == []


@pytest.mark.parametrize(
    "text",
    [
        PLAIN,
        FALLING,
        PLAIN.replace("1e-4", '" 75\\tum "'),
        PLAIN.replace("1e-4", '".1 mm"'),
        PLAIN.replace("1e6", '"1e6 N/m2"'),
        PLAIN.replace("columns = 4", 'columns = 4\nfold_angle = "\u22122 deg"\ncreases = [0.5]'),
        f'{PLAIN}[laws.air_drag]\ntemperature = "-20 degC"\n',
        f'{PLAIN}[laws.mass_damping]\nrate = "3 1/s"\n[run]\nrelax = "-0 s"\n',
        f'{PLAIN}[laws.spin]\nacceleration = "0 Hz/s"\nschedule = {{times = [0.0], values = [1.0]}}\n',
        f'{PLAIN}[laws.springs]\n[laws.triangles]\n{STAGE}without = ["triangles"]\n',
        f'{PLAIN}{BAR}[laws.springs]\n{STAGE}set = {{"bodies.bar.radius" = "1 mm", "run.dt" = 1e-6}}\n',
        CORD,
        f'{CORD}name = "a.b"\n{STAGE}scale = {{"parts.a.b.axial_stiffness" = 2.0}}\n',
    ],
)
def test_both_take(text: str, tmp_path: Path) -> None:
    assert refusal(text, tmp_path) == ""
    assert faults(text) == []


def test_a_byte_order_mark_is_no_fault(tmp_path: Path) -> None:
    assert refusal(f"\ufeff{FILE}", tmp_path) == ""


def test_no_text_is_refused_in_one_line(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_bytes(b"\xff\xfe[\x00")
    with pytest.raises(SceneError, match="is no UTF-8 text") as raised:
        Scene.from_toml(tmp_path / "scene.toml")
    assert "\n" not in str(raised.value)
