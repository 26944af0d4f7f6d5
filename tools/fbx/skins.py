"""Compares the vertices of characters in FBX with the vertices of their GLB file, as Blender moves both.

usage: python skins.py FPS GLB=FBX..

Both files hold one motion on one character, by `mocap retarget MOTION CHARACTER -o FILE`. Prints, for three moments,
the largest distance of a vertex of one file from the nearest vertex of the other.
"""

import contextlib
import io
import math
import sys

import bpy
from mathutils.kdtree import KDTree


def vertices(load, path, rate, seconds):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    # The importer of glTF does not change the rate.
    scene.render.fps, scene.render.fps_base = rate, 1.0
    with contextlib.redirect_stdout(io.StringIO()):
        load(path)
    found = []
    for time in seconds:
        frame = time * scene.render.fps
        whole = math.floor(frame + 1e-9)
        scene.frame_set(whole, subframe=max(0, frame - whole))
        graph = bpy.context.evaluated_depsgraph_get()
        places = []
        for thing in bpy.data.objects:
            if thing.type == "MESH" and thing.find_armature():
                moved = thing.evaluated_get(graph)
                places += [moved.matrix_world @ vertex.co for vertex in moved.data.vertices]
        found.append(places)
    return found


def farthest(of, to):
    tree = KDTree(len(to))
    for index, place in enumerate(to):
        tree.insert(place, index)
    tree.balance()
    return max(tree.find(place)[2] for place in of)


IMPORTERS = {
    "wm.fbx_import": lambda path: bpy.ops.wm.fbx_import(filepath=path, anim_offset=0.0),
    "import_scene.fbx": lambda path: bpy.ops.import_scene.fbx(filepath=path, anim_offset=0.0),
}

rate = int(sys.argv[1])
for glb, fbx in (pair.split("=") for pair in sys.argv[2:]):
    seconds = [0.0, 30 / rate, 60 / rate]
    ours = vertices(lambda path: bpy.ops.import_scene.gltf(filepath=path), glb, rate, seconds)
    for importer, load in IMPORTERS.items():
        theirs = vertices(load, fbx, rate, seconds)
        off = max(max(farthest(a, b), farthest(b, a)) for a, b in zip(ours, theirs))
        print(f"{fbx}, {importer}: {len(theirs[0])} vertices, {1000 * off:.4f} mm")
