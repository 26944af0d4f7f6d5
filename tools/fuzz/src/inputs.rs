//! The formats, and how to make an input of each from bytes.

use std::path::PathBuf;
use std::sync::OnceLock;
use std::{env, fs, process};

use mocap::compress::PackedClip;
use mocap::gltf::Compression;
use mocap::{Importer, Result, Scene, SkeletonMesh};

/// Keywords of each format.
const BVH_WORDS: &[&str] = &[
    "HIERARCHY",
    "ROOT",
    "JOINT",
    "OFFSET",
    "CHANNELS",
    "End Site",
    "MOTION",
    "Frames:",
    "Frame Time:",
    "{",
    "}",
    "#",
    " Xposition",
    " Yrotation",
    " Zscale",
    "JOINT a{OFFSET 0 1 0}",
    "End Site{OFFSET 1 0 0}",
    "CHANNELS 0",
    "CHANNELS 1 Xrotation",
    "CHANNELS 1 Yposition",
    "\n",
    "\r",
    "\r\n",
    "\t",
    "\0",
    "\u{feff}",
    "\u{e9}",
];

/// As above.
const ACCLAIM_WORDS: &[&str] = &[
    ":units",
    ":root",
    ":bonedata",
    ":hierarchy",
    ":FULLY-SPECIFIED",
    ":DEGREES",
    ":RADIANS",
    "begin",
    "end",
    "name",
    "direction 0 1 0",
    "length",
    "axis 0 0 90 XYZ",
    "ZYX",
    "dof rx ry rz",
    "dof l tx",
    "order",
    "TX TY TZ RX RY RZ",
    "root",
    "lfemur",
    "head",
    "limits (-90 90)",
    "#",
    "\n",
    "\r\n",
    "\t",
    "\0",
    "\u{feff}",
];

/// As above.
const C3D_WORDS: &[&str] = &[
    "POINT",
    "USED",
    "SCALE",
    "RATE",
    "DATA_START",
    "FRAMES",
    "LABELS",
    "LABELS2",
    "UNITS",
    "Y_SCREEN",
    "ANALOG",
    "TRIAL",
    "ACTUAL_END_FIELD",
    "P",
    "\0",
];

/// As above.
const FBX_WORDS: &[&str] = &[
    "Objects:  {",
    "Connections:  {",
    "}",
    "C: \"OO\",2,1\n",
    "C: \"OP\",31,1, \"Lcl Rotation\"\n",
    "Model:",
    "NodeAttribute:",
    "LimbNode",
    "AnimationStack:",
    "AnimationCurve:",
    "Deformer:",
    "Cluster",
    "Geometry:",
    "PolygonVertexIndex: *3 {",
    "a: 0,1,-3",
    "KeyTime: *2 {",
    "TransformLink: *16 {",
    "Lcl Translation",
    "RotationOrder",
    "UnitScaleFactor",
    "GeometricTranslation",
    "\n",
    "*4000000000 {",
    "\0",
];

/// As above.
const GLTF_WORDS: &[&str] = &[
    "{",
    "}",
    "[",
    "]",
    ",",
    "\"children\":[0]",
    "\"byteOffset\":",
    "\"componentType\":5123",
    "\"type\":\"VEC4\"",
    "\"sparse\":",
    "\"interpolation\":\"CUBICSPLINE\"",
    "\"extensionsRequired\":[\"a\"]",
    "null",
    "\0",
];

/// Bytes of the motion for testing skeletons: the first frames of a walk.
const MOTION_LENGTH: usize = 2400;

/// A kind of file to try.
pub struct Input {
    /// Its name on the command line, and the extension of its seeds.
    pub name: &'static str,
    /// The folders of `fixtures` that hold its seeds.
    pub folders: &'static [&'static str],
    /// Bytes of the longest seed; longer ones are cut off there, or left out if a part is useless.
    pub longest_seed: usize,
    /// Whether the first bytes of a longer file are a seed too.
    pub cut: bool,
    /// Seeds that are not in files.
    pub made: fn() -> Vec<Vec<u8>>,
    /// The keywords of its format.
    pub words: &'static [&'static str],
    /// Bytes of memory that any input may take, and those that each byte of it may add. An export holds the scene, its
    /// buffer, and the file.
    pub base: usize,
    /// See [`Input::base`].
    pub factor: usize,
    /// What must hold of its scenes, but for the rules of every scene.
    pub(crate) outputs: Outputs,
    read: fn(&[u8], &Importer) -> Result<Scene>,
}

/// What scenes are written as.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outputs {
    /// glTF, BVH and arrays.
    Usual,
    /// FBX.
    Fbx,
}

/// A BVH file.
pub const BVH: Input = Input {
    name: "bvh",
    folders: &["dialects", "broken", "real"],
    longest_seed: 8 << 10,
    cut: false,
    made: Vec::new,
    words: BVH_WORDS,
    base: 1 << 20,
    factor: 512,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::Bvh).read(bytes, "fuzz.bvh"),
};

/// An Acclaim skeleton, alone and with a motion.
pub const ASF: Input = Input {
    name: "asf",
    folders: &["made", "real"],
    longest_seed: 8 << 10,
    cut: false,
    made: Vec::new,
    words: ACCLAIM_WORDS,
    base: 1 << 20,
    factor: 512,
    outputs: Outputs::Usual,
    read: |bytes, importer| {
        let importer = importer.clone().format(mocap::Format::AsfAmc);
        let alone = importer.read(bytes, "fuzz.asf");
        // The reader finds the skeleton in a file. Each process has its own.
        let path = env::temp_dir().join(format!("mocap-fuzz-{}.asf", process::id()));
        fs::write(&path, bytes).expect("the folder of temporary files can be written");
        let with_motion = importer.skeleton(path).read(motion(), "fuzz.amc");
        if with_motion.is_ok() { with_motion } else { alone }
    },
};

/// An Acclaim motion on a known skeleton.
pub const AMC: Input = Input {
    name: "amc",
    folders: &["made", "real"],
    longest_seed: MOTION_LENGTH,
    cut: true,
    made: Vec::new,
    words: ACCLAIM_WORDS,
    base: 1 << 20,
    factor: 512,
    outputs: Outputs::Usual,
    read: |bytes, importer| {
        let skeleton = fixture("real/cmu_02.asf");
        importer
            .clone()
            .format(mocap::Format::AsfAmc)
            .skeleton(skeleton)
            .read(bytes, "fuzz.amc")
    },
};

/// A C3D file.
pub const C3D: Input = Input {
    name: "c3d",
    folders: &["made", "real"],
    longest_seed: 16 << 10,
    cut: true,
    made: Vec::new,
    words: C3D_WORDS,
    base: 1 << 20,
    factor: 512,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::C3d).read(bytes, "fuzz.c3d"),
};

/// An FBX file.
pub const FBX: Input = Input {
    name: "fbx",
    folders: &["made", "real"],
    longest_seed: 512 << 10,
    cut: false,
    made: Vec::new,
    words: FBX_WORDS,
    // Curves are sampled: 4 million values, and 256 for each byte of the file, of four bytes each.
    base: 128 << 20,
    factor: 8192,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::Fbx).read(bytes, "fuzz.fbx"),
};

/// A glTF file.
pub const GLB: Input = Input {
    name: "glb",
    folders: &[],
    longest_seed: 64 << 10,
    cut: false,
    made: glb_seeds,
    words: GLTF_WORDS,
    base: 1 << 20,
    factor: 512,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::Gltf).read(bytes, "fuzz.glb"),
};

/// A glTF file in text, with its buffer in it.
pub const GLTF: Input = Input {
    name: "gltf",
    made: gltf_seeds,
    read: |bytes, importer| importer.clone().format(mocap::Format::Gltf).read(bytes, "fuzz.gltf"),
    ..GLB
};

/// A packed clip.
pub const MCLIP: Input = Input {
    name: "mclip",
    folders: &[],
    longest_seed: 16 << 10,
    made: mclip_seeds,
    words: &["MCLP", "\0"],
    read: |bytes, importer| importer.clone().format(mocap::Format::Mclip).read(bytes, "fuzz.mclip"),
    // 4 million values, and 256 for each byte.
    ..FBX
};

/// A scene of any format that is known by its contents, to be written as FBX.
pub const FBX_OUT: Input = Input {
    name: "fbx_out",
    made: scene_seeds,
    base: 256 << 20,
    factor: 16_384,
    outputs: Outputs::Fbx,
    read: |bytes, importer| importer.read(bytes, "fuzz"),
    ..GLB
};

/// All of them.
pub const FORMATS: &[&Input] = &[&BVH, &ASF, &AMC, &C3D, &FBX, &GLB, &GLTF, &MCLIP, &FBX_OUT];

impl Input {
    /// Bytes as this kind of file. A panic is a finding.
    pub fn read(&self, bytes: &[u8], mesh: SkeletonMesh) -> Result<Scene> {
        (self.read)(bytes, &Importer::new().skeleton_mesh(mesh).gltf_meshes(true))
    }
}

/// Small motions, as this crate writes them.
fn glb_seeds() -> Vec<Vec<u8>> {
    let written = documents().map(|document| document.to_glb().expect("the fixture is written"));
    written.collect()
}

/// As above, in text, and one with a skin and a texture.
fn gltf_seeds() -> Vec<Vec<u8>> {
    let written = documents().map(|document| document.to_embedded().expect("the fixture is written"));
    let skin = include_bytes!("../../../fixtures/made/two_bones_textured.gltf");
    written.chain([skin.to_vec()]).collect()
}

/// Small motions as packed clips, with a key at every frame and at some.
fn mclip_seeds() -> Vec<Vec<u8>> {
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

/// Scenes with and without a motion, a skin, a texture.
fn scene_seeds() -> Vec<Vec<u8>> {
    let files = [
        "dialects/plain.bvh",
        "dialects/two_roots.bvh",
        "made/tiny.fbx",
        "made/two_bones_textured.gltf",
    ];
    let read = |name| fs::read(fixture(name)).expect("the fixture can be read");
    files
        .into_iter()
        .map(read)
        .chain(glb_seeds())
        .chain(gltf_seeds())
        .collect()
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

/// The first frames of a walk on the skeleton of `cmu_02.asf`.
fn motion() -> &'static [u8] {
    static MOTION: OnceLock<Vec<u8>> = OnceLock::new();
    MOTION.get_or_init(|| {
        let mut bytes = fs::read(fixture("real/cmu_02_01.amc")).expect("the fixture can be read");
        bytes.truncate(MOTION_LENGTH);
        bytes
    })
}

/// The path of a file, or of a folder, of the fixtures.
pub fn fixture(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures")).join(name)
}
