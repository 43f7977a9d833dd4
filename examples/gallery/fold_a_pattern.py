"""
A pattern of one's own, folded and released
===========================================

Any flat crease pattern becomes the start of a scene: it is folded by simulation, and then released. Here a square twist
is drawn, whose middle turns by a quarter as its four pleats shut.

The same at the command line, with the pattern in a FOLD file:

.. code-block:: text

    membrane-rs fold square_twist.fold --fraction 0.85 --divide 3 --out folded.npz
"""

import warnings

import matplotlib.pyplot as plt
import membrane_rs
import numpy as np
from membrane_rs import (
    AuditWarning,
    Bending,
    Creases,
    Fixed,
    MassDamping,
    Material,
    Mesh,
    RunSettings,
    Scene,
    Triangles,
    fold,
)
from membrane_rs.plotting import plot_snapshots

# %%
# The pattern
# -----------
# A middle square, a triangle and a trapezoid at each of its sides, and a panel at each corner. Valleys are positive,
# mountains negative; pi is shut.

CM = 0.01
middle = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
rim = [(-3, -3), (1, -3), (3, -3), (3, 1), (3, 3), (-1, 3), (-3, 3), (-3, -1)]
nodes = CM * np.array([(x, y, 0.0) for x, y in middle + rim])
panels = [(0, 1, 2, 3), (0, 5, 6, 1), (1, 7, 8, 2), (2, 9, 10, 3), (3, 11, 4, 0)]
corners = [(0, 4, 5), (1, 6, 7), (2, 8, 9), (3, 10, 11)]
triangles = [*corners, *((a, b, c) for a, b, c, _ in panels), *((a, c, d) for a, _, c, d in panels)]
sides = [(0, 1), (1, 2), (2, 3), (3, 0)]
pleats = [(0, 5), (1, 6), (1, 7), (2, 8), (2, 9), (3, 10), (3, 11), (0, 4)]
letters = "VMVM" + "MVVMMVVM"
angles = [np.pi if letter == "V" else -np.pi for letter in letters]
pattern = Mesh(nodes, triangles, creases=sides + pleats, fold_angles=angles, node_sets={"middle": [0, 1, 2, 3]})

figure, axes = plt.subplots(figsize=(4.5, 4.5), layout="constrained")
for ends in pattern.boundary_edges:
    axes.plot(*(1e3 * nodes[ends, :2].T), color="0.4")
for ends, letter in zip(pattern.creases, letters, strict=True):
    colour, style = ("tab:blue", "--") if letter == "V" else ("tab:red", "-.")
    axes.plot(*(1e3 * nodes[ends, :2].T), color=colour, linestyle=style)
axes.set(title="red: mountains, blue: valleys", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
plt.show()

# %%
# Folded
# ------
# All triangles are divided first, since the panels of this pattern have to bend on the way.

found = fold(pattern.divided(3), 0.85)
print(found)


figure = plt.figure(figsize=(8, 6), layout="constrained")
for number, fraction in enumerate((0.15, 0.3, 0.6, 0.85)):
    shape = fold(pattern.divided(3), fraction).mesh.divided(12)  # drawn by the order of small triangles
    axes = figure.add_subplot(2, 2, number + 1, projection="3d")
    axes.plot_trisurf(
        *(1e3 * shape.positions.T), triangles=shape.triangles, color="tab:olive", linewidth=0, antialiased=False
    )
    axes.set(title=f"{fraction:g} of the angles", xlim=(-38, 38), ylim=(-38, 38), zlim=(-19, 19))
    axes.set_box_aspect((4, 4, 2), zoom=1.3)
    axes.view_init(elev=55, azim=-60)
    axes.set_axis_off()
plt.show()

# %%
# Released
# --------
# A film of 25 um whose creases spring back to a fifth of their folds. Its middle is held.

film = Material(youngs_modulus=3.2e9, poisson_ratio=0.34, density=1420.0, thickness=25e-6)
scene = Scene(
    found.mesh,
    film,
    laws=[Triangles(buckling=1.0, buckling_on_creases=1.0), Bending(),
          Creases(stiffness=1.0, fold_fraction=0.2), MassDamping(rate=30.0)],
    parts=[Fixed(nodes="middle")],
    name="square-twist",
    run=RunSettings(until=0.08, integrator="leapfrog"),
)  # fmt: skip
warnings.simplefilter("ignore", AuditWarning)  # of obtuse triangles, whose bending is coarse
run = membrane_rs.run(scene, frames=81)
figure = plot_snapshots(run, [0.0, 0.004, 0.008, 0.012, 0.02, 0.08])
