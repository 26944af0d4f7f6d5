#!/usr/bin/env python3
"""Writes the joblib files of fixtures/arrays: motions of the G1 as ASAP and PBHC store them. Needs NumPy and joblib.

All numbers follow from formulas, which src/job/tests/it/arrays/joblib.rs repeats.
"""
import pathlib
import joblib
import numpy as np

OUT = pathlib.Path(__file__).resolve().parents[2] / "fixtures" / "arrays"
JOINTS = 29


def motion(frames, turn, fps, order):
    """A base that moves along +X and turns about +Z by `turn` per frame, and joints that move at different speeds."""
    frame, joint = np.arange(frames)[:, None], np.arange(JOINTS)[None]
    angle = turn * np.arange(frames)
    zero = np.zeros(frames)
    dof = 0.01 * frame + 0.002 * joint
    return {
        "root_trans_offset": np.stack([0.1 * np.arange(frames), zero, zero + 0.8], 1),
        "pose_aa": np.zeros((frames, 1 + JOINTS + 3, 3), np.float32, order),
        "dof": np.asarray(dof, np.float32, order),
        "root_rot": np.stack([zero, zero, np.sin(angle / 2), np.cos(angle / 2)], 1),
        "contact_mask": np.ones((frames, 2), np.float32),
        "fps": fps,
    }


joblib.dump({"step": motion(4, 0.1, 50, "C")}, OUT / "asap_joblib.pkl")
joblib.dump({"left": motion(3, 0.2, np.int64(30), "F"), "right": motion(5, -0.2, 30.0, "C")}, OUT / "asap_joblib_two.pkl")
