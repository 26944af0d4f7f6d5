//! The options of the package: records of the library's jobs, and options that only the package has. Absent options
//! have the library's defaults.

use mocap::convert::Moment;
use mocap::figure::HumanoidMap;
use mocap::gltf::{Compression, GltfOptions};
use mocap::job::{
    BvhOutputOptions, CharacterTarget, InputOptions, JobTarget, JointNames, MeshStyle, OutputOptions, SizeOptions,
    SourceFrames, SourceSpace, UnitChoice, UpChoice,
};
use mocap::retarget::RetargetOptions;
use mocap::{Clips, Conversion, Diagnostic, Exporter, FormatInfo, Importer, Limits, WriteOption};
use serde::Deserialize;
use serde_json::Value;

use crate::failure::Failure;
use crate::given::Given;

/// The limits of the reader. WebAssembly has at most 4 GiB of memory, which must hold the file, its scene and the
/// output at the same time.
fn limits() -> Limits {
    Limits::new().max_bytes(512 << 20).max_values(1 << 26)
}

pub(crate) struct ReadOptions {
    reading: InputOptions,
    own: OwnReadOptions,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct OwnReadOptions {
    collapse_keys: Option<bool>,
    hash: Option<bool>,
    skeleton_mesh: Option<MeshStyle>,
    gltf_meshes: bool,
    morph_targets: bool,
}

impl ReadOptions {
    pub(crate) fn of(function: &'static str, options: Value) -> Result<Self, Failure> {
        let mut given = Given::new(function, options)?;
        // In a job the text `1` is also an index.
        let name = given.get("clip").and_then(Value::as_str).map(str::to_owned);
        let mut reading: InputOptions = given.take()?;
        if let Some(name) = name {
            reading.clip = Clips::Name(name);
        }
        let own = given.take()?;
        given.end()?;
        Ok(Self { reading, own })
    }

    pub(crate) fn importer(&self) -> Importer {
        let own = &self.own;
        let mut importer = self
            .reading
            .importer()
            .threads(1)
            .limits(limits())
            .gltf_meshes(own.gltf_meshes)
            .morph_targets(own.morph_targets)
            .skeleton_mesh(own.skeleton_mesh.unwrap_or(MeshStyle::Skinned).into());
        if let Some(collapse) = own.collapse_keys {
            importer = importer.collapse_keys(collapse);
        }
        match own.hash {
            Some(hash) => importer.hash(hash),
            None => importer,
        }
    }

    pub(crate) fn has_gltf_meshes(&self) -> bool {
        self.own.gltf_meshes
    }
}

pub(crate) struct ConvertOptions {
    space: SourceSpace,
    frames: SourceFrames,
    own: OwnConvertOptions,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct OwnConvertOptions {
    /// The unit of the result.
    out_unit: UnitChoice,
    out_up: UpChoice,
    keep_units: bool,
    bones: HumanoidMap,
    first: Option<Moment>,
    last: Option<Moment>,
    names: Option<JointNames>,
}

impl ConvertOptions {
    pub(crate) fn of(options: Value) -> Result<Self, Failure> {
        let mut given = Given::new("convert", options)?;
        let made = Self {
            space: given.take()?,
            frames: given.take()?,
            own: given.take()?,
        };
        given.end()?;
        Ok(made)
    }

    pub(crate) fn bones(&self) -> &HumanoidMap {
        &self.own.bones
    }

    pub(crate) fn conversion(&self) -> Conversion {
        let own = &self.own;
        let mut conversion = self
            .frames
            .conversion()
            .limits(limits())
            .keep_units(own.keep_units)
            .bones(own.bones.clone())
            .trim(own.first, own.last);
        if let Some(metres) = self.space.metres_per_unit() {
            conversion = conversion.metres_per_unit(metres);
        }
        if let Some(up) = self.space.up() {
            conversion = conversion.up(up);
        }
        if let Some(metres) = own.out_unit.metres() {
            conversion = conversion.out_metres_per_unit(metres);
        }
        match own.out_up.axis() {
            Some(up) => conversion.out_up(up),
            None => conversion,
        }
    }

    /// The new names of joints, if the caller wants other names.
    pub(crate) fn names(&self) -> Result<Option<HumanoidMap>, Failure> {
        match &self.own.names {
            Some(JointNames::File(name)) => Err(Failure::argument(format!(
                "names must be vrm, mixamo, unreal, cmu, godot, unity, mhr, soma or an object with the name of each bone, got {:?}",
                name.display().to_string()
            ))),
            names => Ok(names.as_ref().map(JointNames::names).transpose()?),
        }
    }
}

/// The options of all writers. Each writer reads its own options.
pub(crate) struct WriteOptions {
    writing: OutputOptions,
    /// The options set by the caller that only some formats take.
    stated: Vec<WriteOption>,
    /// The name of the clip in a picture.
    pub(crate) name: Option<String>,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct OwnWriteOptions {
    keep_constant: bool,
    skeleton_only: bool,
    name: Option<String>,
}

impl WriteOptions {
    pub(crate) fn of(options: Value) -> Result<Self, Failure> {
        let mut given = Given::new("write", options)?;
        let stated = WriteOption::ALL
            .into_iter()
            .filter(|option| given.states(option.as_str()));
        let stated = stated.collect();
        let own: OwnWriteOptions = given.take()?;
        let mut smaller: SizeOptions = given.take()?;
        let bvh: BvhOutputOptions = given.take()?;
        given.end()?;
        // With an error bound, a job quantizes keys by default; a call keeps 32-bit floats.
        smaller.compress.get_or_insert(Compression::None);
        let mut writing = OutputOptions::default();
        (writing.smaller, writing.bvh) = (smaller, bvh);
        (writing.keep_constant, writing.skeleton_only) = (own.keep_constant, own.skeleton_only);
        // The page gets a single file.
        writing.embed = true;
        Ok(Self {
            writing,
            stated,
            name: own.name,
        })
    }

    pub(crate) fn exporter(&self) -> Exporter {
        self.writing.exporter()
    }

    /// The storage of the clip in a character's file, which is passed through.
    pub(crate) fn gltf(&self) -> GltfOptions {
        self.writing.gltf().keep_constant(self.writing.keep_constant)
    }

    pub(crate) fn is_skeleton_only(&self) -> bool {
        self.writing.skeleton_only
    }

    /// Whether a shell distance is set without an error bound.
    pub(crate) fn is_shell_without_bound(&self) -> bool {
        let smaller = &self.writing.smaller;
        smaller.shell_distance.is_some() && !smaller.has_bound()
    }

    /// The reason why an option has no effect on a format.
    pub(crate) fn refusal(&self, row: &FormatInfo, extension: &str) -> Option<Diagnostic> {
        let mut stated = self.stated.iter();
        stated.find_map(|option| row.refusal(*option, extension))
    }
}

pub(crate) struct PoseRetargetOptions {
    character: CharacterTarget,
    own: OwnRetargetOptions,
}

#[derive(Default, Deserialize)]
#[serde(default, rename_all = "kebab-case")]
struct OwnRetargetOptions {
    bones: HumanoidMap,
    character_bones: HumanoidMap,
    name: Option<String>,
    limb_angles: bool,
}

impl PoseRetargetOptions {
    pub(crate) fn of(options: Value) -> Result<Self, Failure> {
        let mut given = Given::new("retarget", options)?;
        let made = Self {
            character: given.take()?,
            own: given.take()?,
        };
        given.end()?;
        Ok(made)
    }

    pub(crate) fn retargeting(&self) -> Result<RetargetOptions, Failure> {
        let options = JobTarget::Character(self.character.clone()).options()?;
        Ok(options
            .source_bones(self.own.bones.clone())
            .target_bones(self.own.character_bones.clone()))
    }

    /// The name of the clip.
    pub(crate) fn name(&self) -> Option<&str> {
        self.own.name.as_deref()
    }

    /// Whether to keep the angles between the limbs and the source's limbs, for the player.
    pub(crate) fn keeps_limb_angles(&self) -> bool {
        self.own.limb_angles
    }
}
