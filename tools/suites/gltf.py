"""The paths of nodes of a glTF file, by pygltflib and NumPy."""


import warnings

import numpy as np
from pygltflib import GLTF2

from motion import Motion, Nothing, Refused, unique

# Files with versions and chunks that pygltflib does not know; the comparison uses the parts that it reads.
warnings.simplefilter("ignore")
KINDS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
COUNTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
# The largest number of compared times.
TIMES = 200


def numbers(document, index):
    stated = document.accessors[index]
    view = document.bufferViews[stated.bufferView]
    uri = document.buffers[view.buffer].uri
    data = document.get_data_from_buffer_uri(uri) if uri else document.binary_blob()
    kind, count = KINDS[stated.componentType], COUNTS[stated.type]
    stride = view.byteStride or np.dtype(kind).itemsize * count
    begin = (view.byteOffset or 0) + (stated.byteOffset or 0)
    values = np.array([np.frombuffer(data, kind, count, begin + row * stride) for row in range(stated.count)], dtype=float)
    if not stated.normalized:
        return values
    return np.maximum(values / np.iinfo(kind).max, -1)


def turned(quaternion):
    x, y, z, w = quaternion / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def slerp(a, b, part):
    dot = a @ b
    if dot < 0:
        b, dot = -b, -dot
    if dot > 0.9999999:
        return a + part * (b - a)
    angle = np.arccos(dot)
    return (np.sin((1 - part) * angle) * a + np.sin(part * angle) * b) / np.sin(angle)


def sampled(times, values, how, path, time):
    """The value of a sampler at a time, by the appendix of the specification."""
    curve = how == "CUBICSPLINE"
    at = lambda key: values[3 * key + 1] if curve else values[key]
    after = int(np.searchsorted(times, time, side="right"))
    if after == 0 or after == len(times):
        return at(min(after, len(times) - 1))
    before, step = after - 1, times[after] - times[after - 1]
    part = (time - times[before]) / step
    if how == "STEP":
        return at(before)
    if curve:
        t, out, into = part, step * values[3 * before + 2], step * values[3 * after]
        first, last = 2 * t**3 - 3 * t**2 + 1, 3 * t**2 - 2 * t**3
        return first * at(before) + (t**3 - 2 * t**2 + t) * out + last * at(after) + (t**3 - t**2) * into
    if path == "rotation":
        return slerp(at(before), at(after), part)
    return at(before) + part * (at(after) - at(before))


def motion(path, times=None):
    """The motion of the first animation, at these seconds. A file without animations has its rest pose."""
    try:
        document = GLTF2().load(str(path))
        return posed(document, times)
    except Nothing:
        raise
    except Exception as error:  # pygltflib has no error of its own.
        raise Refused(repr(error)) from error


def posed(document, seconds_of_poses):
    nodes = document.nodes
    if not nodes:
        raise Nothing("no node")
    parents = {child: index for index, node in enumerate(nodes) for child in node.children or []}
    tracks, times = {}, [np.zeros(1)]
    for animation in document.animations[:1]:
        for channel in animation.channels:
            node, path = channel.target.node, channel.target.path
            if node is None or path not in ("translation", "rotation", "scale", "weights"):
                continue
            sampler = animation.samplers[channel.sampler]
            keys, values = numbers(document, sampler.input)[:, 0], numbers(document, sampler.output)
            if path == "weights":
                values = values.reshape(len(keys) * (3 if sampler.interpolation == "CUBICSPLINE" else 1), -1)
            tracks[node, path] = keys, values, sampler.interpolation or "LINEAR"
            times.append(keys)
    seconds = max(float(keys[-1]) for keys in times)
    if not tracks:
        times = [0.0]
    elif seconds_of_poses is not None:
        times = seconds_of_poses
    else:
        times = np.linspace(0, seconds, TIMES + 1)

    def local(index, time):
        node = nodes[index]
        if node.matrix and not any(node_of == index for node_of, _ in tracks):
            return np.array(node.matrix, float).reshape(4, 4).T
        parts = {"translation": node.translation or [0, 0, 0], "rotation": node.rotation or [0, 0, 0, 1], "scale": node.scale or [1, 1, 1]}
        for path in parts:
            if (index, path) in tracks:
                keys, values, how = tracks[index, path]
                parts[path] = sampled(keys, values, how, path, time)
        matrix = np.eye(4)
        matrix[:3, :3] = turned(np.array(parts["rotation"], float)) * np.array(parts["scale"], float)
        matrix[:3, 3] = parts["translation"]
        return matrix

    places = np.empty((len(times), len(nodes), 3))
    for frame, time in enumerate(times):
        worlds = {}

        def world(index):
            if index not in worlds:
                above = world(parents[index]) if index in parents else np.eye(4)
                worlds[index] = above @ local(index, time)
            return worlds[index]

        for index in range(len(nodes)):
            places[frame, index] = world(index)[:3, 3]
    # Only the skin determines the positions of its vertices: the transform of its node has no effect.
    pairs = [(node.name, places[:, index]) for index, node in enumerate(nodes) if node.skin is None]
    for (index, path), (keys, values, how) in tracks.items():
        if path == "weights":
            weights = np.array([sampled(keys, values, how, path, time) for time in times])
            pairs += [(f"{nodes[index].name} weight {target}", np.outer(column, [1, 0, 0])) for target, column in enumerate(weights.T)]
    return Motion(seconds, unique(pairs))
