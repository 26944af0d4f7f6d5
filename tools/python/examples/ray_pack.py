"""Converts a folder of motion files to Parquet on a Ray cluster, with a row for each clip, or an error for a broken
file.

    python examples/ray_pack.py DIR OUT

`ray.init()` without an address starts a cluster on this machine; under `ray job submit` it joins the existing cluster.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pyarrow as pa
import ray

import mocap

OPTIONS = mocap.Options(rot="6d", fps=30)


def clips(batch: pa.Table) -> pa.Table:
    """Converts a batch of paths and bytes to a batch of clips, on one machine or on many."""
    names = [Path(path).name for path in batch["path"].to_pylist()]
    return pa.table(mocap.table(zip(names, batch["bytes"].to_pylist()), "clips", OPTIONS))


def pack(folder: Path) -> ray.data.Dataset:
    """The clips of all BVH files below `folder`."""
    files = ray.data.read_binary_files(str(folder), include_paths=True, file_extensions=["bvh"])
    return files.map_batches(clips, batch_format="pyarrow", batch_size=64)


if __name__ == "__main__":
    pack(Path(sys.argv[1])).write_parquet(sys.argv[2])
