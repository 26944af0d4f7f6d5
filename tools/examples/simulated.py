"""Judges examples/simulated: which robots stand, which fall, and that no external force acts unless the caller requests
it."""

import pathlib
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET

import mocap
import numpy as np

EXAMPLE = pathlib.Path(__file__).resolve().parents[2] / "examples/simulated"
sys.path.insert(0, str(EXAMPLE))
from body import MJCF, URDF, Body, Disturbances, load_gains  # noqa: E402
from simulate import CLIPS, reference  # noqa: E402

# The allowed error of the floor's mean force while the robot stands, as a fraction of the weight.
WEIGHT_OFF = 0.05


def main():
    gains, body = load_gains(), Body()
    # The efforts come from the unchanged file. The mass comes from the URDF, which MuJoCo does not read here.
    limits = {joint.get("name"): joint.get("actuatorfrcrange") for joint in ET.parse(MJCF).getroot().iter("joint")}
    efforts = [float(limits[name].split()[1]) for name in body.names]
    assert np.array_equal(body.efforts, efforts), "efforts differ from those of the MJCF"
    mass = sum(float(mass.get("value")) for mass in ET.parse(URDF).getroot().iter("mass"))
    assert abs(body.weight - 9.81 * mass) < 0.1, "masses of the MJCF and the URDF differ"

    still = reference(None)
    stands = body.simulate(still, 0.0, gains)
    row = stands.row()
    print("stand:", row)
    assert not stands.fell and row["seconds"] == row["of"] == 30.0
    assert abs(row["contact_per_weight"] - 1) < WEIGHT_OFF and row["largest_effort"] <= 1 and row["help_largest"] == 0

    walk = reference(*CLIPS["walk"])
    rows = [body.simulate(walk, most, gains).row() for most in (0.0, 0.1, 1.0)]
    for row, most in zip(rows, (0.0, 0.1, 1.0)):
        print(f"walk with help of {most}:", row)
        assert row["help_largest"] <= most + 1e-6 and row["largest_effort"] <= 1 + 1e-6
    assert rows[2]["seconds"] == rows[2]["of"], "with its whole weight as help the robot falls"
    short = reference(None, seconds=4.0)
    fall = lambda **disturbances: Body(Disturbances(**disturbances)).simulate(short, 0.0, gains).fell
    assert not fall(push=(1.0, 2.0, 0.0)) and fall(push=(1.0, 200.0, 0.0)), "a push does nothing, or all"
    slides = Body(Disturbances(friction=0.02)).simulate(walk, 0.0, gains, measure=False).seconds
    print(f"walk on a floor of friction 0.02: {slides:.2f} s upright")
    assert slides != rows[0]["seconds"], "friction does nothing"
    free = body.simulate(walk, 1.0, gains)
    stopped = Body(Disturbances(box=(0.6, 0.0, 0.3))).simulate(walk, 1.0, gains)
    assert not np.allclose(free.qpos[-1], stopped.qpos[-1]), "a box in the way does nothing"

    with tempfile.TemporaryDirectory() as folder:
        files = [pathlib.Path(folder) / name for name in ("a.npz", "b.npz")]
        for file in files:
            subprocess.run(
                [sys.executable, EXAMPLE / "simulate.py", "walk", "-o", file], check=True, capture_output=True
            )
        assert files[0].read_bytes() == files[1].read_bytes(), "two simulations of one motion differ"
        bvh = pathlib.Path(folder) / "a.bvh"
        subprocess.run(
            [sys.executable, "-m", "mocap", "convert", files[0], bvh, "--body", URDF, "--quiet"], check=True
        )
        # The pelvis of the file is at its position in the simulation; MuJoCo's +Z is mocap's +Y.
        there, here = mocap.read(bvh).to_numpy(out_unit="m", out_up="z").positions, np.load(files[0])["qpos"]
        assert len(there) == len(here)


main()
print("examples/simulated: 0 failed")
