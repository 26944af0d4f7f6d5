#!/usr/bin/env python3
"""Compares the nodes of glTF files in `mocap` with an independent sampler in double precision.

    tools/interop/corpus.py [--json] FILE_OR_FOLDER...

Every clip is compared at its ends and at moments between them; a file without a clip is compared in its rest pose. The
limit is 1e-5 of the figure's size. `FILE=TWIN` gives `FILE` to mocap, and its uncompressed copy `TWIN` to the sampler.
`--json` prints an object for each file. MOCAP names the program; the default is target/release/mocap. The exit code is
1 if a file differs or cannot be read.
"""
import base64
import json
import math
import os
import struct
import subprocess
import sys
import urllib.parse
from bisect import bisect_right
from pathlib import Path

MOCAP = os.environ.get("MOCAP", str(Path(__file__).resolve().parents[2] / "target/release/mocap"))
TOLERANCE = 1e-5
TYPES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
COLUMNS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
LARGEST = {"b": 127, "B": 255, "h": 32767, "H": 65535}
# The last moment is after the end: exactly at its key, rounding decides which value a step has.
MOMENTS = (0.0, 0.123, 0.31, 0.5, 0.777, 1.00001)
PATHS = ("translation", "rotation", "scale")


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
        row = struct.Struct(f"<{columns}{kind}")
        stride = view.get("byteStride", row.size)
        start = view.get("byteOffset", 0) + offset
        data = self.buffer(view["buffer"])
        return [row.unpack_from(data, start + index * stride) for index in range(count)]

    def numbers(self, index):
        """The rows of an accessor."""
        accessor = self.json["accessors"][index]
        kind, columns, count = TYPES[accessor["componentType"]], COLUMNS[accessor["type"]], accessor["count"]
        if "bufferView" in accessor:
            values = self.rows(accessor["bufferView"], accessor.get("byteOffset", 0), kind, columns, count)
        else:
            values = [(0,) * columns] * count
        if "sparse" in accessor:
            sparse = accessor["sparse"]
            at, new = sparse["indices"], sparse["values"]
            places = self.rows(at["bufferView"], at.get("byteOffset", 0), TYPES[at["componentType"]], 1, sparse["count"])
            others = self.rows(new["bufferView"], new.get("byteOffset", 0), kind, columns, sparse["count"])
            for (place,), value in zip(places, others):
                values[place] = value
        if accessor.get("normalized"):
            values = [tuple(max(number / LARGEST[kind], -1.0) for number in value) for value in values]
        return values


def unit(quaternion):
    length = math.sqrt(sum(number * number for number in quaternion))
    return tuple(number / length for number in quaternion)


def mixed(a, b, share):
    return tuple(x + share * (y - x) for x, y in zip(a, b))


def slerp(a, b, share):
    a, b = unit(a), unit(b)
    dot = sum(x * y for x, y in zip(a, b))
    if dot < 0:
        b, dot = tuple(-y for y in b), -dot
    angle = math.acos(min(dot, 1.0))
    if angle < 1e-9:
        return mixed(a, b, share)
    left, right = math.sin((1 - share) * angle) / math.sin(angle), math.sin(share * angle) / math.sin(angle)
    return tuple(left * x + right * y for x, y in zip(a, b))


def sample(times, values, interpolation, path, seconds):
    is_curve = interpolation == "CUBICSPLINE"
    value = (lambda key: values[3 * key + 1]) if is_curve else (lambda key: values[key])
    if seconds <= times[0] or len(times) == 1:
        return value(0)
    if seconds >= times[-1]:
        return value(len(times) - 1)
    key = bisect_right(times, seconds) - 1
    duration = times[key + 1] - times[key]
    t = (seconds - times[key]) / duration
    if interpolation == "STEP":
        return value(key)
    if is_curve:
        columns = zip(value(key), values[3 * key + 2], value(key + 1), values[3 * key + 3])
        return tuple(
            (2 * t**3 - 3 * t**2 + 1) * start
            + duration * (t**3 - 2 * t**2 + t) * out
            + (3 * t**2 - 2 * t**3) * end
            + duration * (t**3 - t**2) * into
            for start, out, end, into in columns
        )
    return (slerp if path == "rotation" else mixed)(value(key), value(key + 1), t)


def matrix(node, driven):
    """The local transform as the first three rows of a matrix."""
    if "matrix" in node and not driven:
        return [tuple(float(node["matrix"][4 * column + row]) for column in range(4)) for row in range(3)]
    x, y, z, w = unit(driven.get("rotation", node.get("rotation", (0, 0, 0, 1))))
    turn = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    scale = driven.get("scale", node.get("scale", (1, 1, 1)))
    place = driven.get("translation", node.get("translation", (0, 0, 0)))
    return [tuple(a * b for a, b in zip(row, scale)) + (place[at],) for at, row in enumerate(turn)]


def product(left, right):
    right = [*right, (0.0, 0.0, 0.0, 1.0)]
    return [tuple(sum(row[i] * right[i][column] for i in range(4)) for column in range(4)) for row in left]


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
        if len(found) == len(nodes):
            raise ValueError("a node has more than one parent")
        index, parent = todo.pop()
        found.append((index, parent))
        todo += [(child, index) for child in reversed(nodes[index].get("children", []))]
    return found


def target(channel):
    """The node and the property that a channel moves; None if it moves neither translation, rotation nor scale."""
    at = channel["target"]
    pointer = at.get("extensions", {}).get("KHR_animation_pointer", {}).get("pointer", "").split("/")
    if at["path"] == "pointer" and len(pointer) == 4 and pointer[1] == "nodes" and pointer[3] in PATHS:
        return int(pointer[2]), pointer[3]
    return (at["node"], at["path"]) if at["path"] in PATHS and "node" in at else None


def left_out(gltf):
    """Nodes that only have a visible mesh, in a file with joints."""
    joints = {joint for skin in gltf.get("skins", []) for joint in skin["joints"]}
    moved = {target(c)[0] for a in gltf.get("animations", []) for c in a["channels"] if target(c)}
    shows = lambda node: ("mesh" in node or "camera" in node) and not node.get("children")
    return {i for i, node in enumerate(gltf.get("nodes", [])) if joints and shows(node) and i not in joints | moved}


def run(*arguments):
    return json.loads(subprocess.run([MOCAP, *arguments, "--json"], capture_output=True, check=True).stdout)


def distance(gltf, nodes, driven, posed):
    """The largest error of `mocap`, as a fraction of the figure's size."""
    world = {}
    for index, parent in nodes:
        local = matrix(gltf["nodes"][index], driven.get(index, {}))
        world[index] = local if parent is None else product(world[parent], local)
    places = [[row[3] for row in world[index]] for index, _ in nodes]
    theirs = [[node["matrix"][at] for at in (3, 7, 11)] for node in posed[len(posed) - len(nodes) :]]
    if len(theirs) != len(places):
        raise ValueError(f"mocap has {len(posed)} nodes where {len(nodes)} were expected")
    size = max((abs(number) for place in places for number in place), default=0.0)
    off = [abs(a - b) for place, other in zip(places, theirs) for a, b in zip(place, other)]
    return max(off, default=0.0) / max(size, 1e-9)


def compare(path, twin):
    """The largest distance, and the number of clips."""
    file = File(twin)
    gltf = file.json
    without = left_out(gltf)
    nodes = [(index, parent) for index, parent in listed(gltf) if index not in without]
    pose = lambda *more: run("pose", str(path), "--world", *more)["nodes"]
    worst, clips = 0.0, 0
    for clip, animation in enumerate(gltf.get("animations", [])):
        tracks = []
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            if target(channel):
                times = [time for (time,) in file.numbers(sampler["input"])]
                values = file.numbers(sampler["output"])
                tracks.append((*target(channel), times, values, sampler.get("interpolation", "LINEAR")))
        if not tracks:
            continue
        clips += 1
        start, end = min(track[2][0] for track in tracks), max(track[2][-1] for track in tracks)
        rate = run("info", str(path), "--clip", str(clip))["ticks_per_second"]
        for share in MOMENTS:
            seconds = start + share * (end - start)
            driven = {}
            for node, name, times, values, interpolation in tracks:
                driven.setdefault(node, {})[name] = sample(times, values, interpolation, name, seconds)
            posed = pose("--clip", str(clip), "--tick", repr(float(seconds * rate)))
            worst = max(worst, distance(gltf, nodes, driven, posed))
    if clips == 0 and nodes:
        worst = distance(gltf, nodes, {}, pose("--tick", "0"))
    return worst, clips


def judge(argument):
    path, _, twin = argument.partition("=")
    result = {"file": path, "clips": 0, "off": None, "error": None}
    try:
        result["off"], result["clips"] = compare(Path(path), Path(twin or path))
    except subprocess.CalledProcessError as error:
        result["error"] = error.stderr.decode(errors="replace").strip() or str(error)
    except Exception as error:  # The script reports a file that the sampler cannot read, and continues.
        result["error"] = f"the sampler: {type(error).__name__}: {error}"
    return result


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--json"]
    files = []
    for argument in arguments:
        found = Path(argument).rglob("*") if Path(argument).is_dir() else [argument]
        files += sorted(str(path) for path in found if Path(path).suffix in (".glb", ".gltf") or path == argument)
    failed = 0
    for argument in files:
        result = judge(argument)
        is_right = result["error"] is None and result["off"] <= TOLERANCE
        failed += not is_right
        if "--json" in sys.argv:
            print(json.dumps(result), flush=True)
        elif result["error"]:
            print(f"{result['file']}: {result['error']}")
        else:
            print(f"{result['file']}: {result['clips']} clips, {result['off']:.2e} of its size{'' if is_right else ' - OFF'}")
    if "--json" not in sys.argv:
        print(f"{len(files) - failed} passed, {failed} failed")
    sys.exit(1 if failed or not files else 0)


if __name__ == "__main__":
    main()
