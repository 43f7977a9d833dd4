"""Tables of docs/softening.md: distances of ensembles from the full model, and what they cost."""

from __future__ import annotations

from collections.abc import Mapping

from membrane_rs._markdown import table
from softening_cases import AGAIN, ALIKE, FULL, NARROW
from softening_distance import distance, expected_inside, front, mean_distance, shares_inside, spread, standard_error
from softening_runs import CURVES, PHASE, RATE, Ensemble
from softening_symmetry import PETALS

FORMS = {RATE: ".4f", PHASE: ".2f"}
EARLY = 0.02
"""End of the part in which a narrow displacement has not grown [s]."""
STOPPED = "stopped"


def distance_table(groups: Mapping[str, Mapping[str, Ensemble]], first: str = "scene") -> str:
    """Distance of the mean curves from those of the full model, and how much of it is chance."""
    body = []
    for group, found in groups.items():
        for label, own in found.items():
            if label != FULL:
                body.append((group, label, *(distance_cells(found[FULL], own) if own.is_whole else (STOPPED,) * 8)))
    heads = [
        f"{what}{words}" for what in CURVES.values() for words in ("", ", standard error", ", net", ", by chance [%]")
    ]
    return table((first, "ensemble", *heads), body, words=(0, 1))


def distance_cells(full: Ensemble, own: Ensemble) -> list[str]:
    """Distance, standard error, net distance and share of chance, of the rate and of the phase."""
    cells = []
    for column, form in FORMS.items():
        found = distance(full.curves(column), own.curves(column))
        numbers = (found.value, found.error, found.net)
        cells += [f"{number:{form}}" for number in numbers] + [f"{100.0 * found.chance:.2g}"]
    return cells


def fast_table(groups: Mapping[str, Mapping[str, Ensemble]], names: Mapping[str, str]) -> str:
    """Distance of the softened film of each group, its only one, from all starts of the full model.

    `names`: of the scenes of the films.
    """
    body, count, of_full, throughout = [], 0, 0, 0
    for group, found in groups.items():
        full = Ensemble([*found[FULL].runs, *found[AGAIN].runs])
        ((label, own),) = ((label, own) for label, own in found.items() if label not in {FULL, AGAIN})
        cells = [STOPPED] * 9
        if own.is_whole:
            cells = []
            shares = {column: shares_inside(own.curves(column), full.curves(column)) for column in FORMS}
            throughout += sum(min(of_start) == 1.0 for of_start in zip(*shares.values(), strict=True))
            for column, form in FORMS.items():
                one = distance(full.curves(column), own.curves(column))
                cells += [f"{number:{form}}" for number in (one.value, one.error)]
                cells += [f"{100.0 * one.chance:.2g}", f"{100.0 * shares[column].mean():.0f}"]
            cells.append(f"{full.typical('steps') / own.typical('steps'):.1f}")
        body.append((f"`{names[group]}`", label, *cells))
        count, of_full = len(own.runs), len(full.runs)
    words = ("", ", standard error", ", by chance [%]", ", inside [%]")
    heads = [f"{what}{of}" for what in CURVES.values() for of in words]
    found_table = table(("scene", "film", *heads, "steps fewer by"), body, words=(0, 1))
    caption = (
        f"Mean curves of {count} starts, against {of_full} of the full model; root of the mean square over the "
        "deployment.\n"
        "Inside is the share of the samples of single starts that lie between the lowest and the highest "
        "of the full model:\n"
        f"{100.0 * expected_inside(of_full):.0f} % on average for a start of that model itself.\n"
        f"Starts inside with both curves throughout: {throughout}."
    )
    return f"{caption}\n\n{found_table}"


def petals_table(groups: Mapping[str, Mapping[str, Ensemble]]) -> str:
    """Distance and spread of a sail whose petals are alike, and the cost of a mean by one of them.

    A petal has a quarter of the cost at least, and takes as many times the starts as its variance is larger.
    """
    body: list[tuple[str, ...]] = []
    for group, found in groups.items():
        full, own = Ensemble([*found[FULL].runs, *found[AGAIN].runs]), found[ALIKE]
        if not own.is_whole:
            body.append((group, *(STOPPED,) * 2 * 5))
            continue
        cells: list[str] = []
        for column, form in FORMS.items():
            one = distance(full.curves(column), own.curves(column))
            spreads = spread(full.curves(column)), spread(own.curves(column))
            cells += [f"{number:{form}}" for number in (one.value, one.error, *spreads)]
            cells.append(f"{(spreads[1] / spreads[0]) ** 2 / PETALS:.2f}")
        body.append((group, *cells))
    words = (": distance", ", standard error", ", spread of the full model", ", spread of petals alike", ", cost")
    return table(("scene", *(f"{what}{of}" for what in CURVES.values() for of in words)), body)


def starts_table(groups: Mapping[str, Mapping[str, Ensemble]]) -> str:
    """Single starts of each ensemble: their spread, and their share inside the full model's band."""
    body: list[tuple[str, ...]] = []
    for group, found in groups.items():
        for label, own in found.items():
            if not own.is_whole:
                body.append((group, label, *(STOPPED,) * 6))
                continue
            cells = []
            for column, form in FORMS.items():
                cells.append(f"{spread(own.curves(column)):{form}}")
                if label == FULL:
                    cells += ["-", "-"]
                    continue
                inside = 100.0 * shares_inside(own.curves(column), found[FULL].curves(column))
                cells += [f"{inside.mean():.0f}", f"{inside.min():.0f}"]
            body.append((group, label, *cells))
    heads = [f"{what}{words}" for what in CURVES.values() for words in (": spread", ", inside [%]", ", least [%]")]
    count = max(len(found[FULL].runs) for found in groups.values())
    expected = (
        f"An independent start of the full model itself would be inside the band of {count} others in "
        f"{100.0 * expected_inside(count):.0f} % of the samples on average."
    )
    return f"{table(('scene', 'ensemble', *heads), body, words=(0, 1))}\n{expected}"


def cost_table(groups: Mapping[str, Mapping[str, Ensemble]]) -> str:
    """Steps, processor time and energy error."""
    body = []
    for group, found in groups.items():
        full = found[FULL]
        for label, own in found.items():
            if label == AGAIN:
                continue
            cells = cost_cells(full, own) if own.is_whole else (STOPPED,) * 5
            body.append((group, label, *cells))
    heads = ("steps", "fewer by", "processor time [s]", "less by", "energy error [%]")
    return table(("scene", "film", *heads), body, words=(0, 1))


def cost_cells(full: Ensemble, own: Ensemble) -> tuple[str, ...]:
    """Medians of steps and processor time, both relative to the full model's, and of the error of the energy."""
    steps, seconds, error = (own.typical(name) for name in ("steps", "seconds", "error"))
    return (
        f"{steps:,.0f}",
        f"{full.typical('steps') / steps:.2f}",
        f"{seconds:.2f}",
        f"{full.typical('seconds') / seconds:.2f}",
        f"{100.0 * error:.2f}",
    )


def front_table(groups: Mapping[str, Mapping[str, Ensemble]]) -> str:
    """Error against cost, the cheapest first, and which are on the front of each curve."""
    body = []
    for group, found in groups.items():
        points = points_of(found)
        on_front = {column: {points[k][0] for k in front_of(points, column)} for column in CURVES}
        for label, seconds, errors in sorted(points, key=lambda point: point[1]):
            marks = [what.partition(" ")[0] for column, what in CURVES.items() if label in on_front[column]]
            cells = [f"{errors[column]:{form}}" for column, form in FORMS.items()]
            ratio = found[FULL].typical("seconds") / seconds
            body.append((group, label, f"{seconds:.2f}", f"{ratio:.1f}", *cells, " and ".join(marks) or "-"))
    heads = ("processor time [s]", "less by", *CURVES.values(), "on the front of")
    return table(("scene", "film", *heads), body, words=(0, 1, 6))


Point = tuple[str, float, Mapping[str, float]]
"""Label, processor time [s], and the distance of each curve."""


def points_of(found: Mapping[str, Ensemble]) -> list[Point]:
    """The points of the work-precision diagram; the full model is where its other starts are."""
    return [
        (
            FULL if label == AGAIN else label,
            own.typical("seconds"),
            {column: mean_distance(found[FULL].curves(column), own.curves(column)) for column in CURVES},
        )
        for label, own in found.items()
        if label != FULL and own.is_whole
    ]


def front_of(points: list[Point], column: str) -> list[int]:
    """Indices of the points on the front of a curve."""
    return front([seconds for _, seconds, _ in points], [errors[column] for _, _, errors in points])


def displacement_table(groups: Mapping[str, Mapping[str, Ensemble]]) -> str:
    """Spread of the full model's starts by their displacement, early and on the whole, and distance of the means."""
    body = []
    for group, found in groups.items():
        early = found[FULL].time <= EARLY
        for label in (AGAIN, NARROW):
            own = found[label]
            for column, form in FORMS.items():
                wide, curves = found[FULL].curves(column), own.curves(column)
                body.append((
                    group, label, CURVES[column], f"{spread(curves[:, early]):.1e}", f"{spread(curves):{form}}",
                    f"{mean_distance(wide[:, early], curves[:, early]):.1e}", f"{mean_distance(wide, curves):{form}}",
                    f"{standard_error(wide, curves):{form}}",
                ))  # fmt: skip
    until = f"first {1e3 * EARLY:.0f} ms"
    heads = ("curve", f"spread, {until}", "spread", f"distance, {until}", "distance", "standard error")
    return table(("scene", "ensemble", *heads), body, words=(0, 1, 2))
