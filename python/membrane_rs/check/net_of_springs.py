"""What a scene's net of springs represents of its film: effective moduli along two directions, in words."""

from __future__ import annotations

from collections.abc import Iterator

from membrane_rs.errors import MeshError
from membrane_rs.mesh.findings import Finding
from membrane_rs.mesh.moduli import NetModuli, net_moduli, rectangle_moduli
from membrane_rs.scene import Scene

_SAME = 0.002
"""Difference of two moduli, over the film's, below which the second is left out."""


def net_of_springs(scene: Scene) -> Iterator[Finding]:
    """The moduli of the net of springs, as a fact."""
    lines = net_lines(scene)
    if lines:
        rows = [f"    {what:<12} {text}" for what, text in lines]
        message = "\n".join(["net of springs, relative to the film", *rows])
        yield Finding("info", "net_of_springs", 1, message, "")


def net_lines(scene: Scene) -> list[tuple[str, str]]:
    """(what, moduli over the film's) of the net of springs; empty for a scene without a film of springs."""
    mesh, material = scene.mesh, scene.material
    has_rectangles = any(law.has_rectangles for law in scene.laws)
    if mesh is None or material is None or (scene.negative_springs in (None, "unused") and not has_rectangles):
        return []
    clip = scene.negative_springs == "clip"
    try:
        affine = rectangle_moduli(material) if has_rectangles else net_moduli(mesh, material, clip=clip)
        relaxed = affine if affine.is_balanced else net_moduli(mesh, material, relaxed=True, clip=clip)
    except MeshError as error:
        return [("moduli", f"unknown: {error}")]
    axis = 0.0 if has_rectangles else affine.axis
    along = "a side of the rectangles" if has_rectangles else f"the mesh's own axis, at {axis:.1f} degrees from x"
    lines = [
        ("direction", f"0 degrees is {along}"),
        ("uniform", _moduli(affine, axis)),
    ]
    if any(abs(own - other) > _SAME for own, other in zip(_values(affine, axis), _values(relaxed, axis), strict=True)):
        lines.append(("relaxed", _moduli(relaxed, axis)))
    lines.append(("film", f"E 1, G 1, nu {material.poisson_ratio:.3f}"))
    constants = mesh.spring_constants(material, stiffness=scene.membrane_stiffness())
    clipped = int((constants < 0.0).sum()) if clip else 0
    if clipped:
        lines.append(("clipped", f"{clipped} of {len(mesh.edges)} springs, whose constants were negative, to zero"))
    least, greatest = affine.local_extremes
    lines.append(("extremes", f"E from {least:.3f} to {greatest:.3f} over all directions, around a node"))
    lines.append(("meaning", _meaning(affine, axis)))
    return lines


def _values(moduli: NetModuli, axis: float) -> tuple[float, float, float, float]:
    """E along 0 and 45 degrees, G, nu."""
    return (
        float(moduli.modulus(axis)),
        float(moduli.modulus(axis + 45.0)),
        float(moduli.shear_modulus(axis)),
        float(moduli.poisson_ratio(axis)),
    )


def _moduli(moduli: NetModuli, axis: float) -> str:
    along, diagonal, shear, ratio = _values(moduli, axis)
    return f"E {along:.3f} along 0 degrees, {diagonal:.3f} along 45 degrees; G {shear:.3f}; nu {ratio:.3f}"


def _meaning(moduli: NetModuli, axis: float) -> str:
    if moduli.is_isotropic:
        return "within 1 % of the film in every direction"
    shear = float(moduli.shear_modulus(axis))
    if abs(shear - 1.0) < _SAME:
        return f"the film's in shear; strains along both sides are coupled as at nu = {moduli.poisson_ratio(axis):.3f}"
    soft = f"{100 * abs(1 - shear):.0f} % {'softer' if shear < 1 else 'stiffer'} in shear than the film"
    return f"{soft}; a film in every direction needs equilateral triangles at nu = 1/3, or the law triangles"
