"""Tests windows of motions for training in NumPy, and as tensors if PyTorch is installed."""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from conftest import REAL

import mocap
from mocap.torch import Statistics, Windows

WALK, SHORT = REAL / "cmu_12_01_walk.bvh", REAL / "cmu_short.bvh"


def moving(name: str, frames: int, step: float = 0.0, joints: tuple[str, ...] = ("root", "tip")) -> mocap.Scene:
    """A motion whose root is at (frame, step, 0)."""
    at = np.zeros((frames, len(joints), 3))
    at[:, :, 0] = np.arange(frames)[:, None]
    at[:, :, 1] = step
    at[:, 1:, 1] += 1
    turns = np.broadcast_to(np.array([0.0, 0, 0, 1]), (frames, len(joints), 4))
    parents = [-1, *range(len(joints) - 1)]
    return mocap.from_arrays(positions=at, rotations=turns, names=joints, parents=parents, frame_rate=30)


def firsts(windows: Windows) -> list[tuple[int, int, int]]:
    """The clip, the first frame and the number of true frames of each window."""
    made = [windows.arrays(index) for index in range(len(windows))]
    return [(window["clip"], window["first"], int(window["mask"].sum())) for window in made]


def test_windows_lie_where_they_should() -> None:
    clips = [moving("a", 10), moving("b", 3)]
    options = dict(features=("positions",), options=mocap.Options(), normalize=False)
    assert firsts(Windows(clips, 4, **options)) == [(0, 0, 4), (0, 4, 4), (0, 8, 2), (1, 0, 3)]
    assert firsts(Windows(clips, 4, padding="drop", **options)) == [(0, 0, 4), (0, 4, 4)]
    # Every frame is in a window, and no window follows the first window that reaches the end.
    assert firsts(Windows(clips, 4, stride=3, **options)) == [(0, 0, 4), (0, 3, 4), (0, 6, 4), (1, 0, 3)]
    assert firsts(Windows(clips, 4, stride=3, padding="drop", **options)) == [(0, 0, 4), (0, 3, 4), (0, 6, 4)]
    edge, zero = (Windows(clips, 4, padding=padding, **options).arrays(2) for padding in ("edge", "zero"))
    assert edge["features"][:, 0].tolist() == [8, 9, 9, 9] and zero["features"][:, 0].tolist() == [8, 9, 0, 0]
    assert edge["mask"].tolist() == zero["mask"].tolist() == [True, True, False, False]
    last = Windows(clips, 4, **options)
    np.testing.assert_array_equal(last.arrays(-1)["features"], last.arrays(3)["features"])
    with pytest.raises(IndexError, match="there is no window 4: there are 4"):
        last.arrays(4)


def test_columns_are_the_arrays_of_the_scene() -> None:
    features = ("rotations", "velocities", "contacts")
    options = mocap.Options(rot="6d", fps=30, out_unit="m")
    windows = Windows([WALK, SHORT], 16, features=features, options=options, normalize=False)
    motion = mocap.read(WALK).to_numpy(options, velocities=True, contacts=True)
    assert windows.names == [str(WALK), str(SHORT)] and windows.joints == motion.names
    window = windows.arrays(2)
    assert window["features"].dtype == np.float32 and window["clip"] == 0 and window["first"] == 32
    for name in features:
        found = window["features"][:, windows.columns[name]]
        np.testing.assert_array_equal(found, np.asarray(getattr(motion, name), np.float32)[32:48].reshape(16, -1))


def test_statistics_are_those_of_all_frames_once(tmp_path: Path) -> None:
    features = ("positions", "contacts")
    windows = Windows([WALK, SHORT], 32, stride=5, features=features, options=mocap.Options(fps=30))
    wanted = [mocap.read(path).to_numpy(fps=30).positions.reshape(-1, 38 * 3) for path in (WALK, SHORT)]
    # The statistics come from frames, not from windows, which overlap and are padded.
    frames = np.concatenate(wanted).astype(np.float64)
    positions = windows.columns["positions"]
    np.testing.assert_allclose(windows.statistics.mean[positions], frames.mean(axis=0), rtol=1e-5, atol=1e-5)
    deviation = frames.std(axis=0)
    varies = deviation > 1e-3
    np.testing.assert_allclose(windows.statistics.std[positions][varies], deviation[varies], rtol=1e-4)
    assert windows.statistics.frames == len(frames)
    window = windows.arrays(3)["features"]
    np.testing.assert_allclose(windows.restored(window)[:, positions], frames[15:47], atol=2e-3)
    assert set(np.unique(window[:, windows.columns["contacts"]])) <= {0.0, 1.0}
    assert np.isfinite(window).all()
    # A cache file is written once, and later only read.
    kept = tmp_path / "statistics.npz"
    first = Windows(WALK, 32, statistics=kept)
    stamp = kept.stat().st_mtime_ns
    second = Windows(SHORT, 32, statistics=kept)
    assert kept.stat().st_mtime_ns == stamp
    for other in (second.statistics, Windows(SHORT, 32, statistics=first.statistics).statistics, Statistics.read(kept)):
        np.testing.assert_array_equal(other.mean, first.statistics.mean)
    with pytest.raises(mocap.OptionError, match="statistics have 342 columns, but the features of these motions have 114"):
        Windows(SHORT, 32, features=["positions"], statistics=kept)
    (tmp_path / "none.npz").write_bytes(b"nothing")
    with pytest.raises(mocap.OptionError, match="has no statistics"):
        Windows(SHORT, 32, statistics=tmp_path / "none.npz")


def test_a_seed_shifts_windows_as_it_says() -> None:
    clips = [moving("a", 101)]
    windows = Windows(clips, 8, stride=8, seed=3, normalize=False)
    before = firsts(windows)
    assert before == firsts(windows) == firsts(Windows(clips, 8, stride=8, seed=3, normalize=False))
    assert before != firsts(Windows(clips, 8, stride=8, seed=4, normalize=False))
    windows.set_epoch(1)
    assert firsts(windows) != before
    for number, (_, first, count) in enumerate(firsts(windows)[:-2]):
        assert 8 * number <= first < 8 * number + 8 and count == 8
    windows.set_epoch(0)
    assert firsts(windows) == before


def test_a_cache_reads_a_file_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file, cache = tmp_path / "walk.bvh", tmp_path / "cache"
    file.write_bytes(SHORT.read_bytes())
    plain = Windows(file, 16)
    read: list[str] = []

    def counting(path: str) -> mocap.Scene:
        read.append(path)
        return mocap.read(path)

    monkeypatch.setattr(mocap.torch, "read", counting)
    first, second = (Windows(tmp_path, 16, cache=cache) for _ in range(2))
    assert read == [str(file)] and first.names == second.names == [str(file)]
    for windows in (first, second, pickle.loads(pickle.dumps(second))):
        np.testing.assert_array_equal(windows.arrays(1)["features"], plain.arrays(1)["features"])
        np.testing.assert_array_equal(windows.statistics.std, plain.statistics.std)
    # Other options or another file give other arrays.
    assert Windows(file, 16, cache=cache, options=mocap.Options(fps=30)).statistics.frames < plain.statistics.frames
    file.write_bytes(WALK.read_bytes())
    assert Windows(file, 16, cache=cache).statistics.frames == mocap.read(WALK).frames
    assert len(read) == 3
    assert not list(cache.glob("*.tmp"))


def test_what_does_not_go_together_is_refused(tmp_path: Path) -> None:
    for motions, message in [
        ([moving("a", 9), moving("b", 9, joints=("root", "end"))], "has the joint 'end' where .* has 'tip': retarget"),
        ([moving("a", 9), moving("b", 9, joints=("root",))], "has 1 joints, and .* 2: retarget"),
        ([WALK, REAL / "lecture_Test.bvh"], "lecture_Test.bvh has 4 joints, and .*walk.bvh 38"),
        ([], "there is no motion"),
    ]:
        with pytest.raises(mocap.OptionError, match=message):
            Windows(motions, 4)
    with pytest.raises(mocap.OptionError, match="no clip has 20 frames, the longest has 9: padding='edge'"):
        Windows(moving("a", 9), 20, padding="drop")
    with pytest.raises(mocap.OptionError, match="length must be at least 1"):
        Windows(moving("a", 9), 0)
    with pytest.raises(TypeError, match="there is no option 'strides'; did you mean 'stride'"):
        Windows(moving("a", 9), 4, strides=2)
    with pytest.raises(mocap.OptionError, match="features must be a list of 'positions'.*got \\['rotation'\\]"):
        Windows(moving("a", 9), 4, features=["rotation"])
    with pytest.raises(FileNotFoundError):
        Windows(tmp_path / "no.bvh", 4)
    with pytest.raises(FileNotFoundError):
        Windows(tmp_path / "no.bvh", 4, cache=tmp_path)


def test_packed_clips_and_parts_of_mocap_pack(program: Path, tmp_path: Path) -> None:
    scene = mocap.edit.prepare(WALK)
    clip = mocap.PackedClip.of(scene)
    options = dict(features=("positions",), options=mocap.Options(), normalize=False)
    packed, whole = Windows(clip, 64, **options), Windows(scene, 64, **options)
    assert np.abs(packed.arrays(3)["features"] - whole.arrays(3)["features"]).max() < 0.002
    inputs = tmp_path / "in"
    inputs.mkdir()
    for path in (WALK, SHORT):
        (inputs / path.name).write_bytes(path.read_bytes())
    (inputs / "broken.bvh").write_bytes(b"HIERARCHY\nROOT a\n{\n")
    pack = [program, "pack", inputs, "-o", tmp_path / "out", "--rot", "6d", "--fps", "30", "--velocities", "--contacts"]
    subprocess.run(pack, check=False, capture_output=True)
    features = ("rotations", "velocities", "contacts")
    parts = Windows(tmp_path / "out", 32, features=features)
    files = Windows([WALK, SHORT], 32, features=features, options=mocap.Options(rot="6d", fps=30))
    assert len(parts) == len(files) and [Path(name).name for name in parts.names] == [WALK.name, SHORT.name]
    for index in range(len(parts)):
        np.testing.assert_allclose(parts.arrays(index)["features"], files.arrays(index)["features"], atol=1e-5)
    inventory = tmp_path / "inventory"
    subprocess.run([program, "pack", inputs, "-o", inventory, "--inventory"], check=False, capture_output=True)
    with pytest.raises(mocap.OptionError, match="has no names, rotations, velocities, contacts: mocap pack"):
        Windows(inventory, 32, features=features)


def test_pytorch_is_not_imported_before_it_is_used() -> None:
    code = "import sys, mocap.torch; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert done.stdout == "False\n"


def test_a_loader_of_pytorch_takes_windows() -> None:
    torch = pytest.importorskip("torch", reason="PyTorch is not installed")
    from torch.utils.data import DataLoader

    windows = Windows([WALK, SHORT], 32)
    batches = list(DataLoader(windows, batch_size=4, num_workers=2))
    assert sum(len(batch["features"]) for batch in batches) == len(windows)
    assert batches[0]["features"].dtype == torch.float32 and batches[0]["mask"].dtype == torch.bool
    np.testing.assert_array_equal(batches[0]["features"][3].numpy(), windows.arrays(3)["features"])


def test_a_window_is_tensors_of_its_arrays(monkeypatch: pytest.MonkeyPatch) -> None:
    class Torch:
        """Tests the use of PyTorch."""

        @staticmethod
        def from_numpy(array: np.ndarray) -> tuple[str, np.ndarray]:
            return "tensor", array

    monkeypatch.setitem(sys.modules, "torch", Torch)
    windows = Windows(SHORT, 32)
    for window, index in zip(windows, range(len(windows)), strict=True):
        arrays = windows.arrays(index)
        for name in ("features", "mask"):
            kind, array = window[name]
            assert kind == "tensor"
            np.testing.assert_array_equal(array, arrays[name])
        assert (window["clip"], window["first"]) == (arrays["clip"], arrays["first"])
