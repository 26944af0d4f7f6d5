"""Compares hip, knee and ankle angles of a walk solved by mocap with OpenSim's inverse kinematics of the same markers
on a model with ten degrees of freedom. The licence does not allow copies of the data. The argument is the folder with
gait10dof_static.trc, gait10dof_walk.trc and gait10dof_walk_IK.mot of opensim-org/opensim-models.
"""

import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from judge import solve
from scipy.spatial.transform import Rotation

ANGLE = 5.0  # degrees, RMS about the constant offset between the axes of the two models


def mot(path):
    lines = open(path).read().split("\n")
    head = next(index for index, line in enumerate(lines) if line.strip() == "endheader")
    names = lines[head + 1].split()
    rows = np.array([[float(word) for word in line.split()] for line in lines[head + 2 :] if line.strip()])
    return dict(zip(names, rows.T))


def angles(mocap, folder):
    """The output of `mocap angles` for the same markers. In OpenSim's model, a bent knee has a negative angle."""
    with tempfile.TemporaryDirectory() as made:
        output = pathlib.Path(made, "angles.mot")
        static = ["--markers", "auto", "--static", folder / "gait10dof_static.trc"]
        subprocess.run([mocap, "angles", folder / "gait10dof_walk.trc", "-o", output, *static, "-q"], check=True)
        columns = mot(output)
    return {name: -values if name.startswith("knee") else values for name, values in columns.items()}


def compared(what, ours, theirs):
    """The joints whose difference from OpenSim exceeds the limit."""
    bad = []
    for name in ("hip_flexion", "knee_angle", "ankle_angle"):
        for side in "lr":
            column = f"{name}_{side}"
            count = min(len(ours[column]), len(theirs[column]))
            off = ours[column][:count] - theirs[column][:count]
            print(f"{what}: {column:15} {off.std():6.2f} degrees RMS about {off.mean():7.2f}")
            if off.std() > ANGLE:
                bad.append(f"{column}: {off.std():.2f} degrees")
    return bad


def main():
    mocap, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    motion, said = solve(mocap, folder / "gait10dof_walk.trc", ["--static", str(folder / "gait10dof_static.trc")])
    print(said.strip())
    theirs = mot(folder / "gait10dof_walk_IK.mot")
    bad = compared("mocap angles", angles(mocap, folder), theirs)
    for name, joint in (("hip_flexion", "UpperLeg"), ("knee_angle", "LowerLeg"), ("ankle_angle", "Foot")):
        for side in ("left", "right"):
            turns = motion.turns[:, motion.names.index(side + joint)]
            # Flexion comes first, about the axis to the left: a negative angle moves a thigh or toes forward and up.
            ours = -np.degrees(np.unwrap(Rotation.from_quat(turns).as_euler("XYZ")[:, 0]))
            other = theirs[f"{name}_{side[0]}"]
            count = min(len(ours), len(other))
            off = ours[:count] - other[:count]
            rms = off.std()
            print(f"{side + ' ' + name:20} {rms:6.2f} degrees RMS about {off.mean():7.2f}; {np.ptp(other):6.1f} in all")
            if rms > ANGLE:
                bad.append(f"{side} {name}: {rms:.2f} degrees")
    if bad:
        sys.exit("above 5 degrees: " + ", ".join(bad))


if __name__ == "__main__":
    main()
