"""A small model and a motion of it: `python dancer.py FOLDER` writes dancer.pmx and dancer.vmd, the fixtures of that name."""

import math
import sys
from pathlib import Path

import files

UP, REST = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)
KNEE = ((-math.pi, 0.0, 0.0), (math.radians(-0.5), 0.0, 0.0))
ARMS = math.radians(35)


def turn(axis, degrees):
    half = math.radians(degrees) / 2
    length = math.sqrt(sum(part * part for part in axis))
    return tuple(part / length * math.sin(half) for part in axis) + (math.cos(half),)


def bones():
    """Left-handed, facing -Z, the left hand at +X. The D bones precede the bones from which they inherit, but are in a
    later layer."""
    def bone(name, parent, at, **more):
        made.append({"name": name, "parent": parent, "at": at, **more})

    made = []
    bone("全ての親", None, (0, 0, 0))
    bone("センター", "全ての親", (0, 8, 0))
    bone("グルーブ", "センター", (0, 8.2, 0))
    bone("腰", "グルーブ", (0, 11.6, 0.1))
    bone("下半身", "腰", (0, 12.4, -0.1))
    bone("上半身", "腰", (0, 12.4, -0.1))
    bone("上半身2", "上半身", (0, 13.6, -0.2))
    bone("首", "上半身2", (0, 16.5, 0.2))
    bone("頭", "首", (0, 17.2, 0.0))
    bone("両目", "頭", (0, 20, -0.5))
    for side, letter in ((1, "左"), (-1, "右")):
        def own(name, parent, at, **more):
            parent = letter + parent if any(other["name"] == letter + parent for other in made) else parent
            bone(letter + name, parent, (side * at[0], at[1], at[2]), **more)

        down, out = math.sin(ARMS), math.cos(ARMS)
        own("目", "頭", (0.4, 18.2, -0.6), turns=("両目", 0.5))
        own("肩", "上半身2", (0.4, 15.8, 0.1))
        own("腕", "肩", (1.5, 15.8, 0.2))
        own("腕捩", "腕", (1.5 + 1.5 * out, 15.8 - 1.5 * down, 0.2), flags=0x0400, axis=(side * out, -down, 0))
        own("ひじ", "腕捩", (1.5 + 2.6 * out, 15.8 - 2.6 * down, 0.25), flags=0x0800)
        own("手首", "ひじ", (1.5 + 4.9 * out, 15.8 - 4.9 * down, 0.1))
        own("中指１", "手首", (1.5 + 5.8 * out, 15.8 - 5.8 * down, 0.1))
        own("足D", "下半身", (0.95, 11.0, 0.0), layer=1, turns=(letter + "足", 1.0))
        own("ひざD", "足D", (1.0, 6.2, -0.2), layer=1, turns=(letter + "ひざ", 1.0))
        own("足", "下半身", (0.95, 11.0, 0.0))
        own("ひざ", "足", (1.0, 6.2, -0.2))
        own("足首", "ひざ", (1.05, 1.2, 0.2))
        own("つま先", "足首", (1.05, 0.0, -1.4))
        links = [(letter + "ひざ", KNEE), (letter + "足", None)]
        own("足ＩＫ", "全ての親", (1.05, 1.2, 0.2), ik=(letter + "足首", 40, 2.0, links))
        own("つま先ＩＫ", "足ＩＫ", (1.05, 0.0, -1.4), ik=(letter + "つま先", 3, 4.0, [(letter + "足首", None)]))
    bone("髪", "頭", (0, 19, 1), moves=("左足ＩＫ", 0.1), flags=0x1000)
    bone("長い名前の骨の先", "髪", (0, 18, 1.5))
    return made


MORPHS = ["まばたき", "あ", "にやり"]


def motion():
    slow, fast = (64, 0, 64, 127), (10, 100, 30, 120)
    keys = [
        ("センター", 0, UP, REST, None),
        ("センター", 20, (0.6, -1.4, 0.9), turn((0, 1, 0), 25), files.curves(x=slow, y=fast, z=(127, 0, 0, 127), turn=slow)),
        ("センター", 45, (-0.5, -0.3, -0.4), turn((0, 1, 0), -20), files.curves(turn=fast)),
        ("下半身", 0, UP, REST, None),
        ("下半身", 30, UP, turn((0.2, 1, 0.1), 15), None),
        ("上半身", 0, UP, REST, None),
        ("上半身", 30, UP, turn((1, 0.2, 0.1), 18), files.curves(turn=slow)),
        ("上半身2", 15, UP, turn((0, 1, 0), 20), None),
        ("頭", 10, UP, turn((1, 0, 0), -12), None),
        ("両目", 10, UP, turn((0, 1, 0), 10), None),
        ("左腕", 0, UP, REST, None),
        ("左腕", 25, UP, turn((0.1, 0.3, 1), 70), files.curves(turn=fast)),
        ("左腕捩", 25, UP, turn((math.cos(ARMS), -math.sin(ARMS), 0.3), 30), None),
        ("左ひじ", 25, UP, turn((0, 1, 0), 60), None),
        ("右ひじ", 40, UP, turn((0, -1, 0.2), 95), files.curves(turn=slow)),
        ("右ひじ", 5, UP, REST, None),
        ("左足ＩＫ", 0, UP, REST, None),
        ("左足ＩＫ", 20, (0.8, 2.2, -2.5), turn((1, 0, 0), 20), files.curves(y=fast)),
        ("左足ＩＫ", 45, (0.2, 0.0, 0.8), turn((0, 1, 0), 15), None),
        ("右足ＩＫ", 0, (-0.3, 0, 0.4), turn((0, 1, 0), -20), None),
        ("右足ＩＫ", 45, (-0.3, 0, 0.4), turn((0, 1, 0), -20), None),
        # The later of two keys of a frame counts.
        ("右足ＩＫ", 45, (-0.9, 1.6, 1.9), turn((1, 0, 0), -25), None),
        # The name is longer than its field, which cuts it.
        ("長い名前の骨の先", 30, UP, turn((0, 0, 1), 40), None),
        ("無い骨", 10, (1, 0, 0), REST, None),
        # From frame 50, the keys of the left leg turn it.
        ("左足", 45, UP, REST, None),
        ("左足", 59, UP, turn((1, 0, 0), -35), None),
    ]
    morphs = [("まばたき", 0, 0.0), ("まばたき", 10, 1.0), ("まばたき", 20, 0.0), ("にやり", 30, 0.6), ("あ", 5, 0.0)]
    states = [(0, {"左足ＩＫ": 1, "右足ＩＫ": 1}), (50, {"左足ＩＫ": 0})]
    return keys, morphs, states


def write(folder):
    folder = Path(folder)
    files.pmx(folder / "dancer.pmx", "踊り子", bones(), MORPHS)
    keys, morphs, states = motion()
    files.vmd(folder / "dancer.vmd", "踊り子", keys, morphs, states, cameras=2)


if __name__ == "__main__":
    write(sys.argv[1])
