"""Adds the defects of an estimator, a camera or a sensor to clean motions, from a seed.

The noise follows publications on monocular estimators and measurements on fixtures/real (see README.md). It is white: 2
degrees for the whole rotation of a joint, and 3 to 8 mm for the root.
"""

import json
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

import bvh

HERE = Path(__file__).parent
NOISE_DEGREES = 2.0  # root mean square of the whole angle, over all three axes
NOISE_ROOT_CM = (0.3, 0.8)  # standard deviation per axis, drawn for each clip
DRIFT_CM = (6.0, 3.0)  # along the ground and in height, over a clip
TILT_DEGREES = 3.0
HELD, LOST = 0.02, 0.01  # the fraction of held frames, and of dropped frames; as many others are doubled
FLIPS, SPIKES = 3, 3  # runs of 5 to 20 frames, single frames
SPIKE_CM = 43.0  # of the root, in single frames
HEIGHT_CM = 165.0
SIDES = ("Left", "Right")  # how the names of left and right joints begin
DEPTH_JITTER_CM, DEPTH_WAVER_CM = 2.5, 4.0  # along the axis of a camera: standard deviations, white and of 0.4 to 1 Hz


def sources(folders):
    for source in json.loads((HERE / "sources.json").read_text())["motions"]:
        for folder in folders:
            if (Path(folder) / source["file"]).exists():
                yield dict(source, path=Path(folder) / source["file"])
                break


def load(source, rate):
    """A source in centimetres, +Y up, at about 30 or 60 frames a second, with the floor at height 0."""
    motion = bvh.read(source["path"])
    step = max(1, round(motion.rate / rate))
    motion.rate /= step
    motion = motion.take(np.arange(source["skip"], source.get("end", len(motion.root)), step))
    if source["up"] == "z":
        up = Rotation.from_euler("X", -90, degrees=True)
        motion.root = up.apply(motion.root)
        motion.turns[:, 0] = (up * Rotation.from_quat(motion.turns[:, 0])).as_quat()
    places = motion.positions()
    height = np.percentile(np.ptp(places[..., 1], axis=1), 80)
    scale = HEIGHT_CM / height
    motion.root, motion.offsets = motion.root * scale, motion.offsets * scale
    motion.tips = [(joint, [scale * value for value in tip]) for joint, tip in motion.tips]
    motion.root[:, [0, 2]] -= motion.root[0, [0, 2]]
    return motion


def clips(folders, count, seed, only=None, rates=(30, 60)):
    """Clean cuts of 3 to 8 seconds, the same number at each rate: from the sources of one set, or else from the sources
    of all sets."""
    random = np.random.default_rng(seed)
    found = [source for source in sources(folders) if source.get("only") == only]
    if len(rates) == 1:
        found = [source for source in found if bvh.read(source["path"]).rate > 0.9 * rates[0]]
    loaded = {}
    for index in range(count):
        source, rate = found[index % len(found)], rates[index // len(found) % len(rates)]
        key = (source["file"], rate)
        if key not in loaded:
            loaded[key] = load(source, rate)
        whole = loaded[key]
        length = min(len(whole.root), int(random.uniform(3, 8) * whole.rate))
        first = random.integers(0, len(whole.root) - length + 1)
        clip = whole.take(np.arange(first, first + length))
        feet = [clip.names.index(name) for name in source["ankles"] + source["balls"]]
        clip.root[:, 1] -= np.percentile(clip.positions()[:, feet, 1].min(axis=1), 5)
        yield source, clip, np.random.default_rng([seed, index])


def add_noise(motion, random, correlation=0.0):
    """Noise of all rotations and of the root. It is white, or an Ornstein-Uhlenbeck process whose correlation falls to
    1/e in this time in seconds."""
    frames, joints = motion.turns.shape[:2]
    per_axis = np.radians(NOISE_DEGREES) / np.sqrt(3)
    turns, of_root = random.normal(size=(frames, joints, 3)), random.uniform(*NOISE_ROOT_CM)
    root = random.normal(size=(frames, 3))
    if correlation:
        keep = np.exp(-1 / (correlation * motion.rate))
        for noise in (turns, root):
            for frame in range(1, frames):
                noise[frame] = keep * noise[frame - 1] + np.sqrt(1 - keep**2) * noise[frame]
    noisy = Rotation.from_quat(motion.turns.reshape(-1, 4)) * Rotation.from_rotvec(per_axis * turns.reshape(-1, 3))
    motion.turns = noisy.as_quat().reshape(motion.turns.shape)
    motion.root = motion.root + of_root * root


def add_root_spikes(motion, random):
    """Single frames in which the root is far off."""
    for frame in random.choice(np.arange(4, len(motion.root) - 4), SPIKES, replace=False):
        way = random.normal(size=3)
        motion.root[frame] += SPIKE_CM * way / np.linalg.norm(way)


def interpolated(motion, times):
    """The motion with this number of frames for each frame, linear between two frames."""
    frames = len(motion.root)
    part = (np.arange((frames - 1) * times + 1) / times)[:, None]
    before = np.minimum(part[:, 0].astype(int), frames - 2)
    part = part - before[:, None]
    longer = motion.take(before)
    longer.root = motion.root[before] + part * (motion.root[before + 1] - motion.root[before])
    for joint in range(motion.turns.shape[1]):
        start, end = (Rotation.from_quat(motion.turns[before + step, joint]) for step in (0, 1))
        longer.turns[:, joint] = (start * Rotation.from_rotvec(part * (start.inv() * end).as_rotvec())).as_quat()
    longer.rate = motion.rate * times
    return longer


def add_flips(motion, source, random):
    """Rolls bones, moves single frames far off, exchanges legs. Returns which rotations are wrong."""
    frames, joints = motion.turns.shape[:2]
    wrong = np.zeros((frames, joints), dtype=bool)
    free = np.ones(frames, dtype=bool)
    free[:3] = free[-3:] = False

    def run(length):
        for _ in range(50):
            first = random.integers(3, max(4, frames - length - 3))
            if free[max(0, first - 4) : first + length + 4].all():
                free[max(0, first - 4) : first + length + 4] = False
                return np.arange(first, first + length)
        return np.arange(0)

    for _ in range(FLIPS):
        joint = motion.names.index(source["limbs"][random.integers(4)])
        bone = motion.offsets[motion.parents.index(joint)]
        at = run(random.integers(5, 21))
        half = Rotation.from_rotvec(np.pi * bone / np.linalg.norm(bone))
        motion.turns[at, joint] = (Rotation.from_quat(motion.turns[at, joint]) * half).as_quat() if len(at) else 0
        wrong[at, joint] = True
    for _ in range(SPIKES):
        joint, at = random.integers(1, joints), run(1)
        axis = random.normal(size=3)
        turn = Rotation.from_rotvec(np.radians(random.uniform(45, 120)) * axis / np.linalg.norm(axis))
        motion.turns[at, joint] = (Rotation.from_quat(motion.turns[at, joint]) * turn).as_quat() if len(at) else 0
        wrong[at, joint] = True
    at = run(random.integers(5, 13))
    for part in source["legs"]:
        a, b = (motion.names.index(side + part) for side in source.get("sides", SIDES))
        turns = [Rotation.from_quat(motion.turns[at, joint]) if len(at) else None for joint in (a, b)]
        motion.turns[np.ix_(at, [a, b])] = motion.turns[np.ix_(at, [b, a])]
        if len(at):
            wrong[at, a] |= np.degrees((turns[0].inv() * turns[1]).magnitude()) > 20
            wrong[at, b] |= wrong[at, a]
    return wrong


def add_tilt_and_drift(motion, random):
    frames = len(motion.root)
    t = np.linspace(0, 1, frames)[:, None]
    sizes = np.array([DRIFT_CM[0], DRIFT_CM[1], DRIFT_CM[0]]) / np.sqrt([2, 1, 2])
    way = random.choice([-1, 1], 3) * sizes
    drift = way * (0.5 * t + 0.5 * np.sin(0.5 * np.pi * random.uniform(0.5, 1.5) * t))
    angle = random.uniform(0, 2 * np.pi)
    tilt = Rotation.from_rotvec(np.radians(TILT_DEGREES) * np.array([np.cos(angle), 0, np.sin(angle)]))
    motion.root = tilt.apply(motion.root + drift)
    motion.turns[:, 0] = (tilt * Rotation.from_quat(motion.turns[:, 0])).as_quat()


def add_time(motion, random):
    """Holds frames, and drops and doubles frames in pairs. Returns for each frame the frame of the clean motion that it
    shows."""
    frames = len(motion.root)
    shown = np.arange(frames)
    for frame in random.choice(np.arange(4, frames - 4), max(1, int(HELD * frames)), replace=False):
        shown[frame] = shown[frame - 1]
    for _ in range(max(1, int(LOST * frames))):
        dropped, doubled = random.choice(np.arange(6, frames - 6), 2, replace=False)
        shown = shown.tolist()
        shown.insert(doubled, shown[doubled])
        shown.pop(dropped if dropped < doubled else dropped + 1)
        shown = np.array(shown)
    motion.root, motion.turns = motion.root[shown], motion.turns[shown]
    return shown


def add_depth(motion, random):
    """Adds the depth error of a monocular estimator to the root: noise and slow changes along one axis of the
    ground."""
    frames = len(motion.root)
    angle = random.uniform(0, 2 * np.pi)
    axis = np.array([np.cos(angle), 0, np.sin(angle)])
    t = np.arange(frames) / motion.rate
    waves = [np.sin(2 * np.pi * (random.uniform(0.4, 1.0) * t + random.uniform())) for _ in range(3)]
    waver = sum(waves) / np.sqrt(1.5)
    motion.root = motion.root + (DEPTH_WAVER_CM * waver + random.normal(0, DEPTH_JITTER_CM, frames))[:, None] * axis


def repeat(motion, random):
    """A take at 4/5 of the rate of its file: each fifth frame repeats the frame before. Returns the true rate."""
    own = np.round(np.arange(0, len(motion.root) - 1, 1.25)).astype(int)
    true = motion.rate * 0.8
    slower = motion.take(own)
    shown = np.repeat(np.arange(len(own)), np.where(np.arange(len(own)) % 4 == 3, 2, 1))
    motion.root, motion.turns = slower.root[shown], slower.turns[shown]
    return true


def spoil(clean, source, random, what):
    """Returns the spoiled motion, the flipped rotations, and the clean frame that each frame shows."""
    motion = clean.copy()
    frames, joints = motion.turns.shape[:2]
    wrong, shown = np.zeros((frames, joints), dtype=bool), np.arange(frames)
    if "flips" in what:
        wrong = add_flips(motion, source, random)
    if "floor" in what:
        add_tilt_and_drift(motion, random)
    if "depth" in what:
        add_depth(motion, random)
    if "noise" in what:
        add_noise(motion, random)
    if "time" in what:
        shown = add_time(motion, random)
        wrong = wrong[shown]
    return motion, wrong, shown
