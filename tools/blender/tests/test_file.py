"""Tests the file of the extension: its manifest as Blender checks it, its licences, and its version."""

from __future__ import annotations

import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import bpy
from conftest import ROOT

FILE = Path(os.environ["MOCAP_EXTENSION"])


def test_blender_finds_the_file_valid() -> None:
    checker = Path(bpy.utils.resource_path("LOCAL")) / "scripts/addons_core/bl_pkg/cli/blender_ext.py"
    done = subprocess.run([sys.executable, checker, "validate", FILE], capture_output=True, text=True)
    assert done.returncode == 0 and "Success" in done.stdout, done.stdout + done.stderr


def test_the_licences_of_all_parts_are_in_it() -> None:
    names = set(zipfile.ZipFile(FILE).namelist())
    assert {"LICENSE-MIT", "LICENSE-APACHE", "THIRD-PARTY.md", "blender_manifest.toml", "__init__.py"} <= names
    assert not [name for name in names if "__pycache__" in name or name.startswith(("/", ".."))]
    third = zipfile.ZipFile(FILE).read("THIRD-PARTY.md").decode()
    assert all(f"| {crate} " in third for crate in ("glam", "pyo3", "numpy", "arrow-array"))


def test_it_has_the_version_of_the_workspace() -> None:
    with zipfile.ZipFile(FILE) as file:
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
        assert sorted(manifest["wheels"]) == sorted(f"./{name}" for name in file.namelist() if name.endswith(".whl"))
    workspace = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]
    assert manifest["version"] == workspace["version"]
    assert manifest["blender_version_min"] == "4.2.0"


def test_the_wheel_is_the_module_that_runs() -> None:
    import mocap

    assert Path(mocap.__file__).is_relative_to(bpy.utils.user_resource("EXTENSIONS"))


def test_panel_menu_and_dropped_files_are_known_to_blender() -> None:
    assert bpy.types.Panel.bl_rna_get_subclass_py("MOCAP_PT_panel") is not None
    assert bpy.types.Panel.bl_rna_get_subclass_py("MOCAP_PT_report") is not None
    for name, operator in (("MOCAP_FH_import", "import_motion"), ("MOCAP_FH_retarget", "retarget_files")):
        handler = bpy.types.FileHandler.bl_rna_get_subclass_py(name)
        assert handler.bl_import_operator == f"mocap.{operator}"
        assert {".bvh", ".fbx", ".glb", ".c3d", ".npz", ".vrma", ".usda"} <= set(handler.bl_file_extensions.split(";"))


def test_it_can_be_turned_off_and_on() -> None:
    bpy.ops.preferences.addon_disable(module="bl_ext.user_default.mocap")
    assert not hasattr(bpy.types, "MOCAP_PT_panel")
    bpy.ops.preferences.addon_enable(module="bl_ext.user_default.mocap")
    assert bpy.types.Panel.bl_rna_get_subclass_py("MOCAP_PT_panel") is not None
