"""Makes a graph of half a million frames, and measures time and memory.

    large.py PROGRAM [FRAMES] [FOLDER]

Clips of fixtures/real are retargeted to one skeleton. Random parts of 30 s get 0.8 to 1.25 times their speed. Every
rotation channel gets an offset of up to 8 degrees and a slow wave of up to 4 degrees, to imitate takes of other people.
One seed determines everything. Prints the time and the memory of `mocap graph`, and the number of transitions. With
FOLDER, the clips stay in this folder for later runs.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

REAL = Path(__file__).parents[2] / "fixtures/real"
SKELETON = "cmu_12_01_walk.bvh"
CLIPS = [
    SKELETON, "cmu_01_01.bvh", "rokoko_dance.bvh", "motionbuilder_vicon_walk.bvh", "cmu_salsa_poser_names.bvh", "z_up_dab.bvh",
    "mocopi_jump_six_channels.bvh", "hip_knee_ankle_names.bvh", "kinect_openni.bvh", "cmu_mixed_rotation_orders.bvh",
    "perception_neuron_moving_positions.bvh", "makehuman_zombie_walk.bvh",
]  # fmt: skip
RATE, SECONDS = 30, 30


def read(path):
    """The header of a BVH file, its rows at 30 frames a second, and the columns of rotations."""
    head, rows = path.read_text().split("Frame Time:")
    step, rows = rows.split("\n", 1)
    values = np.array([line.split() for line in rows.splitlines() if line.strip()], float)
    words = head.split()
    names = [w for at, word in enumerate(words) if word == "CHANNELS" for w in words[at + 2 : at + 2 + int(words[at + 1])]]
    turns = np.array([name.endswith("rotation") for name in names])
    values[:, turns] = np.degrees(np.unwrap(np.radians(values[:, turns]), axis=0))
    times = np.arange(0, (len(values) - 1) * float(step), 1 / RATE) / float(step)
    return head[: head.index("Frames:")], resampled(values, times), turns


def resampled(values, at):
    return np.stack([np.interp(at, np.arange(len(values)), column) for column in values.T], 1)


def make(program, frames, folder):
    """Writes the clips into a folder."""
    random = np.random.default_rng(39)
    sources = []
    for name in CLIPS:
        moved = folder / name
        subprocess.run([program, "retarget", REAL / name, "--to-skeleton", REAL / SKELETON, "-o", moved, "-q"], check=True)
        sources.append(read(moved))
        moved.unlink()
    made = 0
    while made < frames:
        head, values, turns = sources[random.integers(len(sources))]
        speed = random.uniform(0.8, 1.25)
        count = min(SECONDS * RATE, int((len(values) - 1) / speed), frames - made)
        if count < 2 * RATE and count < frames - made:
            continue
        start = random.uniform(0, len(values) - 1 - speed * (count - 1))
        rows = resampled(values, start + speed * np.arange(count))
        waves = 4 * np.sin(np.arange(count)[:, None] / RATE * random.uniform(0.2, 1.5, turns.sum()) + random.uniform(0, 7, turns.sum()))
        rows[:, turns] += random.uniform(-8, 8, turns.sum()) + waves
        with open(folder / f"{made:07}.bvh", "w") as out:
            out.write(f"{head}Frames: {count}\nFrame Time: {1 / RATE:.7f}\n")
            np.savetxt(out, rows, fmt="%.4f")
        made += count


def compare(program, folder, graph):
    begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [program, "graph", folder, "-o", graph, "--force"]
    done = subprocess.run(words, check=True, capture_output=True, text=True)
    seconds, used = time.monotonic() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = used.ru_utime + used.ru_stime - before.ru_utime - before.ru_stime
    print(done.stderr.strip().splitlines()[-1])
    # The system gives the largest memory of all commands so far; this command uses most.
    print(f"{seconds:.1f} s, {processor:.1f} s of processor time, {used.ru_maxrss / 1024:.0f} MB at most")


def main():
    program, frames = Path(sys.argv[1]).resolve(), int(sys.argv[2]) if len(sys.argv) > 2 else 500_000
    with tempfile.TemporaryDirectory() as folder:
        kept = Path(sys.argv[3]) if len(sys.argv) > 3 else Path(folder) / "clips"
        if not kept.exists():
            kept.mkdir()
            make(program, frames, kept)
        compare(program, kept, Path(folder) / "graph.json")


main()
