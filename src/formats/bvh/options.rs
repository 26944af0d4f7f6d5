//! The options of the writer.

use crate::ledger::LedgerOptions;
use mocap_scene::options::setters;
use mocap_scene::scene::RotationOrder;
use serde::{Deserialize, Serialize};

/// The joints with position channels.
///
/// [`BvhOptions`] has an example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Channels {
    /// The ROOT, and joints whose position differs from their OFFSET in some frame.
    #[default]
    Auto,
    /// Only the ROOT. Other joints keep their position of the first frame, and their position motion is lost.
    #[serde(rename = "3")]
    #[cfg_attr(feature = "clap", value(name = "3"))]
    Three,
    /// Every joint.
    #[serde(rename = "6")]
    #[cfg_attr(feature = "clap", value(name = "6"))]
    Six,
}

/// Options of the writer.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::bvh::{BvhOptions, Channels};
/// use mocap::scene::RotationOrder;
/// use mocap::{Exporter, Format};
///
/// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// let options = BvhOptions::new().order(RotationOrder::Yxz).digits(3).channels(Channels::Three);
/// let written = Exporter::new().bvh(options).write(&scene, Format::Bvh)?;
/// assert!(written.into_bytes()?.starts_with(b"HIERARCHY"));
/// # Ok::<(), mocap::Error>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct BvhOptions {
    /// The order of the rotation channels of all joints. Default: `None`, each joint's own order, or else `Zxy`.
    pub order: Option<RotationOrder>,
    /// The number of decimals. Default: `None`, as many as are needed to read the same keys back.
    pub digits: Option<usize>,
    /// The joints with position channels.
    pub channels: Channels,
    /// Whether to write a sidecar file, such as `walk.bvh.json` next to `walk.bvh`. It states how the BVH file was
    /// made, which BVH itself cannot store. Every BVH reader of this crate also reads the sidecar.
    pub sidecar: bool,
}

setters! {
    BvhOptions {
        order: Option<RotationOrder>,
        digits: Option<usize>,
        channels: Channels,
        sidecar: bool,
    }
}

impl BvhOptions {
    /// The options that change which data is lost.
    #[doc(hidden)]
    pub fn ledger(&self) -> LedgerOptions {
        LedgerOptions {
            rotations_only: self.channels == Channels::Three,
            sidecar: self.sidecar,
        }
    }
}
