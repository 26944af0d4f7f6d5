"""mocap in Blender: imports motion files as armatures with actions, retargets, cleans, locks feet, and makes loops."""

from __future__ import annotations

import bpy

from . import operators, panel

_CLASSES = (*operators.CLASSES, *panel.CLASSES)


def register() -> None:
    for one in _CLASSES:
        bpy.utils.register_class(one)
    bpy.types.TOPBAR_MT_file_import.append(panel.menu)


def unregister() -> None:
    bpy.types.TOPBAR_MT_file_import.remove(panel.menu)
    for one in reversed(_CLASSES):
        bpy.utils.unregister_class(one)
