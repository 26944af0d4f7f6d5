"""Writes C3D files with reals or integers of Intel, DEC and SGI, by the user guide, without code of mocap."""

import struct

import numpy as np

PROCESSORS = {"intel": 84, "dec": 85, "sgi": 86}


def real(value, processor):
    if processor == "sgi":
        return struct.pack(">f", value)
    if processor == "intel":
        return struct.pack("<f", value)
    low, high = struct.unpack("<HH", struct.pack("<f", value * 4))
    return struct.pack("<HH", high, low)


def word(value, processor):
    return struct.pack(">H" if processor == "sgi" else "<H", int(value) & 0xFFFF)


def parameter(number, name, value, processor):
    """Text, a list of texts, integers, or reals; arrays have the first index fastest."""
    if isinstance(value, str) or isinstance(value, list) and isinstance(value[0], str):
        texts = [value] if isinstance(value, str) else value
        length = max(len(text) for text in texts)
        sizes = [length] if isinstance(value, str) else [length, len(texts)]
        kind, data = -1, "".join(text.ljust(length) for text in texts).encode()
    else:
        array = np.asarray(value)
        flat = array.reshape(-1, order="F")
        sizes = list(array.shape)
        is_integer = np.issubdtype(array.dtype, np.integer)
        kind = 2 if is_integer else 4
        data = b"".join((word if is_integer else real)(number, processor) for number in flat)
    body = struct.pack("bB", kind, len(sizes)) + bytes(sizes) + data + b"\0"
    head = struct.pack("bb", len(name), number) + name.encode()
    return head + word(len(body) + 2, processor) + body


def write(path, points, analog, groups, *, rate, per_frame, first=1, processor="intel", scale=-0.1):
    """`points`: frame, point, (x, y, z, residual); `analog`: channel, sample, in the units of the file. With a `scale`
    above 0, both are integers."""
    frames, count = points.shape[:2]
    channels = len(analog)
    section = b"\1\x50\0" + bytes([PROCESSORS[processor]])
    for number, (group, parameters) in enumerate(groups.items(), 1):
        section += struct.pack("bb", len(group), -number) + group.encode() + word(3, processor) + b"\0"
        section += b"".join(parameter(number, name, value, processor) for name, value in parameters.items())
    section += b"\0\0"
    blocks = -(-len(section) // 512)
    section = section[:2] + bytes([blocks]) + section[3:]
    header = bytearray(512)
    header[0:2] = b"\2\x50"
    words = {2: count, 4: channels * per_frame, 6: first, 8: first + frames - 1, 10: 10, 16: blocks + 2, 18: per_frame}
    for at, value in words.items():
        header[at : at + 2] = word(value, processor)
    header[12:16] = real(scale, processor)
    header[20:24] = real(rate, processor)
    number = word if scale > 0 else real
    data = bytearray()
    for frame in range(frames):
        for x, y, z, residual in points[frame]:
            place = [x / scale, y / scale, z / scale] if scale > 0 else [x, y, z]
            data += b"".join(number(round(value) if scale > 0 else value, processor) for value in [*place, residual])
        for sample in range(frame * per_frame, (frame + 1) * per_frame):
            data += b"".join(number(round(value) if scale > 0 else value, processor) for value in analog[:, sample])
    data += bytes(-len(data) % 512)
    with open(path, "wb") as file:
        file.write(bytes(header) + section.ljust(512 * blocks, b"\0") + bytes(data))
