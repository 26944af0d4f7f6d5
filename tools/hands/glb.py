"""Reads a skinned GLB and poses it, with NumPy alone."""

import json
import struct

import numpy as np

KINDS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
SIZES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def matrix(t, r, s):
    x, y, z, w = np.array(r) / np.linalg.norm(r)
    turn = np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])
    full = np.eye(4)
    full[:3, :3], full[:3, 3] = turn * np.array(s), t
    return full


class Glb:
    def __init__(self, path):
        data = open(path, "rb").read()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json, self.bytes = json.loads(data[20:20 + length]), data[28 + length:]
        nodes = self.json["nodes"]
        self.parent = {child: index for index, node in enumerate(nodes) for child in node.get("children", [])}
        self.index = {node.get("name"): index for index, node in enumerate(nodes)}
        animation = self.json["animations"][-1]
        self.tracks = {}
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            kind = channel["target"]["path"]
            if kind != "weights":
                self.tracks[channel["target"]["node"], kind] = self.read(sampler["input"]), self.read(sampler["output"])
        self.end = max(times[-1] for times, _ in self.tracks.values())

    def read(self, index):
        accessor = self.json["accessors"][index]
        kind, width, count = KINDS[accessor["componentType"]], SIZES[accessor["type"]], accessor["count"]
        values = np.zeros((count, width), kind)
        if "bufferView" in accessor:
            view = self.json["bufferViews"][accessor["bufferView"]]
            size = np.dtype(kind).itemsize * width
            stride = view.get("byteStride", size)
            start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
            rows = np.lib.stride_tricks.as_strided(np.frombuffer(self.bytes, "u1", offset=start), (count, size), (stride, 1))
            values = np.ascontiguousarray(rows).view(kind).reshape(count, width)
        values = values.astype(float)
        if accessor.get("normalized"):
            values = np.maximum(values / np.iinfo(np.dtype(kind)).max, -1)
        return values[:, 0] if width == 1 else values

    def local(self, node, time):
        rest = self.json["nodes"][node]
        if "matrix" in rest:
            return np.array(rest["matrix"]).reshape(4, 4).T
        parts = []
        for kind, usual in (("translation", [0, 0, 0]), ("rotation", [0, 0, 0, 1]), ("scale", [1, 1, 1])):
            value = np.array(rest.get(kind, usual), float)
            if time is not None and (node, kind) in self.tracks:
                times, values = self.tracks[node, kind]
                at = np.clip(np.searchsorted(times, time, "right") - 1, 0, max(len(times) - 2, 0))
                value = values[at]
                if len(times) > 1:
                    part = np.clip((time - times[at]) / (times[at + 1] - times[at]), 0, 1)
                    other = values[at + 1] * (np.sign(value @ values[at + 1]) or 1 if kind == "rotation" else 1)
                    value = value + part * (other - value)
            parts.append(value)
        return matrix(*parts)

    def world(self, time, nodes=None):
        """The matrices from nodes to the world, of all nodes or of some nodes and their ancestors; at rest if no time
        is given."""
        found = {}

        def of(node):
            if node not in found:
                local = self.local(node, time)
                found[node] = of(self.parent[node]) @ local if node in self.parent else local
            return found[node]

        for node in range(len(self.json["nodes"])) if nodes is None else nodes:
            of(node)
        return found

    def below(self, node, top):
        while node is not None and node != top:
            node = self.parent.get(node)
        return node == top

    def skin(self, world, is_part):
        """The vertices that move mostly with the joints of a body part, and the faces between them."""
        vertices, faces = [], []
        for node, of_node in enumerate(self.json["nodes"]):
            if "mesh" not in of_node or "skin" not in of_node:
                continue
            skin = self.json["skins"][of_node["skin"]]
            inverse = self.read(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
            joints = np.array([world[joint] for joint in skin["joints"]]) @ inverse
            of_part = np.array([is_part(joint) for joint in skin["joints"]])
            for primitive in self.json["meshes"][of_node["mesh"]]["primitives"]:
                a = primitive["attributes"]
                points, weights = self.read(a["POSITION"]), self.read(a["WEIGHTS_0"])
                ids = self.read(a["JOINTS_0"]).astype(int)
                inside = (weights * of_part[ids]).sum(1) > 0.5
                moved = np.einsum("vk,vkij,vj->vi", weights, joints[ids], np.c_[points, np.ones(len(points))])[:, :3]
                new = np.cumsum(inside) - 1 + sum(len(v) for v in vertices)
                indices = self.read(primitive["indices"]).astype(int).reshape(-1, 3)
                faces.append(new[indices[inside[indices].all(1)]])
                vertices.append(moved[inside])
        return np.concatenate(vertices), np.concatenate(faces)
