"""Results as dictionaries and lists that print as lines and tables."""

from __future__ import annotations

import html
import json
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

# The largest number of shown list values, table rows, and characters of a value.
_SHOWN_VALUES = 6
_SHOWN_ROWS = 12
_WIDEST = 80


class Report(dict[str, Any]):
    """A report: a dictionary that prints one line per key, and a table in a notebook."""

    def __repr__(self) -> str:
        return "\n".join(_lines(self)) or "nothing"

    def _repr_html_(self) -> str:
        rows = [(key.strip(), value) for key, _, value in (line.partition(": ") for line in _lines(self))]
        cells = [f"<tr><th>{html.escape(key)}</th><td>{html.escape(value)}</td></tr>" for key, value in rows]
        return f"<table>{''.join(cells)}</table>"


class Reports(list[Report]):
    """Several results: a list that prints as a table."""

    def __repr__(self) -> str:
        columns, rows = self._table()
        widths = [max(len(row[at]) for row in [columns, *rows]) for at in range(len(columns))]
        lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in [columns, *rows]]
        return "\n".join([*lines, *self._rest()]) if self else "nothing"

    def _repr_html_(self) -> str:
        columns, rows = self._table()
        head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
        body = ["".join(f"<td>{html.escape(cell)}</td>" for cell in row) for row in rows]
        table = f"<table><tr>{head}</tr>{''.join(f'<tr>{row}</tr>' for row in body)}</table>"
        return table + "".join(f"<p>{line}</p>" for line in self._rest())

    def _table(self) -> tuple[list[str], list[list[str]]]:
        """The columns with plain values, and the cells of the shown rows."""
        plain = {key: None for row in self for key, value in row.items() if not isinstance(value, (dict, list))}
        columns = [key for key in plain if any(row.get(key) is not None for row in self)]
        shown = self[:_SHOWN_ROWS]
        return columns, [["" if row.get(key) is None else _short(row[key]) for key in columns] for row in shown]

    def _rest(self) -> list[str]:
        return [f"... {len(self) - _SHOWN_ROWS} more"] if len(self) > _SHOWN_ROWS else []


class Columns(dict[str, NDArray[Any]]):
    """Arrays by name. They print as types and shapes."""

    def __repr__(self) -> str:
        return "\n".join(f"{name}: {array.dtype} {array.shape}" for name, array in self.items()) or "nothing"


def _lines(report: Mapping[str, Any], indent: str = "") -> Iterable[str]:
    for key, value in report.items():
        if isinstance(value, dict) and value:
            yield f"{indent}{key}:"
            yield from _lines(value, indent + "  ")
        else:
            yield f"{indent}{key}: {_short(value)}"


def _short(value: Any) -> str:
    """A value as a short text."""
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, np.ndarray):
        return f"{value.dtype} {value.shape}"
    if isinstance(value, list):
        if any(isinstance(item, (dict, list)) for item in value):
            return f"{len(value)} entries" if len(value) != 1 else "1 entry"
        shown = ", ".join(_short(item) for item in value[:_SHOWN_VALUES])
        return f"{shown}, ... ({len(value)} values)" if len(value) > _SHOWN_VALUES else shown or "none"
    if isinstance(value, dict):
        return ", ".join(f"{key} {_short(item)}" for key, item in value.items()) or "none"
    text = "none" if value is None else str(value)
    return text if len(text) <= _WIDEST else text[: _WIDEST - 3] + "..."


def parsed(text: str) -> Any:
    """Parses JSON of the native module. Objects become reports, and lists of objects become lists of reports."""
    return _listed(json.loads(text, object_hook=Report))


def _listed(value: Any) -> Any:
    is_list = isinstance(value, list) and value and all(isinstance(item, Report) for item in value)
    return Reports(value) if is_list else value
