"""Imports .glb files into Blender and prints the result as JSON.

usage: python places.py < REQUESTS > ANSWERS

A request is {"file": PATH, "frames_per_second": RATE, "seconds": [TIME, ..]}; the input is a list of them. The answer
to it is {"armatures": COUNT, "meshes": COUNT, "bones": [NAME, ..], "places": [[[x, y, z], ..], ..]}: for each time, for
each bone, the place of its head in glTF's axes. The first answer is Blender's version. Blender itself comes as the
Python package bpy.
"""

import contextlib
import io
import json
import math
import sys

import bpy


def answer(request):
    # Resets Blender each time: no default cube, and no keys of the last file.
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # The importer multiplies the seconds of a key by the scene's rate, and does not change the rate.
    scene = bpy.context.scene
    scene.render.fps = max(1, round(request["frames_per_second"]))
    scene.render.fps_base = 1.0
    try:
        bpy.ops.import_scene.gltf(filepath=request["file"])
    except RuntimeError as error:
        return {"refusal": str(error).strip()}

    armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    meshes = [thing for thing in bpy.data.objects if thing.type == "MESH" and thing.parent in armatures]
    answer = {"armatures": len(armatures), "meshes": len(meshes), "bones": [], "places": []}
    if len(armatures) != 1:
        return answer
    armature = armatures[0]
    answer["bones"] = [bone.name for bone in armature.pose.bones]
    for seconds in request["seconds"]:
        frame = seconds * scene.render.fps
        whole = math.floor(frame)
        scene.frame_set(whole, subframe=frame - whole)
        heads = [armature.matrix_world @ bone.head for bone in armature.pose.bones]
        # The up axis is Z in Blender, and Y in glTF.
        answer["places"].append([[head.x, head.z, -head.y] for head in heads])
    return answer


requests = json.load(sys.stdin)
# The importer prints its progress on standard output, where only the answers may be.
with contextlib.redirect_stdout(io.StringIO()):
    answers = [bpy.app.version_string] + [answer(request) for request in requests]
print(json.dumps(answers))
