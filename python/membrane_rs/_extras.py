"""Libraries that come with an extra: imported where they are needed, and named with their extra where they are missing.

The extras are those of the package's metadata: `pip install "membrane_rs[plot]"`.
"""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from membrane_rs.errors import MissingExtraError

EXTRAS = {
    "matplotlib": "plot",
    "PIL": "plot",
    "pyvista": "plot",
    "k3d": "view",
    "trame": "view",
    "trame_vtk": "view",
    "trame_vuetify": "view",
    "distributed": "sweep",
    "pyarrow": "sweep",
    "pandas": "sweep",
    "xarray": "notebook",
}
"""The smallest extra that brings a library, by the name under which that is imported."""


def need(*modules: str, use: str = "") -> None:
    """See that libraries of extras are installed, without importing them.

    Parameters
    ----------
    *modules : str
        Names under which they are imported.
    use : str, optional
        What they are for, as the beginning of the message. Default: the library's own name.

    Raises
    ------
    MissingExtraError
        One is not installed; the message says which extra to install.
    """
    for module in modules:
        if not _is_installed(module):
            raise missing(module, use)


def extra(module: str, use: str = "") -> ModuleType:
    """A library of an extra, imported. Raises MissingExtraError where it is not installed, or cannot be loaded."""
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise explained(error, use) from None
    except ImportError as error:
        raise unloadable(module, error, use) from error


def explained(error: ImportError, use: str = "") -> ImportError:
    """The error that names the extra of a module that was not found, or what a library that was found lacks; the same
    error for a module of no extra, and for one of this package.
    """
    module = (error.name or "").partition(".")[0]
    if isinstance(error, ModuleNotFoundError):
        return missing(module, use) if module in EXTRAS else error
    return error if module == __package__ else unloadable(module or "a library", error, use)


def unloadable(module: str, error: ImportError, use: str = "") -> MissingExtraError:
    """The error that a library is there, but not what it needs itself, such as a shared library of the system."""
    reason = " ".join(str(error).split())
    return MissingExtraError(
        f"{use}{use and ': '}{module} cannot be loaded ({reason}); install what it lacks, or the library anew",
        EXTRAS.get(module.partition(".")[0], ""),
    )


def missing(module: str, use: str = "") -> MissingExtraError:
    """The error that a library is not installed."""
    name = EXTRAS[module]
    reason = f"{use}: this needs {module}, which" if use else f"{module} is not installed; it"
    return MissingExtraError(f'{reason} comes with the extra {name!r}: pip install "membrane_rs[{name}]"', name)


def _is_installed(module: str) -> bool:
    try:
        return find_spec(module) is not None
    except (ImportError, ValueError):  # a module that was blocked has no specification
        return False
