"""A folder of motion files on a robot, on a Ray cluster: a row for each clip, with its joints or with the error.

    python examples/ray_robot.py DIR g1.urdf OUT
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pyarrow as pa
import ray

import mocap

# Stated, because a block of errors alone would have columns without a type, which no other file of the table has.
SCHEMA = pa.schema(
    [("clip", pa.string()), ("error", pa.string()), ("verdict", pa.string()), ("qpos", pa.list_(pa.list_(pa.float64())))]
)


class OnRobot:
    """Puts motions on a robot, which is read once for each worker."""

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
    """The motions of all BVH files below `folder` on a robot."""
    files = ray.data.read_binary_files(str(folder), include_paths=True, file_extensions=["bvh"])
    # A worker keeps a core for itself, and reading and writing take one too: with a worker for each core, nothing is read.
    workers = max(1, int(ray.cluster_resources()["CPU"]) - 1)
    arguments = [str(robot)]
    return files.map_batches(
        OnRobot, fn_constructor_args=arguments, batch_format="pyarrow", batch_size=8, concurrency=workers
    )


if __name__ == "__main__":
    on_robot(Path(sys.argv[1]), Path(sys.argv[2])).write_parquet(sys.argv[3])
