"""Draws a file of a how-to page in Blender, at three moments, by Cycles, which needs no graphics card.

    PYTHON tools/how-to/blender.py FILE.fbx PICTURE.png

PYTHON has bpy.
"""

import sys

import bpy
from mathutils import Vector

SIZE = (900, 420)  # pixels
SAMPLES = 24  # rays for each pixel
APART = 1.4  # metres between two figures
MOMENTS = (0.2, 0.45, 0.7)  # fractions of the clip


def main(file, picture):
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.wm.fbx_import(filepath=file)
    armature = next(one for one in scene.objects if one.type == "ARMATURE")
    first, last = armature.animation_data.action.frame_range
    hips = armature.pose.bones[1]
    for number, moment in enumerate(MOMENTS):
        scene.frame_set(round(first + moment * (last - first)))
        graph = bpy.context.evaluated_depsgraph_get()
        place = armature.matrix_world @ hips.head
        for skin in [one for one in scene.objects if one.type == "MESH" and one.parent is armature]:
            still = bpy.data.objects.new("still", bpy.data.meshes.new_from_object(skin.evaluated_get(graph)))
            still.matrix_world = skin.evaluated_get(graph).matrix_world
            still.location += Vector(((number - 1) * APART - place.x, -place.y, 0))
            scene.collection.objects.link(still)
    for one in list(scene.objects):
        one.hide_render = one.name.split(".")[0] != "still"

    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples = "CPU", SAMPLES
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = (0.7, 0.7, 0.7)
    scene.view_settings.view_transform = "Standard"
    bpy.ops.mesh.primitive_plane_add(size=30)
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.2, 0.5))
    bpy.context.object.data.energy = 2
    aim = Vector((0, 0, 0.85))
    bpy.ops.object.camera_add(location=aim + Vector((0.4, -6.2, 0.9)))
    scene.camera = bpy.context.object
    scene.camera.rotation_euler = (aim - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


main(*sys.argv[1:])
