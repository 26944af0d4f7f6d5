"""Poses a VRM character in Blender with a VRM animation and the VRM add-on, and prints the poses as JSON.

usage: python vrma.py < REQUEST > ANSWER

The request is {"character": PATH, "animation": PATH, "frames_per_second": RATE, "seconds": [TIME, ..]}. The answer is
a list with, for each time, {BONE: [w, x, y, z], ..}: the rotation of each bone of the humanoid since the T-pose, in
Blender's axes. Blender is the Python package bpy, the add-on bpy-vrm-format.
"""

import contextlib
import io
import json
import math
import sys

import bpy


def poses(request):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    # The add-on puts a key on each frame of the scene, from frame 1.
    scene = bpy.context.scene
    scene.render.fps = round(request["frames_per_second"])
    scene.render.fps_base = scene.render.fps / request["frames_per_second"]
    bpy.ops.preferences.addon_enable(module="io_scene_vrm")
    bpy.ops.import_scene.vrm(filepath=request["character"])
    armature = next(thing for thing in bpy.data.objects if thing.type == "ARMATURE")
    bpy.context.view_layer.objects.active = armature
    bpy.ops.import_scene.vrma(filepath=request["animation"], armature_object_name=armature.name)
    bones = armature.data.vrm_addon_extension.vrm1.humanoid.human_bones.human_bone_name_to_human_bone()
    names = {name.value: bone.node.bone_name for name, bone in bones.items() if bone.node.bone_name}
    rate = scene.render.fps / scene.render.fps_base
    answer = []
    for seconds in request["seconds"]:
        frame = 1 + seconds * rate
        whole = math.floor(frame)
        scene.frame_set(whole, subframe=frame - whole)
        turns = {}
        for name, bone_name in names.items():
            bone = armature.pose.bones[bone_name]
            now = (armature.matrix_world @ bone.matrix).to_quaternion()
            rest = (armature.matrix_world @ bone.bone.matrix_local).to_quaternion()
            turns[name] = list(now @ rest.inverted())
        answer.append(turns)
    return answer


request = json.load(sys.stdin)
# Importers print their progress on standard output, where only the answer may be.
with contextlib.redirect_stdout(io.StringIO()):
    answer = poses(request)
print(json.dumps(answer))
