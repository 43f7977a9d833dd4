"""scene.toml: the scene with all values resolved; mesh.npz beside it where no folding pattern made the mesh."""

from __future__ import annotations

from membrane_rs.results.record import Record
from membrane_rs.results.writer import Writer
from membrane_rs.scene.scene import SCENE_FILE
from membrane_rs.scene.toml import MESH_FILE
from membrane_rs.simulation.stepper import Stepper


class SceneFile(Writer):
    """Writes the scene at the start."""

    own_files = (SCENE_FILE, MESH_FILE)

    def start(self, sim: Stepper, record: Record) -> None:
        """Write it; again where the run is resumed, since it may have been killed before that."""
        sim.scene.save(record.path)
