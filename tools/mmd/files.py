"""Writes .pmx and .vmd files by their specifications, with only `struct`."""

import struct

LINEAR = bytes([20] * 8 + [107] * 8)


def curves(x=(20, 20, 107, 107), y=(20, 20, 107, 107), z=(20, 20, 107, 107), turn=(20, 20, 107, 107)):
    """The 64 bytes of four curves (ax, ay, bx, by), with the programs' usual values in the third and the fourth
    byte."""
    first = [curve[part] for part in range(4) for curve in (x, y, z, turn)]
    rows = [first[row:] + [1] * row for row in range(4)]
    rows[0][2:4] = [0x63, 0x0F]
    return bytes(byte for row in rows for byte in row)


def field(name, size):
    return name.encode("cp932")[:size].ljust(size, b"\0")


def vmd(path, model, bones, morphs=(), states=(), cameras=0):
    """`bones`: (name, frame, position, rotation xyzw, curves); `morphs`: (name, frame, weight); `states`: (frame, {name: on})."""
    out = field("Vocaloid Motion Data 0002", 30) + field(model, 20)
    out += struct.pack("<I", len(bones))
    for name, frame, position, rotation, curve in bones:
        out += field(name, 15) + struct.pack("<I7f", frame, *position, *rotation) + (curve or curves())
    out += struct.pack("<I", len(morphs))
    for name, frame, weight in morphs:
        out += field(name, 15) + struct.pack("<If", frame, weight)
    out += struct.pack("<I", cameras) + bytes(61) * cameras + struct.pack("<II", 0, 0)
    out += struct.pack("<I", len(states))
    for frame, on in states:
        out += struct.pack("<IBI", frame, 1, len(on))
        for name, value in on.items():
            out += field(name, 20) + struct.pack("<B", value)
    path.write_bytes(out)


def text(words, utf8=False):
    data = words.encode("utf-8" if utf8 else "utf-16-le")
    return struct.pack("<i", len(data)) + data


def pmx(path, name, bones, morphs=(), size=1, utf8=False, mesh=True):
    """`bones` as in `dancer`. `size` is the number of bytes of every index. Writes one vertex for each kind of
    weights."""
    code = {1: "b", 2: "h", 4: "i"}[size]
    index = lambda value: struct.pack("<" + code, value)
    at = {bone["name"]: place for place, bone in enumerate(bones)}
    place = lambda bone: index(-1 if bone is None else at[bone])
    out = b"PMX " + struct.pack("<fB8B", 2.0, 8, int(utf8), 1, *[size] * 6)
    out += b"".join(text(words, utf8) for words in (name, "Dancer", "made by tools/mmd", ""))
    kinds = [index(0), index(0) * 2 + bytes(4), index(0) * 4 + bytes(16), index(0) * 2 + bytes(4 + 36)] if mesh else []
    out += struct.pack("<i", len(kinds))
    for kind, weights in enumerate(kinds):
        out += struct.pack("<8f", *[0.0] * 8) + bytes(16) + bytes([kind]) + weights + struct.pack("<f", 1.0)
    out += struct.pack("<i", 3 if mesh else 0) + b"".join(index(place) for place in (range(3) if mesh else ()))
    out += struct.pack("<i", 1) + text("skin.png", utf8)
    out += struct.pack("<i", 2)
    for toon in (0, 1):
        out += text("skin", utf8) * 2 + bytes(65) + index(0) + index(-1) + bytes([0, toon])
        out += (index(-1) if toon == 0 else bytes(1)) + text("", utf8) + struct.pack("<i", 0)
    out += struct.pack("<i", len(bones))
    for bone in bones:
        flags = 0x001E | (0x0020 if "ik" in bone else 0) | bone.get("flags", 0)
        flags |= (0x0100 if "turns" in bone else 0) | (0x0200 if "moves" in bone else 0)
        out += text(bone["name"], utf8) + text("", utf8) + struct.pack("<3f", *bone["at"]) + place(bone.get("parent"))
        out += struct.pack("<iH", bone.get("layer", 0), flags) + struct.pack("<3f", 0, 1, 0)
        if flags & 0x0300:
            source, ratio = bone.get("turns") or bone["moves"]
            out += place(source) + struct.pack("<f", ratio)
        if flags & 0x0400:
            out += struct.pack("<3f", *bone["axis"])
        if flags & 0x0800:
            out += struct.pack("<6f", 1, 0, 0, 0, 0, 1)
        if "ik" in bone:
            target, loops, step, links = bone["ik"]
            out += place(target) + struct.pack("<ifi", loops, step, len(links))
            for link, limits in links:
                out += place(link) + struct.pack("<B", limits is not None)
                out += b"" if limits is None else struct.pack("<6f", *limits[0], *limits[1])
    out += struct.pack("<i", len(morphs))
    for morph in morphs:
        out += text(morph, utf8) * 2 + struct.pack("<BBi", 1, 1, 1) + index(0) + struct.pack("<3f", 0, 0, 0)
    out += struct.pack("<iii", 0, 0, 0)
    path.write_bytes(out)
