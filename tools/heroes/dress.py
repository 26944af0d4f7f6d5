"""Paints clothes on the texture of a GLB or VRM character, in place. See README.md.

The bones that move a texel determine its colour: shirt, trousers, shoes, hair or skin.
"""

import json
import re
import struct
import sys
import zlib
from pathlib import Path

import numpy as np

SIZE = 512  # pixels on each side of the texture
MARGIN = 6  # pixels that each island of the texture is widened by, against seams

# The colours of the palette, as sRGB.
SKIN, HAIR, SHIRT, TROUSERS, SHOES = range(5)
PALETTE = [(224, 172, 138), (74, 44, 26), (214, 96, 44), (44, 62, 96), (92, 58, 40)]

# Garments by the names of bones in MakeHuman's default rig, its game engine rig and its Japanese rig.
GARMENTS = [
    (SHOES, r"foot|toe|ball_|足首|つま先"),
    (TROUSERS, r"pelvis|leg|thigh|calf|腰|足|ひざ|root|spine05|全ての親"),
    (SHIRT, r"spine|breast|clavicle|shoulder|upperarm|上半身|肩|腕"),
    (HAIR, r"head|頭"),
]
# The parts of the head that hair covers, as shares of its size: above BROW, and behind EAR down to NAPE.
BROW, EAR, NAPE = 0.78, 0.46, 0.3

COMPONENTS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def values(document, data, index):
    accessor = document["accessors"][index]
    view = document["bufferViews"][accessor["bufferView"]]
    kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
    stride = view.get("byteStride", kind.itemsize * width)
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.ndarray((accessor["count"], width), kind, data, start, (stride, kind.itemsize))


def garment_of(name):
    return next((garment for garment, pattern in GARMENTS if re.search(pattern, name, re.IGNORECASE)), SKIN)


def painted(document, data):
    """The garment of each texel, and SKIN for texels without a triangle."""
    primitive = document["meshes"][0]["primitives"][0]
    of = {name: values(document, data, index) for name, index in primitive["attributes"].items()}
    joints = document["skins"][0]["joints"]
    garments = np.array([garment_of(document["nodes"][joint]["name"]) for joint in joints])[of["JOINTS_0"]]
    weights = of["WEIGHTS_0"] / of["WEIGHTS_0"].sum(1, keepdims=True, dtype=float)
    shares = np.stack([(weights * (garments == one)).sum(1) for one in range(len(PALETTE))], 1)

    # The armature of a rig may be scaled and turned: the head lies above the feet, and the toes before the heels.
    positions = of["POSITION"].astype(float)
    middle = {one: positions[shares[:, one] > 0.5].mean(0) for one in (SHOES, HAIR, SHIRT)}
    up = np.eye(3)[np.abs(middle[HAIR] - middle[SHOES]).argmax()] * np.sign((middle[HAIR] - middle[SHOES]).sum())
    ahead = middle[SHOES] - positions[shares[:, TROUSERS] > 0.5].mean(0)
    ahead[np.abs(up) > 0.5] = 0
    ahead = np.eye(3)[np.abs(ahead).argmax()] * np.sign(ahead[np.abs(ahead).argmax()])
    head = positions[shares[:, HAIR] > 0.5]
    height, depth = ([(head @ axis).min(), np.ptp(head @ axis)] for axis in (up, ahead))

    texture = np.full((SIZE, SIZE), -1, np.int8)
    corners = values(document, data, primitive["indices"]).reshape(-1, 3)
    pixels = of["TEXCOORD_0"].astype(float) * SIZE - 0.5
    for corner in corners:
        triangle = pixels[corner]
        low, high = np.floor(triangle.min(0)).astype(int), np.ceil(triangle.max(0)).astype(int) + 1
        grid = np.stack(np.meshgrid(*(np.arange(a, b) for a, b in zip(low, high))), -1).reshape(-1, 2)
        edges = np.array([triangle[1] - triangle[0], triangle[2] - triangle[0]]).T
        if abs(np.linalg.det(edges)) < 1e-12:
            continue
        two = np.linalg.solve(edges, (grid - triangle[0]).T).T
        inside = np.column_stack([1 - two.sum(1), two])
        grid, inside = grid[(inside > -0.02).all(1)] % SIZE, inside[(inside > -0.02).all(1)]
        garment = (inside @ shares[corner]).argmax(1)
        point = inside @ positions[corner]
        above, before = ((point @ axis - low) / size for axis, (low, size) in zip((up, ahead), (height, depth)))
        hair = (above > BROW) | ((before < EAR) & (above > NAPE))
        garment[(garment == HAIR) & ~hair] = SKIN
        texture[grid[:, 1], grid[:, 0]] = garment
    for _ in range(MARGIN):
        for axis, step in ((0, 1), (0, -1), (1, 1), (1, -1)):
            beside = np.roll(texture, step, axis)
            texture = np.where(texture < 0, beside, texture)
    return np.maximum(texture, SKIN).astype(np.uint8)


def png(texture):
    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", SIZE, SIZE, 8, 3, 0, 0, 0))
    palette = chunk(b"PLTE", bytes(value for color in PALETTE for value in color))
    rows = b"".join(b"\0" + row.tobytes() for row in texture)
    return b"\x89PNG\r\n\x1a\n" + header + palette + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def padded(block, filler):
    return block + filler * (-len(block) % 4)


def main(path):
    whole = path.read_bytes()
    length = struct.unpack_from("<I", whole, 12)[0]
    document, data = json.loads(whole[20 : 20 + length]), whole[28 + length :]
    image = png(painted(document, data))
    # The buffer is written again, with the new image in place of the old image.
    place, packed = document["images"][0]["bufferView"], b""
    for index, view in enumerate(document["bufferViews"]):
        start = view.get("byteOffset", 0)
        part = image if index == place else data[start : start + view["byteLength"]]
        view["byteOffset"], view["byteLength"] = len(packed), len(part)
        packed = padded(packed + part, b"\0")
    document["buffers"][0]["byteLength"] = len(packed)
    text = padded(json.dumps(document, ensure_ascii=False, separators=(",", ":")).encode(), b" ")
    chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(packed), 0x004E4942) + packed
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    print(f"{path.name}: a texture of {len(image)} bytes")


for name in sys.argv[1:]:
    main(Path(name))
