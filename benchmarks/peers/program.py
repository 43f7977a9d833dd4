"""What a program must offer to be measured."""

from __future__ import annotations

from typing import Protocol

from peers.problem import Floats

NEWTON_ITERATIONS = 10
"""Of Newton's VBD and XPBD in each step: VBD's default."""


class BlownError(ArithmeticError):
    """The program itself says that a run went wrong."""


class Program(Protocol):
    """One method of one program, on one problem.

    `name` for tables. `law`: "triangles" (St. Venant-Kirchhoff), "neo-Hookean" triangles or "springs".
    `bits`: of its floating-point numbers.
    `limit_guess`: where to begin the search for its largest step [s]; None for methods without one.
    """

    name: str
    law: str
    bits: int
    limit_guess: float | None

    def start(self, dt: float) -> None:
        """Go back to the start, with this step [s]; compile what has to be."""

    def masses(self) -> Floats:
        """(n,) of the nodes, as the program holds them [kg]."""

    def step(self, n: int) -> None:
        """Take n steps. Raises BlownError."""

    def motion(self) -> tuple[Floats, Floats]:
        """Positions [m] and velocities [m/s], (n, 3) each."""
