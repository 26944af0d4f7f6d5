"""Finds the positions of a file's nodes in Assimp."""

import json
import math
import subprocess

# The largest distance in frames at which a time counts as at a key, because Assimp prints times with six digits.
NEXT = 0.05


def run(*args):
    return subprocess.run([str(arg) for arg in args], capture_output=True, text=True)


def multiply(a, b):
    """The product of 4 x 4 matrices, which are lists of 16 numbers."""
    return [sum(a[4 * row + k] * b[4 * k + column] for k in range(4)) for row in range(4) for column in range(4)]


def matrix(position, rotation, scale):
    w, x, y, z = rotation
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    made = []
    for row, place in zip(rows, position):
        made += [value * factor for value, factor in zip(row, scale)] + [place]
    return [*made, 0, 0, 0, 1]


def key_at(keys, time, near):
    """The value at a time: linear, or along an arc for a rotation. A key within `near` of the time counts as at the
    time."""
    before = max((key for key in keys if key[0] <= time + near), key=lambda key: key[0], default=keys[0])
    after = min((key for key in keys if key[0] >= time - near), key=lambda key: key[0], default=keys[-1])
    if before[0] >= after[0]:
        return before[1]
    share = (time - before[0]) / (after[0] - before[0])
    a, b = before[1], after[1]
    weights = (1 - share, share)
    if len(a) == 4:
        cosine = sum(x * y for x, y in zip(a, b))
        if cosine < 0:
            b, cosine = [-x for x in b], -cosine
        angle = math.acos(min(cosine, 1))
        if angle > 1e-6:
            weights = tuple(math.sin(weight * angle) / math.sin(angle) for weight in weights)
    return [weights[0] * x + weights[1] * y for x, y in zip(a, b)]


def assimp(path, folder, seconds, file_rate, metres=0.01):
    """The positions of all nodes by name at these times, the end in seconds, and the rate, as Assimp reads them. Assimp
    keeps the unit of the file, whose length in metres is an argument."""
    out = folder / "assimp.json"
    out.unlink(missing_ok=True)
    ran = run("assimp", "export", path, out, "-fassjson")
    if not out.exists():
        return {"refusal": ran.stdout.strip().splitlines()[-1:]}
    scene = json.loads(out.read_text())
    clips = scene.get("animations", [])
    channels, rate, end = {}, None, 0.0
    if clips:
        rate = clips[0]["tickspersecond"]
        end = clips[0]["duration"] / rate
        channels = {channel["name"]: channel for channel in clips[0]["channels"]}
    places = []
    for time in seconds:
        found = {}
        open_nodes = [(scene["rootnode"], matrix((0, 0, 0), (1, 0, 0, 0), (1, 1, 1)))]
        while open_nodes:
            node, above = open_nodes.pop()
            channel = channels.get(node["name"])
            local = node["transformation"]
            if channel:
                # Assimp gives one tick a second for a custom frame rate.
                tick, near = time * rate, NEXT * rate / file_rate
                local = matrix(
                    key_at(channel["positionkeys"], tick, near),
                    key_at(channel["rotationkeys"], tick, near),
                    key_at(channel["scalingkeys"], tick, near),
                )
            world = multiply(above, local)
            found[node["name"]] = [world[3] * metres, world[7] * metres, world[11] * metres]
            open_nodes += [(child, world) for child in node.get("children", [])]
        places.append(found)
    return {"places": places, "end": end, "rate": rate}
