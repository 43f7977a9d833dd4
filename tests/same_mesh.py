"""Whether two meshes are the same, to the bit."""

from __future__ import annotations

from membrane_rs import Mesh


def check_same(mesh: Mesh, other: Mesh) -> None:
    """Two meshes have the same arrays, to the bit, and the same node sets."""
    for name in ("reference", "triangles", "positions", "creases", "fold_angles", "bridges"):
        one, two = getattr(mesh, name), getattr(other, name)
        assert one.shape == two.shape, name
        assert one.tobytes() == two.tobytes(), name
    for kind in ("node_sets", "triangle_sets"):
        one, two = getattr(mesh, kind), getattr(other, kind)
        assert list(one) == list(two)
        assert all(one[name].tolist() == two[name].tolist() for name in one)
