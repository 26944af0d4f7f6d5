"""Draws a file of a how-to page in Blender at three moments, with Cycles, which needs no graphics card.

    PYTHON tools/how-to/blender.py FILE.fbx PICTURE.jpg

PYTHON has bpy.
"""

import sys
from pathlib import Path

import bpy
from mathutils import Vector

SIZE = (900, 420)  # pixels
SAMPLES = 24  # rays for each pixel
APART = 1.9  # metres between the middles of two figures
WORLD = (0.6, 0.67, 0.75, 1)  # light, so that the figures stand out
MOMENTS = (0.1, 0.35, 0.95)  # fractions of the clip


def without_comments(jpeg):
    """The bytes of a JPEG file without its comments, which have the date and the time of rendering."""
    kept, at = jpeg[:2], 2
    while jpeg[at + 1] != 0xDA:
        end = at + 2 + int.from_bytes(jpeg[at + 2 : at + 4], "big")
        if jpeg[at + 1] != 0xFE:
            kept += jpeg[at:end]
        at = end
    return kept + jpeg[at:]


def main(file, picture):
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.wm.fbx_import(filepath=file)
    armature = next(one for one in scene.objects if one.type == "ARMATURE")
    first, last = armature.animation_data.action.frame_range
    for number, moment in enumerate(MOMENTS):
        scene.frame_set(round(first + moment * (last - first)))
        graph = bpy.context.evaluated_depsgraph_get()
        copies = []
        for skin in [one for one in scene.objects if one.type == "MESH" and one.parent is armature]:
            still = bpy.data.objects.new("still", bpy.data.meshes.new_from_object(skin.evaluated_get(graph)))
            still.matrix_world = skin.evaluated_get(graph).matrix_world
            scene.collection.objects.link(still)
            copies.append(still)
        places = [still.matrix_world @ vertex.co for still in copies for vertex in still.data.vertices]
        middle = [(min(place[axis] for place in places) + max(place[axis] for place in places)) / 2 for axis in range(2)]
        for still in copies:
            still.location += Vector(((number - 1) * APART - middle[0], -middle[1], 0))
    for one in list(scene.objects):
        one.hide_render = one.name.split(".")[0] != "still"

    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.use_denoising = "CPU", SAMPLES, True
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    background, sky = tree.nodes.new("ShaderNodeBackground"), tree.nodes.new("ShaderNodeOutputWorld")
    background.inputs["Color"].default_value = WORLD
    tree.links.new(background.outputs["Background"], sky.inputs["Surface"])
    scene.view_settings.view_transform = "Standard"
    bpy.ops.mesh.primitive_plane_add(size=30)
    bpy.ops.object.light_add(type="SUN", rotation=(0.7, 0.2, 0.5))
    bpy.context.object.data.energy = 2
    aim = Vector((0, 0, 0.8))
    bpy.ops.object.camera_add(location=aim + Vector((0.4, -7.6, 1.1)))
    scene.camera = bpy.context.object
    scene.camera.rotation_euler = (aim - scene.camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.render.filepath = picture
    scene.render.image_settings.file_format = "JPEG"
    bpy.ops.render.render(write_still=True)
    path = Path(picture)
    path.write_bytes(without_comments(path.read_bytes()))


main(*sys.argv[1:])
