"""A folder of motion files on a robot, on a Ray cluster: a row for each clip, with its joints or with the error.

    python examples/ray_robot.py DIR g1.urdf OUT
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import ray

import mocap


class OnRobot:
    """Puts motions on a robot, which is read once for each worker."""

    def __init__(self, robot: str) -> None:
        self.robot = mocap.Robot(robot)

    def __call__(self, row: dict[str, Any]) -> dict[str, Any]:
        result: dict[str, Any] = {"clip": Path(row["path"]).name, "error": None, "verdict": None, "qpos": None}
        try:
            motion = self.robot.retarget(mocap.read_bytes(row["bytes"], row["path"]), fps=50)
            result.update(verdict=motion.report["verdict"], qpos=motion.qpos.tolist())
        except mocap.MocapError as error:
            result["error"] = str(error)
        return result


if __name__ == "__main__":
    folder, robot, out = sys.argv[1:]
    files = ray.data.read_binary_files(folder, include_paths=True, file_extensions=["bvh"])
    files.map(OnRobot, fn_constructor_args=[robot], concurrency=2).write_parquet(out)
