"""Every error that membrane_rs raises on purpose, and the category of its warnings about a scene.

All share the base `MembraneError`, and each also derives from the nearest built-in, so that
`except ValueError` works as a user expects. Every message names the value, its place and a remedy.
"""

from __future__ import annotations

import signal
from typing import Any


class _WithRun(BaseException):
    """What may end a run."""

    run: Any = None

    def __reduce__(self) -> Any:
        """A pickle is without the run, whose frames may be many."""
        made = super().__reduce__()
        if isinstance(made, str) or len(made) < 3:
            return made
        kind, values, state, *rest = made
        return (kind, values, {name: value for name, value in state.items() if name != "run"}, *rest)


class MembraneError(_WithRun, Exception):
    """Base of all errors of membrane_rs.

    Attributes
    ----------
    run : Run or None
        What a run had recorded, where `membrane_rs.run` ended by this error; None elsewhere. A pickle is without it.
    """


class InputError(MembraneError, ValueError):
    """A value that was given is outside what the model allows."""


class InputTypeError(InputError, TypeError):
    """A value that was given has the wrong type, shape or dtype."""


class UnknownAttributeError(InputError, AttributeError):
    """An attribute that was set is none that can be."""


class MeshError(InputError):
    """A mesh that cannot be built or simulated as it stands."""


class SceneError(InputError):
    """A scene file or scene that contradicts itself or holds an unknown key or value."""


class MissingFileError(MembraneError, FileNotFoundError):
    """A file that was named is not there."""


class MissingExtraError(MembraneError, ImportError):
    """A library that comes with an extra of the package is not installed.

    Attributes
    ----------
    extra : str
        The extra to install, such as "plot".
    """

    def __init__(self, message: str, extra: str = "") -> None:
        super().__init__(message)
        self.extra = extra

    def __reduce__(self) -> tuple[type[MissingExtraError], tuple[str, str]]:
        return type(self), (str(self), self.extra)


class OutputError(MembraneError, OSError):
    """A result that cannot be written."""


class ExecutorError(MembraneError, RuntimeError):
    """Runs that cannot be made where they were sent: processes that do not start, or an executor that has broken."""


class UnstableError(MembraneError, ArithmeticError):
    """A run that stopped itself: a spurious gain of energy, a value not finite, a strain over its limit.

    Attributes
    ----------
    time : float
        Simulated time of the check that failed [s].
    step : int
        Steps taken by then.
    place : str
        Node or element where it was seen.
    law : str
        The law in which the fault was found.
    """

    def __init__(self, message: str, time: float = 0.0, step: int = 0, place: str = "", law: str = "") -> None:
        super().__init__(message)
        self.time = time
        self.step = step
        self.place = place
        self.law = law


class DisplayError(MembraneError, RuntimeError):
    """A window was asked for where there is no display."""


class AuditWarning(UserWarning):
    """An error or a warning that the audit of a scene found; `Simulation` warns of each once it is built.

    `warnings.simplefilter("error", AuditWarning)` makes each an exception, "ignore" leaves them out.
    """


class Interrupted(_WithRun, KeyboardInterrupt):
    """A signal ended a run: SIGINT, which is Ctrl-C, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1 or SIGUSR2. No error, so no
    `MembraneError`.

    Attributes
    ----------
    signum : int
        Number of the signal.
    name : str
        Its name, such as "SIGTERM".
    run : Run or None
        As that of `MembraneError`.
    """

    def __init__(self, signum: int) -> None:
        self.signum = int(signum)
        self.name = signal.Signals(signum).name
        super().__init__(f"ended by {self.name}")

    def __reduce__(self) -> tuple[type[Interrupted], tuple[int]]:
        return type(self), (self.signum,)
