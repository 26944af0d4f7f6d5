"""Runs jobs of mocap. Every operator runs a job of the command line."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mocap
import numpy as np

from . import glb


@dataclass
class Clip:
    """A motion of the nodes of an outcome."""

    name: str
    frame_rate: float
    poses: np.ndarray
    """The world matrices of the nodes in each frame, (frames, nodes, 4, 4), in metres with +Y up."""


@dataclass
class Outcome:
    """The result of a job."""

    tree: glb.Tree
    joints: list[int]
    """The nodes that are joints."""
    clips: list[Clip]
    report: Mapping[str, Any]


@contextmanager
def folder() -> Iterator[Path]:
    """A temporary folder for the files of a job."""
    with tempfile.TemporaryDirectory(prefix="mocap-", ignore_cleanup_errors=True) as path:
        yield Path(path)


def run(job: Mapping[str, Any], output: Path) -> Outcome:
    """Runs a job whose output is a .glb, and reads the output.

    Raises:
        mocap.MocapError: Where the job fails.
    """
    report = mocap.run({**job, "write": {**job.get("write", {}), "output": output}})
    scene = mocap.read(output, hash=False)
    nodes = scene.nodes
    tree, are_skinned = glb.rest_pose(output)
    # The last node of the file holds the mesh of a character, and is not part of the scene. The scene has the names of
    # the source.
    tree = glb.Tree([node.name for node in nodes], tree.parents[: len(nodes)], tree.world[: len(nodes)])
    joints = [
        index for index, node in enumerate(nodes) if node.kind == "joint" and not node.face and are_skinned[index]
    ]
    return Outcome(tree, joints, [_clip(scene.clip(index), name) for index, name in enumerate(scene.clips)], report)


def _clip(scene: mocap.Scene, name: str) -> Clip:
    poses = [scene.pose(tick) for tick in range(scene.frames)]
    return Clip(name, scene.frame_rate, np.array(poses, dtype=np.float64).reshape(-1, len(scene.nodes), 4, 4))
