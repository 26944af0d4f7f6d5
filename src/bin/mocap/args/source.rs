//! What the caller knows of a file that the file does not state: its unit, its up axis, its bones.

use std::collections::BTreeMap;
use std::fs;
use std::str::FromStr;

use clap::ValueEnum;
use mocap::Scene;
use mocap::figure::{HumanoidBone, HumanoidMap, Unit};
use mocap::scene::UpAxis;
use serde::Deserialize;

/// The unit and the up axis of the input, for all commands that use both. Those of the output are [`OutArgs`].
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct SourceArgs {
    /// Unit of length of the input: auto, m, dm, cm, mm, inch, cmu (5.6444 cm), or metres in one unit
    #[arg(long, value_name = "UNIT", default_value = "auto")]
    unit: UnitArg,
    #[command(flatten)]
    up: SourceUpArgs,
}

/// The up axis of the input, for commands that have no use for its unit.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct SourceUpArgs {
    /// Up axis of the input
    #[arg(long, value_name = "AXIS", default_value = "auto", allow_hyphen_values = true)]
    up: UpArg,
}

/// The bones of the input.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading")]
pub(crate) struct MapArgs {
    /// Take the bones of this JSON file, of the shape that `mocap skeleton --json` prints; those that it does not name
    /// are searched for
    #[arg(long, value_name = "FILE", value_parser = read_map)]
    map: Option<HumanoidMap>,
}

impl SourceArgs {
    /// Metres in a unit of the input, where that is named.
    pub(crate) fn metres_per_unit(&self) -> Option<f64> {
        match self.unit {
            UnitArg::Auto => None,
            UnitArg::Metres(metres) => Some(metres),
        }
    }

    /// The up axis of the input, where it is named.
    pub(crate) fn up(&self) -> Option<UpAxis> {
        self.up.axis()
    }

    /// Lets the scene state what is named.
    pub(crate) fn state(&self, scene: &mut Scene) {
        if let Some(metres) = self.metres_per_unit() {
            scene.metadata.metres_per_unit = Some(metres);
        }
        self.up.state(scene);
    }
}

impl SourceUpArgs {
    fn axis(&self) -> Option<UpAxis> {
        match self.up {
            UpArg::Auto => None,
            UpArg::Y => Some(UpAxis::Y),
            UpArg::Z => Some(UpAxis::Z),
            UpArg::NegY => Some(UpAxis::NegY),
            UpArg::NegZ => Some(UpAxis::NegZ),
        }
    }

    /// Lets the scene state what is named.
    pub(crate) fn state(&self, scene: &mut Scene) {
        if let Some(up) = self.axis() {
            scene.metadata.up = Some(up);
        }
    }
}

impl MapArgs {
    pub(crate) fn bones(&self) -> HumanoidMap {
        self.map.clone().unwrap_or_default()
    }
}

/// The unit and the up axis of the output.
#[derive(Debug, clap::Args)]
pub(crate) struct OutArgs {
    /// Unit of length of the output: m, dm, cm, mm, inch, cmu, or metres in one unit [default: the input's; glTF is in
    /// metres]
    #[arg(long, value_name = "UNIT", value_parser = parse_unit)]
    out_unit: Option<f64>,
    /// Up axis of the output [default: the input's; glTF has +Y up]
    #[arg(long, value_name = "AXIS")]
    out_up: Option<OutUpArg>,
}

impl OutArgs {
    pub(crate) fn metres_per_unit(&self) -> Option<f64> {
        self.out_unit
    }

    pub(crate) fn up(&self) -> Option<UpAxis> {
        self.out_up.map(|up| match up {
            OutUpArg::Y => UpAxis::Y,
            OutUpArg::Z => UpAxis::Z,
        })
    }
}

/// `--unit`.
#[derive(Clone, Copy, Debug)]
enum UnitArg {
    Auto,
    Metres(f64),
}

impl FromStr for UnitArg {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            unit => match parse_unit(unit) {
                Ok(metres) => Ok(Self::Metres(metres)),
                Err(expected) => Err(format!("{expected}, or auto")),
            },
        }
    }
}

fn parse_unit(text: &str) -> Result<f64, String> {
    Unit::named(text)
        .map(Unit::metres)
        .or_else(|| text.parse().ok())
        .filter(|metres: &f64| metres.is_finite() && *metres > 0.0)
        .ok_or_else(|| "expected m, dm, cm, mm, inch, cmu or a number above 0".to_owned())
}

/// `--up`.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum UpArg {
    /// From the feet to the head
    Auto,
    Y,
    Z,
    #[value(name = "-y")]
    NegY,
    #[value(name = "-z")]
    NegZ,
}

/// `--out-up`.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum OutUpArg {
    Y,
    Z,
}

/// What `mocap skeleton --json` prints, or its part `humanoid`.
#[derive(Deserialize)]
struct MapFile {
    humanoid: Option<Box<MapFile>>,
    bones: Option<BTreeMap<HumanoidBone, Option<MapBone>>>,
}

#[derive(Deserialize)]
#[serde(untagged)]
enum MapBone {
    Name(String),
    Bone { joint: String },
}

pub(super) fn read_map(path: &str) -> Result<HumanoidMap, String> {
    let text = fs::read_to_string(path).map_err(|error| error.to_string())?;
    let file: MapFile = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    let bones = file.humanoid.and_then(|humanoid| humanoid.bones).or(file.bones);
    let bones = bones.ok_or("there is no object \"bones\": write {\"bones\": {\"hips\": \"NAME\", ...}}")?;
    let name = |joint| match joint {
        MapBone::Name(joint) | MapBone::Bone { joint } => joint,
    };
    Ok(bones.into_iter().map(|(bone, joint)| (bone, joint.map(name))).collect())
}
