"""The package does not replace a file that may be a source unless asked, and writes no file without a known
extension."""

from __future__ import annotations

from pathlib import Path

import mocap
import pytest
from mocap import edit


def writers(walk: Path) -> dict[str, object]:
    scene = mocap.read(walk)
    return {
        "convert": lambda target, **options: mocap.convert(walk, target, **options),
        "edit.write": lambda target, **options: edit.write(scene, target, **options),
    }


@pytest.mark.parametrize("name", ["convert", "edit.write"])
def test_a_file_that_may_be_a_source_is_replaced_by_overwrite_alone(name: str, walk: Path, tmp_path: Path) -> None:
    write = writers(walk)[name]
    for extension in ("bvh", "glb", "fbx", "mclip"):
        target = tmp_path / f"{name}.{extension}"
        target.write_bytes(b"somebody's work")
        with pytest.raises(mocap.MocapError) as caught:
            write(target)  # type: ignore[operator]
        assert caught.value.code == "output-exists"
        assert target.read_bytes() == b"somebody's work"
        write(target, overwrite=True)  # type: ignore[operator]
        assert target.read_bytes() != b"somebody's work"


@pytest.mark.parametrize("name", ["convert", "edit.write"])
def test_an_output_is_replaced_unless_it_has_changed(name: str, walk: Path, tmp_path: Path) -> None:
    write, other = writers(walk)[name], walk.parent / "cmu_short.bvh"
    for extension in ("bvh", "trc", "vmd", "mclip", "glb", "fbx"):
        target = tmp_path / f"{name}.{extension}"
        write(target)  # type: ignore[operator]
        made, written = target.read_bytes(), target.stat().st_mtime_ns
        # Without a mark of mocap, the file is no output of another motion.
        if extension not in ("glb", "fbx"):
            with pytest.raises(mocap.MocapError, match="did not write from these inputs"):
                writers(other)["edit.write"](target)  # type: ignore[operator]
        write(target)  # type: ignore[operator]
        assert target.read_bytes() == made and target.stat().st_mtime_ns > written
        target.write_bytes(made + b"\n")
        with pytest.raises(mocap.MocapError, match="has changed since mocap wrote it") as caught:
            write(target)  # type: ignore[operator]
        assert caught.value.code == "output-exists"
        assert target.read_bytes() == made + b"\n"


@pytest.mark.parametrize("name", ["convert", "edit.write"])
def test_an_unknown_suffix_is_an_error(name: str, walk: Path, tmp_path: Path) -> None:
    write = writers(walk)[name]
    for target in (tmp_path / "walk.xyz", tmp_path / "walk"):
        with pytest.raises(ValueError, match="must end in"):
            write(target)  # type: ignore[operator]
        assert not target.exists()


def test_an_input_is_never_replaced(walk: Path, tmp_path: Path) -> None:
    own = tmp_path / "walk.bvh"
    own.write_bytes(walk.read_bytes())
    with pytest.raises(mocap.MocapError) as caught:
        mocap.convert(own, own, overwrite=True)
    assert caught.value.code == "output-is-input"
    assert own.read_bytes() == walk.read_bytes()
