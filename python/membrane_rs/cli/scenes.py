"""Commands on scenes: the list of built-in ones, and check."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import typer

from membrane_rs.cli.application import FAILED, SCENES, Json, command, nothing, print_json
from membrane_rs.cli.options import (
    Dt,
    Integrator,
    SceneArgument,
    Set,
    ShortSteps,
    Substeps,
    Until,
    load,
    substeps_of,
    with_settings,
)

if TYPE_CHECKING:
    from membrane_rs.runs import Simulation
    from membrane_rs.scene import Scene


@command(SCENES, example="scenes")
def scenes(*, json: Json = False) -> None:
    """List the built-in scenes."""
    from membrane_rs import scenes as built_in

    names = built_in.names()
    if json:
        print_json([{"name": name, "description": built_in.describe(name)} for name in names])
        return
    width = max(map(len, names))
    for name in names:
        typer.echo(f"{name:<{width}}  {built_in.describe(name)}")


@command(SCENES, example="check spinning-tether")
def check(
    scene: SceneArgument,
    *,
    set_: Set = None,
    integrator: Integrator = None,
    dt: Dt = None,
    substeps: Substeps = None,
    short_steps: ShortSteps = None,
    until: Until = None,
    json: Json = False,
) -> None:
    """Report faults and risks of a scene, the stability limit and the expected cost, without running it."""
    from membrane_rs.check import audit, facts
    from membrane_rs.errors import InputError
    from membrane_rs.mesh import MeshOrigin
    from membrane_rs.scene.staging import planned_starts

    wanted: dict[str, Any] = {
        "until": until, "integrator": integrator, "dt": dt, "substeps": substeps_of(substeps, short_steps),
    }  # fmt: skip
    chosen = load(scene, set_)
    end = wanted.pop("until") if chosen.stages else None
    if end is not None and not 0.0 < end <= chosen.run.until:
        most = chosen.run.until
        raise InputError(f"--until = {end}: must be above 0, and at most {most:g}, where the stages end (s)")
    chosen = with_settings(chosen, wanted)
    say = nothing if json else typer.echo
    say(f"Scene    {chosen.name}")
    document: dict[str, Any] = {"scene": chosen.name, "counts": chosen.counts(), "facts": facts(chosen)}
    for name, count in document["counts"].items():
        say(f"  {name:<10} {count:>9,}")
    for name, words in document["facts"].items():
        say(f"  {name:<10} {words}")
    source = None if chosen.mesh is None else chosen.mesh.source
    if isinstance(source, MeshOrigin):
        say(f"\nMesh     {source}")
        document["mesh"] = source._asdict()
    found = audit(chosen)
    document |= {"ok": found.ok, "audit": [finding.as_dict() for finding in found.findings], "runs": []}
    say(f"\nAudit\n{_indented(str(found))}")
    for k, (stage, start) in enumerate(zip(chosen.stages, planned_starts(chosen.stages), strict=False)):
        duration = stage.duration if end is None else min(stage.duration, end - start)
        if duration <= 0.0:
            break
        latest = "at most " if stage.measure is not None else ""
        say(f"\nStage    {stage.name}, {latest}{duration:g} s")
        document["runs"].append({"stage": stage.name, **_report_run(chosen.staged(k), duration, say, is_later=k > 0)})
    if not chosen.stages:
        say("")
        document["runs"].append(_report_run(chosen, chosen.run.until, say))
    if json:
        print_json(document)
    if not found.ok:
        raise typer.Exit(FAILED)


def _report_run(scene: Scene, duration: float, say: Callable[[str], None], *, is_later: bool = False) -> dict[str, Any]:
    """Step and cost of a scene without stages, or of one of its stages, for so long [s]: said, and as numbers."""
    from membrane_rs.check.redundancy import step_savings
    from membrane_rs.runs import Simulation

    sim = Simulation(scene)
    say(f"Run      {duration:g} s by {sim.integrator}")
    say(f"  stable step  {sim.stable_dt():.4g} s, limited by {sim.limiting_part}")
    say(f"  step         {sim.dt:.4g} s{', later chosen by the tolerance' if sim.is_adaptive else ''}")
    if sim.slow_laws:
        say(f"  once a step  {', '.join(sim.slow_laws)}; the others in {scene.run.substeps} substeps")
    shares = ", ".join(f"{law} {100 * share:.0f} %" for law, share in sim.contiguous_shares.items())
    say(f"  contiguous   {shares or 'none'} (share of elements in contiguous batches, the fast ones)")
    savings = step_savings(scene)
    if not savings:
        say("  savings      none: no single part sets the step, others are within 2 % of it")
    for saving in savings:
        say(f"  savings      {saving.part}: without it {saving.limit:.4g} s, {saving.gain:.3g} times as long")
        say(f"               {saving.advice}")
    found = {
        "duration": duration, "integrator": sim.integrator, "stable_dt": sim.stable_dt(), "dt": sim.dt,
        "limiting_part": sim.limiting_part, "is_adaptive": sim.is_adaptive, "slow_laws": sim.slow_laws,
        "contiguous_shares": sim.contiguous_shares, "savings": [vars(saving) for saving in savings],
    }  # fmt: skip
    sim._check_end(duration)
    steps, seconds = _expected_cost(sim, duration, is_later=is_later)
    if steps is None:
        say("  cost         unknown: the run stops by itself")
    else:
        cost = "in a time that only a run shows" if seconds is None else f"about {_duration(seconds)} on this machine"
        say(f"  cost         {steps:,} steps, {cost}")
    return found | {"steps": steps, "seconds": seconds}


def _expected_cost(sim: Simulation, duration: float, *, is_later: bool) -> tuple[int | None, float | None]:
    """Number of steps in so long [s], and their time [s], extrapolated from a few hundred steps; None for both where
    the run stops by itself within these.

    A later stage begins elsewhere than the scene, from where it is stepped here, and may become unstable there alone:
    its time is then that of the steps before, None without any.
    """
    from membrane_rs.errors import UnstableError

    steps = max(1, round(duration / sim.dt))
    taken, began, spent = 0, time.perf_counter(), 0.0
    while taken < min(steps, 300) and spent < 2.0:
        batch = min(20, steps - taken)
        try:
            sim.step(batch)
        except UnstableError:
            if not is_later:
                return None, None
            break
        taken += batch
        spent = time.perf_counter() - began
    if sim.is_adaptive and taken:
        steps = max(1, round(duration / sim.time * taken))
    return steps, steps * spent / taken if taken else None


def _duration(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds < 5400 else f"{seconds / 3600:.3g} h"


def _indented(text: str) -> str:
    return "\n".join(f"  {line}" for line in text.splitlines())
