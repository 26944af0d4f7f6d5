//! Writes scenes to files. It is the counterpart of [`Importer`](crate::Importer).

#[cfg(feature = "parquet")]
#[doc(hidden)]
pub mod parquet;

use std::path::Path;

use mocap_compress::ErrorBound;
use mocap_figure::convert::Conversion;
use mocap_figure::{Figure, Humanoid};
use mocap_formats::bvh::BvhOptions;
use mocap_formats::fbx::FbxOptions;
use mocap_formats::gltf::{BufferPlace, Compression};
use mocap_formats::{Export, FormatInfo, ReadOptions, Source, WriteOptions, read_back};
use mocap_scene::error::{Code, Diagnostic, Error, Result};
use mocap_scene::files::ReplacePolicy;
use mocap_scene::pose::Trs;
use mocap_scene::process;
use mocap_scene::scene::report::{DataKind, DataLoss};
use mocap_scene::scene::{Assumption, Format, Node, Original, Scene, Topic};

/// Writes scenes, with options, in every format that mocap writes.
///
/// glTF, VRM animations and packed clips are in metres with +Y up. FBX and USD state their unit. So the exporter needs
/// the unit of the scene. It takes the first unit that is available:
///
/// 1. the unit that you state with [`Conversion`], which converts the scene before the export;
/// 2. the unit that the source file of the scene states;
/// 3. if the source file states no unit (BVH), the guess of `Conversion`. A warning with the code [`Code::UnknownUnit`]
///    has the guess and its reason, and the output records the guess.
///
/// The exporter converts a copy of the scene. `Conversion` converts the scene itself.
///
/// In two cases the exporter does not convert lengths, and warns. Either the scene was not read from a file, or
/// [`Conversion::keep_units`](mocap_figure::Conversion::keep_units) keeps its unit. A BVH output has the numbers of the
/// scene, because BVH has no unit. The rest pose of BVH has no rotations. If the rest pose of the scene has rotations,
/// the BVH output has joints whose axes are parallel to the world axes.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Exporter, Format};
///
/// let walk = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?; // nobody states its unit
/// let written = Exporter::new().write(&walk, Format::Gltf)?;
/// println!("{}", written.warnings[0].message); // inferred unit: cmu, because the bones from ankle to head ...
/// let again = mocap::Importer::new().read(&written.into_bytes()?, "walk.glb")?;
/// let head = again.nodes.iter().position(|node| node.name == "Head").unwrap();
/// let pose = mocap::Pose::at_tick(&again, 0, 30.0).unwrap();
/// let height = pose.node_to_world[head].w_axis.y;
/// assert!((1.2..1.8).contains(&height), "{height}"); // metres
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// A format ignores an option that it does not take; [`FormatInfo::takes`] lists its options. [`Export`] has the
/// warnings of an output.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::{Conversion, Exporter};
///
/// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// Conversion::new().apply(&mut scene)?;
/// let folder = tempfile::tempdir().unwrap();
/// for name in ["walk.glb", "walk.gltf", "walk.bvh", "walk.fbx", "walk.mclip"] {
///     let written = Exporter::new().max_error(0.001).export(&scene, folder.path().join(name))?;
///     assert!(written.warnings.is_empty());
/// }
/// assert!(folder.path().join("walk.bin").exists()); // the buffer of walk.gltf
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Exporter {
    format: Option<Format>,
    policy: ReplacePolicy,
    overwrite: bool,
    options: WriteOptions,
}

impl Exporter {
    /// An exporter with the default options.
    pub fn new() -> Self {
        Self::default()
    }

    /// The format. Default: the format of the path's extension.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::{Exporter, Format};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let folder = tempfile::tempdir().unwrap();
    /// Exporter::new().format(Format::Bvh).export(&scene, folder.path().join("take.txt"))?;
    /// assert!(std::fs::read(folder.path().join("take.txt")).unwrap().starts_with(b"HIERARCHY"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn format(mut self, format: Format) -> Self {
        self.format = Some(format);
        self
    }

    /// The error bound. The exporter removes keys and rounds numbers within this bound. Without a bound, it writes
    /// every key unchanged. For a packed clip, the default is the default of [`ErrorBound`].
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::compress::ErrorBound;
    /// use mocap::{Conversion, Exporter, Format};
    ///
    /// let mut scene = mocap::import("fixtures/real/cmu_12_01_walk.bvh")?;
    /// Conversion::new().apply(&mut scene)?;
    /// let bound = ErrorBound::new(0.001).shell_distance(0.03);
    /// let [whole, smaller] = [Exporter::new(), Exporter::new().error_bound(bound)];
    /// let length = |exporter: Exporter| Ok::<_, mocap::Error>(exporter.write(&scene, Format::Gltf)?.len());
    /// assert!(2 * length(smaller)? < length(whole)?);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn error_bound(mut self, bound: impl Into<ErrorBound>) -> Self {
        self.options.error_bound = Some(bound.into());
        self
    }

    /// The largest distance of a joint or end site from its original position, in metres. Sets the distance of
    /// [`Exporter::error_bound`].
    #[must_use]
    pub fn max_error(mut self, metres: f64) -> Self {
        let bound = self.options.error_bound.get_or_insert_default();
        bound.max_error = metres;
        self
    }

    /// The radius of a shell around each joint, in metres. The largest error also applies to the points of the shell,
    /// which represent a skin. Default: the radius of [`Exporter::error_bound`]. FBX uses a radius of at least 3 cm.
    /// Without a largest error, the radius has no effect.
    #[must_use]
    pub fn shell_distance(mut self, metres: f64) -> Self {
        self.options.shell_distance = Some(metres);
        self
    }

    /// How glTF stores keys. Default: [`Compression::Int16`] with a largest error, [`Compression::None`] without one. A
    /// compression other than `None` without a largest error uses the default of [`ErrorBound`].
    #[must_use]
    pub fn compression(mut self, compression: Compression) -> Self {
        self.options.compression = Some(compression);
        self
    }

    /// Whether glTF also has channels for constant tracks, for engines that blend clips channel by channel. Default:
    /// `false`, which stores a constant value only in the node.
    #[must_use]
    pub fn keep_constant(mut self, keep: bool) -> Self {
        self.options.keep_constant = keep;
        self
    }

    /// Where a `.gltf` has its buffer. Default: in a `.bin` file in the same folder.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Exporter;
    /// use mocap::gltf::BufferPlace;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let written = Exporter::new().write_as(&scene, "walk.gltf")?;
    /// assert_eq!(written.files[0].name(), "walk.bin");
    /// let written = Exporter::new().buffer(BufferPlace::Embedded).write_as(&scene, "walk.gltf")?;
    /// assert_eq!(written.files.len(), 1);
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn buffer(mut self, buffer: BufferPlace) -> Self {
        self.options.buffer = buffer;
        self
    }

    /// The BVH options: rotation order, decimals, position channels.
    #[must_use]
    pub fn bvh(mut self, options: BvhOptions) -> Self {
        self.options.bvh = options;
        self
    }

    /// The FBX options: version, unit, axes, root, textures. [`FbxOptions::error_bound`], if set, is the error bound of
    /// the exporter.
    #[must_use]
    pub fn fbx(mut self, options: FbxOptions) -> Self {
        let bound = options.error_bound.clone();
        self.options.fbx = options;
        match bound {
            Some(bound) => self.error_bound(bound),
            None => self,
        }
    }

    /// The joint of each humanoid bone, for a VRM animation. Default: [`Humanoid::of`](mocap_figure::Humanoid::of)
    /// finds the joints.
    #[must_use]
    pub fn humanoid(mut self, humanoid: Humanoid) -> Self {
        self.options.humanoid = Some(humanoid);
        self
    }

    /// The complete motion, if the scene has only some of its frames. The exporter computes the T-pose of a VRM
    /// animation from the complete motion.
    #[doc(hidden)]
    pub fn t_pose_shown_by(mut self, whole: Option<Box<Scene>>) -> Self {
        self.options.whole = whole;
        self
    }

    /// The files that an output may replace. Default: [`ReplacePolicy::default`], which replaces no file that may be a
    /// source.
    #[must_use]
    pub fn replace(mut self, policy: ReplacePolicy) -> Self {
        self.policy = policy;
        self
    }

    /// Whether an output may replace any existing file except an input. Inputs are the files that the policy of
    /// [`Exporter::replace`] names. Default: `false`.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Exporter;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let folder = tempfile::tempdir().unwrap();
    /// let path = folder.path().join("walk.bvh");
    /// std::fs::write(&path, "somebody's work").unwrap();
    /// let error = Exporter::new().export(&scene, &path).unwrap_err();
    /// assert_eq!(error.code().as_str(), "output-exists");
    /// Exporter::new().overwrite(true).export(&scene, &path)?;
    /// # Ok::<(), mocap::Error>(())
    /// ```
    #[must_use]
    pub fn overwrite(mut self, overwrite: bool) -> Self {
        self.overwrite = overwrite;
        self
    }

    /// Writes `scene` to `path`, and its companion files to the same folder. The exporter writes all files or none:
    /// after an error the folder is unchanged.
    ///
    /// # Errors
    /// - the errors of [`Exporter::write_as`]
    /// - [`Code::OutputIsInput`] and [`Code::OutputExists`], by the rules of [`ReplacePolicy`]
    /// - [`Code::Io`]
    pub fn export(&self, scene: &Scene, path: impl AsRef<Path>) -> Result<Export> {
        let path = path.as_ref();
        let written = self.write_as(scene, path)?;
        let mut policy = self.policy.clone();
        if let Some(origin) = &scene.metadata.origin {
            policy = policy.source_name(&origin.name);
        }
        match self.overwrite {
            true => written.save(path, &policy.force(true))?,
            false => written.save(path, &policy)?,
        }
        Ok(written)
    }

    /// Returns the files of `scene` in a format, in memory. The files have the format's first extension: `.glb` for
    /// glTF.
    ///
    /// # Errors
    /// The errors of [`Exporter::write_as`].
    pub fn write(&self, scene: &Scene, format: Format) -> Result<Export> {
        let extension = FormatInfo::of(format).extensions[0];
        self.clone()
            .format(format)
            .write_as(scene, format!("scene.{extension}"))
    }

    /// Returns, in memory, the files that [`Exporter::export`] would write to `path`.
    ///
    /// # Errors
    /// - [`Code::UnknownFormat`]: mocap cannot write the format or the extension of `path`.
    /// - [`Code::Unrepresentable`]: the format cannot hold the scene. The message names the joint.
    /// - [`Code::FrameTime`]: the ticks per second are not above 0.
    /// - [`Code::NoMotion`]: the format needs an animation.
    /// - [`Code::ErrorBound`]: the output cannot keep the largest error.
    /// - [`Code::InvalidValue`]: an option is invalid.
    /// - [`Code::LimitExceeded`], [`Code::NumberRange`]: the file is too large for its format or for the reader.
    /// - [`Code::MissingFeature`]: this build has no meshopt.
    pub fn write_as(&self, scene: &Scene, path: impl AsRef<Path>) -> Result<Export> {
        let path = path.as_ref();
        let row = match self.format {
            Some(format) => Some(FormatInfo::of(format)),
            None if is_vrm(path) => Some(vrm_row(scene, path)?),
            None => FormatInfo::of_output(path),
        };
        let Some(row) = row else {
            return Err(unknown(self.format, path));
        };
        let metadata = &scene.metadata;
        let may_convert = metadata.format.is_some() && scene.original.is_none() && !metadata.keeps_unknown_unit;
        if may_convert && metadata.metres_per_unit.is_none() && !row.keeps_units() {
            return self.write_in_metres(scene, path, row);
        }
        match self.write_scene(scene, path, row) {
            Ok(written) if may_convert && written.warnings.iter().any(is_of_unit) => {
                self.write_in_metres(scene, path, row)
            }
            Err(error) if may_convert && is_of_unit(error.diagnostic()) => self.write_in_metres(scene, path, row),
            written => written,
        }
    }

    /// Writes a scene that no [`Conversion`] converted, in metres with +Y up. Guesses the unit if the source file
    /// states none.
    fn write_in_metres(&self, scene: &Scene, path: &Path, row: &'static FormatInfo) -> Result<Export> {
        let mut in_metres = scene.clone();
        let figure = match &self.options.humanoid {
            Some(humanoid) => Figure::with_bones(scene, humanoid.clone()),
            None => Figure::new(scene),
        };
        let (guesses, _) = Conversion::new().convert(&mut in_metres, &figure)?;
        let mut written = self.write_scene(&in_metres, path, row)?;
        let of_space = guesses
            .iter()
            .filter(|guess| matches!(guess.topic, Topic::Unit | Topic::Up));
        written.warnings.extend(of_space.map(inferred));
        Ok(written)
    }

    fn write_scene(&self, scene: &Scene, path: &Path, row: &'static FormatInfo) -> Result<Export> {
        let options = WriteOptions {
            name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            ..self.options.clone()
        };
        // If the writer copies the original file, the nodes in the copy keep their shear.
        let is_lost = !row.keeps_shear && scene.original.is_none();
        let unsheared = is_lost.then(|| process::take_shear_out(scene)).flatten();
        let scene = unsheared.as_ref().map_or(scene, |unsheared| &unsheared.scene);
        let in_order = (row.has_one_clip && scene.main_clip() > 0).then(|| {
            let mut in_order = scene.clone();
            in_order.put_main_clip_first();
            in_order
        });
        let scene = in_order.as_ref().unwrap_or(scene);
        let mut losses = row.losses(scene, options.bvh.ledger());
        let written = match is_at_rest_for(scene, row) {
            true => row.write(scene, &options),
            false => {
                let mut at_rest = scene.clone();
                process::zero_rest_rotations(&mut at_rest)?;
                row.write(&at_rest, &options)
            }
        };
        let mut written = written.unwrap_or_else(|| Err(unknown(self.format, path)))?;
        written
            .warnings
            .extend(unsheared.as_ref().map(|unsheared| lost_shear(row, unsheared)));
        // The losses that the writer itself counted are added to the losses of the same kind.
        for loss in std::mem::take(&mut written.losses) {
            match losses.iter_mut().find(|known| known.kind == loss.kind) {
                Some(known) => known.count += loss.count,
                None => losses.push(loss),
            }
        }
        let read = |source: &Source<'_>, options: &ReadOptions| row.read(source, options);
        let is_moving = scene.moves() || losses.iter().any(|loss| loss.kind == DataKind::FaceCurves);
        if is_moving && losses.iter().any(|loss| loss.kind.is_motion()) && read_back::is_still(&read, &written.files) {
            return Err(Error::from(nothing_moves(row, &losses)).with_path(path));
        }
        written.warnings.extend(row.loss_warnings(&losses));
        written.losses = losses;
        read_back::check(&read, &written.files, &scene.nodes, scene.animations.iter())
            .map_err(|error| error.with_path(path))?;
        Ok(written)
    }
}

/// The error for an output without motion whose source moves.
#[doc(hidden)]
pub fn nothing_moves(row: &FormatInfo, losses: &[DataLoss]) -> Diagnostic {
    let of_motion = || losses.iter().filter(|loss| loss.kind.is_motion());
    let lost: Vec<String> = of_motion().map(ToString::to_string).collect();
    let message = format!(
        "the output would have no motion, because {} cannot hold {}",
        row.name,
        lost.join(", ")
    );
    // If the format loses the face, the help must be about the face: another clip would not move either.
    let of_face = of_motion().filter(|loss| loss.kind == DataKind::FaceCurves);
    let help = of_face.chain(of_motion()).find_map(|loss| row.remedy(loss.kind));
    let error = Diagnostic::new(Code::Unrepresentable, message);
    match help {
        Some(help) => error.help(help),
        None => error.help("write another format, such as .glb"),
    }
}

fn is_of_unit(warning: &Diagnostic) -> bool {
    warning.code == Code::UnknownUnit
}

/// The warning about a unit or axis that the output needs and the file does not state.
fn inferred(guess: &Assumption) -> Diagnostic {
    Diagnostic::new(Code::UnknownUnit, format!("inferred {guess}")).help(
        "if this is wrong, state the unit and the up axis first: \
         Conversion::new().metres_per_unit(0.01).up(UpAxis::Y).apply(&mut scene)",
    )
}

/// The length of the vector part of a quaternion above which a rest pose counts as rotated: the rounding error of a
/// decomposed matrix.
const ROTATED: f32 = 1e-4;

/// The warning of a format whose nodes have only translation, rotation and scale.
fn lost_shear(row: &FormatInfo, unsheared: &process::ShearOutcome) -> Diagnostic {
    let nodes = match unsheared.nodes {
        1 => "a node".to_owned(),
        nodes => format!("{nodes} nodes"),
    };
    let message = format!(
        "the axes of {nodes} shear at rest, which {} cannot store: they are up to {:.2} degrees from right angles, and \
         the file has right angles",
        row.name, unsheared.degrees
    );
    Diagnostic::new(Code::Unrepresentable, message)
        .in_joint(&unsheared.most)
        .help("write .usda, which keeps sheared axes; or apply the transforms in the program that made the file")
}

/// Whether a format can hold the rest pose of a scene. If it cannot, the writer aligns the axes of the joints with the
/// world axes, so that the rest pose has no rotations. No joint moves.
#[doc(hidden)]
pub fn is_at_rest_for(scene: &Scene, row: &FormatInfo) -> bool {
    let is_rotated = |node: &Node| {
        let rotation = Trs::from_matrix(node.transform).rotation;
        rotation.xyz().length() > ROTATED
    };
    row.has_rest_rotations || !scene.nodes.iter().any(is_rotated) || process::can_zero_rest_rotations(scene).is_err()
}

fn is_vrm(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("vrm"))
}

/// The table row for a `.vrm`: glTF that keeps the humanoid and the meshes of a VRM file.
fn vrm_row(scene: &Scene, path: &Path) -> Result<&'static FormatInfo> {
    if scene.original.as_ref().is_some_and(Original::is_vrm) {
        return Ok(FormatInfo::of(Format::Gltf));
    }
    let message = "a .vrm output needs the character of a VRM file, and the motion has no such character";
    let diagnostic = Diagnostic::new(Code::Unrepresentable, message)
        .help("write .glb or .vrma, or retarget the motion to a character: mocap retarget INPUT HERO.vrm");
    Err(Error::from(diagnostic).with_path(path))
}

/// The error for an output format that mocap cannot write.
fn unknown(format: Option<Format>, path: &Path) -> Error {
    let found = match (format, path.extension()) {
        (Some(format), _) => format!("the format {format}"),
        (None, Some(extension)) => format!(".{}", extension.to_string_lossy()),
        (None, None) => "no extension".to_owned(),
    };
    let message = "the output has no format that mocap can write";
    let diagnostic = Diagnostic::new(Code::UnknownFormat, message)
        .expected_found(FormatInfo::written_extensions(), found)
        .help("change the extension, or name the format: Exporter::format");
    Error::from(diagnostic).with_path(path)
}
