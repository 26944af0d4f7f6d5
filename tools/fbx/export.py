"""Measures size and time of Blender's FBX exporter for the motion of an FBX file: with its default simplification, and
with every key.

usage: python export.py FILE.fbx OUT.fbx
"""

import contextlib
import io
import os
import sys
import time

import bpy

source, target = sys.argv[1:3]
bpy.ops.wm.read_factory_settings(use_empty=True)
with contextlib.redirect_stdout(io.StringIO()):
    bpy.ops.import_scene.fbx(filepath=source, anim_offset=0.0)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 0, round(bpy.data.actions[0].frame_range[1])
    results = []
    for factor in [1.0, 0.0]:
        start = time.process_time()
        bpy.ops.export_scene.fbx(
            filepath=target,
            add_leaf_bones=False,
            bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False,
            bake_anim_simplify_factor=factor,
        )
        results.append((time.process_time() - start, os.path.getsize(target)))
for name, (seconds, size) in zip(["simplified", "every key"], results):
    print(f"{name}: {seconds:.2f} s, {size} bytes")
