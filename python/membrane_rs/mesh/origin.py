"""Where a mesh comes from that another program made."""

from __future__ import annotations

from typing import NamedTuple


class MeshOrigin(NamedTuple):
    """The file that a mesh was read from, and what was done to make a mesh of it; the `source` of that mesh.

    Parameters
    ----------
    file : str
        Its path.
    scale : float
        Length of the unit of its coordinates [m].
    steps : tuple of str
        What was done, a few words each.

    Examples
    --------
    >>> from membrane_rs.mesh import MeshOrigin
    >>> print(MeshOrigin("sail.stl", 0.001, ("24 of 36 corners merged with others of equal coordinates",)))
    sail.stl, in units of 0.001 m
      24 of 36 corners merged with others of equal coordinates
    """

    file: str
    scale: float
    steps: tuple[str, ...]

    def __str__(self) -> str:
        """The file, then a line for each step."""
        return "\n".join([f"{self.file}, in units of {self.scale:g} m", *(f"  {step}" for step in self.steps)])
