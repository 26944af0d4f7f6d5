"""Compares the gait events that mocap finds in runs with the flight phases of the body: runs.py MOCAP RUN.bvh ...

A force for each contact, a half sine with two harmonics, is fitted to the height of the centre of mass; in flight the
force is 0. So the truth comes from Newton's law. It uses the feet only to determine which foot is on the ground. For
CMU's BVH files of 120 Hz.
"""

import json
import pathlib
import subprocess
import sys

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import butter, filtfilt

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "clean"))
import bvh  # noqa: E402

GRAVITY = 9.81
LEG = 0.85  # m, which gives the unit of a file
STEP = 5e-4  # s, of the integration
APART = 150  # ms; events farther apart than this are different events
# Segments: upper joint, lower joint, mass, position of the centre between them (de Leva, J. Biomech. 29, 1996).
MIDDLE = [("Neck", "Head", 0.0694, 0.5), ("Hips", "Neck", 0.4346, 0.45)]
SIDED = [("Arm", "ForeArm", 0.0271, 0.577), ("ForeArm", "Hand", 0.0162, 0.457), ("Hand", "Hand", 0.0061, 0.0),
         ("UpLeg", "Leg", 0.1416, 0.41), ("Leg", "Foot", 0.0433, 0.446), ("Foot", "ToeBase", 0.0137, 0.5)]


def read(path):
    motion = bvh.read(path)
    places = dict(zip(motion.names, motion.positions().transpose(1, 0, 2)))
    length = sum(np.linalg.norm(places["Left" + a][0] - places["Left" + b][0]) for a, b in (("UpLeg", "Leg"), ("Leg", "Foot")))
    return motion.rate, {name: place * LEG / length for name, place in places.items()}


def centre(places):
    """The height of the centre of mass."""
    rows = MIDDLE + [(side + a, side + b, mass, part) for a, b, mass, part in SIDED for side in ("Left", "Right")]
    total = sum(row[2] for row in rows)
    return sum(mass * (places[a] + (places[b] - places[a]) * part) for a, b, mass, part in rows)[:, 1] / total


def contacts(height, rate):
    """The start and the end of each contact, and the RMS of the fit in metres."""
    times, fine = np.arange(len(height)) / rate, np.arange(0, len(height) / rate, STEP)
    smooth = filtfilt(*butter(2, 6 / (rate / 2)), height)
    force = np.gradient(np.gradient(smooth)) * rate * rate / GRAVITY + 1
    near = int(0.15 * rate)
    peaks = [frame for frame in range(len(force)) if force[frame] > 1.3 and force[frame] == force[max(0, frame - near):frame + near + 1].max()]

    def model(values):
        total = np.zeros_like(fine)
        for begin, end, *sizes in values[:-2].reshape(-1, 5):
            phase = (fine - begin) / max(end - begin, 1e-3)
            total += sum(size * np.sin((order + 1) * np.pi * phase) for order, size in enumerate(sizes)) * ((phase > 0) & (phase < 1))
        speed = values[-1] + np.cumsum(total - 1) * GRAVITY * STEP
        return np.interp(times, fine, values[-2] + np.cumsum(speed) * STEP)

    def errors(values):
        shapes = values[:-2].reshape(-1, 5)
        usual = [shapes[:, 3] / 0.4, shapes[:, 4] / 0.3, (shapes[:, 1] - shapes[:, 0] - 0.24) / 0.08]
        return np.concatenate([(model(values) - height) / 0.003, *usual])

    start = [value for frame in peaks for value in (times[frame] - 0.12, times[frame] + 0.12, 2.3, 0, 0)]
    fit = least_squares(errors, [*start, height[0], (smooth[3] - smooth[0]) * rate / 3], loss="soft_l1", max_nfev=80)
    return fit.x[:-2].reshape(-1, 5)[:, :2], np.sqrt(np.mean((model(fit.x) - height) ** 2))


def main():
    program, *paths = sys.argv[1:]
    found = {"heel_strikes": [], "toe_offs": []}
    for path in paths:
        rate, places = read(path)
        truth, rms = contacts(centre(places), rate)
        print(f"{pathlib.Path(path).name}: {len(truth)} contacts, fitted within {rms * 1000:.1f} mm RMS")
        gait = json.loads(subprocess.run([program, "gait", "--json", path], capture_output=True, text=True, check=True).stdout)
        last = len(places["Hips"]) / rate - 0.1
        for begin, end in truth:
            frame = int(np.clip((begin + end) / 2 * rate, 0, len(places["Hips"]) - 1))
            side = min("Left", "Right", key=lambda side: places[side + "Foot"][frame, 1])
            for kind, time in (("heel_strikes", begin), ("toe_offs", end)):
                events = np.array(gait[side.lower()][kind])
                if 0.1 < time < last and len(events):
                    off = (events - time)[np.argmin(np.abs(events - time))] * 1000
                    is_found = abs(off) < APART
                    if is_found:
                        found[kind].append(off)
                    print(f"  {side:5} {kind:12} {time:.3f} s, mocap {off:+.0f} ms" if is_found else f"  {side:5} {kind:12} {time:.3f} s, not found")
    for kind, off in found.items():
        print(f"{kind}: {np.median(off):+.0f} ms in the median, {np.median(np.abs(off)):.0f} ms without sign, at most {np.abs(off).max():.0f} ms")


if __name__ == "__main__":
    main()
