"""Armatures linked from other files. A linked armature gets a library override, so that its action and pose can be
set."""

from __future__ import annotations

import bpy
from mathutils import Matrix

from .rig import ArmatureError


def armature_of(thing: bpy.types.Object | None) -> bpy.types.Object | None:
    """The armature of an object: the object itself, or the only armature in its instanced collection."""
    if thing is None or thing.type == "ARMATURE":
        return thing
    if thing.type != "EMPTY" or thing.instance_collection is None:
        return None
    found = [one for one in thing.instance_collection.all_objects if one.type == "ARMATURE"]
    return found[0] if len(found) == 1 else None


def editable(context: bpy.types.Context, armature: bpy.types.Object) -> bpy.types.Object:
    """The armature itself if it is editable, or else a library override that replaces the link.

    Raises:
        ArmatureError: Where Blender makes no override.
    """
    if armature.library is None:
        override = armature.override_library
        if override is not None and override.is_system_override:
            override.is_system_override = False
        return armature
    # Blender asks the user for the collection of a linked object. The topmost collection contains all related objects.
    linked = [
        one for one in context.scene.collection.children_recursive if one.library and armature in set(one.all_objects)
    ]
    options = {"collection": linked[0].session_uid} if linked and context.active_object == armature else {}
    active, before = context.active_object, set(bpy.data.objects)
    is_instance = active != armature
    if is_instance:
        offset = Matrix.Translation(active.instance_collection.instance_offset)
        place = active.matrix_world @ offset.inverted()
    try:
        bpy.ops.object.make_override_library(**options)
    except RuntimeError as failure:
        raise ArmatureError(f"the armature {armature.name!r} is linked, and cannot be overridden: {failure}") from None
    made = {one for one in set(bpy.data.objects) - before if one.override_library}
    found = [one for one in made if one.override_library.reference == armature]
    if not found:
        raise ArmatureError(f"the armature {armature.name!r} is linked, and Blender makes no library override of it")
    for one in made if is_instance else found:
        one.override_library.is_system_override = False
    # Blender places instanced objects at their positions in their own file.
    for one in made if is_instance else ():
        if one.parent not in made:
            one.matrix_world = place @ one.matrix_world
    found[0].select_set(True)
    context.view_layer.objects.active = found[0]
    return found[0]
