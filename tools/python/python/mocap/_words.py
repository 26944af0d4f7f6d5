# Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.
"""Words that options take."""

from typing import Literal

Unit = Literal[
    "m",
    "dm",
    "cmu",
    "inch",
    "cm",
    "mm",
]
Axis = Literal[
    "y",
    "z",
    "-y",
    "-z",
]
Feet = Literal["lock", "free"]
Floor = Literal["auto", "z=0", "keep"]
RobotFormat = Literal[
    "npz",
    "pkl",
    "csv",
    "qpos",
    "gmr",
    "unitree-csv",
    "mjlab",
    "isaaclab",
    "protomotions",
    "mimickit",
    "twist",
    "dynamics",
]

# Options of jobs and steps that Python spells with an underscore.
DASHED = (
    "all-rows",
    "bone-axis",
    "cut-off",
    "drop-first-frame",
    "ease-in",
    "ease-out",
    "fail-on",
    "fbx-rest",
    "fbx-version",
    "in-place",
    "keep-constant",
    "largest-change",
    "max-angle",
    "max-error",
    "names-of-clips",
    "out-unit",
    "out-up",
    "replace-animations",
    "root-offset",
    "shell-distance",
    "skeleton-only",
    "t-pose-first",
    "velocity-limits",
)
