"""Tests scenes that move between processes, faces, bones, and the output of notebooks."""

from __future__ import annotations

import html
import inspect
import pickle
import re
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from conftest import REAL, REPOSITORY

import mocap

MADE = REPOSITORY / "fixtures" / "made"
SKELETONS = REPOSITORY / "fixtures" / "skeletons"


@pytest.mark.parametrize("file", ["cmu_12_01_walk.bvh", "nan_tokens.bvh", "animation_with_skeleton.fbx", "additive_root_walk.bvh"])
def test_a_scene_is_pickled_bit_by_bit(file: str) -> None:
    scene = mocap.read(REAL / file)
    back = pickle.loads(pickle.dumps(scene))
    assert repr(back) == repr(scene) and back.metadata == scene.metadata and back.warnings == scene.warnings
    found, expected = back.to_numpy(), scene.to_numpy()
    assert found.positions.tobytes() == expected.positions.tobytes()
    assert found.rotations.tobytes() == expected.rotations.tobytes()
    assert back.frame_rate == scene.frame_rate
    # The results from the copy are equal, too.
    assert mocap.edit.mirror(back).report == mocap.edit.mirror(scene).report if scene.bones else True


def test_a_pickled_scene_keeps_what_a_laboratory_recorded() -> None:
    files = [path for path in (REPOSITORY / "fixtures").rglob("*.c3d") if "broken" not in str(path)]
    recorded = [scene for scene in map(mocap.read, files) if scene.recorded and scene.recorded["channels"]]
    assert recorded
    for scene in recorded[:2]:
        back = pickle.loads(pickle.dumps(scene))
        assert back.recorded == scene.recorded
        for name, values in scene.analog().items():
            assert back.analog()[name].tobytes() == values.tobytes()


def height(scene: mocap.Scene) -> float:
    return float(np.ptp(scene.to_numpy().positions[0], axis=0).max())


def test_another_process_takes_a_scene(walk: Path) -> None:
    scene = mocap.read(walk)
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert pool.submit(height, scene).result() == height(scene)


def test_what_is_no_pickled_scene_is_refused(walk: Path) -> None:
    function, (state,) = mocap.read(walk).__reduce__()
    for broken in (b"", b"no scene", state[:-1], state[: len(state) // 2]):
        with pytest.raises(mocap.OptionError, match="the bytes are not a pickled scene of this version"):
            function(broken)


def test_nodes_say_what_they_are_on_a_face() -> None:
    faces = {node.face for node in mocap.read(MADE / "face.vrma").nodes}
    assert {"blink", "lookAt", None} <= faces
    assert {node.face for node in mocap.read(REAL / "cmu_short.bvh").nodes} == {None}
    bones = {node.humanoid_bone: node.name for node in mocap.read(MADE / "face.vrma").nodes}
    assert "hips" in bones and "head" in bones


def test_bones_and_their_corrections(walk: Path) -> None:
    scene = mocap.read(walk)
    bones = scene.bones
    assert (bones["hips"], bones["leftUpperLeg"], bones["rightHand"]) == ("Hips", "LeftUpLeg", "RightHand")
    figure = scene.figure({"head": "Neck1"})
    index = figure["humanoid"]["bones"]["head"]["joint"]
    assert scene.nodes[index].name == "Neck1" and figure["survey"]["unit"]["value"] == "cmu"
    with pytest.raises(mocap.MocapError, match="nobody"):
        scene.figure({"head": "nobody"})


def test_bones_that_are_given_are_those_that_move(walk: Path, tmp_path: Path) -> None:
    walked, hero = mocap.read(walk), mocap.read(SKELETONS / "human_default.gltf")
    plain, _ = mocap.retarget(walked, hero)
    crossed, _ = mocap.retarget(walked, hero, bones={"leftUpperArm": "RightArm", "rightUpperArm": "LeftArm"})
    assert np.abs(plain.to_numpy().positions - crossed.to_numpy().positions).max() > 0.05
    headless, reports = mocap.retarget(walked, hero, target_bones={"head": None})
    assert "head" not in {bone["bone"] for bone in reports[0]["bones"]} if "bones" in reports[0] else True
    with pytest.raises(mocap.MocapError, match="nobody"):
        mocap.retarget(walked, hero, target_bones={"head": "nobody"})
    with pytest.raises(mocap.MocapError, match="nobody"):
        mocap.convert(walk, tmp_path / "walk.glb", bones={"head": "nobody"})
    assert not (tmp_path / "walk.glb").exists()


def test_a_page_has_the_player_and_nothing_from_elsewhere(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    scene.show(tmp_path / "walk.html")
    page = (tmp_path / "walk.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>") and "cmu_12_01_walk" in page
    assert not re.search(r"""(?:src|href)=["']?https?:""", page)
    shown = scene._repr_html_()
    (frame,) = re.findall(r'srcdoc="([^"]*)"', shown)
    assert html.unescape(frame) == scene.to_html() and "allow-same-origin" not in shown


def test_a_long_motion_does_not_fill_a_notebook(walk: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mocap._scene._LARGEST_CELL", 1000)
    shown = mocap.read(walk)._repr_html_()
    assert "scene.show()" in shown and len(shown) < 300


def test_pictures(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    curves = scene.plot("LeftFoot", "RightFoot", width=640)
    assert "LeftFoot" in curves.svg and curves._repr_svg_() == curves.svg
    assert curves.png.startswith(b"\x89PNG")
    width = int.from_bytes(curves.png[16:20], "big")
    assert width == 640
    scene.sheet(poses=3).save(tmp_path / "sheet.png")
    assert (tmp_path / "sheet.png").read_bytes().startswith(b"\x89PNG")
    assert scene.plot("leftFoot").svg == scene.plot("LeftFoot").svg
    with pytest.raises(mocap.OptionError, match="no node or bone is called \"LeftFot\""):
        scene.plot("LeftFot")
    with pytest.raises(mocap.OptionError, match="must end in .svg or .png"):
        curves.save(tmp_path / "a.jpg")


def test_a_chain_multiplies_to_its_joint(lecture: Path) -> None:
    scene = mocap.read(lecture)
    told = scene.chain("Wrist", 9, point=[0.5, 0, 0])
    assert [part["symbol"] for part in told["chain"]] == ["J0", "L1", "J1", "L2", "J2"]
    product = np.eye(4)
    for part in told["chain"]:
        product = product @ np.array(part["matrix"])
        np.testing.assert_allclose(part["product"], product, atol=1e-5)
    np.testing.assert_allclose(product, scene.pose(9)[2], atol=1e-5)
    np.testing.assert_allclose(told["point_in_world"], product @ [0.5, 0, 0, 1] @ np.eye(4, 3), atol=1e-5)
    assert [part["degrees"][0] for part in told["chain"] if "degrees" in part] == pytest.approx([50, 100, 80], abs=1e-4)
    assert "point_in_world" not in scene.chain("Wrist")
    with pytest.raises(mocap.MocapError, match="no joint is called \"Wirst\""):
        scene.chain("Wirst")


def test_all_errors_are_of_one_family(walk: Path, tmp_path: Path) -> None:
    scene = mocap.read(walk)
    for action in [
        lambda: scene.pose(0, space="moon"),
        lambda: scene.chain("Hips", point=[0, 1]),
        lambda: scene.chain("Nose"),
        lambda: scene.to_numpy(rot="7d"),
        lambda: scene.to_numpy(unit="furlong"),
        lambda: scene.to_numpy(fsp=30),
        lambda: mocap.read(walk, root_offset="twice"),
        lambda: mocap.read(walk, lengths="long"),
        lambda: mocap.convert(walk, tmp_path / "walk.xyz"),
        lambda: mocap.convert(walk, tmp_path / "walk.glb", rest="x-pose"),
        lambda: mocap.retarget(scene, scene, scale="large"),
        lambda: mocap.survey(),
        lambda: mocap.run({"write": {"outptu": "a.glb"}}),
        lambda: mocap.run({"steps": [object()]}),
        lambda: mocap.edit.warp_time(scene),
        lambda: mocap.edit.smooth(scene, cut_off=object()),
        lambda: mocap.edit.apply(scene, "dance"),
        lambda: mocap.edit.smooth(scene, cut_off=float("nan")),
        lambda: scene.figure({"nose": "Head"}),
        lambda: scene.plot("Hips", width=0),
        lambda: scene.show(tmp_path),
        lambda: scene.sheet().save(tmp_path / "no" / "sheet.png"),
        lambda: mocap.PackedClip.open(tmp_path / "no.mclip"),
        lambda: mocap.from_arrays(positions=np.zeros((2, 3))),
        lambda: mocap.PackedClip(b"nothing"),
        lambda: mocap.PackedClip.of(scene, max_error=-1),
        lambda: mocap.ik.two_bone([[0, 0, 0]] * 2, [0, 0, 0]),
        lambda: mocap.examine([("a.bvh", b"")], threshold={"skate": float("nan")}),
    ]:
        with pytest.raises(mocap.MocapError) as caught:
            action()
        assert isinstance(caught.value, ValueError) and str(caught.value) and caught.value.code
        assert type(pickle.loads(pickle.dumps(caught.value))) is type(caught.value)


def test_everything_public_says_what_it_is() -> None:
    for module in (mocap, mocap.edit, mocap.ik):
        for name in module.__all__:
            value = getattr(module, name)
            assert (value.__doc__ or "").strip(), name
            if not isinstance(value, type) or issubclass(value, tuple):
                continue
            for member, what in vars(value).items():
                if not member.startswith("_") and (callable(what) or inspect.isdatadescriptor(what)):
                    assert (getattr(what, "__doc__", None) or "").strip(), f"{name}.{member}"
