"""docs/peers.md, in words and tables."""

from __future__ import annotations

import math
from collections.abc import Sequence

from machine import cpu
from membrane_rs._markdown import table

from peers.measure import GROWTH, TRIAL_STEPS, Refinement, nearest
from peers.picture import FILMS
from peers.program import NEWTON_ITERATIONS
from peers.speed import Speed
from peers.speed_report import aims, pace
from peers.words import bullets, paragraph
from peers.work_precision import WANTED, WorkPrecision, measured_order, seconds_at


def text(diagram: WorkPrecision, speed: Speed, versions: dict[str, str]) -> str:
    """The whole page."""
    parts = [
        *_head(versions),
        *_same(diagram),
        *_work(diagram),
        _best(diagram),
        *pace(speed),
        *aims(speed),
        _limits(diagram),
    ]
    return "\n\n".join(part.rstrip() for part in parts) + "\n"


def _head(versions: dict[str, str]) -> list[str]:
    named = ", ".join(f"{name} {version}" for name, version in versions.items())
    programs = [
        """**MuJoCo**: a flex of triangles with `elastic2d="stretch"`, St. Venant and Kirchhoff's law, double precision;
        `Euler` (symplectic), `RK4`, and `discrete`, implicit in position and velocity. `implicit` and `implicitfast`
        refuse such a flex, and it cannot have springs along its edges.""",
        f"""**Newton**: `semi-implicit` (symplectic Euler), `VBD` and `XPBD` ({NEWTON_ITERATIONS} iterations each),
        single precision, on the processor; triangles of a neo-Hookean film, or springs. `XPBD` has no triangles.""",
        """**membrane_rs**: `rk4`, `leapfrog`, `dopri5` (with a given step), double precision; triangles (St. Venant and
        Kirchhoff's law, never wrinkled), or springs (never buckled).""",
    ]
    return [
        "# MuJoCo, Newton and membrane_rs on one membrane",
        paragraph(
            f"""Made by `make peers`, which installs MuJoCo and Newton as an optional extra: {named}. Processor:
            {cpu()};
            one core, one thread, processor time. All programs are run alternately in one session."""
        ),
        paragraph(
            """A flat elastic membrane with tip masses on its corners is set spinning in empty space, unstretched. It
            expands, vibrates in its own plane and continues to turn. It has no creases, buckling, contact or damping,
            so that all of the programs can simulate it."""
        ),
        bullets(programs),
        paragraph(
            """Each program runs in its fastest configuration: contact and other unneeded features are off, MuJoCo takes
            all steps in one call, Newton's steps are captured as a graph and replayed without Python. Compilation is
            not timed."""
        ),
    ]


def _same(diagram: WorkPrecision) -> list[str]:
    problem, film = diagram.problem, diagram.problem.material
    x = problem.mesh.reference[:, 0]
    rows = [
        (
            row.name,
            row.law,
            f"{1e3 * row.mass:.6f}",
            f"{1e3 * row.energy:.6f}",
            f"{100 * row.peak:.4f} %",
            f"{1e3 * row.peak_time:.4f}",
            "-" if row.apart == 0.0 else f"{row.apart:.1e}",
            f"{row.nearest:.1e}",
        )
        for row in diagram.sameness
    ]
    head: tuple[str, ...] = ("program", "law", "mass [g]", "kinetic energy [mJ]")
    head += ("first maximum of the corner radius", "at [ms]")
    head += ("difference due to the material law", "smallest error of any run")
    return [
        "## Equivalence of the problems",
        paragraph(
            f"""The {problem.name}, {len(problem.mesh.triangles)} triangles, {len(problem.mesh.edges)} edges,
            {x.max() - x.min():g} m wide: rubber of E_Y = {film.youngs_modulus:g} Pa, nu = {film.poisson_ratio:.3g},
            {film.density:g} kg/m3, {film.thickness:g} m thick, soft so that its strain is well above single precision;
            tips of {1e3 * problem.tip_mass:g} g, {problem.spin / (2 * math.pi):g} turns per second, {problem.until:g}
            s."""
        ),
        table(head, rows, range(2)),
        paragraph(
            f"""*Mass* and *kinetic energy* as each program holds them at the start. *First maximum of the corner
            radius*: relative to the flat corners, in the converged motion. *Difference due to the material law*: of the
            converged motion from membrane_rs's on triangles, RMS over nodes and {problem.instants} instants, over the
            RMS of what the membrane moves beyond rigid rotation. The diagram excludes it. *Smallest error of any run*:
            the smallest difference of any of the program's runs from its converged motion, which shows that the program
            converges to it."""
        ),
        paragraph(
            f"""Converged motions: membrane_rs by its rk4 ({diagram.own_error:.0e} from itself at twice the step),
            MuJoCo by its own RK4 at half of the finest step of the diagram. Newton's single precision does not allow
            such convergence: its springs are measured against membrane_rs's, its triangles against the same law in
            double precision (`benchmarks/peers/neo_hookean.py`). St. Venant and Kirchhoff's and the neo-Hookean film
            agree at small strain only. A network of springs is another model of the film: on right triangles it is not
            isotropic."""
        ),
    ]


def _work(diagram: WorkPrecision) -> list[str]:
    tables = []
    for film, laws in FILMS.items():
        refinements = [refinement for refinement in diagram.refinements if refinement.program.law in laws]
        head = (film, "largest step [us]", "order", *(f"{wanted:.0e}" for wanted in WANTED), "smallest error")
        tables.append(table(head, [_costs(refinement) for refinement in refinements]))
    dopri5 = next(
        refinement.program for refinement in diagram.refinements if refinement.program.name == "membrane_rs dopri5"
    )
    begins = 1e6 * (dopri5.limit_guess or math.nan)
    return [
        "## Error against work",
        "![Error against processor time and steps, for each program on triangles and on springs](peers.png)",
        paragraph(
            f"""Processor time [ms] that each program takes for a given error against its own converged motion,
            interpolated between two of its steps. *Largest step*: by bisection on growth, kinetic energy {GROWTH:g}
            times that of the start within {TRIAL_STEPS} steps; *none*: an implicit method, whose largest step here is
            {1e6 * diagram.problem.interval:g} us. dopri5 grows from {begins:.1f} us on (triangles), too slowly to be
            detected here. *Order*: slope over the steps above the rounding error."""
        ),
        *tables,
        paragraph(
            """The start is free of elastic force. Symplectic Euler with the initial velocities therefore gives the
            positions of leapfrog, whose velocities are those of half a step later: order 2, and the same error at the
            same step in all three programs, above the rounding error."""
        ),
    ]


def _costs(refinement: Refinement) -> tuple[str, ...]:
    costs = []
    for wanted in WANTED:
        seconds = seconds_at(refinement.levels, wanted)
        costs.append(f"{1e3 * seconds:.3g}" if math.isfinite(seconds) else "-")
    order, limit = measured_order(refinement.levels), refinement.limit
    return (
        refinement.program.name + (" (f32)" if refinement.program.bits == 32 else ""),
        f"{1e6 * limit:.1f}" if limit else "none",
        f"{order:.1f}" if math.isfinite(order) else "-",
        *costs,
        f"{nearest(refinement.levels).error:.0e}",
    )


def _best(diagram: WorkPrecision) -> str:
    lines = []
    for film, laws in FILMS.items():
        refinements = [refinement for refinement in diagram.refinements if refinement.program.law in laws]
        for wanted in WANTED:
            ours = _cheapest(refinements, wanted, ours=True)
            peer = _cheapest(refinements, wanted, ours=False)
            what = f"- {film}, error {wanted:.0e}: "
            if ours and peer:
                ratio = peer[0] / ours[0]
                side = f"{ratio:.2g} times faster than" if ratio >= 1 else f"**{1 / ratio:.2g} times slower** than"
                lines.append(f"{what}{ours[1]} is {side} {peer[1]}.")
            elif ours:
                lines.append(f"{what}{ours[1]}; no other program reaches it.")
            elif peer:
                lines.append(f"{what}**{peer[1]} only.**")
    text = "The fastest method of membrane_rs beside the fastest of the other programs, at the same error:"
    return f"## Fastest program for each error\n\n{text}\n\n" + "\n".join(lines)


def _cheapest(refinements: Sequence[Refinement], wanted: float, *, ours: bool) -> tuple[float, str] | None:
    costs = [
        (seconds_at(refinement.levels, wanted), refinement.program.name)
        for refinement in refinements
        if refinement.program.name.startswith("membrane_rs") == ours
    ]
    return min((cost for cost in costs if math.isfinite(cost[0])), default=None)


def _limits(diagram: WorkPrecision) -> str:
    ours = next(refinement for refinement in diagram.refinements if refinement.program.name == "membrane_rs leapfrog")
    first = ours.levels[0]
    named = "; ".join(
        f"{refinement.program.name} on {refinement.program.law}, {level.error:.1e} in {level.seconds:.2g} s"
        for refinement in diagram.refinements
        if refinement.limit is None
        for level in [nearest(refinement.levels)]
    )
    floors = ", ".join(
        f"{nearest(refinement.levels).error:.1e} on {refinement.program.law}"
        for refinement in diagram.refinements
        if refinement.program.name == "Newton semi-implicit"
    )
    points = [
        f"""MuJoCo's `discrete` and Newton's `VBD` are implicit, and remain stable at steps at which every explicit
        method is unstable. This suits relaxation to equilibrium, and stiff parts that must not set the step. A
        transient motion they damp, at order 1. Their smallest errors here: {named}. The longest step of membrane_rs's
        leapfrog has an error of {first.error:.1e} on {ours.program.law}, in {first.seconds:.2g} s.""",
        f"""Single precision bounds the error of Newton from below, here by {floors}: more steps only increase it. The
        strain of a stiff film is far smaller than that.""",
        """MuJoCo and Newton simulate rigid bodies, joints, friction and contact between anything and anything; Newton
        runs on graphics processors, many scenes at once. None of that is used here, and membrane_rs has none of it.""",
    ]
    return "## Where the other programs are better, and where not\n\n" + bullets(points)
