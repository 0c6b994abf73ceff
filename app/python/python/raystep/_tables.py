"""Tables: lists of rows, or pandas frames where pandas is installed."""

from __future__ import annotations

import csv
import html
import importlib
import importlib.util
import io
from collections.abc import Iterable
from typing import Any, TypeAlias

TableLike: TypeAlias = Any
"""A pandas DataFrame where pandas is installed, otherwise a `Table`."""

MOST_SHOWN = 60


class Table(list[dict[str, Any]]):
    """A list of rows, each a dict with the same keys; missing values are None. A notebook shows it as a table.

    >>> from raystep import Table
    >>> rows = Table([{"pass": 0, "kernel": "generate"}, {"pass": 1, "kernel": "setup"}])
    >>> rows[1]["kernel"], rows.column("pass")
    ('setup', [0, 1])
    """

    def column(self, name: str) -> list[Any]:
        """The values of a column, row by row.

        >>> from raystep import Table
        >>> Table([{"t": 1.5}, {"t": None}]).column("t")
        [1.5, None]
        """
        return [row[name] for row in self]

    def _repr_html_(self) -> str:
        names = list(self[0]) if self else []
        # Columns without any value would only take room.
        names = [name for name in names if any(row[name] is not None for row in self)]
        head = "".join(f"<th>{html.escape(name)}</th>" for name in names)
        rows = "".join(f"<tr>{''.join(map(_cell, (row[name] for name in names)))}</tr>" for row in self[:MOST_SHOWN])
        more = f"<p>… {len(self)} rows</p>" if len(self) > MOST_SHOWN else ""
        return f"<table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>{more}"


class Tables(dict[str, TableLike]):
    """Tables by name, as a command writes them to CSV files, and what it says about them.

    >>> from raystep import Tables
    >>> tables = Tables({"first": []}, text="no difference")
    >>> sorted(tables), tables.text, tables.failure is None
    (['first'], 'no difference', True)
    """

    text: str
    """The command's summary."""
    notes: list[str]
    """Its notes, a line each."""
    failure: str | None
    """Why the result is not what it should be, such as a ray with a wrong hit; None if it is."""

    def __init__(
        self,
        tables: dict[str, TableLike],
        *,
        text: str = "",
        notes: Iterable[str] = (),
        failure: str | None = None,
    ) -> None:
        super().__init__(tables)
        self.text, self.notes, self.failure = text, list(notes), failure

    def __repr__(self) -> str:
        return f"<raystep.Tables: {', '.join(f'{name} ({len(table)} rows)' for name, table in self.items())}>"


def _cell(value: Any) -> str:
    if value is None:
        return "<td></td>"
    return f"<td>{html.escape(f'{value:.6g}' if isinstance(value, float) else str(value))}</td>"


def table(rows: Iterable[dict[str, Any]]) -> TableLike:
    """Rows as a frame if pandas is installed."""
    found = Table(rows)
    if importlib.util.find_spec("pandas") is None:
        return found
    pandas: Any = importlib.import_module("pandas")
    names = list(found[0]) if found else []
    columns = {name: found.column(name) for name in names}
    return pandas.DataFrame({name: pandas.Series(values, dtype=_dtype(values)) for name, values in columns.items()})


def _dtype(values: list[Any]) -> str:
    """The frame's type of a column: integers stay integers where some are missing."""
    kinds = {type(value) for value in values if value is not None}
    has_gaps = None in values
    if kinds == {bool}:
        return "boolean" if has_gaps else "bool"
    if kinds == {int}:
        is_long = any(value is not None and value >= 1 << 63 for value in values)
        return ("UInt64" if is_long else "Int64") if has_gaps else ("uint64" if is_long else "int64")
    return "float64" if kinds and kinds <= {int, float} else "object"


def table_of_csv(text: str) -> TableLike:
    """A command's CSV file, with numbers as numbers: a column of integers, of numbers, of truth values, or of text."""
    reader = csv.reader(io.StringIO(text, newline=""))
    names = next(reader, [])
    rows = list(reader)
    columns = [_typed([row[i] for row in rows]) for i in range(len(names))]
    return table(dict(zip(names, values)) for values in zip(*columns))


def _typed(texts: list[str]) -> list[Any]:
    known = [text for text in texts if text]
    if all(text in ("true", "false") for text in known):
        return [text == "true" if text else None for text in texts]
    for kind in (int, float):
        try:
            return [kind(text) if text else None for text in texts]
        except ValueError:
            pass
    return [text or None for text in texts]
