"""The part of docs/peers.md on the time of a step."""

from __future__ import annotations

from membrane_rs._markdown import table

from peers.deployment import FAST, FINER, INSTANTS, METHOD, REPEATS, SHARE, SUBSTEPS, UNTIL
from peers.speed import Speed, Steps
from peers.words import paragraph

AIMS = {"RK4 step": (18, 25), "leapfrog step": (40, 40), "deployment": (60, 100), "fast deployment": (96, 160)}
"""How many times faster than the other program membrane_rs was meant to be, with AVX2 and with AVX-512. Of the fast
deployment the aim with AVX-512 was set, and is real time there; that with AVX2 is less by the deployment's factor."""


def _pace_of(seconds: float) -> str:
    """Whether a deployment takes longer than it happens."""
    reached = "Real time is reached" if seconds <= UNTIL else "Real time is not reached"
    return f"{reached} on this one: it takes {seconds:.3g} s for {UNTIL:g} s."


def pace(speed: Speed) -> list[str]:
    """Every program's step on the flat sail."""
    mesh, model = speed.problem.mesh, speed.model
    rows = []
    for found in speed.paces:
        law = "springs" if found.law == "springs" else "triangles"
        compared = [speed.pace(f"membrane_rs {method}", law).step for method in ("rk4", "leapfrog")]
        compared += [model["rk4"], model["leapfrog"]]
        rows.append(
            (
                found.name + (" (f32)" if found.bits == 32 else ""),
                found.law,
                f"{1e6 * found.step:.1f}",
                *(f"{found.step / other:.3g}" for other in compared),
                f"{1e6 * found.limit:.2f}" if found.limit else "-",
                f"{found.whole:.3g}" if found.limit else "-",
            )
        )
    versus = ("/ rk4", "/ leapfrog", "/ model 1 rk4", "/ model 1 leapfrog")
    head = ("flat sail", "law", "step [us]", *versus, "largest step [us]", f"{UNTIL:g} s take [s]")
    return [
        "## Time of a step",
        paragraph(
            f"""The membrane of model 1 laid flat, its petals joined: {mesh.node_count} nodes, {len(mesh.edges)} edges,
            {len(mesh.triangles)} triangles, its own film, rate and tip masses. Medians. The columns that begin with a
            slash give the ratio to a step of membrane_rs: on the same flat film with the same kind of law, then of
            model 1 itself with all laws (springs that buckle, dashpots, creases with contact, drag, tethers, spool,
            turning frame): {1e6 * model["rk4"]:.1f} us with rk4, {1e6 * model["leapfrog"]:.1f} us with leapfrog.
            *{UNTIL:g} s take*: processor time at the largest stable step, extrapolated from the time of a step."""
        ),
        table(head, rows, range(2)),
        paragraph(
            """"Particle contact on, no graph" is closer to the default configuration of Newton: it detects contact
            between particles in every step, and Python calls every kernel. Its contact of triangles, also on by
            default, is off there too: it tests every particle against every triangle."""
        ),
    ]


def steps(found: Steps) -> list[tuple[str, ...]]:
    """Aims for a step and the ratios reached: rows of a table."""
    mujoco, rows = found.pace("MuJoCo RK4", "triangles"), []
    flat = "MuJoCo RK4, flat, triangles"
    for law in ("triangles", "springs"):
        ratio = mujoco.step / found.pace("membrane_rs rk4", law).step
        rows.append(_aim("RK4 step", f"flat, {law}", flat, ratio, found.width))
    rows.append(_aim("RK4 step", "model 1, all laws", flat, mujoco.step / found.model["rk4"], found.width))
    for law, peer_law in (("triangles", "neo-Hookean"), ("springs", "springs")):
        leapfrog = found.pace("membrane_rs leapfrog", law).step
        for peer in found.paces:
            if peer.name.startswith("Newton semi-implicit") and peer.law == peer_law:
                against = f"{peer.name}, flat, {peer_law}"
                rows.append(_aim("leapfrog step", f"flat, {law}", against, peer.step / leapfrog, found.width))
    return rows


AIMED = ("what", "membrane_rs", "compared with", "aim", "times faster", "")
"""The head of such a table."""


def aims(speed: Speed) -> list[str]:
    """Aims and the ratios reached."""
    done, fast, rows = speed.deployment, speed.fast, steps(speed)
    full = f"model 1, {METHOD} in {SUBSTEPS} substeps"
    for kind, name, one in (("deployment", full, done), ("fast deployment", FAST, fast)):
        whole = speed.other.whole_by(one.timed.other)
        ours = f"{name}, {1e6 * one.dt:.2f} us a step: {one.timed.processor:.3g} s"
        against = f"MuJoCo RK4, flat, triangles: {whole:.4g} s"
        rows.append(_aim(kind, ours, against, whole / one.timed.processor, speed.width))
    apart = " and ".join(
        f"{done.errors[name]:.2g} in the {curve} (perturbed starts: {done.spreads[name]:.2g} from each other)"
        for name, curve in (("rate", "deployment rate"), ("phase", "phase in degrees"))
    )
    return [
        "## Aims",
        paragraph(
            f"""Aims for {speed.width}, the vector instructions of this machine. The whole deployment of model 1 was run
            by {METHOD} in {SUBSTEPS} substeps with {SHARE:g} of its largest step of {1e6 * done.limit:.2f} us:
            {done.steps} steps in {done.timed.processor:.3g} s of processor time; the deployment itself takes
            {UNTIL:g} s. Its curves are at most {apart} from those of {FINER} at
            {1e6 * done.finer_dt:.2f} us: {"within" if done.is_within else "**beyond**"} the spread of the ensemble in
            [studies.md](studies.md). MuJoCo's {UNTIL:g} s of the flat film, at its own largest stable step, are
            extrapolated from the time of a step. Both programs take turns, {INSTANTS} in a deployment; of {REPEATS}
            deployments that with the median ratio counts."""
        ),
        paragraph(
            f"""`{FAST}` is model 1 with its film {fast.softening:g}-fold [softened](softening.md), run by {METHOD} in
            {fast.substeps} substeps: {fast.steps} steps, timed alike. The distance of its curves from those of model 1
            stands in the project's README, under "Accuracy". With AVX-512 its aim is {AIMS["fast deployment"][1]}
            times, which is real time on the processor for which it was set; that with AVX2 is less by the same factor
            as the deployment's. {_pace_of(fast.timed.processor)}"""
        ),
        table(AIMED, rows, range(3)),
    ]


def _aim(kind: str, ours: str, other: str, ratio: float, width: str) -> tuple[str, ...]:
    aim = AIMS[kind][width == "avx512"]
    return kind, ours, other, f"{aim}", f"{ratio:.3g}", "reached" if ratio >= aim else "not reached"
