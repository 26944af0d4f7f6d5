"""Writes armatures as glTF files for mocap, and reads the rest pose of glTF files from mocap."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mathutils import Matrix, Quaternion, Vector

_FLOAT, _UNSIGNED_SHORT = 5126, 5123


class Skin(NamedTuple):
    """Vertices that nodes move."""

    positions: np.ndarray
    """The rest positions in the world, (vertices, 3)."""
    nodes: np.ndarray
    """The four nodes of each vertex, (vertices, 4)."""
    weights: np.ndarray
    """Their weights, (vertices, 4)."""


class Tree(NamedTuple):
    """Nodes, each after its parent."""

    names: list[str]
    parents: list[int]
    """The index of each node's parent, or -1."""
    world: np.ndarray
    """The rest matrix of each node relative to the world, (nodes, 4, 4)."""


def write(path: Path, tree: Tree, poses: np.ndarray, frame_rate: float, skin: Skin | None) -> None:
    """Writes a .glb.

    Args:
        path: The file.
        tree: The nodes. The first one is the armature, the others are its bones.
        poses: Of each frame the matrices of the nodes to the world, (frames, nodes, 4, 4); no frame without a motion.
        frame_rate: Frames per second.
        skin: Its vertices, if there are any.
    """
    buffer = _Buffer()
    rest = _transforms(tree, tree.world)
    nodes: list[dict[str, Any]] = [
        {"name": name, "translation": at.tolist(), "rotation": turn.tolist(), "scale": scale.tolist()}
        for name, at, turn, scale in zip(tree.names, *rest)
    ]
    for node, parent in enumerate(tree.parents):
        if parent >= 0:
            nodes[parent].setdefault("children", []).append(node)
    inverse = np.linalg.inv(tree.world[1:]).transpose(0, 2, 1).reshape(-1, 16)
    gltf: dict[str, Any] = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "skins": [{"joints": list(range(1, len(nodes))), "inverseBindMatrices": buffer.add(inverse, "MAT4")}],
    }
    if skin is not None:
        # mocap only reads the vertices of triangles, so any triangles will do.
        skin = Skin(*(np.concatenate([part, part[-1:].repeat(-len(part) % 3, axis=0)]) for part in skin))
        attributes = {
            "POSITION": buffer.add(skin.positions, "VEC3"),
            "JOINTS_0": buffer.add((skin.nodes - 1).clip(0).astype(np.uint16), "VEC4"),
            "WEIGHTS_0": buffer.add(skin.weights, "VEC4"),
        }
        gltf["meshes"] = [{"name": "skin", "primitives": [{"attributes": attributes}]}]
        gltf["scenes"][0]["nodes"].append(len(nodes))
        nodes.append({"mesh": 0, "skin": 0})
    if len(poses):
        gltf["animations"] = [_animation(buffer, tree, poses, frame_rate)]
    gltf |= {"accessors": buffer.accessors, "bufferViews": buffer.views, "buffers": [{"byteLength": len(buffer.data)}]}
    text = json.dumps(gltf).encode()
    text += b" " * (-len(text) % 4)
    with path.open("wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 12 + 8 + len(text) + 8 + len(buffer.data)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text)
        file.write(struct.pack("<I4s", len(buffer.data), b"BIN\0") + buffer.data)


def rest_pose(path: Path) -> tuple[Tree, list[bool]]:
    """The nodes of a .glb without its animation, depth-first, and whether each is a joint of a skin."""
    data = path.read_bytes()
    (size,) = struct.unpack_from("<I", data, 12)
    gltf = json.loads(data[20 : 20 + size])
    joints = {joint for skin in gltf.get("skins", []) for joint in skin["joints"]}
    names, parents, world, are_joints = [], [], [], []
    todo = [(root, -1) for root in reversed(gltf["scenes"][gltf.get("scene", 0)]["nodes"])]
    while todo:
        index, parent = todo.pop()
        node = gltf["nodes"][index]
        local = _local(node)
        names.append(node.get("name", ""))
        are_joints.append(index in joints)
        parents.append(parent)
        world.append(world[parent] @ local if parent >= 0 else local)
        todo += [(child, len(names) - 1) for child in reversed(node.get("children", []))]
    return Tree(names, parents, np.array(world)), are_joints


class _Buffer:
    """The accessors of a glTF file, and their bytes."""

    def __init__(self) -> None:
        self.data = bytearray()
        self.views: list[dict[str, int]] = []
        self.accessors: list[dict[str, Any]] = []

    def add(self, values: np.ndarray, kind: str) -> int:
        """Adds an accessor of floats or of nodes; returns its index."""
        is_float = values.dtype.kind == "f"
        values = np.ascontiguousarray(values, np.float32 if is_float else np.uint16)
        accessor: dict[str, Any] = {
            "bufferView": len(self.views),
            "componentType": _FLOAT if is_float else _UNSIGNED_SHORT,
            "count": len(values),
            "type": kind,
        }
        if kind in ("SCALAR", "VEC3"):
            accessor["min"] = np.atleast_1d(values.min(axis=0)).tolist()
            accessor["max"] = np.atleast_1d(values.max(axis=0)).tolist()
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": values.nbytes})
        self.accessors.append(accessor)
        self.data += values.tobytes()
        self.data += bytes(-len(self.data) % 4)
        return len(self.accessors) - 1


def _animation(buffer: _Buffer, tree: Tree, poses: np.ndarray, frame_rate: float) -> dict[str, Any]:
    times = buffer.add(np.arange(len(poses)) / frame_rate, "SCALAR")
    keys = [np.array(values) for values in zip(*(_transforms(tree, pose) for pose in poses))]
    samplers, channels = [], []
    for node in range(len(tree.names)):
        for values, (path, kind) in zip(keys, (("translation", "VEC3"), ("rotation", "VEC4"), ("scale", "VEC3"))):
            channels.append({"sampler": len(samplers), "target": {"node": node, "path": path}})
            samplers.append({"input": times, "output": buffer.add(values[:, node], kind), "interpolation": "LINEAR"})
    return {"name": "motion", "samplers": samplers, "channels": channels}


def _transforms(tree: Tree, world: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Translations, rotations (x, y, z, w) and scales of nodes relative to their parents."""
    places = [Matrix(place) for place in world]
    above = (places[parent].inverted_safe() if parent >= 0 else Matrix() for parent in tree.parents)
    parts = [(up @ place).decompose() for up, place in zip(above, places)]
    at, turns, scales = (np.array([list(part) for part in column], dtype=np.float64) for column in zip(*parts))
    return at, np.roll(turns, -1, axis=1), scales


def _local(node: dict[str, Any]) -> np.ndarray:
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    at, scale = Vector(node.get("translation", (0, 0, 0))), Vector(node.get("scale", (1, 1, 1)))
    return np.array(Matrix.LocRotScale(at, Quaternion((w, x, y, z)), scale), dtype=np.float64)
