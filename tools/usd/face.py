"""Makes fixtures/made/face.usda with usd-core, and prints the world positions of its points by UsdSkel, in metres.

usage: python face.py FOLDER

The file has features that a single writer's files lack. Meshes: quadrangles, normals and indexed texture coordinates of
corners, subsets with materials, left-handed faces. Skins: a mesh with its own order of joints, a mesh with a single
joint, and a mesh without joints. Blend shapes: shapes of all points and of some points, one shape name for two meshes,
a shape with an in-between shape. Animation: a constant weight, an order of weights that differs from the order of
shapes, and an animation without blend shapes.
"""

import sys
from pathlib import Path

from pxr import Gf, Sdf, Usd, UsdGeom, UsdShade, UsdSkel, Vt

path = Path(sys.argv[1]) / "face.usda"
stage = Usd.Stage.CreateInMemory()
UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
UsdGeom.SetStageMetersPerUnit(stage, 0.01)
stage.SetTimeCodesPerSecond(24)
stage.SetStartTimeCode(1)
stage.SetEndTimeCode(25)
root = UsdSkel.Root.Define(stage, "/Hero")
stage.SetDefaultPrim(root.GetPrim())
root.AddTranslateOp().Set(Gf.Vec3d(5, 0, 10))
root.AddRotateZOp().Set(30)

skeleton = UsdSkel.Skeleton.Define(stage, "/Hero/Rig")
skeleton.CreateJointsAttr(["Neck", "Neck/Head"])


def matrix(translation, degrees=0):
    turn = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), degrees))
    return turn * Gf.Matrix4d().SetTranslate(Gf.Vec3d(*translation))


rest = [matrix((0, 0, 140)), matrix((0, 2, 10), 20)]
skeleton.CreateRestTransformsAttr(Vt.Matrix4dArray(rest))
skeleton.CreateBindTransformsAttr(Vt.Matrix4dArray([rest[0], rest[1] * rest[0]]))

for name, color in [("Skin", (0.8, 0.4, 0.2)), ("Hair", (0.1, 0.1, 0.3))]:
    material = UsdShade.Material.Define(stage, f"/Hero/Looks/{name}")
    shader = UsdShade.Shader.Define(stage, f"/Hero/Looks/{name}/Surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    shader.CreateInput("diffuseColor", Sdf.ValueTypeNames.Color3f).Set(Gf.Vec3f(*color))
    shader.CreateInput("opacity", Sdf.ValueTypeNames.Float).Set(0.5 if name == "Hair" else 1.0)
    material.CreateSurfaceOutput().ConnectToSource(shader.ConnectableAPI(), "surface")


def look(prim, name):
    UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material.Get(stage, f"/Hero/Looks/{name}"))


def shape(mesh, name, offsets, ids=None, normals=None):
    made = UsdSkel.BlendShape.Define(stage, mesh.GetPath().AppendChild(name))
    made.CreateOffsetsAttr(Vt.Vec3fArray([Gf.Vec3f(*offset) for offset in offsets]))
    if ids is not None:
        made.CreatePointIndicesAttr(ids)
    if normals is not None:
        made.CreateNormalOffsetsAttr(Vt.Vec3fArray([Gf.Vec3f(*offset) for offset in normals]))
    return made


def bound(mesh, tokens, shapes):
    binding = UsdSkel.BindingAPI.Apply(mesh.GetPrim())
    binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
    binding.CreateBlendShapesAttr(tokens)
    binding.CreateBlendShapeTargetsRel().SetTargets([made.GetPath() for made in shapes])
    return binding


def mesh(name, points, counts, corners):
    made = UsdGeom.Mesh.Define(stage, f"/Hero/{name}")
    made.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(*point) for point in points]))
    made.CreateFaceVertexCountsAttr(counts)
    made.CreateFaceVertexIndicesAttr(corners)
    made.CreateSubdivisionSchemeAttr("none")
    return made


head = mesh(
    "Head",
    [(x, y, z) for z in (0, 20) for y in (-8, 8) for x in (-7, 7)],
    [4] * 6,
    [0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 2, 6, 7, 3, 0, 4, 6, 2, 1, 3, 7, 5],
)
faces = [(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)]
head.CreateNormalsAttr(Vt.Vec3fArray([Gf.Vec3f(*normal) for normal in faces for _ in range(4)]))
head.SetNormalsInterpolation("faceVarying")
coords = UsdGeom.PrimvarsAPI(head).CreatePrimvar("UVMap", Sdf.ValueTypeNames.TexCoord2fArray, "faceVarying")
coords.Set(Vt.Vec2fArray([Gf.Vec2f(0, 0), Gf.Vec2f(1, 0), Gf.Vec2f(1, 0.75), Gf.Vec2f(0, 0.75)]))
coords.SetIndices([0, 1, 2, 3] * 6)
for name, own in [("Skin", [0, 2, 3, 4, 5]), ("Hair", [1])]:
    subset = UsdGeom.Subset.CreateGeomSubset(head, name, "face", own, "materialBind", "nonOverlapping")
    look(subset.GetPrim(), name)
binding = bound(
    head,
    ["smile", "frown", "puff"],
    [
        shape(head, "Smile", [(0, -3, 1), (0, -2, 2)], [0, 1]),
        shape(head, "Frown", [(0, 0, -0.5 * index) for index in range(8)], None, [(0, 0.1, 0)] * 8),
        shape(head, "Puff", [(4, 0, 0)], [5]),
    ],
)
puff = UsdSkel.BlendShape(stage.GetPrimAtPath("/Hero/Head/Puff"))
puff.CreateInbetween("half").SetOffsets(Vt.Vec3fArray([Gf.Vec3f(4, 4, 0)]))
puff.GetInbetween("half").SetWeight(0.5)
binding.CreateJointsAttr(["Neck/Head", "Neck"])
binding.CreateJointIndicesPrimvar(False, 2).Set([0, 1] * 8)
binding.CreateJointWeightsPrimvar(False, 2).Set([0.25, 0.75] * 4 + [1.0, 0.0] * 4)
binding.CreateGeomBindTransformAttr(matrix((0, 1, 145), 10))

teeth = mesh("Teeth", [(-3, -9, 4), (3, -9, 4), (0, -9, 6), (0, -7, 5)], [3, 3], [0, 2, 1, 0, 3, 2])
teeth.CreateOrientationAttr("leftHanded")
look(teeth.GetPrim(), "Skin")
binding = bound(teeth, ["smile"], [shape(teeth, "Shown", [(0, -1, 0)] * 3, [0, 1, 2])])
binding.CreateJointIndicesPrimvar(True, 1).Set([1])
binding.CreateJointWeightsPrimvar(True, 1).Set([1.0])
binding.CreateGeomBindTransformAttr(matrix((0, 1, 145)))

mesh("Chair", [(0, 0, 0), (9, 0, 0), (0, 9, 0)], [3], [0, 1, 2])

talk = UsdSkel.Animation.Define(stage, "/Hero/Talk")
talk.CreateJointsAttr(["Neck", "Neck/Head"])
talk.CreateTranslationsAttr(Vt.Vec3fArray([Gf.Vec3f(0, 0, 140), Gf.Vec3f(0, 2, 10)]))
talk.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)] * 2))
for code, degrees in [(1, 0), (25, 40)]:
    turns = [Gf.Rotation(Gf.Vec3d(0, 0, 1), degrees).GetQuat(), Gf.Rotation(Gf.Vec3d(1, 0, 0), 20 - degrees).GetQuat()]
    talk.CreateRotationsAttr().Set(Vt.QuatfArray([Gf.Quatf(turn) for turn in turns]), code)
talk.CreateBlendShapesAttr(["frown", "puff", "smile"])
for code, weights in [(1, (1, 0, 0)), (13, (0.25, 0, 0.75)), (25, (0, 0, 1))]:
    talk.CreateBlendShapeWeightsAttr().Set(Vt.FloatArray(weights), code)
nod = UsdSkel.Animation.Define(stage, "/Hero/Nod")
nod.CreateJointsAttr(["Neck/Head"])
nod.CreateTranslationsAttr(Vt.Vec3fArray([Gf.Vec3f(0, 2, 10)]))
nod.CreateScalesAttr(Vt.Vec3hArray([Gf.Vec3h(1, 1, 1)]))
for code, degrees in [(1, 20), (25, 60)]:
    turn = Gf.Rotation(Gf.Vec3d(1, 0, 0), degrees).GetQuat()
    nod.CreateRotationsAttr().Set(Vt.QuatfArray([Gf.Quatf(turn)]), code)
UsdSkel.BindingAPI.Apply(skeleton.GetPrim()).CreateAnimationSourceRel().AddTarget(talk.GetPath())
UsdSkel.BindingAPI.Apply(root.GetPrim())
stage.GetRootLayer().Export(str(path))

stage = Usd.Stage.Open(str(path))
UsdSkel.BakeSkinning(UsdSkel.Root(stage.GetDefaultPrim()), Gf.Interval(1, 25))
for name in ("Head", "Teeth"):
    for code in (1, 7, 13, 25):
        baked = UsdGeom.Mesh(stage.GetPrimAtPath(f"/Hero/{name}"))
        world = baked.ComputeLocalToWorldTransform(code)
        points = [0.01 * world.Transform(Gf.Vec3d(point)) for point in baked.GetPointsAttr().Get(code)]
        print(name, code, ", ".join("[" + ", ".join(f"{n:.6f}" for n in point) + "]" for point in points))
