"""Imports FBX and glTF files into Blender and prints the result as JSON.

usage: python blender.py < REQUESTS > ANSWERS

The input is a list of requests {"file": PATH, "seconds": [TIME, ..], "importer": NAME}. NAME is "wm.fbx_import", the
importer built into Blender since 4.5; or "import_scene.fbx", the importer in Python and the default here; or
"import_scene.gltf". The answer to a request is {"version": .., "bones": [NAME, ..], "off_child": {NAME: DEGREES},
"places": [[[x, y, z], ..], ..], "vertices": [[..]], "rate": .., "end": SECONDS, "console": [LINE, ..]}.

"places" has the heads of all bones at each time, in metres with +Y up. "vertices" has the vertices of all meshes, if
the request has "vertices". "off_child" has the rest angles between a bone, which Blender draws along +Y of its frame,
and the line to its child. With several children, the line goes to the nearest child or to their middle. "console" has
the lines that the importer prints besides the version of the file.
"""

import contextlib
import io
import json
import math
import os
import sys
import tempfile

import bpy
from mathutils import Vector


IMPORTERS = {
    "import_scene.fbx": lambda path: bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0),
    "import_scene.gltf": lambda path: bpy.ops.import_scene.gltf(filepath=path),
    "wm.fbx_import": lambda path: bpy.ops.wm.fbx_import(filepath=path, anim_offset=0.0),
}


# Lines that the importers print for every file.
SAID = ("FBX version", "FBX import of", "Failed to open dir")


# In metres: a bone whose child is nearer than this has no known direction.
COINCIDENT = 1e-3


def children(bone, size):
    """The children that are not at the position of the bone. Their own children replace children at this position."""
    for child in bone.children:
        if size * (child.head_local - bone.head_local).length > COINCIDENT:
            yield child
        else:
            yield from children(child, size)


def off_child(armatures):
    """The angle between each bone and the line to its child; with several children, to the nearest child or to their
    middle, whichever angle is less."""
    found = {}
    for armature in armatures:
        size = armature.matrix_world.to_scale().x
        for bone in armature.data.bones:
            lines = [child.head_local - bone.head_local for child in children(bone, size)]
            along = bone.matrix_local.to_3x3().col[1]
            middle = sum(lines, Vector()) / max(len(lines), 1)
            lines.append(middle)
            if size * middle.length <= COINCIDENT:
                continue
            angles = [math.degrees(along.angle(line)) for line in lines]
            found[bone.name] = min(angles)
    return found


def up(place):
    # Blender's up axis is Z.
    return [place.x, place.z, -place.y]


@contextlib.contextmanager
def console(lines):
    """Collects the output of Python and of C."""
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
    # The importer in Python multiplies the seconds of keys by the rounded rate; the built-in importer uses the exact
    # rate.
    of_keys = rate if request.get("importer") == "wm.fbx_import" else scene.render.fps
    ends = [action.frame_range[1] / of_keys for action in bpy.data.actions]
    answer = {
        "version": bpy.app.version_string,
        "bones": [bone.name for armature in armatures for bone in armature.pose.bones],
        "off_child": off_child(armatures),
        "places": [],
        "vertices": [],
        "rate": rate,
        "end": max(ends, default=0.0),
        "clips": sorted({action.name.split("|", 1)[-1] for action in bpy.data.actions}),
        "console": [line for line in lines if not line.startswith(SAID) and "| INFO: " not in line],
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
