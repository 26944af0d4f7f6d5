"""Retargets a folder of motion files to a robot on a Ray cluster, with a row of joints or an error for each clip.

    python examples/ray_robot.py DIR g1.urdf OUT
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import ray

import mocap

# Stated types: a block with only errors would have columns without a type, unlike the other files of the table.
SCHEMA = pa.schema(
    [("clip", pa.string()), ("error", pa.string()), ("verdict", pa.string()), ("qpos", pa.list_(pa.list_(pa.float64())))]
)


class OnRobot:
    """Retargets motions to a robot, which each worker reads once."""

    def __init__(self, robot: str) -> None:
        self.robot = mocap.Robot(robot)

    def __call__(self, batch: pa.Table) -> pa.Table:
        return pa.Table.from_pylist([self.row(**file) for file in batch.to_pylist()], SCHEMA)

    def row(self, path: str, bytes: bytes) -> dict[str, Any]:
        row: dict[str, Any] = {"clip": Path(path).name}
        try:
            motion = self.robot.retarget(mocap.read_bytes(bytes, path), fps=50)
            row.update(verdict=motion.report["verdict"], qpos=motion.qpos.tolist())
        except mocap.MocapError as error:
            row["error"] = str(error)
        return row


def on_robot(folder: Path, robot: Path) -> ray.data.Dataset:
    """The motions of all BVH files below `folder`, retargeted to a robot."""
    files = ray.data.read_binary_files(str(folder), include_paths=True, file_extensions=["bvh"])
    # A worker occupies a core, and reading and writing need a core too. With a worker on every core, nothing would be
    # read.
    workers = max(1, int(ray.cluster_resources()["CPU"]) - 1)
    arguments = [str(robot)]
    return files.map_batches(
        OnRobot, fn_constructor_args=arguments, batch_format="pyarrow", batch_size=8, concurrency=workers
    )


if __name__ == "__main__":
    on_robot(Path(sys.argv[1]), Path(sys.argv[2])).write_parquet(sys.argv[3])
