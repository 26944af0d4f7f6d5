//! A packed clip: bytes from which a pose can be computed at any moment, without unpacking anything else.
//!
//! `docs/packed-clip.md` has the layout, byte by byte. The frames stand in blocks of equal length. A track of a block
//! has a straight line for each of its components, and a key is its distance from there in as few bits as the block
//! needs. All tracks of a key frame stand together, so that a pose reads the headers of a block, and two key frames.

#[doc(hidden)]
pub(crate) mod bits;
mod encoding;
mod layout;
mod lines;
mod read;
pub(crate) mod sample;
mod unpack;
mod write;

use std::borrow::Cow;

use mocap_scene::error::Result;
use mocap_scene::player::Player;
use mocap_scene::pose::Trs;
use mocap_scene::scene::Scene;

use self::encoding::Packed;
use self::layout::{RotationTrack, TranslationTrack};
use super::{CompressedClip, ErrorBound};

/// An animation in packed form, which gives its pose at any tick.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use mocap::compress::PackedClip;
/// use mocap::{Conversion, Trs};
///
/// let mut scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
/// Conversion::new().apply(&mut scene)?;
/// // No joint is more than a millimetre from its position, at any frame.
/// let packed = PackedClip::encode(&scene, 0, 0.001)?;
///
/// let clip = PackedClip::new(packed.bytes())?;
/// let mut pose = vec![Trs::IDENTITY; clip.node_count()];
/// clip.sample(7.5, &mut pose);
/// assert_eq!(clip.name(0), scene.nodes[0].name);
/// # Ok::<(), mocap::Error>(())
/// ```
///
/// A file that is broken is refused when it is opened. After that, nothing fails and nothing is allocated: a clip holds
/// the bytes and, for every node, less than 200 more.
#[derive(Clone, Debug)]
pub struct PackedClip<'a> {
    bytes: Cow<'a, [u8]>,
    /// The pose of constant nodes, and the rest pose of moving nodes.
    rest: Vec<Trs>,
    /// The rest transforms of nodes whose constant ones are others.
    at_rest: Vec<(u32, Trs)>,
    nodes: Vec<ClipNode>,
    rotations: Vec<RotationTrack>,
    translations: Vec<TranslationTrack>,
    frames: usize,
    ticks_per_second: f64,
    duration: f64,
    max_error: f32,
    /// Frames of a block, as a power of two.
    log2_block_frames: u32,
    /// Bytes of the key masks of a block; 0 where every frame has a key.
    mask_bytes: usize,
    /// Bits of the headers of all tracks of a block.
    header_bits: usize,
    /// The place of the ticks of the frames; absent if they are 0, 1, 2 and so on.
    ticks: Option<usize>,
    /// Where the offsets of the blocks stand.
    table: usize,
    /// Where the first block stands.
    blocks: usize,
}

/// What a clip knows of a node beside its pose.
#[derive(Clone, Copy, Debug)]
struct ClipNode {
    parent: Option<u16>,
    is_end_site: bool,
    /// Where its name stands.
    name: (usize, usize),
}

impl PackedClip<'static> {
    /// Packs an animation of `scene`, whose lengths are in metres: no joint or end site is more than `max_error` metres
    /// from its position, at any frame. An [`ErrorBound`] holds for a shell around each joint too.
    ///
    /// # Errors
    /// - [`Code::ErrorBound`](mocap_scene::Code::ErrorBound) if the bound cannot be kept
    /// - [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable) if a scale is not uniform and constant, a value
    ///   is not finite, there is no such animation or there are too many nodes
    /// - [`Code::LimitExceeded`](mocap_scene::Code::LimitExceeded) if there are too many frames
    pub fn encode(scene: &Scene, animation: usize, max_error: impl Into<ErrorBound>) -> Result<Self> {
        Ok(Self::pack(scene, animation, max_error.into())?.0)
    }

    /// A packed clip, and the clip before it was packed, which knows where its error is largest.
    #[doc(hidden)]
    pub fn pack(scene: &Scene, animation: usize, bound: ErrorBound) -> Result<(Self, CompressedClip)> {
        let (bytes, clip) = write::encode(scene, animation, &bound, &Packed)?;
        Ok((Self::new(bytes)?, clip))
    }
}

impl<'a> PackedClip<'a> {
    /// Opens a packed clip.
    ///
    /// # Errors
    /// [`Code::InvalidClip`](mocap_scene::Code::InvalidClip) where the bytes are not a whole and valid packed clip.
    pub fn new(bytes: impl Into<Cow<'a, [u8]>>) -> Result<Self> {
        Ok(read::open(bytes.into())?)
    }

    /// Whether bytes begin like a packed clip.
    #[doc(hidden)]
    pub fn sniff(bytes: &[u8]) -> bool {
        bytes.starts_with(&layout::MAGIC)
    }

    /// Numbers that change from frame to frame.
    #[doc(hidden)]
    pub fn values_a_frame(&self) -> usize {
        4 * self.rotations.len() + 3 * self.translations.len()
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes of the file, without a copy where the clip owns them.
    #[doc(hidden)]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes.into_owned()
    }

    /// How many nodes the skeleton has.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The name of a node; empty where there is no such node.
    pub fn name(&self, node: usize) -> &str {
        let name = self.nodes.get(node).and_then(|node| {
            let (start, end) = node.name;
            std::str::from_utf8(self.bytes.get(start..end)?).ok()
        });
        name.unwrap_or_default()
    }

    /// The parent of a node, which stands before it.
    pub fn parent(&self, node: usize) -> Option<usize> {
        self.nodes.get(node)?.parent.map(usize::from)
    }

    /// Whether a node is an end site, which is not animated.
    pub fn is_end_site(&self, node: usize) -> bool {
        self.nodes.get(node).is_some_and(|node| node.is_end_site)
    }

    /// Ticks per second.
    pub fn ticks_per_second(&self) -> f64 {
        self.ticks_per_second
    }

    /// The last tick.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// A clock for this clip, at its start.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::Trs;
    /// use mocap::compress::PackedClip;
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let clip = PackedClip::encode(&scene, 0, 0.001)?;
    /// let (mut player, mut pose) = (clip.player(), vec![Trs::IDENTITY; clip.node_count()]);
    /// // A tick is a tenth of a second, and the clip is 0.9 s long.
    /// for expected in [5.0, 1.0, 6.0] {
    ///     assert!((player.advance(0.5) - expected).abs() < 1e-9);
    ///     clip.sample(player.tick, &mut pose);
    /// }
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn player(&self) -> Player {
        Player::of_length(self.duration, self.ticks_per_second)
    }

    /// How many frames the source has.
    pub fn frame_count(&self) -> usize {
        self.frames
    }

    /// The largest distance of any joint from its position that was measured, in metres.
    pub fn max_error(&self) -> f64 {
        self.max_error.into()
    }
}
