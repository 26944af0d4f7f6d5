"""Makes motions whose hands touch something, with its own forward and inverse kinematics.

The body is 1.75 m tall, in metres, Y up, facing +Z, with a T-pose at rest. Hands come from the sides, touch for two
seconds while the body sways, and go back.
"""

import numpy as np

RATE, X, Y, Z = 60, np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), np.array([0, 0, 1.0])
# Name, parent, offset from the parent.
JOINTS = [("Hips", None, (0, 0.95, 0)), ("Spine", "Hips", (0, 0.1, 0)), ("Chest", "Spine", (0, 0.14, 0)),
          ("Neck", "Chest", (0, 0.25, 0)), ("Head", "Neck", (0, 0.09, 0.01)), ("HeadEnd", "Head", (0, 0.19, 0))]
for side, sign in (("Left", 1), ("Right", -1)):
    JOINTS += [(f"{side}Shoulder", "Chest", (0.03 * sign, 0.2, 0)), (f"{side}Arm", f"{side}Shoulder", (0.14 * sign, 0, 0)),
               (f"{side}ForeArm", f"{side}Arm", (0.29 * sign, 0, 0)), (f"{side}Hand", f"{side}ForeArm", (0.26 * sign, 0, 0)),
               (f"{side}HandEnd", f"{side}Hand", (0.18 * sign, 0, 0)), (f"{side}UpLeg", "Hips", (0.09 * sign, -0.04, 0)),
               (f"{side}Leg", f"{side}UpLeg", (0, -0.43, 0)), (f"{side}Foot", f"{side}Leg", (0, -0.4, 0)),
               (f"{side}Toe", f"{side}Foot", (0, -0.06, 0.13)), (f"{side}ToeEnd", f"{side}Toe", (0, -0.01, 0.07))]
OFFSET = {name: np.array(offset, float) for name, _, offset in JOINTS}
PARENT = {name: parent for name, parent, _ in JOINTS}


def unit(v):
    return v / np.linalg.norm(v)


def about(axis, degrees):
    a, (x, y, z) = np.radians(degrees), unit(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(a) * k + (1 - np.cos(a)) * k @ k


def basis(along, normal):
    """A rotation matrix whose columns are a direction, a normal as near as possible to another, and their product."""
    along = unit(along)
    normal = unit(normal - along * (normal @ along))
    return np.stack([along, normal, np.cross(along, normal)], 1)


def slerp(a, b, t):
    r = a.T @ b
    angle = np.arccos(np.clip((np.trace(r) - 1) / 2, -1, 1))
    if angle < 1e-6:
        return a
    axis = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    return a @ about(axis if np.linalg.norm(axis) > 1e-9 else X, np.degrees(angle) * t)


class Figure:
    """World rotations, and the positions that follow from them."""

    def __init__(self):
        self.turn = {name: np.eye(3) for name in OFFSET}
        self.root = OFFSET["Hips"].copy()

    def at(self, name):
        parent = PARENT[name]
        return self.root if parent is None else self.at(parent) + self.turn[parent] @ OFFSET[name]

    def trunk(self, degrees):
        """Bends forward; the hips bend by half of the angle."""
        for name, part in (("Hips", 0.5), ("Spine", 0.75), ("Chest", 1), ("Neck", 0.8), ("Head", 0.5)):
            self.turn[name] = about(X, degrees * part)
        for side in ("Left", "Right"):
            self.turn[f"{side}Shoulder"] = self.turn["Chest"]

    def limb(self, upper, lower, end, goal, pole):
        """Moves the end of two bones to a goal, with the middle joint towards the pole."""
        start, a, b = self.at(upper), np.linalg.norm(OFFSET[lower]), np.linalg.norm(OFFSET[end])
        way = goal - start
        length = min(np.linalg.norm(way), 0.999 * (a + b))
        along = unit(way)
        aside = unit(pole - along * (pole @ along))
        x = (length**2 + a * a - b * b) / (2 * length)
        middle = start + along * x + aside * np.sqrt(max(a * a - x * x, 0))
        goal = start + along * length
        rest = np.cross(OFFSET[lower], Z if "Arm" in upper else -Z) if "Arm" in upper else np.cross(OFFSET[lower], Z)
        bend = np.cross(middle - start, aside if "Leg" in upper else -aside)
        for name, child, line in ((upper, lower, middle - start), (lower, end, goal - middle)):
            self.turn[name] = basis(line, bend) @ basis(OFFSET[child], rest).T

    def legs(self, feet):
        for side, goal in zip(("Left", "Right"), feet):
            self.limb(f"{side}UpLeg", f"{side}Leg", f"{side}Foot", goal, Z)
            self.turn[f"{side}Foot"] = self.turn[f"{side}Toe"] = np.eye(3)

    def hand(self, side, wrist, fingers, palm, pole):
        self.limb(f"{side}Arm", f"{side}ForeArm", f"{side}Hand", wrist, pole)
        self.turn[f"{side}Hand"] = basis(fingers, palm) @ basis(OFFSET[f"{side}HandEnd"], -Y).T


def ease(t):
    t = np.clip(t, 0, 1)
    return t**3 * (10 - 15 * t + 6 * t * t)


def signs():
    return (("Left", 1), ("Right", -1))


def prayer(figure, sway):
    return {side: (figure.at("Chest") + np.array([0.015 * s, 0.06 + sway, 0.3]), Y + 0.3 * Z, -s * X, s * X - 0.7 * Y)
            for side, s in signs()}


def on_head(figure, sway):
    turn = figure.turn["Head"]
    wrist = figure.at("Head") + turn @ np.array([-0.08, 0.215, 0.02])
    return {"Right": (wrist, turn @ X, turn @ -Y, -X + 0.2 * Z)}


def on_knees(figure, sway):
    found = {}
    for side, s in signs():
        knee, thigh = figure.at(f"{side}Leg"), unit(figure.at(f"{side}Leg") - figure.at(f"{side}UpLeg"))
        above = unit(np.cross(thigh, X) * -1)
        above = above if above[2] > 0 else -above
        found[side] = (knee - 0.08 * thigh + 0.06 * above, thigh, -above, s * X + 0.3 * Z)
    return found


def on_hips(figure, sway):
    turn, middle = figure.turn["Hips"], figure.root - 0.04 * Y
    return {side: (middle + turn @ np.array([0.2 * s, 0.12, -0.04]), np.array([-0.3 * s, -0.5, 0.8]), -s * X, s * X - 0.6 * Z)
            for side, s in signs()}


def standing(contact, bend=0.0, down=0.0):
    """Arms at the sides, the contact from 1.2 to 3.2 s, and arms at the sides again."""
    for frame in range(int(5 * RATE)):
        t = frame / RATE
        part = ease((t - 0.4) / 0.8) - ease((t - 3.2) / 0.8)
        sway = 0.01 * np.sin(2.2 * t)
        figure = Figure()
        figure.root = figure.root + np.array([0.015 * np.sin(1.7 * t), -0.03 - down * part + 0.3 * sway, -0.2 * down * part])
        figure.trunk(4 + bend * part + 100 * sway)
        figure.legs([np.array([0.12, 0.08, 0.0]), np.array([-0.12, 0.08, 0.0])])
        goals = contact(figure, sway)
        for side, s in signs():
            shoulder = figure.at(f"{side}Arm")
            down_at = shoulder + np.array([0.1 * s, -0.5, 0.05])
            rest = (down_at, -Y + 0.1 * Z, -s * X, -Z + 0.3 * s * X)
            goal = goals.get(side, rest)
            # Moves in an arc in front of the body, and to the outside.
            arc = 0.12 * np.sin(np.pi * part) * (Z + 0.8 * s * X)
            turns = [basis(g[1], g[2]) for g in (rest, goal)]
            turn = slerp(*turns, part)
            figure.hand(side, rest[0] + part * (goal[0] - rest[0]) + arc, turn[:, 0], turn[:, 1], rest[3] + part * (goal[3] - rest[3]))
        yield figure


def crawl():
    """On hands and knees, 0.25 m/s."""
    period, step = 1.6, 0.4
    for frame in range(int(6 * RATE)):
        t = frame / RATE
        figure = Figure()
        figure.trunk(84)
        figure.turn["Hips"] = about(X, 74)
        figure.turn["Neck"], figure.turn["Head"] = about(X, 50), about(X, 25)
        figure.root = np.array([0.0, 0.49, step / period * t])
        # A limb stands for 0.7 of a period, then swings ahead.
        def place(phase, ahead):
            cycle = t / period + phase
            whole, part = np.floor(cycle), cycle % 1
            swing = ease((part - 0.7) / 0.3)
            return ahead + step * (whole - phase + swing - 0.35), 0.07 * np.sin(np.pi * np.clip((part - 0.7) / 0.3, 0, 1)) ** 2
        for (side, s), phase in zip(signs(), (0.0, 0.5)):
            z, up = place(phase, 0.5)
            figure.hand(side, np.array([0.17 * s, 0.05 + up, z]), Z, -Y, -Z + 0.4 * s * X)
            z, up = place(phase + 0.5, 0.03)
            hip = figure.at(f"{side}UpLeg")
            knee = np.array([hip[0], 0.055 + 0.4 * up, z])
            line = unit(knee - hip)
            figure.turn[f"{side}UpLeg"] = basis(line, X) @ basis(-Y, X).T
            knee = hip + 0.43 * line
            figure.turn[f"{side}Leg"] = basis(np.array([0, 0.07 - knee[1], -0.4]), X) @ basis(-Y, X).T
            figure.turn[f"{side}Foot"] = figure.turn[f"{side}Toe"] = about(X, 150)
        yield figure


MOTIONS = {
    "prayer": lambda: standing(prayer),
    "head": lambda: standing(on_head),
    "knees": lambda: standing(on_knees, 62, 0.16),
    "hips": lambda: standing(on_hips),
    "crawl": crawl,
}


def bvh(figures):
    """The text of a BVH file, in centimetres."""
    names = [name for name, _, _ in JOINTS if not name.endswith("End")]
    lines, children = ["HIERARCHY"], {}
    for name, parent, _ in JOINTS:
        children.setdefault(parent, []).append(name)
    order = []

    def write(name, depth):
        tab = "\t" * depth
        offset = " ".join(f"{100 * v:.4f}" for v in OFFSET[name])
        if name not in names:
            lines.extend([f"{tab}End Site", f"{tab}{{", f"{tab}\tOFFSET {offset}", f"{tab}}}"])
            return
        order.append(name)
        kind = "ROOT" if PARENT[name] is None else "JOINT"
        channels = "3 Zrotation Xrotation Yrotation"
        if kind == "ROOT":
            channels, offset = "6 Xposition Yposition Zposition Zrotation Xrotation Yrotation", "0 0 0"
        lines.extend([f"{tab}{kind} {name}", f"{tab}{{", f"{tab}\tOFFSET {offset}", f"{tab}\tCHANNELS {channels}"])
        for child in children.get(name, []):
            write(child, depth + 1)
        lines.append(f"{tab}}}")

    write("Hips", 0)
    rows = []
    for figure in figures:
        row = list(100 * figure.root)
        for name in order:
            above = figure.turn[PARENT[name]] if PARENT[name] else np.eye(3)
            m = above.T @ figure.turn[name]
            row += [np.degrees(a) for a in (np.arctan2(-m[0, 1], m[1, 1]), np.arcsin(np.clip(m[2, 1], -1, 1)), np.arctan2(-m[2, 0], m[2, 2]))]
        rows.append(" ".join(f"{value:.5f}" for value in row))
    return "\n".join(lines + ["MOTION", f"Frames: {len(rows)}", f"Frame Time: {1 / RATE:.7f}"] + rows) + "\n"
