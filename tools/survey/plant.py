"""Plants defects and twins into clean motions by arithmetic on the text of BVH files, without code of mocap."""

import math
import re

import numpy as np


class Bvh:
    """A BVH file as numbers: the hierarchy's text, names, parents, offsets, channels, and frames x channels."""

    def __init__(self, text):
        head, tail = text.split("MOTION", 1)
        self.head = head
        lines = tail.strip().splitlines()
        self.frame_time = float(lines[1].split(":")[1])
        self.rows = np.array([[float(v) for v in line.split()] for line in lines[2:] if line.strip()])
        self.names, self.parents, self.offsets, self.channels, self.first = [], [], [], [], []
        stack, count, current = [], 0, None
        for line in head.splitlines():
            words = line.split()
            if not words:
                continue
            if words[0] in ("ROOT", "JOINT"):
                self.names.append(" ".join(words[1:]))
                self.parents.append(stack[-1] if stack else -1)
                self.offsets.append(None)
                self.channels.append([])
                self.first.append(count)
                current = len(self.names) - 1
            elif words[0] == "End":
                current = None
            elif words[0] == "{":
                stack.append(current)
            elif words[0] == "}":
                stack.pop()
            elif words[0] == "OFFSET" and current is not None:
                self.offsets[current] = np.array([float(v) for v in words[1:4]])
            elif words[0] == "CHANNELS":
                self.channels[current] = words[2:]
                self.first[current] = count
                count += int(words[1])

    def copy(self):
        other = object.__new__(Bvh)
        other.__dict__.update(self.__dict__)
        other.rows = self.rows.copy()
        return other

    def text(self):
        rows = "\n".join(" ".join(f"{v:.6f}" for v in row) for row in self.rows)
        frames = getattr(self, "stated", len(self.rows))
        return f"{self.head}MOTION\nFrames: {frames}\nFrame Time: {self.frame_time:.7f}\n{rows}\n"

    def columns(self, joint, kind):
        return [self.first[joint] + i for i, c in enumerate(self.channels[joint]) if c.lower().endswith(kind)]

    def world(self):
        """Positions of all joints, frames x joints x 3, and rotations relative to the world."""
        frames = len(self.rows)
        places = np.zeros((frames, len(self.names), 3))
        turns = np.zeros((frames, len(self.names), 3, 3))
        for joint, parent in enumerate(self.parents):
            local = np.broadcast_to(np.eye(3), (frames, 3, 3)).copy()
            moved = np.broadcast_to(self.offsets[joint], (frames, 3)).copy()
            for i, channel in enumerate(self.channels[joint]):
                values = self.rows[:, self.first[joint] + i]
                axis = "xyz".index(channel[0].lower())
                if channel.lower().endswith("position"):
                    moved[:, axis] = values
                else:
                    local = local @ axis_rotation(axis, np.radians(values))
            if parent < 0:
                places[:, joint], turns[:, joint] = moved, local
            else:
                places[:, joint] = places[:, parent] + np.einsum("fij,fj->fi", turns[:, parent], moved)
                turns[:, joint] = turns[:, parent] @ local
        return places, turns

    def set_local(self, joint, frame, matrix):
        """Sets the Euler angles of a joint so that its rotation is `matrix`."""
        from scipy.spatial.transform import Rotation

        order = "".join(c[0].upper() for c in self.channels[joint] if c.lower().endswith("rotation"))
        angles = Rotation.from_matrix(matrix).as_euler(order, degrees=True)
        self.rows[frame, self.columns(joint, "rotation")] = angles


def axis_rotation(axis, angles):
    c, s = np.cos(angles), np.sin(angles)
    matrix = np.zeros((len(angles), 3, 3))
    a, b = (axis + 1) % 3, (axis + 2) % 3
    matrix[:, axis, axis] = 1
    matrix[:, a, a], matrix[:, a, b], matrix[:, b, a], matrix[:, b, b] = c, -s, s, c
    return matrix


def words(name):
    return re.sub(r"[^a-z]", "", name.lower())


# Words that identify the joints of the clean clips, tried in this order.
BODY = {
    "hips": ("hips", "hip", "pelvis"),
    "neck": ("neck", "neck1", "neck01"),
    "head": ("head",),
    "shoulder": ("arm", "uparm", "upperarm", "shoulder"),
    "elbow": ("forearm", "lowarm", "lowerarm", "elbow"),
    "hand": ("hand", "wrist"),
    "knee": ("leg", "lowleg", "lowerleg", "knee"),
    "foot": ("foot", "ankle"),
    "toe": ("toebase", "toe", "toes"),
}


class Body:
    """The joints of a clean clip by their names, and their positions in metres."""

    def __init__(self, bvh, metres):
        self.bvh, self.metres = bvh, metres
        names = [words(name.split(":")[-1]) for name in bvh.names]

        def find(options, side=""):
            for option in options:
                for full in (side + option, option + side):
                    if full in names:
                        return names.index(full)
            return None

        self.hips = find(BODY["hips"]) or 0
        self.neck = find(BODY["neck"]) or find(BODY["head"])
        self.sides = {}
        for side in ("left", "right"):
            self.sides[side] = {key: find(BODY[key], side) for key in ("shoulder", "elbow", "hand", "knee", "foot", "toe")}
        self.places, self.turns = bvh.world()
        self.places = self.places * metres

    def toes(self):
        joints = [side["toe"] if side["toe"] is not None else side["foot"] for side in self.sides.values()]
        return [joint for joint in joints if joint is not None]

    def contacts(self, rate, least=0.35):
        """The spans in which a toe is slow and low, as (joint, first, last)."""
        found = []
        for joint in self.toes():
            at = self.places[:, joint]
            speed = np.linalg.norm(np.gradient(at, axis=0), axis=1) * rate
            low = at[:, 1] < np.percentile(at[:, 1], 5) + 0.03
            still = (speed < 0.15) & low
            start = None
            for frame, value in enumerate(list(still) + [False]):
                if value and start is None:
                    start = frame
                elif not value and start is not None:
                    if frame - start >= least * rate:
                        found.append((joint, start, frame - 1))
                    start = None
        return found


class Planted(Exception):
    """The kind of defect cannot be planted in the clip."""


def span(rng, bvh, shortest, longest, margin=0.15, most=0.33):
    rate = 1 / bvh.frame_time
    # A value in half of a clip or more counts as usual for the clip.
    longest = min(longest, most * len(bvh.rows) / rate)
    if longest < shortest:
        raise Planted
    length = round(rng.uniform(shortest, longest) * rate)
    room = len(bvh.rows) - length - 2 * round(margin * rate)
    if room < 1:
        raise Planted
    start = round(margin * rate) + rng.randrange(room)
    return start, start + length


def root_columns(bvh):
    columns = {c[0].lower(): bvh.first[0] + i for i, c in enumerate(bvh.channels[0]) if c.lower().endswith("position")}
    return columns["x"], columns["y"], columns["z"]


def bump(frames, start, end, ramp):
    """1 from start to end, ramps before and after, and 0 elsewhere."""
    at = np.arange(frames)
    rise = np.clip((at - (start - ramp)) / max(ramp, 1), 0, 1)
    fall = np.clip(((end - 1 + ramp) - at) / max(ramp, 1), 0, 1)
    smooth = lambda v: v * v * (3 - 2 * v)
    return smooth(np.minimum(rise, fall))


def lift(rng, bvh, metres, low, high, shortest, longest, ramp=0.1):
    start, end = span(rng, bvh, shortest, longest, 0.3)
    amount = rng.uniform(low, high)
    _, y, _ = root_columns(bvh)
    bvh.rows[:, y] += amount / metres * bump(len(bvh.rows), start, end, max(1, round(ramp / bvh.frame_time)))
    return [start, end - 1], amount


def frozen(rng, bvh, metres):
    start, end = span(rng, bvh, 0.6, 2.0)
    bvh.rows[start:end] = bvh.rows[start]
    return [start, end - 1], (end - start) * bvh.frame_time


def gap(rng, bvh, metres):
    start, end = span(rng, bvh, 0.6, 2.0)
    steps = np.abs(np.diff(bvh.rows, axis=0))
    moving = [
        joint
        for joint in range(1, len(bvh.names))
        if bvh.columns(joint, "rotation") and (steps[:, bvh.columns(joint, "rotation")].max(axis=1) > 0.01).mean() > 0.9
    ]
    if not moving:
        raise Planted
    joint = rng.choice(moving)
    columns = bvh.columns(joint, "rotation")
    # If the joint ends where it was held, it has missed no motion.
    jump = np.abs(bvh.rows[end, columns] - bvh.rows[start, columns]).max()
    if jump < max(3, 6 * np.median(steps[:, columns].max(axis=1))):
        raise Planted
    bvh.rows[start:end, columns] = bvh.rows[start, columns]
    return [start, end - 1], (end - start) * bvh.frame_time


def breathing(rng, bvh, metres):
    body = Body(bvh, metres)
    joint = rng.choice([side[key] for side in body.sides.values() for key in ("elbow", "hand", "knee", "foot") if side[key]])
    if len(bvh.channels[joint]) != 3:
        raise Planted
    start, end = span(rng, bvh, 0.3, 1.5)
    amount = rng.uniform(0.05, 0.2)
    ramp = round(0.1 / bvh.frame_time)
    factor = 1 + amount * bump(len(bvh.rows), start, end, ramp)
    at = bvh.first[joint]
    bvh.rows = np.insert(bvh.rows, [at, at, at], factor[:, None] * bvh.offsets[joint][None], axis=1)
    lines = bvh.head.splitlines()
    number = -1
    for index, line in enumerate(lines):
        if line.strip().startswith("CHANNELS"):
            number += 1
            if number == joint:
                rest = line.split()[2:]
                lines[index] = "CHANNELS 6 Xposition Yposition Zposition " + " ".join(rest)
    bvh.head = "\n".join(lines) + "\n"
    return [start, end - 1], 100 * amount


def t_pose(rng, bvh, metres):
    start, end = span(rng, bvh, 0.1, 0.6)
    rotations = [c for joint in range(len(bvh.names)) for c in bvh.columns(joint, "rotation")]
    bvh.rows[start:end, rotations] = 0
    body = Body(bvh, metres)
    side = body.sides["left"]
    arm = body.places[start, side["hand"]] - body.places[start, side["shoulder"]]
    shin = body.places[start, side["foot"]] - body.places[start, side["knee"]]
    if abs(arm[1]) > 0.1 * np.linalg.norm(arm) or -shin[1] < 0.92 * np.linalg.norm(shin):
        raise Planted
    across = body.places[start, side["knee"]] - body.places[start, body.sides["right"]["knee"]]
    if arm.dot(across) < 0.97 * np.linalg.norm(arm) * np.linalg.norm(across):
        raise Planted
    return [start, end - 1], (end - start) * bvh.frame_time


def skate(rng, bvh, metres):
    body, rate = Body(bvh, metres), 1 / bvh.frame_time
    contacts = [c for c in body.contacts(rate) if c[1] > 3 and c[2] < len(bvh.rows) - 4]
    if not contacts:
        raise Planted
    joint, start, end = rng.choice(contacts)
    amount, angle = rng.uniform(0.10, 0.3), rng.uniform(0, 2 * math.pi)
    at = np.clip((np.arange(len(bvh.rows)) - start) / (end - start), 0, 1)
    x, _, z = root_columns(bvh)
    bvh.rows[:, x] += amount / metres * math.cos(angle) * at
    bvh.rows[:, z] += amount / metres * math.sin(angle) * at
    return [start, end], 100 * amount


def floating(rng, bvh, metres):
    frames, amount = lift(rng, bvh, metres, 0.08, 0.14, 0.5, 1.5)
    return frames, 100 * amount


def under_floor(rng, bvh, metres):
    body = Body(bvh, metres)
    heights = body.places[:, body.toes(), 1].min(axis=1)
    heights -= np.percentile(heights, 10)
    frames, amount = lift(rng, bvh, metres, -0.12, -0.06, 0.3, 0.8)
    # A foot in the air is above the floor even if the body is sunk.
    if np.mean(heights[frames[0] : frames[1] + 1] < 0.03) < 0.5:
        raise Planted
    return frames, -100 * amount


def no_support(rng, bvh, metres):
    frames, amount = lift(rng, bvh, metres, 0.3, 0.6, 0.9, 1.8)
    return frames, (frames[1] - frames[0]) * bvh.frame_time


def treadmill(rng, bvh, metres):
    x, _, z = root_columns(bvh)
    seconds = len(bvh.rows) * bvh.frame_time
    path = np.hypot(np.diff(bvh.rows[:, x]), np.diff(bvh.rows[:, z])).sum() * metres
    if seconds < 2.5 or path / seconds < 0.6:
        raise Planted
    # Steps: the feet pass each other along the path.
    body = Body(bvh, metres)
    left, right = (body.places[:, side["foot"]] for side in body.sides.values())
    along = bvh.rows[-1, [x, z]] - bvh.rows[0, [x, z]]
    apart = (left - right)[:, [0, 2]] @ along / np.linalg.norm(along)
    sides = [1 if a > 0.2 else -1 for a in apart if abs(a) > 0.2]
    if sum(a != b for a, b in zip(sides, sides[1:])) < 3:
        raise Planted
    for column in (x, z):
        # The rest of the path is its sway about a mean over one second.
        width = max(3, round(1 / bvh.frame_time)) | 1
        padded = np.pad(bvh.rows[:, column], width // 2, mode="reflect", reflect_type="odd")
        trend = np.convolve(padded, np.ones(width) / width, mode="valid")
        bvh.rows[:, column] += trend[0] - trend
    return [0, len(bvh.rows) - 1], seconds


def self_collision(rng, bvh, metres):
    body = Body(bvh, metres)
    side = rng.choice([side for side in body.sides.values() if side["hand"]])
    start, end = span(rng, bvh, 0.3, 1.0)
    for frame in range(start, end):
        places, turns = body.places[frame], body.turns[frame]
        target = places[body.hips] + 0.45 * (places[body.neck] - places[body.hips])
        shoulder, elbow, hand = (places[side[key]] for key in ("shoulder", "elbow", "hand"))
        upper, lower = np.linalg.norm(elbow - shoulder), np.linalg.norm(hand - elbow)
        reach = np.linalg.norm(target - shoulder)
        if not abs(upper - lower) < reach < upper + lower:
            raise Planted
        along = (target - shoulder) / reach
        bend = elbow - shoulder - (elbow - shoulder).dot(along) * along
        bend /= np.linalg.norm(bend)
        cosine = (upper**2 + reach**2 - lower**2) / (2 * upper * reach)
        new_elbow = shoulder + upper * (cosine * along + math.sqrt(1 - cosine**2) * bend)
        first = arc(elbow - shoulder, new_elbow - shoulder) @ turns[side["shoulder"]]
        parent = turns[bvh.parents[side["shoulder"]]]
        bvh.set_local(side["shoulder"], frame, parent.T @ first)
        carried = first @ turns[side["shoulder"]].T
        second = arc(carried @ (hand - elbow), target - new_elbow) @ carried @ turns[side["elbow"]]
        if bvh.parents[side["elbow"]] != side["shoulder"] or bvh.parents[side["hand"]] != side["elbow"]:
            raise Planted
        bvh.set_local(side["elbow"], frame, first.T @ second)
    return [start, end - 1], 10.0


def arc(a, b):
    a, b = a / np.linalg.norm(a), b / np.linalg.norm(b)
    axis, cosine = np.cross(a, b), float(np.dot(a, b))
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + k + k @ k / (1 + cosine)


def clipped_end(rng, bvh, metres):
    _, y, _ = root_columns(bvh)
    seconds, amount = rng.uniform(0.15, 0.25), rng.uniform(0.18, 0.4)
    frames = max(2, round(seconds / bvh.frame_time))
    bvh.rows[-frames:, y] += amount / metres * np.linspace(0, 1, frames)
    return [len(bvh.rows) - 1] * 2, 100 * amount


def scaled(bvh, times):
    """Puts a clip in another unit."""
    bvh.head = re.sub(
        r"(OFFSET\s+)(\S+)\s+(\S+)\s+(\S+)",
        lambda m: m[1] + " ".join(f"{float(m[i]) * times:.7f}" for i in (2, 3, 4)),
        bvh.head,
    )
    for joint in range(len(bvh.names)):
        bvh.rows[:, bvh.columns(joint, "position")] *= times


def odd_unit(rng, bvh, metres):
    times = rng.choice([2.54, 10.0, 100.0])
    scaled(bvh, times)
    return [0, len(bvh.rows) - 1], times


def odd_axis(rng, bvh, metres):
    x, y, z = root_columns(bvh)
    bvh.rows[:, [y, z]] = np.stack([-bvh.rows[:, z], bvh.rows[:, y]], axis=1)
    quarter = axis_rotation(0, np.array([math.pi / 2]))[0]
    _, turns = bvh.world()
    for frame in range(len(bvh.rows)):
        bvh.set_local(0, frame, quarter @ turns[frame, 0])
    return [0, len(bvh.rows) - 1], 90.0


def not_finite(rng, bvh, metres):
    frame = rng.randrange(2, len(bvh.rows) - 2)
    bvh.rows[frame, rng.randrange(3, bvh.rows.shape[1])] = math.nan
    return [0, len(bvh.rows) - 1], 1.0


def doubled(rng, bvh, metres):
    frame = rng.randrange(20, len(bvh.rows) - 20)
    moves(bvh, frame)
    bvh.rows = np.insert(bvh.rows, frame, bvh.rows[frame - 1], axis=0)
    return [frame, frame], 1.0


def dropped(rng, bvh, metres):
    frame = rng.randrange(20, len(bvh.rows) - 20)
    moves(bvh, frame)
    bvh.rows = np.delete(bvh.rows, frame, axis=0)
    return [frame, frame], 1.0


def moves(bvh, frame):
    """Refuses a frame around which hardly anything moves, because a repeated frame is not visible there."""
    steps = np.abs(np.diff(bvh.rows[frame - 5 : frame + 5, 3:], axis=0)).max(axis=1) / bvh.frame_time
    if steps.min() < 60:
        raise Planted


def flip(rng, bvh, metres):
    joints = [joint for joint in range(1, len(bvh.names)) if len(bvh.columns(joint, "rotation")) == 3]
    joint = rng.choice(joints)
    start, end = span(rng, bvh, 0.05, 0.8)
    column = rng.choice(bvh.columns(joint, "rotation"))
    bvh.rows[start:end, column] += 180
    return [start, end - 1], end - start


def exchanged(rng, bvh, metres):
    """Exchanges the rotations of both legs where they differ by 30 degrees and by more than the change between two
    frames."""
    body = Body(bvh, metres)
    start, end = span(rng, bvh, 0.1, 0.6)
    left, right = (legs(bvh, body, side) for side in ("left", "right"))
    pairs = list(zip(left, right))
    if any(bvh.channels[a] != bvh.channels[b] for a, b in pairs):
        raise Planted
    apart = np.zeros(end - start)
    for a, b in pairs:
        columns = bvh.columns(a, "rotation"), bvh.columns(b, "rotation")
        apart = np.maximum(apart, np.abs(bvh.rows[start:end, columns[0]] - bvh.rows[start:end, columns[1]]).max(axis=1))
    # If legs move more between two frames than they differ, the exchange is ambiguous.
    columns = [c for joint in left + right for c in bvh.columns(joint, "rotation")]
    step = np.abs(np.diff(bvh.rows[max(0, start - 5) : end + 5, columns], axis=0)).max()
    if apart[[0, -1]].min() < max(30, step):
        raise Planted
    for a, b in pairs:
        one, two = bvh.columns(a, "rotation"), bvh.columns(b, "rotation")
        swapped = bvh.rows[start:end, one].copy()
        bvh.rows[start:end, one] = bvh.rows[start:end, two]
        bvh.rows[start:end, two] = swapped
    return [start, end - 1], end - start


def legs(bvh, body, side):
    """The joints of a leg, from the hip to the foot."""
    foot, chain = body.sides[side]["foot"], []
    while foot != body.hips and foot >= 0 and len(chain) < 3:
        chain.append(foot)
        foot = bvh.parents[foot]
    return chain[::-1]


def beyond_range(rng, bvh, metres):
    """A knee that bends forwards by 25 to 60 degrees, about the axis about which it bends elsewhere in the clip."""
    body = Body(bvh, metres)
    side = body.sides[rng.choice(["left", "right"])]
    knee, foot, hip = side["knee"], side["foot"], bvh.parents[side["knee"]]
    start, end = span(rng, bvh, 0.2, 1.0)
    thigh, shin = (body.places[:, knee] - body.places[:, hip]), (body.places[:, foot] - body.places[:, knee])
    cross = np.cross(thigh, shin) / (np.linalg.norm(thigh, axis=1) * np.linalg.norm(shin, axis=1))[:, None]
    most = int(np.linalg.norm(cross, axis=1).argmax())
    if np.linalg.norm(cross[most]) < 0.5:
        raise Planted
    axis = body.turns[most, hip].T @ cross[most] / np.linalg.norm(cross[most])
    amount = rng.uniform(25, 60)
    for frame in range(start, end):
        bent = math.degrees(math.asin(min(1.0, np.linalg.norm(cross[frame]))))
        turn = rotation_about(axis, -math.radians(bent + amount))
        local = body.turns[frame, hip].T @ body.turns[frame, knee]
        bvh.set_local(knee, frame, turn @ local)
    return [start, end - 1], amount


def rotation_about(axis, angle):
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def tilted(rng, bvh, metres):
    """Tilts the world by 4 to 8 degrees across the path of a clip that moves by two metres or more."""
    x, y, z = root_columns(bvh)
    path = bvh.rows[:, [x, z]] * metres
    along = path[-1] - path[0]
    if np.linalg.norm(along) < 2:
        raise Planted
    amount, angle = rng.uniform(4, 8), rng.uniform(-0.5, 0.5)
    along = along / np.linalg.norm(along)
    axis = rotation_about(np.array([0.0, 1.0, 0.0]), angle) @ np.array([along[1], 0.0, -along[0]])
    turn = rotation_about(axis, math.radians(amount))
    _, turns = bvh.world()
    bvh.rows[:, [x, y, z]] = bvh.rows[:, [x, y, z]] @ turn.T
    for frame in range(len(bvh.rows)):
        bvh.set_local(0, frame, turn @ turns[frame, 0])
    return [0, len(bvh.rows) - 1], amount


def height_drift(rng, bvh, metres):
    """A drift in height by 20 to 35 cm over the clip."""
    _, y, _ = root_columns(bvh)
    if len(bvh.rows) * bvh.frame_time < 2:
        raise Planted  # one stance shows no drift
    amount = rng.choice([-1, 1]) * rng.uniform(0.2, 0.35)
    at = np.linspace(0, 1, len(bvh.rows))
    bvh.rows[:, y] += amount / metres * at
    return [0, len(bvh.rows) - 1], 100 * abs(amount)


def noise(rng, bvh, metres):
    degrees = rng.uniform(1.5, 3)
    columns = [c for joint in range(1, len(bvh.names)) for c in bvh.columns(joint, "rotation")]
    random = np.random.default_rng(rng.randrange(1 << 30))
    bvh.rows[:, columns] += random.normal(0, degrees, (len(bvh.rows), len(columns)))
    return [0, len(bvh.rows) - 1], degrees


def cut_off(rng, bvh, metres):
    bvh.stated = len(bvh.rows)
    bvh.rows = bvh.rows[: round(rng.uniform(0.3, 0.9) * len(bvh.rows))]
    return [len(bvh.rows) - 1] * 2, 100 * (1 - len(bvh.rows) / bvh.stated)


def no_motion(rng, bvh, metres):
    bvh.rows[:] = bvh.rows[len(bvh.rows) // 2]
    return [0, len(bvh.rows) - 1], len(bvh.names)


def feet_pass(bvh, metres):
    """The speed in m/s relative to the hips that the faster foot exceeds in a tenth of the frames."""
    body = Body(bvh, metres)
    feet = [side["foot"] for side in body.sides.values()]
    if None in feet:
        return 0.0
    steps = np.diff(body.places[:, feet] - body.places[:, [body.hips]], axis=0)
    return np.percentile(np.linalg.norm(steps, axis=2).max(axis=1), 90) / bvh.frame_time


def wrong_rate(rng, bvh, metres):
    # Four or five times too fast, or one frame per second, as if a writer lost the frame time.
    fast = rng.choice([4.0, 5.0, None])
    # The feet of sprinters pass the hips at 10 m/s. A slow walk at four times its speed stays below this.
    if fast and fast * feet_pass(bvh, metres) < 10:
        raise Planted
    times = fast or 1 / bvh.frame_time
    bvh.frame_time = bvh.frame_time / fast if fast else 1.0
    return [0, len(bvh.rows) - 1], times


def foot_through_floor(rng, bvh, metres):
    body, rate = Body(bvh, metres), 1 / bvh.frame_time
    sides = [side for side in body.sides.values() if side["foot"] is not None and side["toe"] is not None]
    if len(sides) < 2 or any(bvh.parents[side["toe"]] != side["foot"] for side in sides):
        raise Planted
    contacts = [c for c in body.contacts(rate, 0.3) if c[1] > 3 and c[2] < len(bvh.rows) - 4]
    # The toes of one foot point down while the toes of the other stand.
    rng.shuffle(contacts)
    for joint, first, last in contacts:
        side = next(side for side in sides if side["toe"] != joint)
        floor = np.percentile(body.places[:, side["toe"], 1], 5)
        length = np.linalg.norm(body.places[first, side["toe"]] - body.places[first, side["foot"]])
        low = [frame for frame in range(first, last) if body.places[frame, side["foot"], 1] - length < floor - 0.05]
        if len(low) >= 0.2 * rate and low[-1] - low[0] + 1 == len(low):
            for frame in low:
                foot = body.turns[frame, side["foot"]]
                toes = body.places[frame, side["toe"]] - body.places[frame, side["foot"]]
                parent = body.turns[frame, bvh.parents[side["foot"]]]
                bvh.set_local(side["foot"], frame, parent.T @ arc(toes, np.array([0, -1.0, 0.02])) @ foot)
            return [low[0], low[-1]], 5.0
    raise Planted


KINDS = {
    "cut-off": cut_off,
    "no-motion": no_motion,
    "wrong-rate": wrong_rate,
    "foot-through-floor": foot_through_floor,
    "doubled": doubled,
    "dropped": dropped,
    "flip": flip,
    "exchanged": exchanged,
    "noise": noise,
    "not-finite": not_finite,
    "frozen": frozen,
    "gap": gap,
    "breathing": breathing,
    "t-pose": t_pose,
    "skate": skate,
    "floating": floating,
    "under-floor": under_floor,
    "no-support": no_support,
    "treadmill": treadmill,
    "tilted": tilted,
    "height-drift": height_drift,
    "beyond-range": beyond_range,
    "self-collision": self_collision,
    "clipped-end": clipped_end,
    "odd-unit": odd_unit,
    "odd-axis": odd_axis,
}
# Kinds whose place must be found within two frames: they begin and end abruptly, without a ramp or a window.
HAS_PLACE = ["doubled", "dropped", "flip", "exchanged", "frozen", "gap", "t-pose", "self-collision", "clipped-end"]
# Kinds whose ramps and contacts blur the place: the found span must cover half of the planted span.
OVERLAPS = ["breathing", "skate", "floating", "under-floor", "foot-through-floor", "no-support", "treadmill"]


def mirrored(rng, bvh):
    """Exchanges left and right, for skeletons that are symmetric about x and whose joint axes are the world's axes."""
    names = [name.lower() for name in bvh.names]
    other = {}
    for joint, name in enumerate(names):
        twin = name.replace("left", "\0").replace("right", "left").replace("\0", "right")
        exchange = {"l": "r", "r": "l"}
        if twin == name and name[-2:] in ("_l", "_r"):
            twin = name[:-1] + exchange[name[-1]]
        if twin == name and name[0] in "lr":
            twin = exchange[name[0]] + name[1:]
        other[joint] = names.index(twin) if twin in names else joint
        if np.abs(bvh.offsets[other[joint]] * [-1, 1, 1] - bvh.offsets[joint]).max() > 0.05 * (1 + np.abs(bvh.offsets[joint]).max()):
            raise Planted
    # Other kinds of names: if the names have no sides to exchange, left and right of the body would be wrong.
    if all(joint == twin for joint, twin in other.items()):
        raise Planted
    rows = bvh.rows.copy()
    for joint, twin in other.items():
        if bvh.channels[joint] != bvh.channels[twin]:
            raise Planted
        for i, channel in enumerate(bvh.channels[joint]):
            negate = channel.lower() in ("xposition", "yrotation", "zrotation")
            rows[:, bvh.first[joint] + i] = bvh.rows[:, bvh.first[twin] + i] * (-1 if negate else 1)
    places, _ = bvh.world()
    bvh.rows = rows
    # With other joint axes, exchanged numbers do not mirror the motion.
    made, _ = bvh.world()
    off = np.abs(made - places[:, [other[joint] for joint in range(len(names))]] * [-1, 1, 1])
    if off.max() > 0.01 * np.ptp(places.reshape(-1, 3), axis=0).max():
        raise Planted


def retimed(rng, bvh):
    bvh.frame_time *= rng.choice([rng.uniform(0.91, 0.96), rng.uniform(1.04, 1.1)])


def other_rate(rng, bvh):
    stride = rng.choice([2, 3, 4] if bvh.frame_time < 0.015 else [2])
    bvh.rows = bvh.rows[::stride]
    bvh.frame_time *= stride


def other_skeleton(rng, bvh):
    """Changes the lengths of bones and the size, and keeps the motion of the joints."""
    size = rng.uniform(0.8, 1.25)
    factors = {}

    def scaled(match):
        numbers = [float(match[i]) for i in (2, 3, 4)]
        # One factor for each length, so that left and right stay equal.
        factor = size * factors.setdefault(round(math.hypot(*numbers), 1), rng.uniform(0.88, 1.12))
        return match[1] + " ".join(f"{number * factor:.5f}" for number in numbers)

    bvh.head = re.sub(r"(OFFSET\s+)(\S+)\s+(\S+)\s+(\S+)", scaled, bvh.head)
    bvh.rows[:, root_columns(bvh)] *= size


def piece(rng, bvh):
    start, end = span(rng, bvh, 2.1, 0.8 * len(bvh.rows) * bvh.frame_time, 0, 0.8)
    bvh.rows = bvh.rows[start:end]


def same_motion(rng, bvh):
    bvh.rows = np.round(bvh.rows, 3)


def same_bytes(rng, bvh):
    pass


def trembling(rng, bvh):
    """Noise of up to a degree in every rotation."""
    columns = [c for joint in range(1, len(bvh.names)) for c in bvh.columns(joint, "rotation")]
    random = np.random.default_rng(rng.randrange(1 << 30))
    bvh.rows[:, columns] += random.normal(0, rng.uniform(0.2, 1.0), (len(bvh.rows), len(columns)))


def other_unit(rng, bvh):
    odd_unit(rng, bvh, 1.0)


def resampled(rng, bvh):
    """Resamples to a rate that is no simple fraction of the original rate."""
    rate = rng.choice([24, 25, 30, 50])
    seconds = (len(bvh.rows) - 1) * bvh.frame_time
    at = np.arange(int(seconds * rate) + 1) / rate / bvh.frame_time
    before = np.minimum(at.astype(int), len(bvh.rows) - 2)
    fraction = (at - before)[:, None]
    rows = bvh.rows.copy()
    angles = [c for joint in range(len(bvh.names)) for c in bvh.columns(joint, "rotation")]
    rows[:, angles] = np.degrees(np.unwrap(np.radians(rows[:, angles]), axis=0))
    if np.abs(np.diff(rows[:, angles], axis=0)).max() > 60:
        raise Planted  # no mean of two angles that wrap around
    bvh.rows = rows[before] * (1 - fraction) + rows[before + 1] * fraction
    bvh.frame_time = 1 / rate


def vertical(bvh):
    """The axis along which the trunk is longest, at rest and in the median of the frames."""
    rest = bvh.copy()
    rest.rows = np.zeros((1, bvh.rows.shape[1]))
    axes = set()
    for body in Body(rest, 1.0), Body(bvh, 1.0):
        if body.neck is None:
            raise Planted
        trunk = np.median(np.abs(body.places[:, body.neck] - body.places[:, body.hips]), axis=0)
        axes.add(int(trunk.argmax()))
    if len(axes) > 1:
        raise Planted
    return axes.pop()


def elsewhere(rng, bvh):
    """Rotates about the vertical and moves the whole clip."""
    columns, axis = root_columns(bvh), vertical(bvh)
    turn = rotation_about(np.eye(3)[axis], rng.uniform(-math.pi, math.pi))
    _, turns = bvh.world()
    bvh.rows[:, columns] = bvh.rows[:, columns] @ turn.T
    bvh.rows[:, [column for column in columns if column != columns[axis]]] += [rng.uniform(-50, 50), rng.uniform(-50, 50)]
    for frame in range(len(bvh.rows)):
        bvh.set_local(0, frame, turn @ turns[frame, 0])


def together(*changes):
    def change(rng, bvh):
        for one in changes:
            one(rng, bvh)

    return change


TWINS = {
    "bytes": same_bytes,
    "motion": same_motion,
    "mirrored": mirrored,
    "retimed": retimed,
    "rate": other_rate,
    "resampled": resampled,
    "skeleton": other_skeleton,
    "piece": piece,
    "noise": trembling,
    "unit": other_unit,
    "elsewhere": elsewhere,
    "piece-skeleton": together(piece, other_skeleton),
    "piece-rate": together(piece, other_rate),
    "retimed-noise": together(retimed, trembling),
    "mirrored-piece": together(mirrored, piece),
}
