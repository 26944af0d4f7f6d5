#!/usr/bin/env python3
"""Compares where `mocap` puts the nodes of glTF files with an independent sampler in double precision.

    tools/interop/corpus.py FILE_OR_FOLDER...

Every clip is compared at its keys' ends and at moments between them. A node may be off by 1e-5 of the figure's size.
MOCAP names the program; without it, target/release/mocap is taken. Needs numpy. Exit code 1 where a file is off.
"""
import base64
import json
import os
import struct
import subprocess
import sys
import urllib.parse
from pathlib import Path

import numpy as np

MOCAP = os.environ.get("MOCAP", str(Path(__file__).parents[2] / "target/release/mocap"))
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
LARGEST = {"i1": 127, "u1": 255, "<i2": 32767, "<u2": 65535}


class File:
    def __init__(self, path):
        data = path.read_bytes()
        self.bin = None
        if data[:4] == b"glTF":
            at = 12
            while at + 8 <= len(data):
                size, kind = struct.unpack_from("<I4s", data, at)
                chunk = data[at + 8 : at + 8 + size]
                if kind == b"JSON":
                    self.json = json.loads(chunk)
                elif kind == b"BIN\0":
                    self.bin = chunk
                at += 8 + size
        else:
            self.json = json.loads(data.decode("utf-8-sig"))
        self.folder = path.parent
        self.buffers = {}

    def buffer(self, index):
        if index not in self.buffers:
            uri = self.json["buffers"][index].get("uri")
            if uri is None:
                data = self.bin
            elif uri.startswith("data:"):
                data = base64.b64decode(uri.split(",", 1)[1])
            else:
                data = (self.folder / urllib.parse.unquote(uri)).read_bytes()
            self.buffers[index] = data
        return self.buffers[index]

    def rows(self, view, offset, kind, columns, count):
        view = self.json["bufferViews"][view]
        size = np.dtype(kind).itemsize * columns
        stride = view.get("byteStride", size)
        start = view.get("byteOffset", 0) + offset
        data = self.buffer(view["buffer"])
        rows = [np.frombuffer(data, kind, columns, start + row * stride) for row in range(count)]
        return np.array(rows).reshape(count, columns)

    def numbers(self, index):
        accessor = self.json["accessors"][index]
        kind, columns, count = TYPES[accessor["componentType"]], COLUMNS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            values = self.rows(accessor["bufferView"], accessor.get("byteOffset", 0), kind, columns, count).astype(float)
        else:
            values = np.zeros((count, columns))
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            indices, new = sparse["indices"], sparse["values"]
            places = self.rows(
                indices["bufferView"], indices.get("byteOffset", 0), TYPES[indices["componentType"]], 1, sparse["count"]
            )
            values[places[:, 0]] = self.rows(new["bufferView"], new.get("byteOffset", 0), kind, columns, sparse["count"])
        if accessor.get("normalized"):
            values = np.maximum(values / LARGEST[kind], -1)
        return values


def slerp(a, b, share):
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    dot = a @ b
    if dot < 0:
        b, dot = -b, -dot
    angle = np.arccos(min(dot, 1.0))
    if angle < 1e-9:
        return a + share * (b - a)
    return (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)


def sample(times, values, way, path, seconds):
    curve = way == "CUBICSPLINE"
    value = (lambda key: values[3 * key + 1]) if curve else (lambda key: values[key])
    if seconds <= times[0] or len(times) == 1:
        return value(0)
    if seconds >= times[-1]:
        return value(len(times) - 1)
    key = int(np.searchsorted(times, seconds, side="right")) - 1
    duration = times[key + 1] - times[key]
    t = (seconds - times[key]) / duration
    if way == "STEP":
        return value(key)
    if curve:
        return (
            (2 * t**3 - 3 * t**2 + 1) * value(key)
            + duration * (t**3 - 2 * t**2 + t) * values[3 * key + 2]
            + (3 * t**2 - 2 * t**3) * value(key + 1)
            + duration * (t**3 - t**2) * values[3 * key + 3]
        )
    if path == "rotation":
        return slerp(value(key), value(key + 1), t)
    return value(key) + t * (value(key + 1) - value(key))


def matrix(node, driven):
    if "matrix" in node and not driven:
        return np.array(node["matrix"], float).reshape(4, 4).T
    x, y, z, w = (lambda q: q / np.linalg.norm(q))(np.array(driven.get("rotation", node.get("rotation", [0, 0, 0, 1])), float))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    result = np.eye(4)
    result[:3, :3] = turn * np.array(driven.get("scale", node.get("scale", [1, 1, 1])), float)
    result[:3, 3] = driven.get("translation", node.get("translation", [0, 0, 0]))
    return result


def listed(gltf):
    """The nodes of the default scene, depth-first, each with its parent."""
    nodes, scenes = gltf.get("nodes", []), gltf.get("scenes", [])
    if scenes:
        roots = scenes[gltf.get("scene", 0)].get("nodes", [])
    else:
        children = {child for node in nodes for child in node.get("children", [])}
        roots = [node for node in range(len(nodes)) if node not in children]
    found, todo = [], [(root, None) for root in reversed(roots)]
    while todo:
        index, parent = todo.pop()
        found.append((index, parent))
        todo += [(child, index) for child in reversed(nodes[index].get("children", []))]
    return found


def left_out(gltf):
    """Nodes that only show something, in a file with joints."""
    joints = {joint for skin in gltf.get("skins", []) for joint in skin["joints"]}
    moved = {c["target"].get("node") for a in gltf.get("animations", []) for c in a["channels"] if c["target"]["path"] != "weights"}
    shows = lambda node: ("mesh" in node or "camera" in node) and not node.get("children")
    return {i for i, node in enumerate(gltf.get("nodes", [])) if joints and shows(node) and i not in joints | moved}


def compare(path):
    file = File(path)
    gltf = file.json
    run = lambda *args: json.loads(subprocess.run([MOCAP, *args, "--json"], capture_output=True, check=True).stdout)
    nodes = [(index, parent) for index, parent in listed(gltf) if index not in left_out(gltf)]
    worst = 0.0
    for clip, animation in enumerate(gltf.get("animations", [])):
        tracks = []
        for channel in animation["channels"]:
            target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
            if target["path"] in ("translation", "rotation", "scale") and "node" in target:
                times, values = file.numbers(sampler["input"])[:, 0], file.numbers(sampler["output"])
                tracks.append((target["node"], target["path"], times, values, sampler.get("interpolation", "LINEAR")))
        if not tracks:
            continue
        start, end = min(track[2][0] for track in tracks), max(track[2][-1] for track in tracks)
        rate = run("info", str(path), "--clip", str(clip))["ticks_per_second"]
        # The last moment is after the end: at its very key a step is one or the other within a float's rounding.
        for share in (0.0, 0.123, 0.31, 0.5, 0.777, 1.00001):
            seconds = start + share * (end - start)
            driven = {}
            for node, name, times, values, way in tracks:
                driven.setdefault(node, {})[name] = sample(times, values, way, name, seconds)
            world, places = {}, []
            for index, parent in nodes:
                local = matrix(gltf["nodes"][index], driven.get(index, {}))
                world[index] = world[parent] @ local if parent is not None else local
                places.append(world[index][:3, 3])
            posed = run("pose", str(path), "--clip", str(clip), "--world", "--tick", repr(float(seconds * rate)))["nodes"]
            posed = posed[len(posed) - len(nodes) :]
            theirs = np.array([[node["matrix"][3], node["matrix"][7], node["matrix"][11]] for node in posed])
            places = np.array(places)
            size = max(np.ptp(places, axis=0).max(), np.abs(places).max(), 1e-9)
            worst = max(worst, np.abs(places - theirs).max() / size)
    return worst


def main():
    paths = []
    for argument in map(Path, sys.argv[1:]):
        paths += sorted(p for p in argument.rglob("*") if p.suffix in (".glb", ".gltf")) if argument.is_dir() else [argument]
    failed = 0
    for path in paths:
        try:
            worst = compare(path)
        except Exception as error:  # A file that one side cannot read is told, and the others go on.
            detail = getattr(error, "stderr", b"") or b""
            print(f"{path}: {type(error).__name__}: {error} {detail.decode(errors='replace').strip()}")
            failed += 1
            continue
        is_off = not worst <= 1e-5
        failed += is_off
        print(f"{path}: {worst:.2e} of its size{' - OFF' if is_off else ''}")
    print(f"{len(paths) - failed} passed, {failed} failed")
    sys.exit(1 if failed or not paths else 0)


main()
