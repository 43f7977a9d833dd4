"""Every program on a problem."""

from __future__ import annotations

from peers import mujoco_flex, newton_cloth, ours
from peers.problem import Problem
from peers.program import Program


def programs(problem: Problem) -> list[Program]:
    """membrane_rs on triangles and on springs, MuJoCo, Newton on triangles and on springs."""
    found: list[Program] = []
    guesses = {}
    for law in ("triangles", "springs"):
        own = ours.programs(problem, law)
        guesses[law] = {program.name.split()[1]: program.limit_guess or 0.0 for program in own}
        found += own
    found += mujoco_flex.programs(problem, guesses["triangles"])
    found += newton_cloth.programs(problem, "neo-Hookean", guesses["triangles"]["leapfrog"])
    found += newton_cloth.programs(problem, "springs", guesses["springs"]["leapfrog"])
    return found


def plain(problem: Problem) -> list[Program]:
    """Newton's semi-implicit solver in its default configuration, on triangles and on springs: for times only."""
    return [newton_cloth.Cloth(problem, "semi-implicit", law, None, plain=True) for law in ("neo-Hookean", "springs")]
