"""Prints where ufbx or Assimp has the nodes of a file, as JSON: of each time a map from name to place.

    clients.py ufbx|assimp FILE METRES SECONDS..

METRES is what a unit of the file is for Assimp, which keeps the numbers of the file."""

import gc
import json
import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "fbx"))

# Frames per second of the highest rate among the files: so near a key is at a time.
RATE = 240.0
# Scenes of ufbx: its module frees them in an order that crashes, also the garbage collector.
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
