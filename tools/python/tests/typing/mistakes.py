"""Nine mistakes, one on each line with `# wrong`. A type checker finds exactly these."""

import mocap
from mocap import edit

scene = mocap.read("walk.bvh", root_offset="add")
mocap.read("walk.bvh", root_ofset="add")  # wrong: a misspelt option
mocap.convert("walk.bvh", "walk.glb", max_error="1mm")  # wrong: a string where metres are due
scene.to_numpy(rot="euler-xyz")  # wrong: no word of the option
walk, report = edit.smooth(scene, cutoff=8)  # wrong: a misspelt option of a step
mocap.retarget(scene)  # wrong: no target
lock = edit.foot_lock.step(height="feet.json")  # wrong: a path where a number is due
print(scene.to_numpy().rotation)  # wrong: no attribute of the result
frames: int = edit.mirror("walk.bvh")  # wrong: another type of the result
mocap.PackedClip.of(None)  # wrong: None where a scene is due

moved, reports = mocap.retarget("walk.bvh", scene, feet="free", scale=1.2)
mocap.convert(moved, "walk.fbx", fbx_target="unreal", trim=(0.5, None))
edit.write(edit.reach(walk, "hips", "left-hand", range=(1, 2.5)).scene, "walk.glb", max_error=0.001, overwrite=True)
positions = scene.to_numpy(mocap.Options(fps=30), velocities=True, out_unit="m").positions
print(positions.shape, reports[0]["verdict"], report["largest_rotation"], scene.clips, lock.options, frames)
