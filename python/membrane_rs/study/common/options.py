"""What all studies of many runs take: how long runs are, what they record, where they are made, where they are kept."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, TypedDict, TypeVar, cast

from membrane_rs.results.recorded import Recorded
from membrane_rs.scene import Scene
from membrane_rs.study.common.many_runs import ManyRuns, Where
from membrane_rs.study.common.one_run import RunSetup
from membrane_rs.study.common.perturbation import SHIFT

F = TypeVar("F", bound=Callable[..., Any])


class RunOptions(TypedDict, total=False):
    """Keyword parameters of studies of many runs; `membrane_rs.study.sweep` describes them."""

    until: float | None
    samples: int | None
    record: Recorded | None
    shift: float
    time_limit: float | None
    executor: Where
    jobs: int | None
    out: str | Path | None
    overwrite: bool
    retry: bool


def many_runs(
    scene: Scene,
    request: Mapping[str, Any],
    outputs: Sequence[str],
    *,
    until: float | None = None,
    samples: int | None = None,
    record: Recorded | None = None,
    shift: float = SHIFT,
    time_limit: float | None = None,
    executor: Where = "threads",
    jobs: int | None = None,
    out: str | Path | None = None,
    overwrite: bool = False,
    retry: bool = False,
) -> ManyRuns:
    """The runs of a study with its options.

    Parameters
    ----------
    scene : Scene
        From which all runs depart.
    request : mapping
        What else a folder of the same runs must have been asked for: plain values by name.
    outputs : sequence of str
        Patterns of further files that are the folder's own.
    until, samples, record, shift, time_limit, executor, jobs, out, overwrite, retry
        As in `membrane_rs.study.sweep`.

    Raises
    ------
    InputError, InputTypeError, OutputError
        As `ManyRuns` does.
    """
    return ManyRuns(
        scene, RunSetup(until, samples, record or {}, shift, time_limit), executor=executor, jobs=jobs, folder=out,
        request=request, outputs=outputs, overwrite=overwrite, retry=retry,
    )  # fmt: skip


def takes_run_options(function: F) -> F:
    """A function with `**options: Unpack[RunOptions]` whose signature, in helps and completion, names each of them.

    It raises TypeError for a keyword that is none of them.
    """
    own = inspect.signature(function)
    named = [one for one in own.parameters.values() if one.kind is not inspect.Parameter.VAR_KEYWORD]
    options = [
        one for name, one in inspect.signature(many_runs).parameters.items() if name in RunOptions.__annotations__
    ]
    signature = own.replace(parameters=[*named, *options])

    @wraps(function)
    def called(*args: Any, **keywords: Any) -> Any:
        try:
            signature.bind(*args, **keywords)
        except TypeError as error:
            raise TypeError(f"{function.__name__}(): {error}") from None
        return function(*args, **keywords)

    called.__signature__ = signature  # type: ignore[attr-defined]
    return cast("F", called)
