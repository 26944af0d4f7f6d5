"""Plays a motion on a robot in MuJoCo's viewer.

    python examples/mujoco_play.py walk.bvh g1.xml
"""

from __future__ import annotations

import sys
import time

import mujoco
import mujoco.viewer

import mocap


def play(motion: mocap.RobotMotion, model: mujoco.MjModel) -> None:
    """Shows the motion until the window is closed."""
    data = mujoco.MjData(model)
    with mujoco.viewer.launch_passive(model, data) as viewer:
        while viewer.is_running():
            for pose in motion.qpos:
                data.qpos[:] = pose
                mujoco.mj_kinematics(model, data)
                viewer.sync()
                time.sleep(1 / motion.fps)


if __name__ == "__main__":
    clip, robot = sys.argv[1:]
    play(mocap.Robot(robot).retarget(mocap.read(clip)), mujoco.MjModel.from_xml_path(robot))
