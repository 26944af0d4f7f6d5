"""The panel in the sidebar of the 3D viewport, the menu entry, and the handler of dropped files."""

from __future__ import annotations

import bpy

from . import operators, overrides, report

_EXTENSIONS = ";".join(f".{one}" for one in operators.EXTENSIONS)


class MOCAP_PT_panel(bpy.types.Panel):
    bl_label = "Mocap"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Mocap"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator(operators.ImportMotion.bl_idname, icon="IMPORT")
        column = layout.column(align=True)
        column.operator(operators.RetargetFiles.bl_idname, icon="ARMATURE_DATA")
        column.operator(operators.RetargetSelected.bl_idname, icon="CON_ARMATURE")
        column = layout.column(align=True)
        for operator in (operators.Clean, operators.FootLock, operators.Loop):
            column.operator(operator.bl_idname)


class MOCAP_PT_report(bpy.types.Panel):
    bl_label = "Report"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Mocap"
    bl_parent_id = "MOCAP_PT_panel"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        armature = overrides.armature_of(context.active_object)
        return armature is not None and bool(report.kept(armature))

    def draw(self, context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        for line in report.kept(overrides.armature_of(context.active_object)):
            column.label(text=line)


class MOCAP_FH_import(bpy.types.FileHandler):
    bl_idname = "MOCAP_FH_import"
    bl_label = "Motion (mocap)"
    bl_import_operator = operators.ImportMotion.bl_idname
    bl_file_extensions = _EXTENSIONS

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type in ("VIEW_3D", "OUTLINER")


class MOCAP_FH_retarget(bpy.types.FileHandler):
    bl_idname = "MOCAP_FH_retarget"
    bl_label = "Retarget to Active Armature (mocap)"
    bl_import_operator = operators.RetargetFiles.bl_idname
    bl_file_extensions = _EXTENSIONS

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        is_viewport = context.area is not None and context.area.type == "VIEW_3D"
        return is_viewport and overrides.armature_of(context.active_object) is not None


def menu(self: bpy.types.Menu, context: bpy.types.Context) -> None:
    """The entry of the menu File, Import."""
    self.layout.operator(operators.ImportMotion.bl_idname, text="Motion (mocap)")


CLASSES = (MOCAP_PT_panel, MOCAP_PT_report, MOCAP_FH_import, MOCAP_FH_retarget)
