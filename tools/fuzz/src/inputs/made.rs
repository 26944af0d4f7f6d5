//! Seeds that are not in files: fixtures in formats that this crate writes.

use std::fs;

use mocap::arrays::{ArrayOptions, Arrays};
use mocap::compress::PackedClip;
use mocap::gltf::Compression;
use mocap::{Conversion, Exporter, Format, Scene};

use super::fixture;

/// Small motions, as this crate writes them.
pub(super) fn glb() -> Vec<Vec<u8>> {
    let written = documents().map(|document| document.to_glb().expect("the fixture is written"));
    written.collect()
}

/// Small motions as glTF text, and one with a skin and a texture.
pub(super) fn gltf() -> Vec<Vec<u8>> {
    let written = documents().map(|document| document.to_embedded().expect("the fixture is written"));
    let skin = include_bytes!("../../../../fixtures/made/two_bones_textured.gltf");
    written.chain([skin.to_vec()]).collect()
}

/// Small motions as packed clips, with a key at every frame and at some.
pub(super) fn mclip() -> Vec<Vec<u8>> {
    let packed = |(name, bound)| {
        let scene = mocap::import(fixture(name)).expect("the fixture is read");
        let clip = PackedClip::encode(&scene, 0, bound).expect("the fixture is packed");
        clip.bytes().to_vec()
    };
    let seeds = [
        ("dialects/plain.bvh", 0.001),
        ("dialects/channels_0_to_6.bvh", 0.001),
        ("real/cmu_short.bvh", 0.01),
        ("real/cmu_short.bvh", 0.5),
        ("real/lecture_Test.bvh", 0.0001),
    ];
    seeds.into_iter().map(packed).collect()
}

/// Markers with gaps, separated by tabs and by blanks.
pub(super) fn trc() -> Vec<Vec<u8>> {
    let header = "PathFileType\t4\t(X/Y/Z)\ta.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n60\t2\t2\tmm\n\
        Frame#\tTime\tR.ASIS\t\t\tV Sacral\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n\n";
    let tabs = format!("{header}1\t0\t1\t2\t3\t4\t5\t6\n2\t0.02\t\t\t\t4\t5\t6.5\n");
    let blanks = "PathFileType 4\nDataRate NumFrames NumMarkers Units\n0 2 1 m\nFrame# Time A\n1 0 1 2 3\n2 .1 0 0 0\n";
    vec![tabs.into_bytes(), blanks.as_bytes().to_vec()]
}

/// Joint angles, as OpenSim's older models have them.
pub(super) fn mot() -> Vec<Vec<u8>> {
    let text = "Coordinates\nversion=1\nnRows=2\nnColumns=6\ninDegrees=yes\nendheader\n\
        time\tpelvis_ty\thip_flexion_r\thip_flexion_l\tknee_angle_r\tknee_angle_l\n\
        0\t0.9\t10\t-10\t-5\t-20\n0.02\t0.9\t12\t-12\t-4\t-25\n";
    vec![text.as_bytes().to_vec()]
}

/// Small motions as USD, as this crate writes them.
pub(super) fn usda() -> Vec<Vec<u8>> {
    usd("usda")
}

/// Small motions as USD archives.
pub(super) fn usdz() -> Vec<Vec<u8>> {
    usd("usdz")
}

fn usd(extension: &str) -> Vec<Vec<u8>> {
    let written = |name| {
        let scene = mocap::import(fixture(name)).expect("the fixture is read");
        let written = Exporter::new().write_as(&scene, format!("seed.{extension}"));
        let written = written.expect("the fixture is written").into_bytes();
        written.expect("a skeleton is one file")
    };
    ["dialects/plain.bvh", "dialects/two_roots.bvh", "real/lecture_Test.bvh"]
        .map(written)
        .into()
}

/// Scenes with and without a motion, a skin, a texture.
pub(super) fn scenes() -> Vec<Vec<u8>> {
    let files = [
        "dialects/plain.bvh",
        "dialects/two_roots.bvh",
        "made/tiny.fbx",
        "made/two_bones_textured.gltf",
    ];
    let read = |name| fs::read(fixture(name)).expect("the fixture can be read");
    files.into_iter().map(read).chain(glb()).chain(gltf()).collect()
}

fn documents() -> impl Iterator<Item = mocap::gltf::Document> {
    let names = [
        "dialects/plain.bvh",
        "dialects/channels_0_to_6.bvh",
        "dialects/two_roots.bvh",
    ];
    let compressions: &[_] = match cfg!(feature = "meshopt") {
        true => &[
            Compression::None,
            Compression::Int16,
            Compression::Meshopt,
            Compression::MeshoptKhr,
        ],
        false => &[Compression::None, Compression::Int16],
    };
    let scenes = names.map(|name| mocap::import(fixture(name)).expect("the fixture is read"));
    let written = |scene: mocap::Scene| {
        compressions.iter().map(move |&compression| {
            let options = mocap::gltf::GltfOptions::new().compression(compression);
            mocap::gltf::Document::new(&scene, &options).expect("the fixture can be written")
        })
    };
    scenes.into_iter().flat_map(written)
}

/// A walk on the bones of a humanoid, with a key at every frame, and with a single key.
pub(super) fn vrma() -> Vec<Vec<u8>> {
    let mut scene = import("real/cmu_short.bvh");
    Conversion::new().apply(&mut scene).expect("the fixture is converted");
    let written = [4.0, 0.0].map(|last| {
        scene.trim(0.0, last);
        let written = Exporter::new().write(&scene, Format::Vrma);
        let bytes = written.and_then(mocap::Export::into_bytes);
        bytes.expect("the fixture is written")
    });
    written.into()
}

/// Robots in URDF: a small robot, and whole robots.
pub(super) fn urdf() -> Vec<Vec<u8>> {
    let mut seeds = vec![URDF.to_vec()];
    seeds.extend(["robots/h1.urdf", "robots/g1_29dof_rev_1_0.urdf"].map(read));
    seeds
}

/// Robots in MJCF: a small robot, and whole robots.
pub(super) fn mjcf() -> Vec<Vec<u8>> {
    let mut seeds = vec![MJCF.to_vec()];
    seeds.extend(["robots/h1_nomesh.xml", "robots/g1_29dof_rev_1_0_nomesh.xml"].map(read));
    seeds
}

/// Arrays of small motions, whose source is [`ARRAYS_OF`].
pub(super) fn npz() -> Vec<Vec<u8>> {
    let options = [ArrayOptions::new(), ArrayOptions::new().velocities(true)];
    let made = options.map(|options| {
        Arrays::of(&import(ARRAYS_OF), &options)
            .expect("arrays are made")
            .to_npz()
    });
    made.into()
}

/// Arrays of small motions as CSV, whose source is [`ARRAYS_OF`].
pub(super) fn csv() -> Vec<Vec<u8>> {
    let motion = Arrays::of(&import(ARRAYS_OF), &ArrayOptions::new()).expect("arrays are made");
    vec![
        motion.to_csv().into_bytes(),
        motion.to_csv_for_spreadsheet().into_bytes(),
        b"frame,time,joint,x,y,z\n0,0,hip,0,1,0\n0,0,knee,0,0.5,0\n1,0.1,hip,0,1,0.1\n".to_vec(),
        b"time;a_x;a_y;a_z;b_x;b_y;b_z;c_x;c_y;c_z\n0;1;2;3;;;;7;8;9\n0.1;1;2;3;4;5;6;7;8;9\n".to_vec(),
    ]
}

/// Models of bodies, in an archive and in a pickle.
pub(super) fn bodies() -> Vec<Vec<u8>> {
    ["arrays/body_smplh.npz", "arrays/body_smpl.pkl"].map(read).into()
}

/// The source of the arrays.
pub(super) const ARRAYS_OF: &str = "dialects/plain.bvh";

fn import(name: &str) -> Scene {
    mocap::import(fixture(name)).expect("the fixture is read")
}

fn read(name: &str) -> Vec<u8> {
    fs::read(fixture(name)).expect("the fixture can be read")
}

const URDF: &[u8] = br#"<robot name="r">
  <link name="base"> <visual> <geometry> <box size="0.2 0.3 0.1"/> </geometry> </visual> </link>
  <joint name="hip" type="revolute"> <parent link="base"/> <child link="thigh"/> <origin xyz="0 0.1 0" rpy="0 0.5 0"/>
    <axis xyz="0 1 0"/> <limit lower="-1" upper="1.5" velocity="20" effort="80"/> </joint>
  <link name="thigh"> <inertial> <origin xyz="0 0 -0.2"/> <mass value="3"/> </inertial>
    <collision> <geometry> <cylinder radius="0.05" length="0.4"/> </geometry> </collision> </link>
  <joint name="knee" type="continuous"> <parent link="thigh"/> <child link="shin"/> <mimic joint="hip" offset="0.1"/> </joint>
  <link name="shin"> <collision> <geometry> <sphere radius="0.05"/> </geometry> </collision> </link>
  <joint name="foot" type="fixed"> <parent link="shin"/> <child link="sole"/> </joint> <link name="sole"/>
</robot>
"#;

const MJCF: &[u8] = br#"<mujoco model="m">
  <compiler eulerseq="ZYX"/>
  <default> <joint range="-90 90"/> <default class="c"> <joint axis="0 1 0"/> <geom type="capsule"/> </default> </default>
  <worldbody>
    <body name="base" pos="0 0 3" childclass="c"> <freejoint name="root"/>
      <body name="upper" pos="0 0 -1" euler="90 0 0">
        <joint name="a" pos="0 0 0.5"/> <joint name="b" axis="1 0 0" range="-10 20" actuatorfrcrange="-5 6"/>
        <geom fromto="0 0 0 0 0 -2" size="0.1"/>
        <body name="ball"> <joint name="s" type="ball" limited="false"/> <site name="t" pos="0 0 1"/> </body>
      </body>
    </body>
  </worldbody>
  <equality> <joint joint1="b" joint2="a" polycoef="0.1 2 0 0 0"/> </equality>
  <actuator> <motor joint="a" ctrlrange="-1 1"/> </actuator>
</mujoco>
"#;
