"""Blender with the extension, the program, and a reader of glTF that shares no code with Blender or the program."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[3]
FIXTURES = ROOT / "fixtures"
sys.path.insert(0, str(ROOT / "tools/interop"))

import corpus  # noqa: E402

# Blender's +Z is glTF's +Y.
TO_BLENDER = np.array(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)), dtype=np.float64)


@pytest.fixture(scope="session", autouse=True)
def extension() -> None:
    """Installs the extension from its file, which contains the wheel, with Blender's own installer."""
    file = os.environ["MOCAP_EXTENSION"]
    bpy.ops.preferences.addon_enable(module="bl_pkg")
    bpy.ops.extensions.package_install_files(filepath=file, repo="user_default", enable_on_install=True)
    assert "bl_ext.user_default.mocap" in bpy.context.preferences.addons


@pytest.fixture(autouse=True)
def empty(extension: None) -> None:
    """An empty Blender."""
    bpy.ops.wm.read_homefile(use_empty=True)


def mocap(*words: object) -> None:
    """Runs the program."""
    subprocess.run([os.environ["MOCAP"], *map(str, words), "--quiet"], check=True)


class Written:
    """A .glb file of the program: names and positions of nodes, in double precision."""

    def __init__(self, path: Path, clip: int = 0) -> None:
        file = corpus.File(path)
        self._gltf = file.json
        self._nodes = corpus.listed(file.json)
        self.names = [file.json["nodes"][index].get("name", "") for index, _ in self._nodes]
        skinned = {joint for skin in file.json.get("skins", []) for joint in skin["joints"]}
        nodes = [file.json["nodes"][index] for index, _ in self._nodes]
        # An end site with child nodes is a joint.
        ends = [node.get("extras", {}).get("end_site") and "children" not in node for node in nodes]
        self.is_joint = [index in skinned and not is_end for (index, _), is_end in zip(self._nodes, ends)]
        self._tracks = []
        self.duration = 0.0
        for channel in (file.json.get("animations") or [{"channels": []}])[clip]["channels"]:
            sampler = file.json["animations"][clip]["samplers"][channel["sampler"]]
            if corpus.target(channel):
                keys = [time for (time,) in file.numbers(sampler["input"])]
                self.duration = max(self.duration, keys[-1])
                values = file.numbers(sampler["output"])
                self._tracks.append((*corpus.target(channel), keys, values, sampler.get("interpolation", "LINEAR")))

    def joints(self) -> list[str]:
        """The names of the joints, depth-first."""
        return [name for name, is_joint in zip(self.names, self.is_joint) if is_joint]

    def pose(self, seconds: float | None) -> dict[str, np.ndarray]:
        """The matrices from nodes to Blender's world by name, at a time or at rest. Names are unique."""
        driven: dict[int, dict[str, tuple[float, ...]]] = {}
        for node, path, times, values, kind in self._tracks if seconds is not None else ():
            driven.setdefault(node, {})[path] = corpus.sample(times, values, kind, path, seconds)
        world: dict[int, list[tuple[float, ...]]] = {}
        for index, parent in self._nodes:
            local = corpus.matrix(self._gltf["nodes"][index], driven.get(index, {}))
            world[index] = local if parent is None else corpus.product(world[parent], local)
        rows = [np.array([*world[index], (0, 0, 0, 1)]) for index, _ in self._nodes]
        return {name: TO_BLENDER @ matrix for name, matrix in zip(self.names, rows)}


def posed(armature: bpy.types.Object, frame: float) -> dict[str, np.ndarray]:
    """The matrices from bones to the world, as Blender evaluates them."""
    bpy.context.scene.frame_set(int(frame), subframe=frame - int(frame))
    evaluated = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    world = np.array(evaluated.matrix_world, dtype=np.float64)
    return {bone.name: world @ np.array(bone.matrix, dtype=np.float64) for bone in evaluated.pose.bones}


def angle(one: np.ndarray, other: np.ndarray) -> float:
    """The angle in degrees between two rotation matrices, which may be scaled."""
    one, other = (matrix[:3, :3] / np.linalg.norm(matrix[:3, :3], axis=0) for matrix in (one, other))
    # The arc cosine of the trace loses half of the digits at small angles.
    return float(np.degrees(2 * np.arcsin(min(1.0, np.linalg.norm(one - other) / np.sqrt(8)))))


def distance(one: np.ndarray, other: np.ndarray) -> float:
    """The distance between the positions of two matrices."""
    return float(np.linalg.norm(one[:3, 3] - other[:3, 3]))


def sampled(count: int, most: int = 12) -> list[int]:
    """The frames from the first to the last."""
    return sorted({round(index) for index in np.linspace(0, count - 1, min(count, most))})


def call(name: str, **options: object) -> None:
    """Calls an operator as the panel does. An option that is not given has its default, not its last value."""
    for known in getattr(bpy.ops.mocap, name).get_rna_type().properties:
        if known.type in ("BOOLEAN", "ENUM", "FLOAT", "STRING") and not known.is_readonly:
            options.setdefault(known.identifier, known.default)
    assert getattr(bpy.ops.mocap, name)("EXEC_DEFAULT", True, **options) == {"FINISHED"}


def curves(armature: bpy.types.Object) -> list[bpy.types.FCurve]:
    """The f-curves of an armature's action, read through the interface of each Blender version."""
    action = armature.animation_data.action
    if hasattr(action, "layers"):
        slot = armature.animation_data.action_slot
        return list(action.layers[0].strips[0].channelbag(slot).fcurves)
    return list(action.fcurves)
