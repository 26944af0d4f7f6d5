"""Judges examples/learned: a short training twice, and the committed network without PyTorch."""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/learned"
sys.path.insert(0, str(EXAMPLE))
# Steps of the short training; bytes of the committed network.
STEPS, MOST_BYTES = 40, 3_000_000
# Limits of the committed network on each path: mean and largest distance from the path in cm, slide of the lower toe in
# cm/s.
MEAN_OFF, MOST_OFF, MOST_SLIDE = 15.0, 50.0, 30.0


def run(*words):
    return subprocess.run(
        [sys.executable, *map(str, words)], check=True, capture_output=True, text=True, cwd=EXAMPLE
    ).stdout


def trains(folder):
    """One seed always gives the same file, different seeds give different files, and training reduces the loss."""
    files = [folder / f"{name}.safetensors" for name in ("one", "again", "other", "longer")]
    printed = [
        run("train.py", "-o", file, "--steps", STEPS * (1 + 4 * (file is files[3])), "--seed", 1 + (file is files[2]))
        for file in files
    ]
    one, again, other, _ = (file.read_bytes() for file in files)
    assert one == again, "two trainings from one seed differ"
    assert one != other, "two seeds give one network"
    short, longer = (float(text.rsplit("loss ", 1)[1].split(",")[0]) for text in (printed[0], printed[3]))
    assert longer < short, f"loss {short} after {STEPS} steps, {longer} after five times as many"


def plays(folder):
    """The committed network follows the paths, without PyTorch."""
    model = EXAMPLE / "walk.safetensors"
    assert model.stat().st_size < MOST_BYTES
    without = (
        "import runpy, sys; sys.modules['torch'] = None; sys.argv = sys.argv[1:]; "
        "runpy.run_path(sys.argv[0], run_name='__main__')"
    )
    files = [folder / "one.bvh", folder / "two.bvh"]
    for file in files:
        run("-c", without, "play.py", "--path", "0/0 + 0/2 + 1/3", "-o", file)
    assert files[0].read_bytes() == files[1].read_bytes(), "two walks along one path differ"
    run("-m", "mocap", "check", files[0])

    import mocap
    from compare import PATHS, SPEED, measures
    from play import Path, Walker

    hips = mocap.read(files[0]).to_numpy().positions[-1, 0, [0, 2]]
    assert np.linalg.norm(hips - [1, 3]) < MOST_OFF / 100, f"the walk ends at {hips}"
    for name, points in PATHS.items():
        walker = Walker(model)
        roots, poses, _ = walker.walk(Path(points), SPEED)
        off, most, slide, jerk = measures(walker.scene(roots, poses), Path(points))
        print(
            f"{name}: {off:.1f} cm off the path, {most:.0f} at most; feet slide {slide:.1f} cm/s; jerk {jerk:.0f} m/s3"
        )
        assert off < MEAN_OFF and most < MOST_OFF and slide < MOST_SLIDE


with tempfile.TemporaryDirectory() as temporary:
    trains(pathlib.Path(temporary))
    plays(pathlib.Path(temporary))
print("examples/learned: 0 failed")
