"""Judges `mocap graph` with the paper's equation in NumPy, with SciPy, and with separate kinematics. See README.md."""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "clean"))
import bvh  # noqa: E402

# The metres per unit of CMU's files, and copies of the program's default options.
METRES, RATE, WINDOW = 0.0254 / 0.45, 31.25, 10
OPTIONS = ["--unit", "cmu", "--rate", RATE, "--force"]
FAILED = []


def hold(name, value, wanted, is_held):
    print(f"{'ok  ' if is_held else 'FAIL'} {name}: {value} (wanted: {wanted})")
    if not is_held:
        FAILED.append(name)


def run(*words):
    words = [str(word) for word in words]
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(words)}: {done.stderr}")
    return done.stdout


def cloud(motion):
    """All joints and tips in every frame, in metres, and the weight of each: half the length of the bones that meet
    there."""
    places = motion.positions()
    world = [None] * len(motion.names)
    lengths = np.zeros(len(motion.names) + len(motion.tips))
    for joint, parent in enumerate(motion.parents):
        local = bvh.Rotation.from_quat(motion.turns[:, joint])
        world[joint] = local if parent < 0 else world[parent] * local
        if parent >= 0:
            lengths[[joint, parent]] += np.linalg.norm(motion.offsets[joint]) / 2
    tips = []
    for tip, (joint, offset) in enumerate(motion.tips):
        tips.append(places[:, joint] + world[joint].apply(offset))
        lengths[[joint, len(motion.names) + tip]] += np.linalg.norm(offset) / 2
    points = np.concatenate([places, np.stack(tips, 1)], 1) * METRES
    return points, lengths / lengths.sum()


def distance(p, q, weights):
    """Equation 1 of the paper in its closed form, for frames x points x (x, y, z) with +Y up. Returns the square root
    of the sum."""
    w = weights.ravel()
    (x, y, z), (x1, y1, z1) = p.reshape(-1, 3).T, q.reshape(-1, 3).T
    total, mx, mz, mx1, mz1 = w.sum(), w @ x, w @ z, w @ x1, w @ z1
    angle = np.arctan2(
        w @ (x * z1 - x1 * z) - (mx * mz1 - mx1 * mz) / total, w @ (x * x1 + z * z1) - (mx * mx1 + mz * mz1) / total
    )
    cos, sin = np.cos(angle), np.sin(angle)
    x0 = (mx - mx1 * cos - mz1 * sin) / total
    z0 = (mz + mx1 * sin - mz1 * cos) / total
    apart = (x - x0 - x1 * cos - z1 * sin) ** 2 + (y - y1) ** 2 + (z - z0 + x1 * sin - z1 * cos) ** 2
    return np.sqrt(w @ apart)


def exact(path, folder):
    """A copy without the rest pose in the first frame. Its frame time has few decimals, so that frames of the graph are
    frames of the clip."""
    motion = bvh.read(path).take(slice(1, None))
    motion.rate = 4 * RATE
    bvh.write(folder / path.name, motion)
    return folder / path.name


def read(path):
    """A clip at the rate of the graph."""
    motion = bvh.read(path)
    return motion.take(slice(0, None, round(motion.rate / RATE)))


def judge_distances(mocap, files, folder, count):
    matrix = folder / "matrix.npy"
    run(mocap, "graph", *files, *OPTIONS, "--matrix", matrix)
    found = np.load(matrix)
    clouds = [cloud(read(file)) for file in files]
    (p, weights), (q, _) = clouds[0], clouds[-1]
    taper = np.minimum(np.arange(1, WINDOW + 1), np.arange(WINDOW, 0, -1)).astype(float)
    all_weights = np.outer(taper / taper.sum(), weights)
    shape = (len(p) - WINDOW + 1, len(q) - WINDOW + 1)
    hold(f"matrix of {' and '.join(file.stem for file in files)}", found.shape, shape, found.shape == shape)
    random = np.random.default_rng(1)
    cells = np.stack([random.integers(0, side, count) for side in found.shape], 1)
    truth = np.array([distance(p[i : i + WINDOW], q[j : j + WINDOW], all_weights) for i, j in cells])
    apart = np.abs(truth - found[cells[:, 0], cells[:, 1]]).max()
    hold(f"distances of {count} pairs, metres apart at most", f"{apart:.1e}", "1e-6", apart <= 1e-6)
    return found


def minima(matrix, threshold, is_same):
    """The cells below the threshold that are less than their eight neighbours."""
    padded = np.pad(matrix, 1, constant_values=np.inf)
    rows, columns = matrix.shape
    shifts = [(i, j) for i in range(3) for j in range(3) if (i, j) != (1, 1)]
    least = np.min([padded[i : i + rows, j : j + columns] for i, j in shifts], 0)
    is_least = (matrix <= least) & (matrix <= np.float32(threshold))
    if is_same:
        is_least &= np.subtract.outer(np.arange(rows), np.arange(columns)) <= -WINDOW
    return set(zip(*np.nonzero(is_least)))


def judge_graph(mocap, files, folder, threshold):
    graphs = []
    for words in [["--whole"], []]:
        path = folder / f"graph{len(words)}.json"
        run(mocap, "graph", *files, *OPTIONS, "--threshold", f"{threshold}m", "-o", path, *words)
        graphs.append(json.loads(path.read_text()))
    whole, kept = graphs
    starts = np.cumsum([0] + [clip["frames"] for clip in whole["clips"]])
    node = lambda end: starts[end[0]] + end[1]
    edges = [(frame, frame + 1) for clip in range(len(files)) for frame in range(starts[clip], starts[clip + 1] - 1)]
    edges += [(node(transition["from"]), node(transition["to"])) for transition in whole["transitions"]]
    edges = np.array(edges)
    count = starts[-1]
    links = csr_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    labels = connected_components(links, directed=True, connection="strong")[1]
    inside = labels == np.bincount(labels).argmax()
    stated = np.zeros(count, bool)
    for clip, part in enumerate(clip["part"] for clip in kept["clips"]):
        if part:
            stated[starts[clip] + part[0] : starts[clip] + part[1] + 1] = True
    equal = bool((inside == stated).all())
    hold(f"largest component at {threshold} m, {inside.sum()} of {count} frames, is SciPy's", equal, True, equal)
    of_part = [t for t in whole["transitions"] if inside[node(t["from"])] and inside[node(t["to"])]]
    hold("transitions that are kept", len(kept["transitions"]), len(of_part), kept["transitions"] == of_part)
    return whole


def judge_minima(whole, matrix, threshold):
    own = {(t["from"][1], t["to"][1] - WINDOW + 1) for t in whole["transitions"]}
    truth = minima(matrix, threshold, True)
    truth |= {(j, i) for i, j in truth}
    hold("local minima below the threshold", len(own), len(truth), own == truth)


def judge_all_minima(mocap, files, folder, threshold):
    """Compares the transitions among several clips with the complete matrices of all pairs of clips."""
    graph, matrix, truth = folder / "all.json", folder / "pair.npy", set()
    run(mocap, "graph", *files, *OPTIONS, "--threshold", f"{threshold}m", "--whole", "-o", graph)
    for first in range(len(files)):
        for second in range(first, len(files)):
            pair = [files[first]] if first == second else [files[first], files[second]]
            run(mocap, "graph", *pair, *OPTIONS, "--matrix", matrix)
            found = minima(np.load(matrix), threshold, first == second)
            truth |= {(first, i, second, j) for i, j in found} | {(second, j, first, i) for i, j in found}
    transitions = json.loads(graph.read_text())["transitions"]
    own = {(*t["from"], t["to"][0], t["to"][1] - WINDOW + 1) for t in transitions}
    hold(f"local minima among {len(files)} clips at {threshold} m", len(own), len(truth), own == truth)


def speeds(places, rate):
    """The speed and the acceleration of each joint."""
    speed = np.linalg.norm(np.diff(places, axis=0), axis=2) * rate
    acceleration = np.linalg.norm(np.diff(places, 2, axis=0), axis=2) * rate**2
    return speed, acceleration


FEET = [("Left", ["LeftFoot", "LeftToeBase"]), ("Right", ["RightFoot", "RightToeBase"])]


def slide(motion, places):
    """The mean speed over the ground of feet in contact: low (3 cm above the level of the joint) and slow (15 cm/s),
    for 0.08 s or longer. Only the slowest joint of a foot counts, because a foot turns about its heel or its ball."""
    slides = []
    for _, names in FEET:
        joints = [motion.names.index(name) for name in names if name in motion.names]
        low, ground = [], []
        for joint in joints:
            height = places[:, joint, 1]
            over = np.linalg.norm(np.gradient(places[:, joint][:, [0, 2]], axis=0), axis=1) * motion.rate
            low.append((height < np.percentile(height, 5) + 0.03) & (over < 0.15))
            ground.append(over)
        slowest = np.min(ground, 0)
        rests = np.any(low, 0)
        edges = np.flatnonzero(np.diff(np.concatenate([[0], rests, [0]])))
        for start, end in edges.reshape(-1, 2):
            if end - start >= 0.08 * motion.rate:
                slides.append(slowest[start:end])
    return np.concatenate(slides) if slides else np.zeros(1)


def judge_walk(mocap, files, folder, threshold, seconds, seed):
    graph, out = folder / "graph.json", folder / "walk.bvh"
    run(mocap, "graph", *files, *OPTIONS, "--threshold", f"{threshold}m", "-o", graph)
    said = run(
        mocap, "graph", "walk", graph, "--unit", "cmu", "--seconds", seconds, "--seed", seed, "--json", "-o", out, "--force"
    )
    report = json.loads(said)
    motion = bvh.read(out)
    frames = round(seconds * motion.rate) + 1
    hold("frames of the walk", len(motion.root), frames, len(motion.root) == frames)
    places = motion.positions() * METRES
    sources = [speeds(bvh.read(file).positions() * METRES, motion.rate) for file in files]
    limits = [np.percentile(np.concatenate([of[i] for of in sources]), 99.9) for i in range(2)]
    at = np.zeros(len(places), bool)
    for start in report["transitions"]:
        at[int(start * motion.rate) : int((start + WINDOW / RATE) * motion.rate) + 2] = True
    for kind, values, limit, unit in zip(["speed", "acceleration"], speeds(places, motion.rate), limits, ["m/s", "m/s2"]):
        here = values[at[: len(values)]]
        beyond = 100 * (here > limit).mean()
        print(
            f"     {kind} in {len(report['transitions'])} transitions: 99.9th percentile {np.percentile(here, 99.9):.2f}, "
            f"most {here.max():.2f} {unit}; of the sources {limit:.2f}; beyond it {beyond:.3f} % of values"
        )
        ratio = np.percentile(here, 99.9) / limit
        hold(f"99.9th percentile of {kind} in transitions", f"{ratio:.3f} of the sources'", "1", ratio <= 1)
    own = slide(motion, places)
    clips = [bvh.read(file) for file in files]
    source = np.concatenate([slide(clip, clip.positions() * METRES) for clip in clips])
    value = 100 * own.mean()
    print(f"     slide of feet in contact: {value:.2f} cm/s on average; in the sources {100 * source.mean():.2f}")
    hold("slide in cm/s", f"{value:.2f}", "1", value <= 1.0)


def turning(mocap, walk, folder):
    """The walk, and the walk bent along arcs to both sides, as clips that turn."""
    motion = bvh.read(walk)
    length = np.linalg.norm((motion.root[-1] - motion.root[0])[[0, 2]]) * METRES
    # The direction in which the figure walks, as an angle from +X to +Z; a larger angle is further right.
    along = np.arctan2(*(motion.root[-1] - motion.root[0])[[2, 0]])
    files = [walk]
    for radius in [1.0, 2.0, -1.0, -2.0]:
        angles = np.linspace(0, length / abs(radius), 12)
        x, y = np.sin(angles) * abs(radius), (1 - np.cos(angles)) * radius
        x, y = x * np.cos(along) - y * np.sin(along), x * np.sin(along) + y * np.cos(along)
        path = "+".join(f"{a:.3f}/{b:.3f}" for a, b in zip(x, y))
        files.append(folder / f"turn{radius:+.0f}.bvh")
        run(mocap, "edit", walk, "--unit", "cmu", "-o", files[-1], "--force", "--step", f"warp:path={path}", "--step", "foot-lock")
    return files


def arc(*pieces):
    """A path of pieces: the length of each piece in metres, and its turn in degrees."""
    points, direction = [np.zeros(2)], 0.0
    for length, turn in pieces:
        for _ in range(round(length / 0.1)):
            direction += np.radians(turn) / round(length / 0.1)
            points.append(points[-1] + 0.1 * np.array([np.cos(direction), np.sin(direction)]))
    return np.array(points)


PATHS = [
    ("straight", arc((8, 0)), True),
    ("circle of 3 m", arc((18.85, 360)), True),
    ("S of 2 m", arc((1, 0), (3.14, 90), (3.14, -90), (1, 0)), True),
    ("corner of 1 m", arc((4, 0), (1.6, 90), (4, 0)), True),
    ("right angle", np.array([[0, 0], [4, 0], [4, 5]], float), False),
]


def nearest(path, place, reached):
    """The distance along a path to the point nearest to a position, at most a metre before or after `reached`."""
    starts, steps = path[:-1], np.diff(path, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    before = np.concatenate([[0], np.cumsum(lengths)[:-1]])
    parts = np.clip(((place - starts) * steps).sum(1) / lengths**2, 0, 1)
    apart = np.linalg.norm(starts + parts[:, None] * steps - place, axis=1)
    along = before + parts * lengths
    apart[np.abs(along - reached) > 1] = np.inf
    best = apart.argmin()
    return along[best], apart[best]


def judge_paths(mocap, files, folder):
    graph, out = folder / "turns.json", folder / "path.bvh"
    run(mocap, "graph", *files, *OPTIONS, "-o", graph)
    for name, path, is_held in PATHS:
        points = "+".join(f"{x:.4f}/{y:.4f}" for x, y in path)
        said = run(mocap, "graph", "walk", graph, "--unit", "cmu", "--path", points, "--json", "-o", out, "--force")
        points, weights = cloud(bvh.read(out))
        rate = bvh.read(out).rate
        centres = np.einsum("fpa,p->fa", points[:, :, [0, 2]], weights)
        reached, along, apart = 0.0, [], []
        for centre in centres:
            reached, distance = nearest(path, centre, reached)
            along.append(reached)
            apart.append(distance)
        lengths = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
        on = np.stack([np.interp(along, lengths, path[:, axis]) for axis in range(2)], 1)
        frames = np.arange(len(centres))
        first, last = np.maximum(frames - round(rate / 2), 0), np.minimum(frames + round(rate / 2), len(frames) - 1)
        own, wanted = centres[last] - centres[first], on[last] - on[first]
        cross, dot = own[:, 0] * wanted[:, 1] - own[:, 1] * wanted[:, 0], (own * wanted).sum(1)
        turn = np.abs(np.degrees(np.arctan2(cross, dot)))
        values = np.mean(apart), np.max(apart), np.mean(turn), np.max(turn)
        text = "{:.3f} m on average, {:.3f} at most, {:.1f} degrees, {:.1f}".format(*values)
        is_near = values[1] <= 0.10 and values[3] <= 10
        hold(f"{name}: {text}", f"{along[-1]:.2f} of {lengths[-1]:.2f} m", "10 cm, 10 degrees" if is_held else "said", is_near or not is_held)
        stated = json.loads(said)["path"]
        stated = [stated[key] for key in ["mean_distance", "largest_distance", "mean_angle", "largest_angle"]]
        off = np.abs(np.subtract(values, stated))
        hold("  the report", np.round(stated, 3).tolist(), "within 1 cm and 3 degrees", off[:2].max() < 0.01 and off[2:].max() < 3)


def judge_speed(mocap, file, folder):
    motion = bvh.read(file)
    frames = round(30 * motion.rate)
    files = []
    for index in range(2):
        files.append(folder / f"long{index}.bvh")
        bvh.write(files[-1], motion.take((np.arange(frames) + 400 * index) % len(motion.root)))
    read_alone = time.monotonic()
    for path in files:
        run(mocap, "info", path)
    begin = time.monotonic()
    run(mocap, "graph", *files, *OPTIONS, "--matrix", folder / "long.npy")
    end = time.monotonic()
    print(f"     matrix of two clips of 30 s: {end - begin:.2f} s, of which reading them takes {begin - read_alone:.2f} s")
    hold("matrix of two clips of 30 s, in seconds", f"{end - begin:.2f}", "1", end - begin <= 1.0)


def judge_hostile(mocap, graph, folder):
    """Damaged graphs give an error of the file, and no output."""
    text = graph.read_text()
    whole = json.loads(text)
    damaged = [b"", b"{}", b"[]", b"\xff\xfe\x00", text.encode()[: len(text) // 2], text.replace('"motion-graph": 1', '"motion-graph": 2')]
    damaged += ["[" * 100_000, text.replace('"distance":', '"distance":1e999,"x":'), text + text]

    def changed(change):
        copy = json.loads(text)
        change(copy)
        damaged.append(json.dumps(copy))

    big = 2**63
    changed(lambda g: g["transitions"][0].update({"from": [0, big]}))
    changed(lambda g: g["transitions"][0].update({"to": [9, 0]}))
    changed(lambda g: g["transitions"][0].update({"to": [0, 0]}))
    changed(lambda g: g["transitions"][0].update({"distance": -1.0}))
    changed(lambda g: g["clips"][0].update({"frames": big}))
    changed(lambda g: g["clips"][0].update({"part": [5, 2]}))
    changed(lambda g: g["clips"][0].update({"part": None}))
    changed(lambda g: g["clips"][0].update({"sha256": "0"}))
    changed(lambda g: g["clips"][0].update({"file": "/dev/zero"}))
    changed(lambda g: g["clips"][0].update({"animation": 7}))
    changed(lambda g: g["options"].update({"rate": 1e30}))
    changed(lambda g: g["options"].update({"rate": 0.5}))
    changed(lambda g: g["options"].update({"window": 1e30}))
    changed(lambda g: g["options"].update({"rate": 1000.0}))
    changed(lambda g: g.update({"clips": []}))
    changed(lambda g: g.update({"transitions": []}))
    random = np.random.default_rng(2)
    for _ in range(40):
        copy = bytearray(text.encode())
        copy[random.integers(len(copy))] = random.integers(256)
        damaged.append(bytes(copy))
    refused = 0
    for index, data in enumerate(damaged):
        path, out = folder / "damaged.json", folder / "damaged.glb"
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        words = [mocap, "graph", "walk", path, "--seconds", "2", "-o", out]
        done = subprocess.run(words, capture_output=True, text=True, timeout=60, cwd=folder)
        is_clean = done.returncode in (1, 2) and not out.exists() and "panicked" not in done.stderr
        refused += is_clean
        # With another digit in a distance, or another letter in an option, the file may still be a valid graph.
        if not is_clean and (index < len(damaged) - 40 or done.returncode != 0):
            hold(f"damaged graph {index}", f"{done.returncode} {done.stderr}", "an error", False)
        out.unlink(missing_ok=True)
    hold("damaged graphs that are refused, or still valid", f"{refused} of {len(damaged)}", "no other", True)
    assert whole["motion-graph"] == 1


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("fixtures", type=pathlib.Path)
    parser.add_argument("--all", action="store_true")
    args = parser.parse_args()
    mocap = str(pathlib.Path(args.mocap).resolve())
    walk, other = [args.fixtures.resolve() / name for name in ["cmu_12_01_walk.bvh", "cmu_01_01.bvh"]]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        walk, other = [exact(file, folder) for file in [walk, other]]
        matrix = judge_distances(mocap, [walk], folder, 300)
        if args.all:
            # Another clip of the skeleton: the walk in reverse.
            second = folder / "reversed.bvh"
            bvh.write(second, bvh.read(walk).take(slice(None, None, -1)))
            judge_distances(mocap, [walk, second], folder, 1000)
            judge_distances(mocap, [other], folder, 3000)
        whole = judge_graph(mocap, [walk], folder, 0.1)
        judge_minima(whole, matrix, 0.1)
        for threshold in [0.06, 0.08, 0.12] if args.all else [0.08]:
            judge_graph(mocap, [other], folder, threshold)
        judge_walk(mocap, [walk], folder, 0.06, 60, 1)
        judge_hostile(mocap, folder / "graph.json", folder)
        turns = turning(mocap, walk, folder)
        for threshold in [0.03, 0.06, 0.2] if args.all else [0.06]:
            judge_all_minima(mocap, turns, folder, threshold)
        judge_paths(mocap, turns, folder)
        if args.all:
            for seed in range(2, 5):
                judge_walk(mocap, [other], folder, 0.06, 60, seed)
            judge_speed(mocap, other, folder)
    print(f"{len(FAILED)} failed")
    sys.exit(bool(FAILED))


main()
