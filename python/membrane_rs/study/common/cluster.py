"""Workers of a cluster, by the scheduler of dask: https://distributed.dask.org."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from membrane_rs._extras import extra
from membrane_rs._validation import show
from membrane_rs.errors import ExecutorError, InputError

SECONDS = 20.0
"""For so long the scheduler is waited for."""


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """An executor of the workers that a scheduler has, whenever they come and go.

    A run whose worker dies is made by another one. The workers need this package in the same version.

    Parameters
    ----------
    address : str
        Of the scheduler, such as "tcp://127.0.0.1:8786".

    Raises
    ------
    MissingExtraError
        distributed is not installed.
    InputError
        No scheduler at the address.
    ExecutorError
        A worker that has another version of this package, or none.
    """
    distributed = extra("distributed")
    try:
        client = distributed.Client(address, timeout=SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"dask = {show(address)}: no scheduler answers there ({reason}); start one with `dask scheduler`, and give "
            "the address that it names"
        ) from None
    with client:
        check_workers(client)
        yield client.get_executor()


def check_workers(client: Any) -> None:
    """Refuse workers whose runs may have other bits. Raises ExecutorError."""
    from membrane_rs import __version__

    for worker, found in client.run(_version, on_error="return").items():
        if found != __version__:
            what = f"has membrane_rs {found}" if isinstance(found, str) else f"has no membrane_rs ({found})"
            raise ExecutorError(f"the worker {worker} {what}; install {__version__} there, as it is here")


def _version() -> str:
    from membrane_rs import __version__

    return __version__
