"""Prints the positions of a file's nodes in ufbx or Assimp as JSON: for each time, a map from name to position.

    clients.py ufbx|assimp FILE METRES SECONDS..

METRES is the length of the file's unit for Assimp, which keeps the numbers of the file."""

import gc
import json
import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "fbx"))

# The highest frame rate of the files: within such a frame, a key counts as at a time.
RATE = 240.0
# Keeps all scenes of ufbx, because its module crashes when it frees them, even through the garbage collector.
HELD = []


def in_ufbx(path, seconds):
    import ufbx

    gc.disable()
    scene = ufbx.load_file(
        path,
        target_axes=ufbx.axes_right_handed_y_up,
        target_unit_meters=1,
        space_conversion=ufbx.SpaceConversion.MODIFY_GEOMETRY,
    )
    anim = scene.anim_stacks[0].anim
    HELD.extend([scene, anim])
    posed = [scene.evaluate(anim, anim.time_begin + time) for time in seconds]
    HELD.extend(posed)
    return [{node.name: [*node.node_to_world.c3] for node in frame.nodes if not node.is_root} for frame in posed]


def in_assimp(path, metres, seconds):
    from assimp import assimp

    with tempfile.TemporaryDirectory() as folder:
        found = assimp(path, Path(folder), seconds, RATE, metres)
    if "refusal" in found:
        sys.exit(str(found["refusal"]))
    return found["places"]


def main(client, path, metres, *seconds):
    seconds = [float(second) for second in seconds]
    found = in_ufbx(path, seconds) if client == "ufbx" else in_assimp(path, float(metres), seconds)
    print(json.dumps(found), flush=True)
    os._exit(0)


main(*sys.argv[1:])
