//! The form of a job's output: a scene, the file of a character, the joints of a robot, or arrays.

use std::path::Path;

use mocap_figure::convert::{RestPoseSource, RootMotion};
use mocap_formats::fbx::FbxTextures;
use mocap_formats::gltf::{Character, Compression};
use mocap_formats::{FormatInfo, WriteOption, words};
use mocap_retarget::Target;
use mocap_scene::error::{Code, Diagnostic, Result};
use mocap_scene::scene::Format;

use super::array_layout::ArrayLayout;
use super::robot_format::RobotFormat;
use super::{JobTarget, MotionJob, OutputOptions, SourceFrames};

/// The form of an output.
#[derive(Clone, Copy, Debug)]
pub(super) enum Form {
    /// A scene, in a format of the table of formats.
    Scene(&'static FormatInfo),
    /// The file of a character with all its contents, and the added motions.
    Character,
    /// The positions of a robot's joints.
    Robot(RobotFormat),
    /// The arrays of a motion that keeps its skeleton.
    Arrays(ArrayLayout),
}

/// The extension of glTF in JSON. A character in glTF or VRM is passed through: its file is kept, and motions are
/// added.
const OF_TEXT: [&str; 1] = ["gltf"];
const OF_BINARY: [&str; 2] = ["glb", VRM];
const VRM: &str = "vrm";

impl Form {
    /// The form of a motion that keeps its skeleton, which may be a robot.
    pub(super) fn of_motion(writing: &OutputOptions, is_of_robot: bool) -> Result<Self> {
        let name = writing.extension();
        let form = match (RobotFormat::named(&name), ArrayLayout::named(&name)) {
            // A motion that is read from a VRM file is written as glTF. The glTF reader recognises VRM by the contents.
            _ if name == VRM => Self::Scene(FormatInfo::of(Format::Gltf)),
            (Some(format), _) if is_of_robot => Self::Robot(format),
            (_, Some(layout)) => Self::Arrays(layout),
            (Some(_), None) => {
                let message = format!(
                    "the format {name} contains the joint positions of a robot: if the input is the motion of a robot, \
                     name this robot in {{body}}; otherwise, retarget the motion to a robot"
                );
                return Err(Diagnostic::new(Code::InvalidValue, message).into());
            }
            (None, None) => {
                let known = FormatInfo::written_extensions();
                let known = format!("{known}, or for arrays .npz, .npy, .csv, .parquet or .pkl");
                Self::Scene(row(writing, &known)?)
            }
        };
        form.check(writing)?;
        Ok(form)
    }

    /// The file extension, if it differs from the name of the format.
    pub(super) fn extension(self) -> Option<&'static str> {
        match self {
            Self::Scene(_) | Self::Character => None,
            Self::Robot(format) => Some(format.extension()),
            Self::Arrays(layout) => Some(layout.extension()),
        }
    }

    /// Whether the output keeps the unit and the axes of the motion.
    pub(super) fn keeps_units(self) -> bool {
        match self {
            Self::Scene(row) => row.keeps_units(),
            Self::Arrays(layout) => layout.keeps_units(),
            Self::Robot(_) => true,
            Self::Character => false,
        }
    }

    /// Whether the rest pose of the output is the T-pose.
    pub(super) fn has_t_pose(self) -> bool {
        match self {
            Self::Scene(row) => row.states_bones,
            Self::Arrays(layout) => !layout.keeps_units(),
            Self::Robot(_) | Self::Character => false,
        }
    }

    /// The form of retargeted motions.
    pub(super) fn onto(writing: &OutputOptions, named: &JobTarget, target: &Target, has_disk: bool) -> Result<Self> {
        let extension = writing.extension();
        let form = match target {
            Target::Robot(_) => match RobotFormat::named(&extension) {
                Some(format) => Self::Robot(format),
                None => {
                    let of_robots = RobotFormat::ALL
                        .iter()
                        .filter(|format| format.name() == format.extension());
                    let of_robots = Vec::from_iter(of_robots.map(|format| format!(".{}", format.name())));
                    let known = format!("{}, {}", of_robots.join(", "), FormatInfo::written_extensions());
                    Self::Scene(row(writing, &known)?)
                }
            },
            Target::Character(character) => of_character(writing, named.file(), character, has_disk)?,
            Target::Skeleton(_) => Self::Scene(row(writing, &FormatInfo::written_extensions())?),
        };
        let keeps_fbx = |row: &FormatInfo| {
            let is_fbx = matches!(target, Target::Skeleton(scene) if scene.metadata.fbx.is_some());
            is_fbx && row.format == Format::Fbx
        };
        let keeps = match form {
            Self::Character => true,
            Self::Scene(row) => keeps_fbx(row),
            Self::Robot(_) | Self::Arrays(_) => false,
        };
        if let JobTarget::Character(character) = named
            && character.replace_animations
            && !keeps
        {
            let message = "{replace-animations} would do nothing: only an output in the format of the character, glTF, \
                           VRM or FBX, keeps its animations";
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        form.check(writing)?;
        Ok(form)
    }

    /// For a motion that keeps its skeleton: refuses options for the rest pose or the root that the output cannot
    /// represent.
    pub(super) fn check_frames(self, frames: &SourceFrames) -> Result<()> {
        let extension = self.extension().unwrap_or_default();
        let stated = [
            (WriteOption::Rest, frames.rest != RestPoseSource::default()),
            (WriteOption::RootMotion, frames.root == RootMotion::Extract),
        ];
        let mut stated = stated.into_iter().filter(|(_, is_stated)| *is_stated);
        match stated.find_map(|(option, _)| self.refusal(option, extension)) {
            Some(refusal) => Err(refusal.into()),
            None => Ok(()),
        }
    }

    /// The reason why the output of a job without a target cannot be compared with its source; `None` if it can.
    pub(super) fn no_verification(self, job: &MotionJob) -> Option<Diagnostic> {
        let SourceFrames {
            rest,
            root,
            t_pose_first,
            ..
        } = &job.source.frames;
        let is_other = *rest != RestPoseSource::default() || *root != RootMotion::Keep || *t_pose_first;
        let message = match self {
            Self::Robot(_) => "{verify} compares positions of joints, but the file has angles; leave it out",
            Self::Arrays(layout) if !layout.keeps_units() => {
                "{verify} compares joints by their names, but the layout has other joints; leave it out"
            }
            Self::Arrays(_) if is_other || !job.steps.is_empty() => {
                "for arrays, {verify} cannot repeat steps or changes of the root or the rest pose; leave it out"
            }
            _ => return None,
        };
        Some(Diagnostic::new(Code::InvalidValue, message))
    }

    /// The reason why an option of writing has no effect on the output; `None` if it has an effect.
    pub(super) fn refusal(self, option: WriteOption, extension: &str) -> Option<Diagnostic> {
        let gltf = FormatInfo::of(Format::Gltf);
        let what = match self {
            Self::Scene(row) => return row.refusal(option, extension),
            Self::Character if OF_KEYS.contains(&option) => return None,
            Self::Character if option == WriteOption::Embed && OF_TEXT.contains(&extension) => return None,
            Self::Character if !gltf.takes(option) => return gltf.refusal(option, extension),
            // Root motion is written to an existing node of the character.
            Self::Character if option == WriteOption::RootMotion => return None,
            Self::Character if option == WriteOption::BoneAxis => {
                let message = "{bone-axis} would rotate the joints' axes, but the meshes and extensions of a glTF or VRM \
                               character stay unchanged; write .fbx, or leave it out";
                return Some(Diagnostic::new(Code::InvalidValue, message));
            }
            Self::Character => "a character, because mocap keeps the contents of the character's file",
            Self::Robot(_) => "the joint positions of a robot",
            Self::Arrays(layout) if layout.takes(option) => return None,
            Self::Arrays(_) => "arrays",
        };
        let message = format!("{{{option}}} has no effect on {what}; omit this option");
        Some(Diagnostic::new(Code::InvalidValue, message))
    }

    /// Refuses options without an effect on the output, and values that the output cannot represent.
    fn check(self, writing: &OutputOptions) -> Result<()> {
        let extension = writing.extension();
        let mut stated = writing.stated().into_iter();
        if let Some(refusal) = stated.find_map(|option| self.refusal(option, &extension)) {
            return Err(refusal.into());
        }
        if let Some(wanted) = self.extension().filter(|wanted| names_another(&writing.output, wanted)) {
            let output = writing.output.display();
            let message = format!("{output}: the name of a file with arrays of {extension} must end in .{wanted}");
            return Err(Diagnostic::new(Code::InvalidValue, message).into());
        }
        let problem = match self {
            Self::Scene(row) => problem_of_bound(writing, row).or_else(|| problem_of_stream(writing)),
            Self::Character => problem_of_bound(writing, FormatInfo::of(Format::Gltf)),
            Self::Robot(_) | Self::Arrays(_) => None,
        };
        match problem {
            Some(message) => Err(Diagnostic::new(Code::InvalidValue, message).into()),
            None => Ok(()),
        }
    }
}

/// Whether the output's extension belongs to another format than `wanted`.
fn names_another(output: &Path, wanted: &str) -> bool {
    let own = output
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_ascii_lowercase();
    let is_known = FormatInfo::of_output(output).is_some()
        || ArrayLayout::named(&own).is_some_and(|layout| layout.extension() == own)
        || RobotFormat::named(&own).is_some_and(|format| format.extension() == own);
    is_known && own != wanted
}

/// Options of key storage: the only options for the animations of a character.
const OF_KEYS: [WriteOption; 3] = [WriteOption::Compress, WriteOption::MaxError, WriteOption::ShellDistance];

/// The row of the output's format. `known` are the allowed extensions.
fn row(writing: &OutputOptions, known: &str) -> Result<&'static FormatInfo> {
    let extension = writing.extension();
    FormatInfo::of_output(&Path::new("scene").with_extension(&extension)).ok_or_else(|| unknown(writing, known).into())
}

fn unknown(writing: &OutputOptions, known: &str) -> Diagnostic {
    let message = match (&writing.to, writing.is_stream()) {
        (None, _) if writing.is_folder() => format!(
            "{}: a folder does not name the format of its outputs: {{to}} must be {known}",
            writing.output.display()
        ),
        (None, false) if writing.output.as_os_str().is_empty() => {
            format!("the output has no name: name a file that ends in {known}")
        }
        (None, false) => format!(
            "{}: the name of the output must end in {known}",
            writing.output.display()
        ),
        _ => format!("{{to}}: the format must be {known}"),
    };
    Diagnostic::new(Code::UnknownFormat, message)
}

/// The form of motions on a character. A passed-through file keeps its format; other formats are written from the
/// character's scene.
fn of_character(writing: &OutputOptions, file: &Path, character: &Character, has_disk: bool) -> Result<Form> {
    let extension = writing.extension();
    let is_text = file.extension().is_some_and(|own| own.eq_ignore_ascii_case("gltf"));
    let (own, others): (&[&str], &[&str]) = match is_text {
        true => (&OF_TEXT, &OF_BINARY),
        false => (&OF_BINARY, &OF_TEXT),
    };
    let known = || {
        let is_passed_through = |extension: &&str| own.contains(extension) || others.contains(extension);
        let written = FormatInfo::ALL.iter().filter(|row| row.writes());
        let written = written.flat_map(|row| row.extensions.iter().copied());
        let from_scene = written.filter(|extension| !is_passed_through(extension));
        let listed = |extensions: &mut dyn Iterator<Item = &str>| {
            words(extensions.map(|extension| format!(".{extension}")), "or")
        };
        format!(
            "{}, like the character's file, or in {}; {{to-skeleton}} writes only the skeleton, without the meshes",
            listed(&mut own.iter().copied()),
            listed(&mut from_scene.into_iter())
        )
    };
    if others.contains(&extension.as_str()) {
        return Err(unknown(writing, &known()).into());
    }
    if !own.contains(&extension.as_str()) {
        return Ok(Form::Scene(row(writing, &known())?));
    }
    match character.external_files()?.first().filter(|_| has_disk) {
        Some(beside) => check_beside(writing, file, beside).map(|()| Form::Character),
        None => Ok(Form::Character),
    }
}

/// Refuses an output that would lose the link to a file in the character's folder.
fn check_beside(writing: &OutputOptions, file: &Path, beside: &str) -> Result<()> {
    let output = writing.output.as_path();
    let message = match writing.is_folder() {
        true => format!(
            "{}: outputs in a folder would not find {beside}, a file next to the character: name a character that \
             contains all its files, such as a .glb",
            file.display()
        ),
        false if file.parent() == output.parent() => return Ok(()),
        false => format!(
            "{} would not find {beside}, a file next to the character: write to the character's folder",
            output.display()
        ),
    };
    Err(Diagnostic::new(Code::InvalidValue, message).into())
}

/// Reports a largest error that the format cannot guarantee, or a shell distance without a largest error.
fn problem_of_bound(writing: &OutputOptions, row: &FormatInfo) -> Option<String> {
    let smaller = &writing.smaller;
    // Some formats have only one kind of key storage. Such a format always has a largest error, or does not support a
    // largest error.
    let chooses = row.takes(WriteOption::Compress);
    // Only 32-bit floats keep every key exactly.
    let is_exact = chooses && smaller.compress == Some(Compression::None);
    if smaller.max_error.is_some_and(|length| length.to_metres() == 0.0) && !is_exact {
        let exact = match chooses {
            true => "name a length above 0, or {compress} none",
            false => "name a length above 0, or leave it out",
        };
        let name = row.name;
        return Some(format!(
            "{{max-error}} 0: {name} cannot be exact with fewer keys or bits; {exact}"
        ));
    }
    (chooses && smaller.shell_distance.is_some() && !smaller.has_bound()).then(|| {
        "{shell-distance} would do nothing: it needs a largest error; add {max-error} 1mm, or leave it out".to_owned()
    })
}

/// Reports that textures cannot be written next to the output, if the output is standard output or a folder.
fn problem_of_stream(writing: &OutputOptions) -> Option<String> {
    if writing.fbx.textures != FbxTextures::Beside {
        return None;
    }
    let why = match (writing.is_stream(), writing.is_folder()) {
        (true, _) => "standard output is one file; name a file, not -, or leave it out",
        (_, true) => "textures of many files could have the same name; write one file at a time, or leave it out",
        (false, false) => return None,
    };
    Some(format!("{{textures}} beside: {why}"))
}
