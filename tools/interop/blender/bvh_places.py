"""Imports .bvh files into Blender and prints the positions of their joints as JSON.

usage: python bvh_places.py < REQUESTS > ANSWERS

A request is {"file": PATH, "frames": [FRAME, ..]}; the input is a list of them. The answer to it is {"bones": [NAME, ..],
"places": [[[x, y, z], ..], ..]}: for each frame, for each bone, the place of its head in the axes of the file. The first
answer is Blender's version. Blender itself comes as the Python package bpy.
"""

import contextlib
import io
import json
import math
import sys

import bpy


def answer(request):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    # The frames of the file are the frames of the scene, from 1, and the axes do not change.
    bpy.ops.import_anim.bvh(filepath=request["file"], frame_start=1, axis_forward="Y", axis_up="Z")
    armature = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
    answer = {"bones": [bone.name for bone in armature.pose.bones], "places": []}
    for frame in request["frames"]:
        whole = math.floor(frame)
        scene.frame_set(whole + 1, subframe=frame - whole)
        heads = [armature.matrix_world @ bone.head for bone in armature.pose.bones]
        answer["places"].append([list(head) for head in heads])
    return answer


requests = json.load(sys.stdin)
# The importer prints its progress on standard output, where only the answers may be.
with contextlib.redirect_stdout(io.StringIO()):
    answers = [bpy.app.version_string] + [answer(request) for request in requests]
print(json.dumps(answers))
