//! The formats, and how bytes become an input of each format.

mod made;
mod search;
mod words;

use std::path::PathBuf;
use std::sync::OnceLock;
use std::{env, fs, process};

use mocap::biomechanics::TimeSeries;
use mocap::verify::Verifier;
use mocap::{Importer, Result, Scene, SkeletonMesh};

use self::words::{
    ACCLAIM_WORDS, BVH_WORDS, C3D_WORDS, CSV_WORDS, FBX_WORDS, GLTF_WORDS, MOT_WORDS, NPZ_WORDS, ROBOT_WORDS,
    TRC_WORDS, USD_WORDS, VRMA_WORDS,
};

/// Bytes of the motion for testing skeletons: the first frames of a walk.
const MOTION_LENGTH: usize = 2400;

/// A kind of file to try.
pub struct Input {
    /// The name of the format on the command line, and the extension of its seeds.
    pub name: &'static str,
    /// The folders of `fixtures` that hold its seeds.
    pub folders: &'static [&'static str],
    /// The size of the longest seed in bytes. Longer files are cut, or omitted if a part is useless.
    pub longest_seed: usize,
    /// Whether the first bytes of a longer file are a seed too.
    pub cut: bool,
    /// Seeds that are not in files.
    pub made: fn() -> Vec<Vec<u8>>,
    /// The keywords of its format.
    pub words: &'static [&'static str],
    /// The bytes of memory that any input may use, and the bytes that each byte of the input may add. An export holds
    /// the scene, its buffer, and the file.
    pub base: usize,
    /// See [`Input::base`].
    pub factor: usize,
    /// The check of the format's scenes, besides the rules of every scene.
    pub(crate) outputs: Outputs,
    read: fn(&[u8], &Importer) -> Result<Scene>,
}

/// The formats to which scenes are written.
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
    factor: 1024,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::Bvh).read(bytes, "fuzz.bvh"),
};

/// An Acclaim skeleton, alone and with a motion.
pub(crate) const ASF: Input = Input {
    name: "asf",
    folders: &["made", "real"],
    longest_seed: 8 << 10,
    cut: false,
    made: Vec::new,
    words: ACCLAIM_WORDS,
    base: 1 << 20,
    factor: 1024,
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
pub(crate) const AMC: Input = Input {
    name: "amc",
    folders: &["made", "real"],
    longest_seed: MOTION_LENGTH,
    cut: true,
    made: Vec::new,
    words: ACCLAIM_WORDS,
    base: 1 << 20,
    factor: 1024,
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
pub(crate) const C3D: Input = Input {
    name: "c3d",
    folders: &["made", "real"],
    longest_seed: 16 << 10,
    cut: true,
    made: Vec::new,
    words: C3D_WORDS,
    base: 1 << 20,
    factor: 1024,
    outputs: Outputs::Usual,
    read: |bytes, importer| {
        let scene = importer.clone().format(mocap::Format::C3d).read(bytes, "fuzz.c3d")?;
        // The reader refuses only broken channels and plates.
        let _ = (TimeSeries::analog(&scene), TimeSeries::ground_forces(&scene));
        Ok(scene)
    },
};

/// A TRC file.
pub(crate) const TRC: Input = Input {
    name: "trc",
    folders: &[],
    longest_seed: 16 << 10,
    cut: true,
    made: made::trc,
    words: TRC_WORDS,
    base: 1 << 20,
    // A marker is a joint, and needs only a name of one letter.
    factor: 8192,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::Trc).read(bytes, "fuzz.trc"),
};

/// Joint angles of OpenSim.
pub(crate) const MOT: Input = Input {
    name: "mot",
    made: made::mot,
    words: MOT_WORDS,
    // A file without frames still has a body of 22 joints.
    factor: 1024,
    read: |bytes, importer| importer.clone().format(mocap::Format::Mot).read(bytes, "fuzz.mot"),
    ..TRC
};

/// An FBX file.
pub(crate) const FBX: Input = Input {
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
pub(crate) const GLB: Input = Input {
    name: "glb",
    folders: &[],
    longest_seed: 64 << 10,
    cut: false,
    made: made::glb,
    words: GLTF_WORDS,
    base: 1 << 20,
    factor: 1024,
    outputs: Outputs::Usual,
    read: |bytes, importer| importer.clone().format(mocap::Format::Gltf).read(bytes, "fuzz.glb"),
};

/// A glTF text file that contains its buffer.
pub(crate) const GLTF: Input = Input {
    name: "gltf",
    made: made::gltf,
    read: |bytes, importer| importer.clone().format(mocap::Format::Gltf).read(bytes, "fuzz.gltf"),
    ..GLB
};

/// A packed clip.
pub(crate) const MCLIP: Input = Input {
    name: "mclip",
    folders: &[],
    longest_seed: 16 << 10,
    made: made::mclip,
    words: &["MCLP", "\0"],
    read: |bytes, importer| importer.clone().format(mocap::Format::Mclip).read(bytes, "fuzz.mclip"),
    // 4 million values, and 256 for each byte.
    ..FBX
};

/// A scene of any format that is known by its contents, to be written as FBX.
pub(crate) const FBX_OUT: Input = Input {
    name: "fbx_out",
    made: made::scenes,
    base: 256 << 20,
    factor: 16_384,
    outputs: Outputs::Fbx,
    read: |bytes, importer| importer.read(bytes, "fuzz"),
    ..GLB
};

/// A VRM animation.
pub(crate) const VRMA: Input = Input {
    name: "vrma",
    made: made::vrma,
    words: VRMA_WORDS,
    read: |bytes, importer| importer.clone().format(mocap::Format::Vrma).read(bytes, "fuzz.vrma"),
    ..GLB
};

/// Text of USD.
pub(crate) const USDA: Input = Input {
    name: "usda",
    folders: &["made"],
    made: made::usda,
    words: USD_WORDS,
    read: |bytes, importer| importer.clone().format(mocap::Format::Usd).read(bytes, "fuzz.usda"),
    ..GLB
};

/// An archive of USD.
pub(crate) const USDZ: Input = Input {
    name: "usdz",
    folders: &[],
    made: made::usdz,
    read: |bytes, importer| importer.clone().format(mocap::Format::Usd).read(bytes, "fuzz.usdz"),
    ..USDA
};

/// A motion of MikuMikuDance, on a model that is known.
pub(crate) const VMD: Input = Input {
    name: "vmd",
    folders: &["made"],
    made: Vec::new,
    words: &["\u{0}", "\u{1}"],
    read: |bytes, importer| {
        let importer = importer.clone().format(mocap::Format::Vmd);
        importer.skeleton(fixture("made/dancer.pmx")).read(bytes, "fuzz.vmd")
    },
    ..FBX
};

/// A model of MikuMikuDance, alone and with a motion, whose IK it solves.
pub(crate) const PMX: Input = Input {
    name: "pmx",
    read: |bytes, importer| {
        let alone = importer.clone().format(mocap::Format::Pmx).read(bytes, "fuzz.pmx");
        // The reader finds the model in a file. Each process has its own.
        let path = env::temp_dir().join(format!("mocap-fuzz-{}.pmx", process::id()));
        fs::write(&path, bytes).expect("the folder of temporary files can be written");
        let motion = fs::read(fixture("made/dancer.vmd")).expect("the fixture is there");
        let importer = importer.clone().format(mocap::Format::Vmd).skeleton(path);
        importer.read(&motion, "fuzz.vmd").or(alone)
    },
    ..VMD
};

/// A robot of ROS.
pub(crate) const URDF: Input = Input {
    name: "urdf",
    made: made::urdf,
    words: ROBOT_WORDS,
    base: 4 << 20,
    factor: 1024,
    read: |bytes, importer| importer.clone().format(mocap::Format::Urdf).read(bytes, "fuzz.urdf"),
    ..GLB
};

/// A robot of MuJoCo.
pub(crate) const MJCF: Input = Input {
    name: "mjcf",
    made: made::mjcf,
    read: |bytes, importer| importer.clone().format(mocap::Format::Mjcf).read(bytes, "fuzz.xml"),
    ..URDF
};

/// Arrays of NumPy, as a motion, or else as `verify` reads them.
pub(crate) const NPZ: Input = Input {
    name: "npz",
    folders: &["arrays"],
    longest_seed: 16 << 10,
    made: made::npz,
    words: NPZ_WORDS,
    base: 4 << 20,
    factor: 1024,
    read: |bytes, importer| {
        let read = importer.clone().format(mocap::Format::Npz).read(bytes, "fuzz.npz");
        read.or_else(|_| verified(bytes, "npz"))
    },
    ..GLB
};

/// One NumPy array.
pub(crate) const NPY: Input = Input {
    name: "npy",
    made: Vec::new,
    base: 64 << 20,
    read: |bytes, importer| importer.clone().format(mocap::Format::Npy).read(bytes, "fuzz.npy"),
    ..NPZ
};

/// Arrays in a pickle.
pub(crate) const PKL: Input = Input {
    name: "pkl",
    words: &[
        "poses",
        "trans",
        "body_pose",
        "global_orient",
        "c",
        "R",
        "b",
        "numpy\nndarray\n",
        "_reconstruct",
        "\u{94}",
    ],
    read: |bytes, importer| importer.clone().format(mocap::Format::Pickle).read(bytes, "fuzz.pkl"),
    ..NPY
};

/// Tensors of PyTorch.
pub(crate) const PT: Input = Input {
    name: "pt",
    read: |bytes, importer| importer.clone().format(mocap::Format::Torch).read(bytes, "fuzz.pt"),
    ..PKL
};

/// Arrays and positions in text, as a motion, and as `verify` reads them.
pub(crate) const CSV: Input = Input {
    name: "csv",
    folders: &[],
    made: made::csv,
    words: CSV_WORDS,
    read: |bytes, importer| {
        let verified = verified(bytes, "csv");
        let read = importer.clone().format(mocap::Format::Csv).read(bytes, "fuzz.csv");
        read.or(verified)
    },
    ..NPZ
};

/// The model of a body, for a motion that is known.
pub(crate) const BODY: Input = Input {
    name: "body",
    folders: &[],
    made: made::bodies,
    base: 64 << 20,
    words: &[
        "v_template",
        "J_regressor",
        "shapedirs",
        "kintree_table",
        "shape",
        "descr",
    ],
    read: |bytes, importer| {
        // A body is a file. Each process has its own.
        let path = env::temp_dir().join(format!("mocap-fuzz-{}.body", process::id()));
        fs::write(&path, bytes).expect("the folder of temporary files can be written");
        importer.clone().body(path).import(fixture("arrays/shaped_smplh.npz"))
    },
    ..NPZ
};

/// A database of motions, whose clip is the scene. The check searches the database, and steers a figure with it.
pub(crate) const MDB: Input = Input {
    name: "mdb",
    folders: &[],
    longest_seed: 64 << 10,
    made: search::databases,
    words: &[
        "mocapMDB",
        "\"frames\":",
        "\"packed\":",
        "\"mirrored\":",
        "\"leg\":",
        "MCLP",
    ],
    // A clip in a database uses as much memory as a separate clip, plus its frames on another skeleton.
    base: 256 << 20,
    factor: 16_384,
    read: |bytes, _| search::database(bytes),
    ..MCLIP
};

/// A motion graph of a known clip. The check walks over it.
pub(crate) const GRAPH: Input = Input {
    name: "graph",
    folders: &[],
    longest_seed: 64 << 10,
    made: search::graphs,
    words: &[
        "\"part\":",
        "\"from\":",
        "\"to\":",
        "\"distance\":",
        "\"frames\":",
        "\"rate\":",
        "null",
        "1e30",
    ],
    base: 64 << 20,
    factor: 1024,
    read: |bytes, _| search::graph(bytes),
    ..MCLIP
};

/// All kinds of input.
pub const FORMATS: &[&Input] = &[
    &BVH, &ASF, &AMC, &C3D, &TRC, &MOT, &FBX, &USDA, &USDZ, &VMD, &PMX, &GLB, &GLTF, &VRMA, &MCLIP, &URDF, &MJCF, &NPZ,
    &NPY, &PKL, &PT, &CSV, &BODY, &FBX_OUT, &MDB, &GRAPH,
];

impl Input {
    /// Bytes as this kind of file. A panic is a finding.
    pub fn read(&self, bytes: &[u8], mesh: SkeletonMesh) -> Result<Scene> {
        (self.read)(bytes, &Importer::new().skeleton_mesh(mesh).gltf_meshes(true))
    }
}

/// The verdict on arrays of a small motion: an error, or the motion. `verify` opens only files.
fn verified(bytes: &[u8], extension: &str) -> Result<Scene> {
    let source = fixture(made::ARRAYS_OF);
    let path = env::temp_dir().join(format!("mocap-fuzz-{}.{extension}", process::id()));
    fs::write(&path, bytes).expect("the folder of temporary files can be written");
    Verifier::new().files(&source, &path)?;
    mocap::import(source)
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
