"""
A sweep of two values
=====================

`study.sweep` runs a scene for every combination of values, on all cores of the machine. Here a crease springs open: how
fast depends on its stiffness and on the thickness of the film.
"""

from membrane_rs import study

found = study.sweep(
    "single-crease",
    {
        "laws.creases.stiffness": "1:20:log7",
        "material.thickness": "5um:10um:5",
    },
    until=0.02,
    samples=41,
    record=["largest_speed"],
)
print(found.summary())

# %%
# A map
# -----
# Two parameters are a map for each column of the table, one is a curve.

figure = found.plot(["highest_largest_speed", "final_rate"])

# %%
# One row
# -------
# A row has the values, the outcome, the features of the curves, and the extremes of what was recorded. A run that fails
# is a row as well, with the reason.

fastest = max(found.rows, key=lambda row: row["highest_largest_speed"])
print(found.name_of(fastest))
print(f"{fastest['outcome']}, {fastest['highest_largest_speed']:.3g} m/s")
