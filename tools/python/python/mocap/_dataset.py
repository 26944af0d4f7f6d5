"""Datasets for the library ``datasets`` of Hugging Face."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from . import _mocap
from ._array_options import Options
from ._call import public
from ._errors import OptionError
from ._job_options import ReadOptions
from ._options import StrPath
from ._survey import files_of


@public
def write_dataset(
    paths: StrPath | Iterable[StrPath],
    folder: StrPath,
    options: Options = Options(),
    *,
    license: str | None = None,
    part_size: int = 256,
    read_options: ReadOptions = ReadOptions(),
) -> dict[str, str]:
    """Writes motions as a dataset, as ``mocap pack --to hf`` does: Parquet files with a row for each clip, and a card.

    >>> mocap.write_dataset("takes", "dataset", mocap.Options(rot="6d", fps=30), license="cc-by-4.0")  # doctest: +SKIP
    {}
    >>> datasets.load_dataset("dataset", split="train")[0]["frames"]  # doctest: +SKIP
    131

    The card, ``README.md``, has the columns with their units, statistics, and the licence files from the folders of the
    clips.

    Args:
        paths: Files and folders. Folders are searched recursively for files with the extension of a format.
        folder: The new folder. It must be absent or empty.
        options: The contents of the arrays. By default the arrays are in metres with +Y up.
        license: The licence of the clips, as a Hugging Face identifier.
        part_size: Size of a Parquet file, in megabytes of uncompressed values.
        read_options: How to read.

    Returns:
        The files that could not be read, with the reasons. The card also lists them.

    Raises:
        MocapError: If the folder has files, ``license`` is not an identifier, or no file can be read.
    """
    listed = [paths] if isinstance(paths, (str, os.PathLike)) else paths
    files = [(_name(file, path), file) for path in listed for file in files_of([path])]
    if not files:
        raise OptionError("there is no file to write")
    text = options.to_json()
    return dict(_mocap.write_dataset(files, folder, license, part_size * 1_000_000, text, read_options))


def _name(file: str, path: StrPath) -> str:
    """The path of a file relative to the searched folder, or the name of a file that the caller names."""
    below = os.path.relpath(file, path) if os.path.isdir(path) else os.path.basename(file)
    return Path(below).as_posix()
