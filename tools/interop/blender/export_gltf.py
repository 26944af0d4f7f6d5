"""Writes a motion file as glTF with the default settings of Blender's exporter; `unsampled` keeps the curves.

    export_gltf.py INPUT OUTPUT [unsampled]
"""

import sys

import bpy

source, output, *options = sys.argv[1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
if source.endswith(".bvh"):
    bpy.ops.import_anim.bvh(filepath=source, update_scene_fps=True, update_scene_duration=True)
elif source.endswith(".fbx"):
    bpy.ops.import_scene.fbx(filepath=source)
else:
    bpy.ops.import_scene.gltf(filepath=source)
bpy.ops.export_scene.gltf(filepath=output, export_force_sampling="unsampled" not in options)
