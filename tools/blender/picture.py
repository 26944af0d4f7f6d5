#!/usr/bin/env python3
"""Draws a character with a retargeted motion from two sides, beside the imported motion.

    PYTHON tools/blender/picture.py HERO.glb MOTION OUTPUT.png MOCAP.zip

PYTHON has bpy. OUTPUT-front.png and OUTPUT-side.png are drawn by Cycles, which needs no graphics card.
"""

import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

SIZE = (720, 480)
SAMPLES = 16


def tube(armature, bone):
    """Makes a visible mesh for a bone."""
    length = bone.length
    bpy.ops.mesh.primitive_cone_add(vertices=8, radius1=length / 8, radius2=length / 40, depth=length)
    cone = bpy.context.object
    cone.parent, cone.parent_type, cone.parent_bone = armature, "BONE", bone.name
    # A child of a bone is at its tail, with its +Y along the bone.
    cone.rotation_euler, cone.location = (-math.pi / 2, 0, 0), (0, -length / 2, 0)


def main():
    hero, motion, output, file = sys.argv[1:5]
    bpy.ops.preferences.addon_enable(module="bl_pkg")
    bpy.ops.extensions.package_install_files(filepath=file, repo="user_default", enable_on_install=True)
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=hero)
    (armature,) = [one for one in bpy.context.scene.objects if one.type == "ARMATURE"]
    bpy.context.view_layer.objects.active = armature
    bpy.ops.mocap.retarget_files(filepath=motion, rate="SET")
    bpy.ops.mocap.import_motion(filepath=motion, rate="SET")
    imported = bpy.context.object
    imported.location.x += 1.2
    for bone in imported.data.bones:
        tube(imported, bone)

    scene = bpy.context.scene
    scene.frame_set((scene.frame_start + scene.frame_end) // 2)
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", SAMPLES
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.6, 0.6, 0.6)
    bpy.ops.mesh.primitive_plane_add(size=20)
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.3, 0.5))
    bpy.context.object.data.energy = 3
    middle = armature.matrix_world @ armature.pose.bones[1].head + Vector((0.6, 0, 0))
    middle.z = 0.95
    for name, direction in (("front", Vector((0.1, -1, 0.15))), ("side", Vector((-1, -0.35, 0.15)))):
        bpy.ops.object.camera_add(location=middle + 5.2 * direction.normalized())
        scene.camera = bpy.context.object
        scene.camera.rotation_euler = (-direction).to_track_quat("-Z", "Y").to_euler()
        path = Path(output)
        scene.render.filepath = str(path.with_name(f"{path.stem}-{name}.png").resolve())
        bpy.ops.render.render(write_still=True)


main()
