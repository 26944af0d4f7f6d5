"""Prints how closely the network of examples/learned, motion matching and the motion graph follow the same paths.

All three use the same walks.

    python compare.py [--model FILE] [--keep FOLDER]"""

import argparse
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import mocap
import numpy as np
from mocap import edit

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "examples/learned"))
from features import RATE, smooth  # noqa: E402
from motions import BODY, scenes, write  # noqa: E402
from play import MODEL, Path, Walker  # noqa: E402

SPEED = 1.1
# A toe below this height above the floor slides, in metres. (Zhang et al. 2018 weight toes by height; here all toes
# count alike.)
LOW = 0.03
# Laps of the circle by which the time of a frame is measured.
LAPS = 6


def arc(centre, radius, first, last, count):
    angles = np.radians(np.linspace(first, last, count))
    return [(centre[0] - radius * np.cos(angle), centre[1] + radius * np.sin(angle)) for angle in angles]


CIRCLE = arc((1.5, 0), 1.5, 0, 360, 37)
PATHS = {
    "right angle": [(0, 0), (0, 4), (4, 4)],
    "circle of 3 m": CIRCLE,
    "S of 2 m": arc((1, 0), 1, 0, 180, 19) + arc((3, 0), 1, 0, -180, 19)[1:],
}


def measures(scene, path):
    """Mean and largest distance from the path in cm, slide of the lower toe in cm/s, RMS jerk of joints in m/s3."""
    motion = scene.to_numpy(fps=RATE, out_unit="m", out_up="y")
    positions = motion.positions.astype(float)
    root = smooth(positions[:, 0][:, [0, 2]])
    dense = path.at(np.linspace(0, path.along[-1], 2000))[0]
    off = np.linalg.norm(root[:, None] - dense, axis=2).min(1)
    toes = positions[:, [motion.names.index(name) for name in ("LeftToeBase", "RightToeBase")]]
    height = toes[..., 1] - np.percentile(toes[..., 1].min(1), 5)
    speed = np.linalg.norm(np.gradient(toes[..., [0, 2]], axis=0), axis=2) * RATE
    lower = np.arange(len(height)), height.argmin(1)
    stands = height[lower] < LOW
    jerk = np.diff(positions, 3, axis=0) * RATE**3
    return 100 * off.mean(), 100 * off.max(), 100 * speed[lower][stands].mean(), np.sqrt((jerk**2).sum(2).mean())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--model", default=MODEL)
    parser.add_argument("--keep", help="a folder for the motions")
    args = parser.parse_args()
    walker = Walker(args.model)
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(args.keep or folder)
        program = lambda *words: subprocess.run(
            [sys.executable, "-m", "mocap", *map(str, words)], check=True, capture_output=True
        )
        text = lambda points: "+".join(f"{x:.4f}/{z:.4f}" for x, z in points)

        def network(points, name):
            roots, poses, seconds = walker.walk(Path(points), SPEED)
            return walker.scene(roots, poses), seconds

        def locked(points, name):
            scene, seconds = network(points, name)
            begin = time.process_time()
            scene = edit.foot_lock(scene)[0]
            return scene, seconds + (time.process_time() - begin) / scene.frames

        def matching(points, name):
            used = lambda: sum(resource.getrusage(resource.RUSAGE_CHILDREN)[:2])
            output, begin = folder / f"matching-{name}.bvh", used()
            program(
                "match",
                folder / "walks.mdb",
                "--path",
                text(points),
                "--speed",
                SPEED,
                "--character",
                BODY,
                "-o",
                output,
                "--force",
            )
            return mocap.read(output), used() - begin

        def graph(points, name):
            begin = time.process_time()
            scene = moments.walk(path=points)[0]
            return scene, (time.process_time() - begin) / scene.frames

        methods = {"network": network, "network, foot lock": locked}
        size = pathlib.Path(args.model).stat().st_size
        data = {"network": size, "network, foot lock": size}
        clips = write(folder / "clips")
        program("index", *clips, "-o", folder / "walks.mdb", "--pack", "--force")
        moments = mocap.graph(clips)
        moments.write(folder / "graph.json")
        methods |= {"motion matching": matching, "motion graph": graph}
        data["motion matching"] = (folder / "walks.mdb").stat().st_size
        data["motion graph"] = sum(file.stat().st_size for file in [*clips, folder / "graph.json"])
        # The time of one lap includes the reading of the files, as does the time of many laps.
        once, often = matching(CIRCLE, "lap"), matching(LAPS * CIRCLE[:-1] + CIRCLE[-1:], "laps")
        led = (often[1] - once[1]) / (often[0].frames - once[0].frames)
        print("| path | method | mean cm off | largest | slide, cm/s | jerk, m/s3 | kB | us a frame |")
        print("|---|---|---|---|---|---|---|---|")
        for name, points in PATHS.items():
            for method, walk in methods.items():
                scene, seconds = walk(points, name.replace(" ", "-"))
                if args.keep:
                    edit.write(scene, folder / f"{method}-{name}.bvh".replace(" ", "-").replace(",", ""))
                seconds = led if method == "motion matching" else seconds
                mean, most, slide, jerk = measures(scene, Path(points))
                print(
                    f"| {name} | {method} | {mean:.1f} | {most:.0f} | {slide:.1f} | {jerk:.0f} "
                    f"| {data[method] / 1000:,.0f} | {1e6 * seconds:.0f} |"
                )
        rows = [measures(scene, Path([(0, 0), (0, 1)]))[2:] for scene in scenes()]
        print("the walks themselves: slide {:.1f} cm/s, jerk {:.0f} m/s3".format(*np.mean(rows, axis=0)))


if __name__ == "__main__":
    main()
