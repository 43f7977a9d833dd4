"""
Folding patterns
================

A pattern makes the flat mesh from a few dimensions, with its mountain and valley creases, and the stowed shape beside
it. Here a square sail is drawn flat, and stowed in its two ways: as a cross, and wound up round its spool. Beside
it is a hexagon wound round its hub. Then a Miura sheet folds.
"""

import math

import matplotlib.pyplot as plt
from membrane_rs.folding import Miura, SpiralHexagon, SquareSail

# %%
# The pattern
# -----------
# Mountain folds are negative and valley folds positive, in the sign of the FOLD format.

sail = SquareSail(outer_width=0.455, inner_width=0.103, fold_lines=7, rows=16)
mesh = sail.mesh()
print(f"{mesh.node_count} nodes, {len(mesh.triangles)} triangles, {len(mesh.creases)} creases")

figure, axes = plt.subplots(figsize=(6, 6), layout="constrained")
axes.triplot(*(1e3 * mesh.reference[:, :2].T), mesh.triangles, color="0.85", linewidth=0.4)
for sign, colour, name in ((-1, "tab:red", "mountain"), (1, "tab:blue", "valley")):
    folds = mesh.creases[sign * mesh.fold_angles > 0]
    for number, ends in enumerate(folds):
        axes.plot(*(1e3 * mesh.reference[ends, :2].T), color=colour, label="" if number else name)
axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
axes.legend(loc="upper right")
plt.show()

# %%
# Stowed shapes
# -------------
# The same sail, seen along the spin axis, with its edges alone; beside it a hexagon, wound round its hub.

wound = SquareSail(stowage="wound").mesh()
hexagon = SpiralHexagon().mesh()
figure, row = plt.subplots(1, 3, figsize=(11, 4), layout="constrained")
for axes, title, stowed in zip(row, ("cross", "wound", "hexagon"), (mesh, wound, hexagon), strict=True):
    axes.triplot(*(1e3 * stowed.positions[:, :2].T), stowed.triangles, color="tab:gray", linewidth=0.3)
    axes.set(title=title, xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
plt.show()

# %%
# Miura's fold
# ------------
# Rigid facets fold along both directions at once. One angle, the tilt of the facets, gives the whole shape.

figure = plt.figure(figsize=(8, 5.5), layout="constrained")
for number, degrees in enumerate((5, 35, 60, 80)):
    sheet = Miura(straight_side=0.02, zigzag_side=0.02, tilt=math.radians(degrees), columns=6, rows=6)
    axes = figure.add_subplot(2, 2, number + 1, projection="3d")
    folded = sheet.mesh()
    points = 1e3 * folded.positions.T
    axes.plot_trisurf(*points, triangles=folded.triangles, color="tab:olive", linewidth=0, antialiased=False)
    axes.set(title=f"tilt {degrees} degrees, {100 * sheet.packing:.0f} % of the flat area")
    axes.set(xlim=(-60, 60), ylim=(-60, 60), zlim=(-20, 20))
    axes.set_box_aspect((3, 3, 1), zoom=1.25)
    axes.view_init(elev=45, azim=-70)
    axes.set_axis_off()
plt.show()
