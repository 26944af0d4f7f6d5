"""Makes fixtures/made/arm.usda with usd-core, and prints the world positions of its joints by UsdSkel, in metres.

usage: python fixture.py FOLDER

The file has features that a single writer's files lack. Stage: centimetres with +Z up, time codes from 101 at 48 a
second, text in other quotes. Skeleton: a moved, rotated and scaled prim above it, a joint whose path skips a name,
joints row by row. Animation: translations and rotations at different times, scales, an omitted joint, another order of
joints.
"""

import sys
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdSkel, Vt

path = Path(sys.argv[1]) / "arm.usda"
stage = Usd.Stage.CreateInMemory()
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
UsdGeom.SetStageMetersPerUnit(stage, 0.01)
stage.SetTimeCodesPerSecond(48)
stage.SetFramesPerSecond(24)
stage.SetStartTimeCode(101)
stage.SetEndTimeCode(149)
stage.SetMetadata("documentation", "An arm that says \"hello\", as 'others' write it")

root = UsdSkel.Root.Define(stage, "/Set")
stage.SetDefaultPrim(root.GetPrim())
root.AddTranslateOp().Set(Gf.Vec3d(10, 20, 30))
root.AddRotateYZXOp().Set(Gf.Vec3f(10, 20, 30))
root.AddScaleOp().Set(Gf.Vec3f(2, 2, 2))
skeleton = UsdSkel.Skeleton.Define(stage, "/Set/Rig")
joints = ["Base", "Base/Arm", "Base/Tail", "Base/Arm/Sleeve/Hand"]
skeleton.CreateJointsAttr(joints)


def matrix(translation, axis, degrees):
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(*axis), degrees))
    return turn * Gf.Matrix4d().SetTranslate(Gf.Vec3d(*translation))


rest = [
    matrix((1, 2, 3), (0, 0, 1), 30),
    matrix((0, 0, 40), (1, 0, 0), 45),
    matrix((0, -15, 0), (0, 0, 1), 0),
    matrix((5, 0, 25), (0, 1, 0), -60),
]
skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(rest))
bind = [rest[0], rest[1] * rest[0], rest[2] * rest[0], rest[3] * rest[1] * rest[0]]
skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray(bind))

animation = UsdSkel.Animation.Define(stage, "/Set/Wave")
animation.CreateJointsAttr(["Base/Arm/Sleeve/Hand", "Base", "Base/Arm"])
for code, base in [(101, (1, 2, 3)), (125, (1, 2, 9)), (149, (7, 2, 3))]:
    translations = [(5, 0, 25), base, (0, 0, 40)]
    animation.CreateTranslationsAttr().Set(Vt.Vec3fArray([Gf.Vec3f(*t) for t in translations]), code)
for code, degrees in [(101, 0), (113, 50), (137, -20), (149, 90)]:
    turns = [((0, 1, 0), -60), ((0, 0, 1), 30 + degrees), ((1, 0, 0), 45 - degrees)]
    turns = [Gf.Rotation(Gf.Vec3d(*axis), angle).GetQuat() for axis, angle in turns]
    animation.CreateRotationsAttr().Set(Vt.QuatfArray([Gf.Quatf(turn) for turn in turns]), code)
animation.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1), Gf.Vec3h(1, 1, 1), Gf.Vec3h(1, 1.5, 2)]))
binding = UsdSkel.BindingAPI.Apply(skeleton.GetPrim())
binding.CreateAnimationSourceRel().AddTarget(Sdf.Path("/Set/Wave"))
UsdSkel.BindingAPI.Apply(root.GetPrim())
stage.GetRootLayer().Export(str(path))

stage = Usd.Stage.Open(str(path))
cache = UsdSkel.Cache()
root = UsdSkel.Root(stage.GetDefaultPrim())
cache.Populate(root, Usd.PrimDefaultPredicate)
query = cache.GetSkelQuery(UsdSkel.Skeleton(stage.GetPrimAtPath("/Set/Rig")))
for code in (101, 107, 125, 140, 149):
    found = query.ComputeJointWorldTransforms(UsdGeom.XformCache(code))
    rows = [[0.01 * number for number in world.ExtractTranslation()] for world in found]
    print(code, ", ".join("[" + ", ".join(f"{n:.7f}" for n in row) + "]" for row in rows))
