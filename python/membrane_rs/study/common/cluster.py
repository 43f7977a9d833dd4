"""Workers of a cluster, by the scheduler of dask: https://distributed.dask.org."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager, suppress
from typing import Any

from membrane_rs._extras import extra
from membrane_rs._validation import show
from membrane_rs.errors import ExecutorError, InputError

START = "start one with `dask scheduler`, and give the address that it names"
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
        A worker that has another version of this package, or none; a scheduler that ends before the runs do.
    """
    distributed = extra("distributed")
    if not isinstance(address, str) or not address.strip():  # for which distributed starts a cluster of its own
        raise InputError(f"dask = {show(address)}: is no address of a scheduler; {START}")
    client = distributed.Client.__new__(distributed.Client)
    try:
        client.__init__(address, timeout=SECONDS, set_as_default=False)
    except Exception as error:  # noqa: BLE001 - what answers may be no scheduler: errors of every kind
        with suppress(Exception):
            # Else it closes when it is collected as garbage: if that is while another client starts, both wait for ever
            # for the lock of their loops.
            client.close()
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(f"dask = {show(address)}: no scheduler answers there ({reason}); {START}") from None
    with _quiet(), client:
        check_workers(client)
        try:
            yield client.get_executor()
        except ExecutorError as error:
            if client.status == "running":
                raise
            raise ExecutorError(
                f"the scheduler at {address} is gone; runs that are done are in the folder, if there is one: start "
                "another scheduler, and go on with them"
            ) from error


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep what distributed logs of a lost connection, with a traceback, from the screen: an error says the same."""
    logger = logging.getLogger("distributed")
    level = logger.level
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    finally:
        logger.setLevel(level)


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
