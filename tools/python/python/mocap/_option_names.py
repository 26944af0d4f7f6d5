# Written by `MOCAP_WRITE=1 cargo test -p mocap-bindings`, from the documentation of Rust: do not edit.
"""Options of jobs and steps that Python spells with an underscore."""

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
