"""A survey of a folder of motion files on a Ray cluster: workers examine files, and one process judges them together.

    python examples/ray_survey.py DIR survey.jsonl

Near-duplicates, the map and the selection need all clips together; their record of a clip is 340 bytes per second. The
output is what `mocap survey DIR -o survey.jsonl` writes, and `mocap survey survey.jsonl --html card.html` shows it.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pyarrow as pa
import ray

import mocap


def lines(batch: pa.Table) -> pa.Table:
    """Converts a batch of paths and bytes to record lines, one for each clip."""
    files = zip(batch["path"].to_pylist(), batch["bytes"].to_pylist())
    return pa.table({"line": pa.array(mocap.examine(files), pa.string())})


def survey(folder: Path, **options: object) -> mocap.Survey:
    """The survey of all BVH files below `folder`; options are the options of `mocap.survey`."""
    files = ray.data.read_binary_files(str(folder), include_paths=True, file_extensions=["bvh"])
    found = files.map_batches(lines, batch_format="pyarrow", batch_size=64)
    records = (line for batch in found.iter_batches(batch_format="pyarrow") for line in batch["line"].to_pylist())
    return mocap.survey(records=records, **options)  # type: ignore[arg-type]


if __name__ == "__main__":
    survey(Path(sys.argv[1])).write(sys.argv[2])
