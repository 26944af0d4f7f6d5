//! The options of an [`Importer`], one method each.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use mocap_scene::limits::Limits;
use mocap_scene::process::SkeletonMesh;
use mocap_scene::scene::{Format, RootOffset};

use super::{Clips, Importer};
#[cfg(doc)]
use mocap_scene::error::{Code, Error};
#[cfg(doc)]
use mocap_scene::scene::Scene;
#[cfg(doc)]
use mocap_scene::scene::report::Origin;
#[cfg(feature = "solve")]
use mocap_solve::{Lengths, MarkerWeights};

impl Importer {
    /// How the OFFSET and the position channels of a BVH root combine. Default: [`RootOffset::Auto`], which decides
    /// from the first frame and from the median of all frames.
    /// [`Metadata::root_offset`](mocap_scene::scene::Metadata::root_offset) has the decision and its reason.
    ///
    /// Programs combine them in different ways. The wrong choice moves the whole figure by the OFFSET.
    ///
    /// ```
    /// use mocap::{Importer, RootOffset};
    ///
    /// let text = b"HIERARCHY ROOT a { OFFSET 0 9 0 CHANNELS 3 Xposition Yposition Zposition }
    ///     MOTION Frames: 1 Frame Time: 0.1\n0 1 0\n";
    /// let height = |policy| -> Result<f32, mocap::Error> {
    ///     let scene = Importer::new().root_offset(policy).read(text, "a.bvh")?;
    ///     Ok(scene.animations[0].channels[0].position_keys.values[0].y)
    /// };
    /// assert_eq!(height(RootOffset::Replace)?, 1.0);
    /// assert_eq!(height(RootOffset::Add)?, 10.0);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn root_offset(mut self, policy: RootOffset) -> Self {
        self.read.root_offset = policy;
        self
    }

    /// The playback rate in frames per second. Default: the rate of the file.
    ///
    /// The motion keeps its frames and plays faster or slower; the scene records the change. To keep the speed and
    /// compute new frames, call [`Conversion::frame_rate`](mocap_figure::Conversion::frame_rate). Import fails with
    /// [`Code::InvalidValue`] if the rate is not finite and above 0.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let scene = mocap::Importer::new().retime(60.0).import("fixtures/real/lecture_Test.bvh")?;
    /// assert_eq!(scene.animations[0].ticks_per_second, 60.0);
    /// assert_eq!(scene.animations[0].frame_count(), 10);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn retime(mut self, frames_per_second: f64) -> Self {
        self.read.retime = Some(frames_per_second);
        self
    }

    /// The rate at which curves between keys are sampled, in frames per second. FBX has such curves. Default: the rate
    /// of the file.
    #[must_use]
    #[doc(hidden)]
    pub fn sampling_rate(mut self, frames_per_second: f64) -> Self {
        self.read.sampling_rate = Some(frames_per_second);
        self
    }

    /// Whether to read the rows of a BVH file beyond the number after `Frames:`. Default: `false`, the reader ignores
    /// those rows. In both cases a [`Code::FrameCount`] warning states the two numbers.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let text = b"HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 1 Frame Time: 0.1\n10\n20\n";
    /// let frames = |all| -> Result<usize, mocap::Error> {
    ///     Ok(Importer::new().all_rows(all).read(text, "a.bvh")?.animations[0].frame_count())
    /// };
    /// assert_eq!((frames(false)?, frames(true)?), (1, 2));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn all_rows(mut self, all: bool) -> Self {
        self.read.all_rows = all;
        self
    }

    /// Whether to keep the unit and the axes that an FBX file states. Default: `false`, lengths are converted to metres
    /// and the axes to +Y up. [`Metadata::metres_per_unit`](mocap_scene::scene::Metadata::metres_per_unit) and
    /// [`Metadata::up`](mocap_scene::scene::Metadata::up) have the result. Other formats always keep the units of the
    /// file.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// # #[cfg(feature = "fbx")] {
    /// use mocap::scene::UpAxis;
    ///
    /// let scene = mocap::Importer::new().file_units(true).import("fixtures/made/tiny.fbx")?;
    /// assert_eq!((scene.metadata.metres_per_unit, scene.metadata.up), (Some(0.01), Some(UpAxis::Z)));
    /// # }
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn file_units(mut self, keep: bool) -> Self {
        self.read.file_units = keep;
        self
    }

    /// Upper bounds for the counts and sizes in a file. Default: [`Limits::default`]. If a file exceeds a bound, import
    /// fails with [`Code::LimitExceeded`] before it allocates the memory. [`Limits`] has an example.
    #[must_use]
    pub fn limits(mut self, limits: Limits) -> Self {
        self.read.limits = limits;
        self
    }

    /// The animations to keep. Default: all. From a file of arrays with several persons, import reads one person, for
    /// example `Clips::Name("person_1")`. The default is the person with the most frames.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Clips;
    ///
    /// let importer = mocap::Importer::new().clips(Clips::Name("Run".to_owned()));
    /// let error = importer.import("fixtures/real/lecture_Test.bvh").unwrap_err();
    /// assert_eq!(error.code().as_str(), "invalid-value");
    /// ```
    #[must_use]
    pub fn clips(mut self, clips: Clips) -> Self {
        #[cfg(feature = "arrays")]
        {
            self.read.person = match &clips {
                Clips::Name(name) => Some(name.clone()),
                _ => None,
            };
        }
        self.clips = clips;
        self
    }

    /// Solves rotations from joint positions, with this joint set: smpl22, smpl24, coco17, h36m, mediapipe33,
    /// openpose25, mhr70, mhr127, or a JSON file for [`JointSet::from_json`](mocap_solve::JointSet::from_json).
    /// Default: an array with the joints of SMPL is solved. Other positions become points without a skeleton.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let scene = mocap::Importer::new().joints("smpl22").import("fixtures/arrays/points_smpl22.npy")?;
    /// assert_eq!(scene.nodes[0].name, "pelvis");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[cfg(feature = "solve")]
    #[must_use]
    pub fn joints(mut self, set: impl Into<String>) -> Self {
        self.joints = Some(set.into());
        self
    }

    /// The bone lengths of a skeleton that is solved from joint positions. Default: [`Lengths::Median`], the median of
    /// each length over the frames. Import fails with [`Code::InvalidValue`] if nothing is solved. It also fails for
    /// markers, because their skeleton always has constant lengths.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::solve::Lengths;
    ///
    /// let importer = mocap::Importer::new().lengths(Lengths::Moving);
    /// let scene = importer.import("fixtures/arrays/points_smpl22.npy")?;
    /// assert!(scene.animations[0].channels.iter().all(|channel| channel.position_keys.len() > 1));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[cfg(feature = "solve")]
    #[must_use]
    pub fn lengths(mut self, lengths: Lengths) -> Self {
        self.lengths = Some(lengths);
        self
    }

    /// Solves a skeleton with rotations from the markers of a file. The value is `auto` for labels of a known set
    /// (`docs/markers.md`), `auto:NAME` for one of several subjects, or a JSON file with an object from labels to
    /// landmarks. Default: markers become points without a skeleton.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let error = mocap::Importer::new().markers("auto").import("fixtures/real/optotrak.c3d").unwrap_err();
    /// assert!(error.to_string().contains("do not show where the legs are"));
    /// ```
    #[cfg(feature = "solve")]
    #[must_use]
    pub fn markers(mut self, names: impl Into<String>) -> Self {
        self.markers = Some(names.into());
        self
    }

    /// The weights of the marker solver. Default: [`MarkerWeights::default`], which has an example.
    #[cfg(feature = "solve")]
    #[must_use]
    pub fn marker_weights(mut self, weights: MarkerWeights) -> Self {
        self.marker_weights = weights;
        self
    }

    /// A file of a standing person, with markers that the motion may lack, such as markers inside of knees and ankles.
    /// The import then solves a skeleton, with `markers("auto")` unless [`Importer::markers`] is set.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let importer = mocap::Importer::new().static_trial("nosuch.trc");
    /// let error = importer.import("fixtures/real/optotrak.c3d").unwrap_err();
    /// assert!(error.to_string().contains("nosuch.trc"));
    /// ```
    #[cfg(feature = "solve")]
    #[must_use]
    pub fn static_trial(mut self, path: impl Into<PathBuf>) -> Self {
        self.standing = Some(path.into());
        self
    }

    /// The body for arrays of rotations, such as AMASS files. It is a file with a figure in any format, or a model of
    /// SMPL, SMPL-H or SMPL-X as `.npz` or `.pkl`. The shape of a model follows the shape coefficients of the motion.
    /// Default: a body of generic proportions, 1.70 m tall. Import fails with [`Code::InvalidValue`] if the input file
    /// has its own bone lengths.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let importer = mocap::Importer::new().body("fixtures/real/cmu_12_01_walk.bvh");
    /// let scene = importer.import("fixtures/arrays/amass_smplh.npz")?;
    /// let is_stated = |assumption: &mocap::scene::Assumption| assumption.choice.contains("bones of the given body");
    /// assert!(scene.metadata.assumptions.iter().any(is_stated));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[cfg(feature = "arrays")]
    #[must_use]
    pub fn body(mut self, path: impl Into<PathBuf>) -> Self {
        self.body = Some(path.into());
        self
    }

    /// The format. Default: detected from the contents, or else from the extension.
    ///
    /// With this option, a file whose beginning is broken is still read as the format, and the error names the line.
    ///
    /// ```
    /// use mocap::Importer;
    /// use mocap::scene::Format;
    ///
    /// let error = Importer::new().read(b"ROOT a {}", "take.txt").unwrap_err();
    /// assert_eq!(error.code().as_str(), "unknown-format");
    /// let error = Importer::new().format(Format::Bvh).read(b"ROOT a {}", "take.txt").unwrap_err();
    /// assert_eq!(error.code().as_str(), "missing-keyword");
    /// ```
    #[must_use]
    pub fn format(mut self, format: Format) -> Self {
        self.format = Some(format);
        self
    }

    /// The skeleton file of a motion whose skeleton is in a second file (`.amc` and its `.asf`). Default: a file in the
    /// folder of the motion. A motion that is read from memory has no default. Without a skeleton, import fails with
    /// [`Code::MissingFile`].
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    ///
    /// let motion = std::fs::read("fixtures/real/cmu_02_01.amc").unwrap();
    /// let importer = Importer::new();
    /// assert_eq!(importer.read(&motion, "walk.amc").unwrap_err().code().as_str(), "missing-file");
    /// let scene = importer.skeleton("fixtures/real/cmu_02.asf").read(&motion, "walk.amc")?;
    /// assert_eq!(scene.nodes[0].name, "root");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn skeleton(mut self, path: impl Into<PathBuf>) -> Self {
        self.skeleton = Some(path.into());
        self
    }

    /// The mesh that shows the skeleton. Default: [`SkeletonMesh::Segmented`]. A file with its own meshes, such as FBX,
    /// keeps its meshes instead. With [`SkeletonMesh::Own`] a file without meshes gets no mesh. With
    /// [`SkeletonMesh::None`] the scene has no meshes at all, and importing takes less time.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::{Importer, SkeletonMesh};
    ///
    /// let meshes = |kind| -> Result<usize, mocap::Error> {
    ///     Ok(Importer::new().skeleton_mesh(kind).import("fixtures/real/lecture_Test.bvh")?.meshes.len())
    /// };
    /// assert!(meshes(SkeletonMesh::Segmented)? > 1);
    /// assert_eq!((meshes(SkeletonMesh::Skinned)?, meshes(SkeletonMesh::None)?), (1, 0));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn skeleton_mesh(mut self, kind: SkeletonMesh) -> Self {
        self.skeleton_mesh = kind;
        self.read.without_meshes = kind == SkeletonMesh::None;
        self
    }

    /// Whether to read the meshes of a glTF file, with their skins, materials and colour textures. Default: `false`,
    /// only the skeleton and the animations are read. A mesh that cannot be read is skipped with a
    /// [`Code::IgnoredMesh`] warning.
    ///
    /// The meshes are in [`Scene::meshes`]. Each mesh has bones, like the meshes of an FBX file. A mesh without a skin
    /// is bound to its node. Morph targets have the initial weights of the file.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    ///
    /// let path = "fixtures/made/two_bones_textured.gltf";
    /// let scene = Importer::new().gltf_meshes(true).import(path)?;
    /// assert_eq!(scene.meshes[0].texture_coords.len(), scene.meshes[0].vertices.len());
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn gltf_meshes(mut self, read: bool) -> Self {
        self.read.gltf_meshes = read;
        self
    }

    /// Reads the meshes of the file in every format, and generates none. The skin shows where the soles are, so code
    /// that estimates the ground needs the skin.
    #[must_use]
    #[doc(hidden)]
    pub fn with_own_meshes(self) -> Self {
        self.skeleton_mesh(SkeletonMesh::Own).gltf_meshes(true)
    }

    /// An importer that reads characters with their meshes. It has default options, except that it reads morph targets
    /// if this importer does.
    #[must_use]
    #[doc(hidden)]
    pub fn for_characters(&self) -> Self {
        Self::new().gltf_meshes(true).morph_targets(self.read.morph_targets)
    }

    /// Whether to read data that only a comparison needs: the skeletons that mocap drew in USD, and both bind poses
    /// that an FBX file states.
    #[must_use]
    #[doc(hidden)]
    pub fn for_comparison(mut self, read: bool) -> Self {
        self.read.for_comparison = read;
        self
    }

    /// Whether to read the morph targets of meshes: the blend shapes of FBX and USD, and the morph targets of glTF if
    /// [`gltf_meshes`](Self::gltf_meshes) is set. Default: `false`. Targets that cannot be read are skipped with a
    /// [`Code::IgnoredMesh`] warning; their mesh is read without them.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    ///
    /// let importer = Importer::new().gltf_meshes(true).morph_targets(true);
    /// let scene = importer.import("fixtures/characters/human_vrm0.vrm")?;
    /// let targets = scene.meshes.iter().flat_map(|mesh| &mesh.morph_targets);
    /// assert!(targets.clone().any(|target| target.name == "blink" && target.weight == 0.0));
    /// assert!(targets.clone().all(|target| target.offsets.len() == target.vertex_ids.len()));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn morph_targets(mut self, read: bool) -> Self {
        self.read.morph_targets = read;
        self
    }

    /// Whether to read the triangles of a robot's mesh files, for pictures: STL, OBJ and COLLADA (`.dae`), with as much
    /// detail as a picture shows. Default: `false`, only the extent of STL and OBJ meshes is read.
    ///
    /// ```
    /// use mocap::retarget::robot::{add_links, robot_scene};
    /// use mocap::{Importer, MemoryFile};
    ///
    /// let robot = r#"<robot name="r"><link name="arm"><visual><geometry>
    ///     <mesh filename="package://r/meshes/arm.obj" scale="0.001 0.001 0.001"/>
    ///     </geometry></visual></link></robot>"#;
    /// let arm = b"v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 500\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 3 4\n";
    /// let robot = MemoryFile { name: "r.urdf", bytes: robot.as_bytes() };
    /// let arm = MemoryFile { name: "meshes/arm.obj", bytes: arm };
    /// let robot = Importer::new().robot_meshes(true).read_robot_among(robot, &[arm])?;
    /// let mut scene = robot_scene(&robot);
    /// add_links(&robot, &mut scene);
    /// assert_eq!(scene.meshes[0].indices.len(), 4 * 3);
    /// assert!(scene.meshes[0].vertices.iter().any(|vertex| vertex.z == 0.5));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn robot_meshes(mut self, read: bool) -> Self {
        self.robot_meshes = read;
        self
    }

    /// Whether to reduce a constant track to one key. Default: `true`. With `false` every rotation track has a key for
    /// each frame, as in the file.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let keys = |collapse| -> Result<usize, mocap::Error> {
    ///     let text = b"HIERARCHY ROOT a { CHANNELS 1 Xrotation } MOTION Frames: 3 Frame Time: 0.1\n5\n5\n5\n";
    ///     let scene = Importer::new().collapse_keys(collapse).read(text, "a.bvh")?;
    ///     Ok(scene.animations[0].channels[0].rotation_keys.len())
    /// };
    /// assert_eq!((keys(true)?, keys(false)?), (1, 3));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn collapse_keys(mut self, collapse: bool) -> Self {
        self.collapse_keys = collapse;
        self
    }

    /// Whether a warning fails the import. Default: `false`, [`Scene::warnings`] has the warnings. With `true` the
    /// first warning becomes the error, and [`Error::warnings`] has the other warnings. Marker gaps are not a fault:
    /// they stay warnings.
    ///
    /// ```
    /// use mocap::Importer;
    ///
    /// let text = b"HIERARCHY ROOT a { OFFSET 0 0 0 }";
    /// assert_eq!(Importer::new().read(text, "a.bvh")?.warnings[0].code.as_str(), "no-motion");
    /// let error = Importer::new().strict(true).read(text, "a.bvh").unwrap_err();
    /// assert_eq!(error.code().as_str(), "no-motion");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn strict(mut self, strict: bool) -> Self {
        self.strict = strict;
        self
    }

    /// Whether to compute [`Origin::sha256`]. Default: `true`, so that an output names its exact source file. Hashing
    /// takes about half as long as reading the numbers. With several threads, hashing and reading run in parallel.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// let scene = mocap::Importer::new().hash(false).import("fixtures/real/lecture_Test.bvh")?;
    /// assert_eq!(scene.metadata.origin.unwrap().sha256, "");
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn hash(mut self, hash: bool) -> Self {
        self.hash = hash;
        self
    }

    /// The largest number of threads that read one file. Default: 0, the number of cores. The scene does not depend on
    /// the number of threads. One thread reads files below a few MB.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Importer;
    ///
    /// let path = "fixtures/real/lecture_Test.bvh";
    /// assert_eq!(Importer::new().threads(1).import(path)?, Importer::new().threads(2).import(path)?);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn threads(mut self, threads: usize) -> Self {
        self.read.threads = NonZeroUsize::new(threads);
        self
    }
}
