"""Computes the rest vertices of a GLB file with NumPy, by the specification of glTF."""

import json
import struct
from pathlib import Path

import numpy as np

TYPES = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def parts(path):
    data = Path(path).read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    return json.loads(data[20 : 20 + length]), data[20 + length + 8 :]


def accessor(document, buffer, index):
    stated = document["accessors"][index]
    view = document["bufferViews"][stated["bufferView"]]
    kind, count = TYPES[stated["componentType"]], COUNTS[stated["type"]]
    size = np.dtype(kind).itemsize * count
    stride = view.get("byteStride", size)
    begin = view.get("byteOffset", 0) + stated.get("byteOffset", 0)
    rows = [np.frombuffer(buffer, kind, count, begin + row * stride) for row in range(stated["count"])]
    values = np.array(rows)
    if stated.get("normalized"):
        values = values.astype(np.float64) / np.iinfo(kind).max
    return values


def local(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    matrix = np.eye(4)
    matrix[:3, :3] = np.array(turn) * np.array(node.get("scale", [1, 1, 1]))
    matrix[:3, 3] = node.get("translation", [0, 0, 0])
    return matrix


def skinned(path):
    """The vertices of each primitive in the order of the nodes; weights are normalised to a sum of 1."""
    document, buffer = parts(path)
    nodes = document["nodes"]
    worlds = [None] * len(nodes)
    parents = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}

    def world(index):
        if worlds[index] is None:
            above = world(parents[index]) if index in parents else np.eye(4)
            worlds[index] = above @ local(nodes[index])
        return worlds[index]

    for index, node in enumerate(nodes):
        if "mesh" not in node:
            continue
        for primitive in document["meshes"][node["mesh"]]["primitives"]:
            attributes = primitive["attributes"]
            points = accessor(document, buffer, attributes["POSITION"]).astype(float)
            points = np.concatenate([points, np.ones((len(points), 1))], axis=1)
            if "skin" not in node:
                yield (points @ world(index).T)[:, :3]
                continue
            skin = document["skins"][node["skin"]]
            inverse = accessor(document, buffer, skin["inverseBindMatrices"]).astype(float)
            inverse = inverse.reshape(-1, 4, 4).transpose(0, 2, 1)
            moved = np.array([world(joint) for joint in skin["joints"]]) @ inverse
            joint = accessor(document, buffer, attributes["JOINTS_0"])
            weight = accessor(document, buffer, attributes["WEIGHTS_0"]).astype(float)
            weight /= weight.sum(axis=1, keepdims=True)
            whole = np.einsum("vi,viab->vab", weight, moved[joint])
            yield np.einsum("vab,vb->va", whole, points)[:, :3]
