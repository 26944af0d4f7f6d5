"""Reads the content of a GLB or VRM file from its JSON and its bytes, without a glTF library."""

import hashlib
import json
import math
import struct

SIZES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}
CODES = {5120: "b", 5121: "B", 5122: "h", 5123: "H", 5125: "I", 5126: "f"}
COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
# Normalised integers as numbers.
FULL = {5120: 127, 5121: 255, 5122: 32767, 5123: 65535}


class Document:
    def __init__(self, path):
        data = path.read_bytes()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + length])
        self.bytes = data[20 + length + 8 :]

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.bytes[start : start + view["byteLength"]], view.get("byteStride")

    def raw(self, index):
        """The bytes of each element of an accessor, one after the other, without the bytes between them."""
        accessor = self.json["accessors"][index]
        size = SIZES[accessor["componentType"]] * COMPONENTS[accessor["type"]]
        found = bytearray(size * accessor["count"])
        if "bufferView" in accessor:
            data, stride = self.view(accessor["bufferView"])
            stride, start = stride or size, accessor.get("byteOffset", 0)
            for item in range(accessor["count"]):
                found[size * item : size * (item + 1)] = data[start + stride * item : start + stride * item + size]
        sparse = accessor.get("sparse")
        if sparse:
            places, _ = self.view(sparse["indices"]["bufferView"])
            code = CODES[sparse["indices"]["componentType"]]
            places = struct.unpack_from(f"<{sparse['count']}{code}", places, sparse["indices"].get("byteOffset", 0))
            data, _ = self.view(sparse["values"]["bufferView"])
            start = sparse["values"].get("byteOffset", 0)
            for number, item in enumerate(places):
                found[size * item : size * (item + 1)] = data[start + size * number : start + size * (number + 1)]
        return bytes(found)

    def values(self, index):
        accessor = self.json["accessors"][index]
        data, kind = self.raw(index), accessor["componentType"]
        count = COMPONENTS[accessor["type"]]
        flat = struct.unpack(f"<{len(data) // SIZES[kind]}{CODES[kind]}", data)
        if accessor.get("normalized"):
            flat = [max(value / FULL[kind], -1.0) for value in flat]
        return [flat[at : at + count] for at in range(0, len(flat), count)]

    def hashes(self):
        """A hash of each part of the character that a motion must leave alone."""
        document = self.json
        found = {}

        def add(name, *parts):
            whole = hashlib.sha256()
            for part in parts:
                whole.update(part if isinstance(part, bytes) else json.dumps(part, sort_keys=True).encode())
            found[name] = whole.hexdigest()

        def accessor(index):
            """The fields and the numbers of an accessor, without their position in the file."""
            said = document["accessors"][index]
            keys = ["componentType", "type", "count", "normalized", "min", "max"]
            return [json.dumps({key: said.get(key) for key in keys}).encode(), self.raw(index)]

        for number, mesh in enumerate(document.get("meshes", [])):
            parts = [mesh.get("name"), mesh.get("weights"), mesh.get("extras"), mesh.get("extensions")]
            for primitive in mesh["primitives"]:
                rest = {key: value for key, value in primitive.items() if key not in ("attributes", "indices", "targets")}
                parts.append(rest)
                for name, index in sorted(primitive["attributes"].items()):
                    parts += [name, *accessor(index)]
                parts += accessor(primitive["indices"]) if "indices" in primitive else []
                for target in primitive.get("targets", []):
                    for name, index in sorted(target.items()):
                        parts += [name, *accessor(index)]
            add(f"mesh {number}", *parts)
        for number, image in enumerate(document.get("images", [])):
            rest = {key: value for key, value in image.items() if key != "bufferView"}
            add(f"image {number}", rest, self.view(image["bufferView"])[0] if "bufferView" in image else b"")
        for number, skin in enumerate(document.get("skins", [])):
            rest = {key: value for key, value in skin.items() if key != "inverseBindMatrices"}
            add(f"skin {number}", rest, *accessor(skin["inverseBindMatrices"]))
        for section in ["materials", "textures", "samplers", "scenes", "scene", "cameras", "extensions", "extras"]:
            if section in document:
                add(section, document[section])
        add("extensionsUsed", sorted(document.get("extensionsUsed", [])))
        # A moving node has translation, rotation and scale instead of a matrix; the comparison of positions judges
        # them.
        moving = ("matrix", "translation", "rotation", "scale")
        for number, node in enumerate(document.get("nodes", [])):
            add(f"node {number}", {key: value for key, value in node.items() if key not in moving})
        return found

    def places(self, seconds):
        """The positions of all named nodes at these times in the last animation, in metres with +Y up."""
        animation = self.json["animations"][-1]
        tracks = {}
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            times = [time[0] for time in self.values(sampler["input"])]
            tracks[channel["target"]["node"], channel["target"]["path"]] = (times, self.values(sampler["output"]))
        nodes = self.json["nodes"]
        tops = set(range(len(nodes))) - {child for node in nodes for child in node.get("children", [])}
        answer = []
        for time in seconds:
            found, open_nodes = {}, [(top, IDENTITY) for top in tops]
            while open_nodes:
                index, above = open_nodes.pop()
                node = nodes[index]
                world = multiply(above, local(node, lambda path: at(tracks.get((index, path)), time)))
                found[node.get("name", "")] = [world[3], world[7], world[11]]
                open_nodes += [(child, world) for child in node.get("children", [])]
            answer.append(found)
        return answer

    def end(self):
        animation = self.json["animations"][-1]
        return max(self.values(sampler["input"])[-1][0] for sampler in animation["samplers"])


IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def multiply(a, b):
    """The product of 4 x 4 matrices, which are lists of 16 numbers."""
    return [sum(a[4 * row + k] * b[4 * k + column] for k in range(4)) for row in range(4) for column in range(4)]


def at(track, time):
    """The value of a track: linear, or along an arc for a rotation."""
    if track is None:
        return None
    times, values = track
    after = next((place for place, key in enumerate(times) if key >= time), len(times) - 1)
    if after == 0 or times[after] <= time:
        return values[after]
    a, b = values[after - 1], values[after]
    part = (time - times[after - 1]) / (times[after] - times[after - 1])
    weights = (1 - part, part)
    if len(a) == 4:
        cosine = sum(x * y for x, y in zip(a, b))
        if cosine < 0:
            b, cosine = [-x for x in b], -cosine
        angle = math.acos(min(cosine, 1))
        if angle > 1e-6:
            weights = tuple(math.sin(weight * angle) / math.sin(angle) for weight in weights)
    return [weights[0] * x + weights[1] * y for x, y in zip(a, b)]


def local(node, animated):
    if "matrix" in node:
        return [node["matrix"][4 * column + row] for row in range(4) for column in range(4)]

    def value(path, usual):
        found = animated(path)
        return node.get(path, usual) if found is None else found

    x, y, z, w = value("rotation", (0, 0, 0, 1))
    length = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / length, y / length, z / length, w / length
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    scale, made = value("scale", (1, 1, 1)), []
    for row, place in zip(rows, value("translation", (0, 0, 0))):
        made += [number * factor for number, factor in zip(row, scale)] + [place]
    return [*made, 0, 0, 0, 1]
