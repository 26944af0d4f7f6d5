"""Places OpenCap's markers on OpenSim's models with OpenSim's kinematics, and compares mocap's angles and joints with
the model's: models.py MOCAP MODELS MOTION.. [--hold]. MODELS is the folder OpenSim_Setup of the package Pose2Sim.
MOTION, any motion file, only moves the model: OpenSim's coordinates and centres are the truth.
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import opensim

from gait import mot
from planted import trc

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "clean"))
import bvh  # noqa: E402

from judge import solve  # noqa: E402

NOISE = 0.001  # m, of each coordinate
ANGLES = 5.0  # degrees, about a constant offset
MODELS = ["Model_Pose2Sim_simple.osim", "Model_Pose2Sim_muscles_flex.osim"]
COMPARED = ["hip_flexion", "knee_angle", "ankle_angle"]
SIDED = ["hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle", "arm_flex", "arm_add", "arm_rot", "elbow_flex", "pro_sup"]
MOVED = ["pelvis_tilt", "pelvis_list", "pelvis_rotation", *(name + side for name in SIDED for side in ("_r", "_l"))]
CENTRES = {"femur": "UpperLeg", "tibia": "LowerLeg", "talus": "Foot", "humerus": "UpperArm", "ulna": "LowerArm"}


def angles(mocap, path, folder, *options):
    out = pathlib.Path(folder) / "angles.mot"
    subprocess.run([mocap, "angles", str(path), "-o", str(out), "--force", "--quiet", *options], check=True)
    return mot(out)


def vector(point):
    return [point.get(axis) for axis in range(3)]


def planted(path, motion):
    """Markers, the coordinates in degrees, and the centres of joints, frame by frame, in metres."""
    model = opensim.Model(str(path))
    model.updateMarkerSet(opensim.MarkerSet(str(path.parent / "Markers_LSTM.xml")))
    state = model.initSystem()
    coordinates, bodies, markers = model.getCoordinateSet(), model.getBodySet(), model.getMarkerSet()
    kept = [name for name in (markers.get(index).getName() for index in range(markers.getSize())) if name.endswith("_study")]
    frames = len(motion["time"])
    tracks = {name: np.zeros((frames, 3)) for name in kept}
    truth = {name: np.zeros(frames) for name in MOVED}
    centres = {body + side: np.zeros((frames, 3)) for body in CENTRES for side in ("_r", "_l")}
    for frame in range(frames):
        for name in MOVED:
            coordinate = coordinates.get(name)
            value = np.clip(np.radians(motion[name][frame]), coordinate.getRangeMin(), coordinate.getRangeMax())
            coordinate.setValue(state, value, False)
            truth[name][frame] = np.degrees(value)
        for axis in "xyz":
            coordinates.get(f"pelvis_t{axis}").setValue(state, motion[f"pelvis_t{axis}"][frame], False)
        model.realizePosition(state)
        for name in kept:
            tracks[name][frame] = vector(markers.get(name).getLocationInGround(state))
        for name, track in centres.items():
            track[frame] = vector(bodies.get(name).getPositionInGround(state))
    return tracks, truth, centres


def loads(mocap, model):
    """OpenSim takes the forces of a file as external loads, by the names of their columns."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "forces.mot"
        subprocess.run([mocap, "forces", str(HERE / "../../fixtures/made/plates.c3d"), "-o", str(path), "--quiet"], check=True)
        written = mot(path)
        model = opensim.Model(str(model))
        all_loads = opensim.ExternalLoads()
        all_loads.setDataFileName(str(path))
        for plate in (1, 2, 3):
            force = opensim.ExternalForce()
            force.setName(f"plate{plate}")
            force.set_applied_to_body("calcn_r")
            force.set_force_expressed_in_body("ground")
            force.set_point_expressed_in_body("ground")
            force.set_force_identifier(f"ground_force_{plate}_v")
            force.set_point_identifier(f"ground_force_{plate}_p")
            force.set_torque_identifier(f"ground_moment_{plate}_m")
            force.set_data_source_name(str(path))
            all_loads.cloneAndAppend(force)
        model.addModelComponent(all_loads)
        all_loads.thisown = False
        model.initSystem()
        row = len(written["time"]) // 2
        for plate in (1, 2, 3):
            load = opensim.ExternalForce.safeDownCast(all_loads.get(plate - 1))
            time = float(written["time"][row])
            for name, found in ((f"ground_force_{plate}_v", load.getForceAtTime(time)), (f"ground_force_{plate}_p", load.getPointAtTime(time)),
                                (f"ground_moment_{plate}_m", load.getTorqueAtTime(time))):
                expected = [written[name + axis][row] for axis in "xyz"]
                assert np.allclose(vector(found), expected, atol=1e-6), (name, vector(found), expected)
    print(f"OpenSim {opensim.GetVersion()} applies the forces of three plates")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("mocap")
    parser.add_argument("models", type=pathlib.Path)
    parser.add_argument("motions", nargs="+", type=pathlib.Path)
    parser.add_argument("--hold", action="store_true")
    given = parser.parse_args()
    opensim.Logger.setLevelString("Off")
    loads(given.mocap, given.models / MODELS[0])
    random = np.random.default_rng(1)
    most = 0.0
    for motion in given.motions:
        for name in MODELS:
            with tempfile.TemporaryDirectory() as folder:
                driving = angles(given.mocap, motion, folder)
                rate = 1 / (driving["time"][1] - driving["time"][0])
                tracks, truth, centres = planted(given.models / name, driving)
                path = pathlib.Path(folder) / "planted.trc"
                noisy = np.stack(list(tracks.values()), 1)
                trc(path, list(tracks), noisy + random.normal(0, NOISE, noisy.shape), rate)
                found = angles(given.mocap, path, folder, "--markers", "auto")
                solved, _ = solve(given.mocap, path)
            print(f"{motion.name} on {name}: {len(noisy)} frames, {noisy.shape[1]} markers")
            for coordinate in MOVED[3:]:
                off = found[coordinate] - truth[coordinate]
                rms = np.std(off)
                if any(coordinate.startswith(name) for name in COMPARED):
                    most = max(most, rms)
                    print(f"  {coordinate:14} {rms:6.2f} degrees RMS about an offset of {np.mean(off):.1f}, range {np.ptp(truth[coordinate]):.0f}")
            positions = dict(zip(solved.names, solved.positions().transpose(1, 0, 2)))
            for body, track in centres.items():
                joint = ("right" if body.endswith("_r") else "left") + CENTRES[body[:-2]]
                print(f"  {joint:14} {np.median(np.linalg.norm(positions[joint] - track, axis=1)) * 1000:6.1f} mm median")
    print(f"worst of hips, knees and ankles: {most:.2f} degrees, wanted {ANGLES}")
    if given.hold and most > ANGLES:
        sys.exit("an angle is too far off")


if __name__ == "__main__":
    main()
