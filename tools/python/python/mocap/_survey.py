"""Surveys a dataset: defects, near-duplicates, a diverse subset."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Literal

from . import _mocap
from ._call import public
from ._errors import OptionError
from ._job_options import ReadOptions
from ._mocap import ArrowTable
from ._options import StrPath
from ._report import Reports, parsed


class Survey:
    """A row for each clip of many files: measures, defects with their frames, and near-duplicates.

    ``docs/survey-columns.md`` has the columns and the kinds of defects.
    """

    def __init__(self, native: _mocap.Survey) -> None:
        self._native = native

    def __len__(self) -> int:
        return len(self._native)

    def __repr__(self) -> str:
        return f"<mocap.Survey of {len(self)} clips>"

    def _repr_html_(self) -> str:
        return self.rows._repr_html_()

    @property
    def rows(self) -> Reports:
        """The rows as dictionaries, in the order of their files; ``defects`` has every finding."""
        return Reports(parsed(self._native.rows_json()))

    @property
    def files(self) -> list[str]:
        """The files of the clips."""
        return self._native.files

    @property
    def problem(self) -> str | None:
        """The clips with the verdict ``fail_on`` or worse; ``None`` without such clips."""
        return self._native.problem

    def to_arrow(self) -> ArrowTable:
        """The rows as a table for Polars, DuckDB, pyarrow: ``polars.DataFrame(found.to_arrow())``."""
        return self._native.arrow()

    @public
    def write(self, path: StrPath, *, overwrite: bool = False) -> None:
        """Writes a file by its extension: the rows to ``.csv``, ``.json``, ``.jsonl``, ``.parquet`` or ``.txt`` (only
        the file names), a page about the corpus to ``.html``, the findings to ``.sarif``.

        Args:
            path: The file to write. It must not be a surveyed file.
            overwrite: Whether to replace a file that may be a source.

        Raises:
            MocapError: For another extension, and if the file cannot be written. A package without the feature
                ``parquet`` writes no ``.parquet``: ``polars.DataFrame(found.to_arrow()).write_parquet(path)`` does.
        """
        self._native.write(path, overwrite)


@public
def survey(
    paths: StrPath | Iterable[StrPath] = (),
    *,
    where: str | None = None,
    select: int | str | None = None,
    split: Sequence[float] = (),
    by: Sequence[Literal["quality", "diversity", "person", "skeleton", "near-duplicate"]] = (),
    threshold: Mapping[str, float | tuple[float, float]] | None = None,
    fail_on: Literal["suspect", "bad"] | None = None,
    records: Iterable[str] = (),
    read_options: ReadOptions = ReadOptions(),
) -> Survey:
    """Surveys motions, on all cores, as ``mocap survey`` does.

    >>> found = mocap.survey("takes", where="verdict = good and not twin")   # doctest: +SKIP
    >>> found.rows[0]["verdict"]                                         # doctest: +SKIP
    'good'

    Args:
        paths: Files and folders. Folders are searched recursively for files with the extension of a format. A
            ``.jsonl`` file is the output of an earlier survey.
        where: Keep the rows for which this is true, such as ``"skate < 1 and not twin"``.
        select: Keep this number of clips, or a percentage such as ``"3%"``, as different as possible.
        split: Split the clips into parts of these fractions, such as ``(0.8, 0.1, 0.1)``: ``split`` of a row is
            ``"train"``, ``"validation"`` or ``"test"``.
        by: How to select: ``"quality"`` first drops bad clips and near-duplicates; the default is quality and
            diversity. Or which clips a split keeps together; the default is ``"near-duplicate"``.
        threshold: For a kind of defect, the amount from which a clip is bad, or two amounts for suspect and bad.
            Infinity disables the kind.
        fail_on: ``problem`` names the clips with this verdict or a worse one.
        records: Lines of :func:`examine` from other processes, instead of ``paths``.
        read_options: How to read.

    Raises:
        MocapError: For an invalid expression, threshold or record. A file that cannot be read is a row with an
            ``error``.
        ValueError: If ``paths`` and ``records`` are both empty.
    """
    lines = list(records)
    files = files_of([paths] if isinstance(paths, (str, os.PathLike)) else paths)
    if not lines and not files:
        raise OptionError("there is no file to survey")
    if lines and files:
        raise OptionError("paths and records cannot be surveyed together: write the records to a .jsonl file, and name it")
    options = {"where": where, "select": select, "fail-on": fail_on}
    given = {name: value for name, value in options.items() if value is not None}
    made = json.dumps({**given, "split": list(split), "by": list(by), "threshold": _thresholds(threshold)})
    return Survey(_mocap.survey(files, lines, made, read_options))


@public
def examine(
    files: Iterable[tuple[str, bytes]],
    *,
    threshold: Mapping[str, float | tuple[float, float]] | None = None,
    read_options: ReadOptions = ReadOptions(),
) -> list[str]:
    """Examines files in memory. Returns a line of JSON for each clip, for ``records`` of :func:`survey` or for a
    ``.jsonl`` file.

    Map this function over the batches of Ray Data, Spark or Dask. :func:`survey` then finds near-duplicates, the map
    and the selection from all lines together.
    """
    return _mocap.examine(list(files), json.dumps({"threshold": _thresholds(threshold)}), read_options)


def _thresholds(threshold: Mapping[str, float | tuple[float, float]] | None) -> list[str]:
    def text(amount: float | tuple[float, float]) -> str:
        return f"{amount[0]}..{amount[1]}" if isinstance(amount, tuple) else str(amount)

    return [f"{kind}={text(amount)}" for kind, amount in (threshold or {}).items()]


def files_of(paths: Iterable[StrPath], *more: str) -> list[str]:
    """The files of paths. Files of folders are sorted by name, and have a readable extension or an extension in
    ``more``."""
    known = tuple(f".{extension}" for extension in (*_mocap.extensions(), *more))
    files: list[str] = []
    for path in map(Path, paths):
        if not path.is_dir():
            files.append(str(path))
            continue
        for folder, folders, names in os.walk(path):
            folders.sort()
            files += [os.path.join(folder, name) for name in sorted(names) if name.lower().endswith(known)]
    return files
