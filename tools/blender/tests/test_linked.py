"""Tests armatures of other files: linked data, links, overrides, and collections that an empty object instances."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest
import targets
from conftest import FIXTURES, Written, call, mocap, posed
from test_retarget import compare, exported

MOTION = FIXTURES / "real/cmu_short.bvh"


@pytest.fixture
def library(tmp_path: Path) -> tuple[Path, Written]:
    """A Blender file with a character in a collection, and the program's output for this character."""
    targets.read(FIXTURES / "characters/human_game_engine.glb").name = "Hero"
    mocap("retarget", MOTION, exported(tmp_path), "-o", tmp_path / "out.glb")
    collection = bpy.data.collections.new("Heroes")
    bpy.context.scene.collection.children.link(collection)
    for one in list(bpy.context.scene.objects):
        for other in list(one.users_collection):
            other.objects.unlink(one)
        collection.objects.link(one)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_homefile(use_empty=True)
    return tmp_path / "library.blend", Written(tmp_path / "out.glb")


def linked(file: Path) -> bpy.types.Collection:
    with bpy.data.libraries.load(str(file), link=True) as (_, into):
        into.collections = ["Heroes"]
    return into.collections[0]


def retargeted(written: Written) -> bpy.types.Object:
    call("retarget_files", filepath=str(MOTION), rate="SET")
    armature = bpy.context.object
    assert armature.type == "ARMATURE" and armature.library is None
    compare(armature, written, 120)
    return armature


def test_a_link_becomes_an_override(library: tuple[Path, Written]) -> None:
    file, written = library
    bpy.context.scene.collection.children.link(linked(file))
    targets.activate(bpy.data.objects["Hero"])
    armature = retargeted(written)
    assert armature.override_library is not None and not armature.override_library.is_system_override
    assert [one.name for one in bpy.context.scene.objects if one.type == "ARMATURE"] == ["Hero"]
    assert armature.override_library.reference.animation_data is None


def test_an_instance_of_a_collection_becomes_an_override(library: tuple[Path, Written]) -> None:
    file, written = library
    empty = bpy.data.objects.new("Heroes", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", linked(file)
    bpy.context.scene.collection.objects.link(empty)
    targets.activate(empty)
    armature = retargeted(written)
    assert armature.override_library is not None
    assert [one.name for one in bpy.context.scene.objects if one.type == "ARMATURE"] == ["Hero"]


def test_an_instance_that_stands_elsewhere_stays_there(library: tuple[Path, Written]) -> None:
    file, written = library
    empty = bpy.data.objects.new("Heroes", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", linked(file)
    empty.location = (1, 2, 3)
    bpy.context.scene.collection.objects.link(empty)
    targets.activate(empty)
    call("retarget_files", filepath=str(MOTION), rate="SET")
    found, expected = posed(bpy.context.object, 30)["head"], written.pose(29 / 120)["head"]
    assert found[:3, 3] - expected[:3, 3] == pytest.approx([1, 2, 3], abs=1e-4)


@pytest.mark.parametrize("is_full", [True, False])
def test_an_override_stays_one(library: tuple[Path, Written], is_full: bool) -> None:
    file, written = library
    collection = linked(file)
    bpy.context.scene.collection.children.link(collection)
    collection.override_hierarchy_create(bpy.context.scene, bpy.context.view_layer, do_fully_editable=is_full)
    (armature,) = [one for one in bpy.data.objects if one.type == "ARMATURE" and one.override_library]
    targets.activate(armature)
    count = len(bpy.data.objects)
    assert retargeted(written) == armature and len(bpy.data.objects) == count
    call("foot_lock")
    assert armature.animation_data.action.library is None


def test_an_object_with_linked_bones(library: tuple[Path, Written]) -> None:
    file, written = library
    collection = linked(file)
    bpy.context.scene.collection.children.link(collection)
    source = next(one for one in collection.objects if one.type == "ARMATURE")
    # A local object with the mesh; the armature data stays in its file.
    armature = source.copy()
    for thing in [one for one in collection.objects if one.type == "MESH"]:
        mesh = thing.copy()
        for modifier in mesh.modifiers:
            modifier.object = armature
        mesh.parent = armature
        bpy.context.scene.collection.objects.link(mesh)
    bpy.context.scene.collection.objects.link(armature)
    targets.activate(armature)
    assert armature.data.library is not None
    assert retargeted(written) == armature


def test_an_override_lasts_in_a_file(library: tuple[Path, Written], tmp_path: Path) -> None:
    file, written = library
    bpy.context.scene.collection.children.link(linked(file))
    targets.activate(bpy.data.objects["Hero"])
    name = retargeted(written).name
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "shot.blend"))
    (armature,) = [one for one in bpy.data.objects if one.name == name and one.library is None]
    compare(armature, written, 120)
