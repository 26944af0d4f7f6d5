"""Compares the steps of `mocap edit` with the program and with their descriptions."""

from __future__ import annotations

import inspect
import json
import pickle
import re
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import REAL

import mocap
from mocap import edit


@pytest.fixture
def clip(walk: Path) -> mocap.Scene:
    return edit.prepare(mocap.read(walk))


def positions(scene: mocap.Scene) -> Any:
    return scene.to_numpy(unit="m", up="y").positions


def test_the_program_does_the_same(program: Path, walk: Path, clip: mocap.Scene, tmp_path: Path) -> None:
    other, _ = edit.mirror(clip)
    edit.write(other, tmp_path / "other.glb")
    scene, reports = clip, []
    for function, options in [
        (edit.foot_lock, {"speed": 0.3}),
        (edit.smooth, {"cut_off": 8, "filter": "gaussian"}),
        (edit.despike, {"threshold": 5, "longest": 2}),
        (edit.loop_clip, {"frames": (20, 200), "in_place": True}),
        (edit.warp_time, {"moments": [(0, 0), (0.5, 1.0)]}),
        (edit.warp_path, {"points": [(0, 0, 0), (1, -1, 2)], "facing": "kept"}),
        (edit.in_between, {"every": 10, "keys": [5, 7], "interpolation": "slerp"}),
        (edit.fill, {"longest": 0.2}),
        (edit.mirror, {}),
        (edit.reach, {"to": (0.3, 1.2, 0.5), "limb": "left-hand", "range": "0.2..0.4", "ease_in": 0.1}),
        (edit.pin, {"to": "hips", "limb": "right-hand", "range": "0.5..0.7"}),
        (edit.look_at, {"at": (1, 1.5, 9), "neck": 0.5}),
        (edit.turn, {"by": 90}),
        (edit.clean, {"contacts": False}),
        (edit.ground, {}),
    ]:
        scene, report = function(scene, **options)
        reports.append(report)
    edit.write(scene, tmp_path / "here.glb")
    steps = [
        "foot-lock:speed=0.3",
        "smooth:cut-off=8,filter=gaussian",
        "despike:threshold=5,longest=2",
        "loop:frames=20..200,in-place=true",
        "warp:0=0,0.5=1",
        "warp:path=0:0/0+1:-1/2,facing=kept",
        "in-between:every=10,keys=5+7,interpolation=slerp",
        "fill:longest=0.2",
        "mirror",
        "reach:to=0.3/1.2/0.5,limb=left-hand,range=0.2..0.4,ease-in=0.1",
        "pin:to=hips,limb=right-hand,range=0.5..0.7",
        "look-at:at=1/1.5/9,neck=0.5",
        "turn:by=90",
        "clean:contacts=false",
        "ground",
    ]
    command = [program, "edit", walk, "-o", tmp_path / "there.glb", "--json"]
    command += [word for step in steps for word in ("--step", step)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    assert [report["changed"] for report in json.loads(done.stdout)] == reports
    here, there = (mocap.read(tmp_path / name) for name in ("here.glb", "there.glb"))
    np.testing.assert_allclose(positions(here), positions(there), atol=1e-6)
    subprocess.run([program, "verify", walk, tmp_path / "here.glb", "--max-error", "0.01mm"], check=True)


STEPS: list[str] = json.loads((REAL.parents[1] / "tests" / "steps.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("step", STEPS)
def test_a_step_does_the_same_in_a_job(step: str, tmp_path: Path) -> None:
    takes_other = step.split(":")[0] in ("concat", "blend", "layer")
    files = [REAL / "cmu_short.bvh", *[REAL / "cmu_12_01_walk.bvh"][: int(takes_other)]]
    first, *others = (edit.prepare(mocap.read(file)) for file in files)
    changed = edit.apply(first, step, *others)
    edit.write(changed.scene, tmp_path / "here.glb")
    motion, *others_of_job = map(str, files)
    source = {"inputs": [motion], "with": others_of_job, "frames": {"drop-first-frame": "auto"}}
    report = mocap.run({"source": source, "steps": [step], "write": {"output": str(tmp_path / "job.glb")}})
    assert [done["changed"] for done in report["steps"]] == [changed.report]
    here, there = (mocap.read(tmp_path / name) for name in ("here.glb", "job.glb"))
    np.testing.assert_allclose(positions(here), positions(there), atol=1e-6)


def test_every_step_has_a_function(program: Path) -> None:
    text = subprocess.run([program, "edit", "--help"], check=True, capture_output=True, text=True).stdout
    names = re.findall(r"^  ([a-z][a-z-]*) {2,}\S", text.split("Steps (")[1], re.MULTILINE)
    assert len(names) >= 17
    functions = {"loop": ["loop_clip"], "warp": ["warp_time", "warp_path"]}
    for name in names:
        for function in functions.get(name, [name.replace("-", "_")]):
            assert inspect.isfunction(getattr(edit, function)) and function in edit.__all__


def test_a_scene_stays_and_a_mirror_image_of_a_mirror_image_is_the_motion(clip: mocap.Scene) -> None:
    before = positions(clip)
    once, report = edit.mirror(clip)
    assert report["pairs"] >= 10 and np.abs(positions(once) - before).max() > 0.1
    twice, _ = edit.mirror(once)
    np.testing.assert_allclose(positions(twice), before, atol=2e-6)
    np.testing.assert_array_equal(positions(clip), before)
    assert [step["edit"] for step in twice.metadata["steps"] if step["step"] == "edit"] == [{"step": "mirror"}] * 2


def test_two_motions(clip: mocap.Scene) -> None:
    other, _ = edit.mirror(clip)
    for weight, expected in ((0, clip), (1, other), ([(0, 1.0), (9, 1.0)], other)):
        mixed, _ = edit.blend(clip, other, weight)
        np.testing.assert_allclose(positions(mixed), positions(expected), atol=1e-5)
    joined, report = edit.concat(clip, clip, blend=0.2)
    assert joined.frames == report["frames"] == 2 * clip.frames - 1
    arms, report = edit.layer(clip, other, "arms")
    assert report["joints"] > 4 and arms.frames == clip.frames
    with pytest.raises(mocap.MocapError, match="the step concat uses the motion number 2, but the number of motions is 1"):
        edit.apply(clip, "concat")
    same = {"step": "smooth", "cut_off": np.float32(8)}
    assert edit.apply(clip, same).report == edit.apply(clip, "smooth:cut-off=8").report
    with pytest.raises(mocap.MocapError, match="has no key \"cutoff\".*did you mean cut_off") as caught:
        edit.apply(clip, {"step": "smooth", "cutoff": 8})
    assert caught.value.code == "unknown-option"
    with pytest.raises(mocap.MocapError, match="no joint is called \"Tail\""):
        edit.apply(clip, "mirror", bones={"hips": "Tail"})


def test_contacts_and_refusals(clip: mocap.Scene, tmp_path: Path) -> None:
    found = edit.contacts(clip, hands=True, height=0.04)
    assert [point["bone"] for point in found["points"]] == [
        "leftFoot",
        "rightFoot",
        "leftToes",
        "rightToes",
        "leftHand",
        "rightHand",
    ]
    assert all(len(point["at_rest"]) == clip.frames for point in found["points"])
    for refused, code in [
        (lambda: edit.smooth(clip, cut_off=0), "invalid-value"),
        (lambda: edit.blend(clip, clip, 1.5), "invalid-value"),
        (lambda: edit.mirror(mocap.read(REAL / "lecture_Test.bvh")), "not-humanoid"),
    ]:
        with pytest.raises(mocap.MocapError) as caught:
            refused()
        assert caught.value.code == code
    with pytest.raises(TypeError, match="either moments or a speed"):
        edit.warp_time(clip)
    with pytest.raises(ValueError, match="must end in .bvh, .vrma, .glb, .gltf, .trc, .fbx, .usda, .usdz, .mclip or .vmd"):
        edit.write(clip, tmp_path / "walk.obj")
    edit.write(clip, tmp_path / "walk.bvh")
    assert mocap.read(tmp_path / "walk.bvh").frames == clip.frames
    edit.write(clip, tmp_path / "walk.fbx")
    assert mocap.read(tmp_path / "walk.fbx").frames == clip.frames


def test_steps_are_objects(clip: mocap.Scene, walk: Path, tmp_path: Path) -> None:
    smooth, lock = edit.smooth.step(cut_off=8), edit.foot_lock.step()
    assert smooth == edit.Step("smooth", {"cut_off": 8}) != lock
    assert pickle.loads(pickle.dumps(smooth)) == smooth
    other, _ = edit.mirror(clip)
    joined = edit.concat.step(other, blend=0.1)
    one, reports = edit.apply_all(clip, [smooth, lock, joined, "reverse"])
    by_hand = clip
    for step in (smooth, lock, joined):
        by_hand, _ = step(by_hand)
    by_hand, last = edit.reverse(by_hand)
    np.testing.assert_array_equal(positions(one), positions(by_hand))
    assert len(reports) == 4 and reports[3] == last
    again, _ = edit.apply_all(clip, [smooth, lock, "concat:blend=0.1", "reverse"], [other])
    np.testing.assert_array_equal(positions(again), positions(one))
    job = {"source": {"inputs": [walk]}, "steps": [smooth, "mirror"], "write": {"output": tmp_path / "smooth.bvh"}}
    assert len(mocap.run(job)["steps"]) == 2
    with pytest.raises(mocap.OptionError, match="source.with"):
        mocap.run({**job, "steps": [joined]})
    with pytest.raises(mocap.UnknownOptionError, match="the step smooth has its own bones"):
        edit.apply_all(clip, [edit.smooth.step(bones={"head": "Neck"})])


def test_functions_of_steps_show_what_they_take() -> None:
    assert list(inspect.signature(edit.fill).parameters) == ["scene", "longest", "shortest"]
    assert list(inspect.signature(edit.fill.step).parameters) == ["longest", "shortest"]
    assert list(inspect.signature(edit.reach).parameters)[:3] == ["scene", "to", "limb"]
    with pytest.raises(TypeError, match="there is no option 'cut_of'; did you mean 'cut_off'"):
        edit.smooth(None, cut_of=8)
