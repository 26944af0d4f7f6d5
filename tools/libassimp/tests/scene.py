"""Prints the nodes, meshes and channels of a motion in pyassimp.

    scene.py motion.bvh
"""

import ctypes
import sys

import pyassimp
from pyassimp import core, postprocess

HIGHEST_WITHOUT_BONES = postprocess.aiProcessPreset_TargetRealtime_MaxQuality | postprocess.aiProcess_Debone


def print_node(node, depth):
    meshes = " ".join(str(len(mesh.vertices)) for mesh in node.meshes)
    print("  " * depth + node.name, "meshes", meshes)
    for row in node.transformation:
        print("  " * depth, *(f"{value:.6g}" for value in row))
    for child in node.children:
        print_node(child, depth + 1)


def print_channel(channel):
    print("channel", channel.nodename.data.decode())
    for kind in "position", "rotation", "scaling":
        keys = getattr(channel, kind + "keys")
        print(" ", kind, len(keys))
        for key in keys:
            print("   ", f"{key.time:.6g}", *(f"{value:.6g}" for value in key.value))


# On standard error, so that the standard output is the same for every library.
print(core._assimp_lib.dll._name, file=sys.stderr)
with pyassimp.load(sys.argv[1], processing=HIGHEST_WITHOUT_BONES) as scene:
    print_node(scene.rootnode, 0)
    for mesh in scene.meshes:
        print("mesh", len(mesh.vertices), len(mesh.faces), len(mesh.bones), "material", mesh.materialindex)
        for vertex in mesh.vertices:
            print(" ", *(f"{value:.6g}" for value in vertex))
        for face in mesh.faces:
            print(" ", *face)
    for material in scene.materials:
        print("material", sorted(material.properties.items(), key=str))
    for animation in scene.animations:
        print("animation", animation.duration, f"{animation.tickspersecond:.6g}")
        for channel in animation.channels:
            print_channel(channel)
    blob = pyassimp.export_blob(scene, "glb2").contents
    print("exported", ctypes.string_at(blob.data, 4).decode(), blob.size > 1000)
