//! Contents around a skeleton: comments, references, variants, and prims that move the skeleton. Positions are computed
//! by hand.

use mocap::glam::Vec3;
use mocap::{Code, Pose, Scene};

use super::read;

/// A skeleton of two joints in a prim. The text `within` is before the skeleton, and `behind` is after the prim.
fn layer(root: &str, within: &str, behind: &str) -> String {
    let unit = "((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,1,0,1))";
    format!(
        "#usda 1.0\n( timeCodesPerSecond = 10 metersPerUnit = 1 startTimeCode = 0 endTimeCode = 20 )\n\
         def SkelRoot \"C\" {root}\n{{\n{within}\n\
         def Skeleton \"S\" {{\n uniform token[] joints = [\"a\", \"a/b\"]\n\
         uniform matrix4d[] restTransforms = [{unit}, {unit}]\n rel skel:animationSource = </C/A>\n}}\n\
         def SkelAnimation \"A\" {{\n uniform token[] joints = [\"a\", \"a/b\"]\n\
         float3[] translations = [(0,1,0), (0,1,0)]\n\
         quatf[] rotations.timeSamples = {{ 0: [(1,0,0,0),(1,0,0,0)], 20: [(0.7071068,0,0,0.7071068),(1,0,0,0)] }}\n\
         half3[] scales = [(1,1,1), (1,1,1)]\n}}\n}}\n{behind}\n"
    )
}

fn tip(scene: &Scene, tick: f64) -> Vec3 {
    let pose = Pose::at_tick(scene, 0, tick).unwrap();
    let node = scene.nodes.iter().position(|node| node.name == "b").unwrap();
    pose.node_to_world[node].w_axis.truncate()
}

#[test]
fn comments_and_names_of_files_are_those_of_usd() {
    let plain = read(&layer("", "", "")).unwrap();
    for within in [
        "// by hand: \" @ {\n",
        "/* \" of\n several { lines */",
        "asset texture = @@@a@b{.png@@@\n",
        "asset texture = @@@a\\@@@b.png@@@\n asset[] none = [@@, @b.png@]",
    ] {
        let scene = read(&layer("", within, "")).unwrap();
        assert_eq!(scene.animations, plain.animations, "{within}");
    }
    for references in [
        "references = @./prop.usda@</P> (offset = 10)",
        "prepend references = [@a.usda@</P> (offset = 10; scale = 2), </Q>]",
        "payload = @a.usda@ (offset = 1)",
        "payload = @@@a@b.usda@@@</P>",
    ] {
        let scene = read(&layer("", "", &format!("def \"Prop\" ( {references} )\n{{\n}}"))).unwrap();
        assert_eq!(scene.animations, plain.animations, "{references}");
        assert_eq!(scene.warnings[0].code, Code::MissingFile);
    }
}

#[test]
fn prims_above_a_skeleton_move_it() {
    let near = |found: Vec3, expected: [f32; 3]| {
        assert!(
            found.abs_diff_eq(Vec3::from_array(expected), 1e-5),
            "{found} {expected:?}"
        );
    };
    let moves = "double3 xformOp:translate.timeSamples = { 0: (0,0,0), 20: (5,0,0) }\n\
                 uniform token[] xformOpOrder = [\"xformOp:translate\"]";
    let scene = read(&layer("", moves, "")).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    near(tip(&scene, 0.0), [0.0, 2.0, 0.0]);
    // The joint a rotates by 45 degrees about Z, and then by 90 degrees.
    let half = 0.5_f32.sqrt();
    near(tip(&scene, 10.0), [2.5 - half, 1.0 + half, 0.0]);
    near(tip(&scene, 20.0), [4.0, 1.0, 0.0]);
    // A rotation of 360 degrees, whose two keys are one rotation, and a constant scale.
    let turns = "float xformOp:rotateY.timeSamples = { 0: 0, 20: 360 }\n float3 xformOp:scale = (2, 2, 2)\n\
                 uniform token[] xformOpOrder = [\"xformOp:rotateY\", \"xformOp:scale\"]";
    let scene = read(&layer("", turns, "")).unwrap();
    near(tip(&scene, 10.0), [2.0 * half, 2.0 + 2.0 * half, 0.0]);
    near(tip(&scene, 20.0), [-2.0, 2.0, 0.0]);
    // Without an animation of the skeleton, the animation of the prim remains.
    let still = layer("", moves, "").replace("SkelAnimation", "Scope");
    let scene = read(&still).unwrap();
    assert_eq!((scene.animations.len(), scene.animations[0].duration), (1, 20.0));
    near(tip(&scene, 10.0), [2.5, 2.0, 0.0]);
}

#[test]
fn the_selected_variant_is_read() {
    let sets = "variantSet \"model\" = {\n\"low\" { def Scope \"X\" { } }\n\"high\" ( doc = \"}\" ) {\n";
    let text = layer("( variants = { string model = \"high\" } )", sets, "");
    // The set ends after the skeleton and its animation.
    let (before, after) = text.rsplit_once("}\n").unwrap();
    let selected = format!("{before}}}\n}}\n}}\n{after}");
    let scene = read(&selected).unwrap();
    assert_eq!(scene.animations, read(&layer("", "", "")).unwrap().animations);
    for root in ["", "( variants = { string shade = \"high\" } )"] {
        let error = read(&selected.replace("( variants = { string model = \"high\" } )", root)).unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("/C has variants of \"model\", but the layer selects none"),
            "{message}"
        );
    }
    // An opinion of the prim is stronger than an opinion of its variant.
    let sets = "double3 xformOp:translate = (1,0,0)\n variantSet \"place\" = { \"far\" {\n\
                double3 xformOp:translate = (9,0,0)\n uniform token[] xformOpOrder = [\"xformOp:translate\"]\n} }";
    let scene = read(&layer("( variants = { string place = \"far\" } )", sets, "")).unwrap();
    assert!(tip(&scene, 0.0).abs_diff_eq(Vec3::new(1.0, 2.0, 0.0), 1e-6));
}
