"""Imports FBX files into Blender and prints what it makes of them, as JSON.

usage: python blender.py < REQUESTS > ANSWERS

A request is {"file": PATH, "seconds": [TIME, ..], "importer": "wm.fbx_import" or "import_scene.fbx"}, the importer built
into Blender since 4.5 or that in Python, which is the default here; the input is a list of them. The answer to it is {"version": .., "bones":
[NAME, ..], "places": [[[x, y, z], ..], ..], "vertices": [[..]], "rate": .., "end": SECONDS, "console": [LINE, ..]}: for each
time the places of the heads of all bones in metres with +Y up, and those of the vertices of all meshes where the request
has "vertices"; and the lines that the importer prints beside the version of the file.
"""

import contextlib
import io
import json
import math
import os
import sys
import tempfile

import bpy


IMPORTERS = {
    "import_scene.fbx": lambda path: bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0),
    "wm.fbx_import": lambda path: bpy.ops.wm.fbx_import(filepath=path, anim_offset=0.0),
}


# What the importers print of every file.
SAID = ("FBX version", "FBX import of", "Failed to open dir")


def up(place):
    # Blender points up along Z.
    return [place.x, place.z, -place.y]


@contextlib.contextmanager
def console(lines):
    """Collects what is printed, by Python and by C."""
    with tempfile.TemporaryFile(mode="w+") as file:
        saved = os.dup(1), os.dup(2)
        sys.stdout.flush()
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
        try:
            yield
        finally:
            sys.stdout.flush()
            sys.stderr.flush()
            for target, fd in zip((1, 2), saved):
                os.dup2(fd, target)
                os.close(fd)
            file.seek(0)
            lines.extend(line.strip() for line in file if line.strip())


def answer(request):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    lines = []
    with console(lines):
        try:
            IMPORTERS[request.get("importer", "import_scene.fbx")](request["file"])
        except Exception as error:  # noqa: BLE001, the importer of Python raises whatever goes wrong
            return {"refusal": f"{type(error).__name__}: {error}".strip()}
    scene = bpy.context.scene
    armatures = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    meshes = sorted((thing for thing in bpy.data.objects if thing.type == "MESH"), key=lambda thing: thing.name)
    rate = scene.render.fps / scene.render.fps_base
    # The importer in Python puts keys at the whole rate times their seconds, the other one at the exact rate.
    of_keys = rate if request.get("importer") == "wm.fbx_import" else scene.render.fps
    ends = [action.frame_range[1] / of_keys for action in bpy.data.actions]
    answer = {
        "version": bpy.app.version_string,
        "bones": [bone.name for armature in armatures for bone in armature.pose.bones],
        "places": [],
        "vertices": [],
        "rate": rate,
        "end": max(ends, default=0.0),
        "clips": sorted({action.name.split("|", 1)[-1] for action in bpy.data.actions}),
        "console": [line for line in lines if not line.startswith(SAID)],
    }
    for seconds in request["seconds"]:
        frame = seconds * of_keys
        whole = math.floor(frame)
        scene.frame_set(whole, subframe=frame - whole)
        heads = [up(armature.matrix_world @ bone.head) for armature in armatures for bone in armature.pose.bones]
        answer["places"].append(heads)
        if request.get("vertices"):
            graph = bpy.context.evaluated_depsgraph_get()
            found = []
            for mesh in meshes:
                moved = mesh.evaluated_get(graph)
                found.extend(up(moved.matrix_world @ vertex.co) for vertex in moved.data.vertices)
            answer["vertices"].append(found)
    return answer


requests = json.load(sys.stdin)
print(json.dumps([answer(request) for request in requests]))
