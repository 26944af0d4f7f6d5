"""Reads markers of a C3D file of an Intel processor in millimetres, strictly by the description of the format."""

import struct

import numpy as np

BLOCK = 512


def markers(path):
    """Label -> (frames, 3), NaN where the marker was not seen; axes as in the file."""
    data = open(path, "rb").read()
    first = data[0]
    points, analog, start, end = struct.unpack_from("<4H", data, 2)
    scale, block = struct.unpack_from("<fH", data, 12)
    labels, offset = [], (first - 1) * BLOCK + 4
    groups, found = {}, {}
    while data[offset]:
        length, group = abs(struct.unpack_from("b", data, offset)[0]), struct.unpack_from("b", data, offset + 1)[0]
        name = data[offset + 2 : offset + 2 + length].decode("latin-1").upper()
        at = offset + 2 + length
        following = struct.unpack_from("<H", data, at)[0]
        if group < 0:
            groups[-group] = name
        else:
            found[group, name] = at + 2
        if following == 0:
            break
        offset = at + following
    for (group, name), at in found.items():
        if groups.get(group) == "POINT" and name == "LABELS":
            width, count = data[at + 2], data[at + 3]
            text = data[at + 4 : at + 4 + width * count].decode("latin-1")
            labels = [text[width * index : width * (index + 1)].strip() for index in range(count)]
    frames = end - start + 1
    kind = "<f4" if scale < 0 else "<i2"
    numbers = np.frombuffer(data, kind, frames * (4 * points + analog), (block - 1) * BLOCK)
    rows = numbers.reshape(frames, -1)[:, : 4 * points].reshape(frames, points, 4).astype(float)
    rows[rows[:, :, 3] < 0] = np.nan
    xyz = rows[:, :, :3] * (1.0 if scale < 0 else scale)
    return {label: xyz[:, index] for index, label in enumerate(labels)}
