"""Arrays that a user gives: of numbers, and without a mask."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from membrane_rs.errors import InputError, InputTypeError


def numeric(
    values: Any, name: str, kinds: str, wanted: str, irregular: type[InputError] = InputTypeError
) -> NDArray[Any]:
    """`values` as an array of one of some kinds of dtype ("f" float, "i" "u" whole numbers, "b" truth values).

    Raises
    ------
    InputTypeError
        Another dtype, or masked entries, whose mask would be lost.
    irregular
        Rows of different lengths.
    """
    if _is_masked(values):
        raise InputTypeError(
            f"{name} has masked entries, and must hold {wanted}; fill them (numpy.ma.filled(values, fill_value)) or "
            "leave their rows out"
        )
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, RecursionError) as error:
        raise irregular(f"{name} is no regular array ({error}); give rows of equal length") from None
    if array.dtype.kind not in kinds and (array.size or array.dtype.kind not in "fiu"):
        raise InputTypeError(f"{name} has dtype {array.dtype}; it must hold {wanted}")
    return array


def _is_masked(values: object, depth: int = 2) -> bool:
    """Whether an array, or one in a list of lists, has masked entries."""
    if isinstance(values, np.ma.MaskedArray):
        return bool(np.ma.is_masked(values))
    return depth > 0 and isinstance(values, list | tuple) and any(_is_masked(item, depth - 1) for item in values)
