"""Imports USD files into Blender and compares every bone with `mocap fk`, in frames over the whole motion.

usage: python blender.py MOCAP FILE..

Needs bpy of PyPI (Blender 5.0) and NumPy. A frame of Blender is a time code. Blender's importer converts +Y up to +Z up
and does not change the scene's frame rate.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

ALLOWED = 1e-4  # metres: Blender stores poses in 32 bits, and bones as heads and tails
FRAMES = 12

mocap, files = sys.argv[1], sys.argv[2:]
with tempfile.TemporaryDirectory() as name:
    for source in files:
        take, truth = Path(name) / "take.usdz", Path(name) / "truth.npz"
        for words in (["convert", source, take, "--force"], ["fk", source, "-o", truth, "--force", "--out-unit", "m", "--out-up", "y"]):
            subprocess.run([mocap, *map(str, words)], check=True, capture_output=True)
        truth = np.load(truth)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.wm.usd_import(filepath=str(take))
        (armature,) = [found for found in bpy.data.objects if found.type == "ARMATURE"]
        count, worst = len(truth["positions"]), 0.0
        bones = [bone.name for bone in armature.data.bones]
        assert len(bones) == len(truth["names"]), (len(bones), len(truth["names"]))
        for frame in np.unique(np.linspace(0, count - 1, FRAMES).astype(int)):
            bpy.context.scene.frame_set(int(frame))
            heads = [armature.matrix_world @ armature.pose.bones[bone].head for bone in bones]
            found = np.array([[head.x, head.z, -head.y] for head in heads])
            distance = np.linalg.norm(found[:, None] - truth["positions"][frame][None], axis=2)
            # Each joint has its bone, and each bone its joint.
            worst = max(worst, distance.min(axis=0).max(), distance.min(axis=1).max())
        print(f"usd: Blender {bpy.app.version_string}: {Path(source).name}: {len(bones)} bones at most {1000 * worst:.4f} mm off")
        assert worst < ALLOWED, (source, worst)
