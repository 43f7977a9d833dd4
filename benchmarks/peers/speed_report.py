"""The part of docs/peers.md on the time of a step."""

from __future__ import annotations

from peers.speed import UNTIL, Pace, Speed
from peers.words import paragraph, table

AIMS = {"RK4 step": (18, 25), "leapfrog step": (40, 40), "deployment": (60, 100)}
"""How many times faster than the peer membrane_rs was meant to be, with AVX2 and with AVX-512."""


def pace(speed: Speed) -> list[str]:
    """Every program's step on the flat sail."""
    mesh, model = speed.problem.mesh, speed.model
    rows = []
    for found in speed.paces:
        law = "springs" if found.law == "springs" else "triangles"
        compared = [_pace(speed, f"membrane_rs {method}", law).step for method in ("rk4", "leapfrog")]
        compared += [model.steps["rk4"], model.steps["leapfrog"]]
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
        "## The time of a step",
        paragraph(
            f"""The membrane of model 1 laid flat, its petals joined: {mesh.node_count} nodes, {len(mesh.edges)} edges,
            {len(mesh.triangles)} triangles, its own film, rate and tip masses. Medians. The columns that begin with a
            stroke divide a step by one of membrane_rs: on the same flat film with the same kind of law, then of model 1
            itself with everything on (springs that buckle, dashpots, creases with contact, drag, tethers, spool,
            turning
            frame): {1e6 * model.steps["rk4"]:.1f} us with rk4, {1e6 * model.steps["leapfrog"]:.1f} us with leapfrog.
            *{UNTIL:g} s take*: processor time at the largest stable step, extrapolated from the time of a step."""
        ),
        table(head, rows, 2),
        paragraph(
            """"Particle contact on, no graph" is nearer to how Newton comes: it looks for contact between particles in
            every step, and Python calls every kernel. Its contact of triangles, also on as it comes, is off there
            too: it
            tries every particle against every triangle."""
        ),
    ]


def aims(speed: Speed) -> list[str]:
    """What was aimed at, and what was reached."""
    model, mujoco = speed.model, _pace(speed, "MuJoCo RK4", "triangles")
    rows = []

    def row(kind: str, ours: str, other: str, ratio: float) -> None:
        aim = AIMS[kind][speed.width == "avx512"]
        rows.append((kind, ours, other, f"{aim}", f"{ratio:.3g}", "reached" if ratio >= aim else "not reached"))

    flat = "MuJoCo RK4, flat, triangles"
    for law in ("triangles", "springs"):
        row("RK4 step", f"flat, {law}", flat, mujoco.step / _pace(speed, "membrane_rs rk4", law).step)
    row("RK4 step", "model 1, everything on", flat, mujoco.step / model.steps["rk4"])
    for law, peer_law in (("triangles", "neo-Hookean"), ("springs", "springs")):
        leapfrog = _pace(speed, "membrane_rs leapfrog", law).step
        for peer in speed.paces:
            if peer.name.startswith("Newton semi-implicit") and peer.law == peer_law:
                row("leapfrog step", f"flat, {law}", f"{peer.name}, flat, {peer_law}", peer.step / leapfrog)
    limit = model.limits["leapfrog"]
    at_limit = UNTIL / limit * model.steps["leapfrog"]
    whole = f"{flat}: {mujoco.whole:.4g} s"
    default = f"model 1, leapfrog, its default step of {1e6 * model.dt:.2f} us: {model.deployment:.3g} s"
    longest = f"model 1, leapfrog, its largest step of {1e6 * limit:.2f} us: {at_limit:.3g} s, extrapolated"
    row("deployment", default, whole, mujoco.whole / model.deployment)
    row("deployment", longest, whole, mujoco.whole / at_limit)
    return [
        "## What was aimed at",
        paragraph(
            f"""Aims for {speed.width}, the vector instructions of this machine. The deployment of model 1 with
            leapfrog at
            its default step was run whole; MuJoCo's {UNTIL:g} s of the flat film, at its own largest stable step, are
            extrapolated from the time of a step."""
        ),
        table(("what", "membrane_rs", "against", "aim", "times faster", ""), rows, 3),
    ]


def _pace(speed: Speed, name: str, law: str) -> Pace:
    return next(found for found in speed.paces if found.name == name and found.law == law)
