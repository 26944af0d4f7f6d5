"""Tests files with meshes, and their skeletons without meshes."""

from __future__ import annotations

import json
import struct
from pathlib import Path

import mocap
import mocap.edit

CHARACTER = Path(__file__).resolve().parents[3] / "fixtures" / "characters" / "human_default.glb"


def meshes(path: Path) -> list[str]:
    """The names of the meshes of a .glb, read without the package."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    return [mesh["name"] for mesh in json.loads(data[20 : 20 + length]).get("meshes", [])]


def test_a_skeleton_is_written_alone(tmp_path: Path) -> None:
    mocap.convert(CHARACTER, tmp_path / "whole.glb")
    mocap.convert(CHARACTER, tmp_path / "alone.glb", skeleton_only=True)
    assert "SkeletonMesh" not in meshes(tmp_path / "whole.glb")
    # As in the program, the mesh that shows the skeleton is no mesh of the file.
    assert meshes(tmp_path / "alone.glb") == ["SkeletonMesh"]
    scene = mocap.edit.prepare(mocap.read(CHARACTER))
    mocap.edit.write(scene, tmp_path / "written.glb", skeleton_only=True)
    assert meshes(tmp_path / "written.glb") == []
