"""Rows of many runs as a table: in Parquet (an extra), in CSV, or of pandas (an extra). Numbers keep all bits."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from membrane_rs._extras import extra, need
from membrane_rs._files import replacing, write_text
from membrane_rs._validation import show
from membrane_rs.errors import InputError, MissingExtraError

if TYPE_CHECKING:
    import pandas as pd

Format = Literal["parquet", "csv"]
FORMATS = ("parquet", "csv")
Row = Mapping[str, Any]


def table_format(wanted: str | None) -> str:
    """The format of a table: as wanted, or Parquet where pyarrow is installed, and else CSV.

    Raises InputError for no format, and MissingExtraError for Parquet without pyarrow.
    """
    if wanted is None:
        try:
            need("pyarrow")
        except MissingExtraError:
            return "csv"
        return "parquet"
    if wanted not in FORMATS:
        raise InputError(f"table = {show(wanted)}: must be one of {', '.join(FORMATS)}")
    if wanted == "parquet":
        need("pyarrow", use="tables in Parquet")
    return wanted


def columns_of(rows: Sequence[Row], first: Sequence[str] = ()) -> dict[str, list[Any]]:
    """The columns of some rows, those of `first` before the others; None where a row has no such entry."""
    names = dict.fromkeys([*first, *(name for row in rows for name in row)])
    return {name: [_cell(row.get(name)) for row in rows] for name in names}


def write_table(path: Path, rows: Sequence[Row], first: Sequence[str] = ()) -> None:
    """Write rows as Parquet or CSV, by the ending of `path`, whole or not at all.

    Raises OutputError where it cannot be written, and MissingExtraError for Parquet without pyarrow.
    """
    columns = columns_of(rows, first)
    if path.suffix == ".parquet":
        arrow, parquet = extra("pyarrow"), extra("pyarrow.parquet")
        table = arrow.table({name: arrow.array(values) for name, values in columns.items()})
        with replacing(path, synced=True) as part:
            parquet.write_table(table, part)
        return
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(columns)
    lines.writerows([_word(value) for value in values] for values in zip(*columns.values(), strict=True))
    write_text(path, text.getvalue(), synced=True)


def to_pandas(rows: Sequence[Row], first: Sequence[str] = ()) -> pd.DataFrame:
    """The rows as a table of pandas. Raises MissingExtraError without it."""
    frame: pd.DataFrame = extra("pandas").DataFrame(columns_of(rows, first))
    return frame


def _cell(value: Any) -> Any:
    """An entry of a table: a list as text."""
    return json.dumps(value) if isinstance(value, list | tuple) else value


def _word(value: Any) -> str:
    """An entry of a CSV file."""
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else repr(value) if isinstance(value, float) else str(value)
