//! A packed clip: bytes from which a pose can be computed at any time, without unpacking the rest.
//!
//! `docs/packed-clip.md` has the layout, byte by byte. The frames are in blocks of equal length. In a block, each
//! component of a track has a straight line. A key is stored as its difference from the line, in as few bits as the
//! block needs. All tracks of a key frame are stored together, so that a pose reads the headers of one block and two
//! key frames.

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

/// An animation in packed form. It gives its pose at any tick.
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
/// The constructor refuses a broken file. After that, no call fails or allocates. In memory, a clip takes its bytes and
/// less than 200 bytes more for every node.
#[derive(Clone, Debug)]
pub struct PackedClip<'a> {
    bytes: Cow<'a, [u8]>,
    /// For each node, its transform: constant if the node does not move, otherwise the transform of the rest pose.
    rest: Vec<Trs>,
    /// The transforms in the rest pose that differ from the constant transform of the node, each with the index of the
    /// node.
    at_rest: Vec<(u32, Trs)>,
    nodes: Vec<ClipNode>,
    rotations: Vec<RotationTrack>,
    translations: Vec<TranslationTrack>,
    frames: usize,
    ticks_per_second: f64,
    duration: f64,
    max_error: f32,
    /// The binary logarithm of the number of frames in a block.
    log2_block_frames: u32,
    /// The size of a block's key mask in bytes; 0 if every frame has a key.
    mask_bytes: usize,
    /// The size of all track headers of a block, in bits.
    header_bits: usize,
    /// The byte position of the ticks of the frames; `None` if the ticks are 0, 1, 2 and so on.
    ticks: Option<usize>,
    /// The byte position of the table of block offsets.
    table: usize,
    /// The byte position of the first block.
    blocks: usize,
}

/// The data of a node except its pose.
#[derive(Clone, Copy, Debug)]
struct ClipNode {
    parent: Option<u16>,
    is_end_site: bool,
    /// The position of the first byte of its name, and the position after the last byte.
    name: (usize, usize),
}

impl PackedClip<'static> {
    /// Packs an animation of `scene`, whose lengths must be in metres. Every joint and end site stays within
    /// `max_error` metres of its position, at every frame. An [`ErrorBound`] also covers a shell around each joint.
    ///
    /// # Errors
    /// - [`Code::ErrorBound`](mocap_scene::Code::ErrorBound) if the bound cannot be kept
    /// - [`Code::Unrepresentable`](mocap_scene::Code::Unrepresentable) if a scale is not uniform and constant, a value
    ///   is not finite, there is no such animation or there are too many nodes
    /// - [`Code::LimitExceeded`](mocap_scene::Code::LimitExceeded) if there are too many frames
    pub fn encode(scene: &Scene, animation: usize, max_error: impl Into<ErrorBound>) -> Result<Self> {
        Ok(Self::pack(scene, animation, max_error.into())?.0)
    }

    /// Returns a packed clip, and the compressed clip from which it was packed. The compressed clip states the node and
    /// the tick of the largest error.
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
    /// [`Code::InvalidClip`](mocap_scene::Code::InvalidClip) if the bytes are not a complete and valid packed clip.
    pub fn new(bytes: impl Into<Cow<'a, [u8]>>) -> Result<Self> {
        Ok(read::open(bytes.into())?)
    }

    /// Whether the bytes begin like a packed clip.
    #[doc(hidden)]
    pub fn sniff(bytes: &[u8]) -> bool {
        bytes.starts_with(&layout::MAGIC)
    }

    /// The number of values that change from frame to frame.
    #[doc(hidden)]
    pub fn values_a_frame(&self) -> usize {
        4 * self.rotations.len() + 3 * self.translations.len()
    }

    /// The bytes of the file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes of the file, without a copy if the clip owns them.
    #[doc(hidden)]
    pub fn into_bytes(self) -> Vec<u8> {
        self.bytes.into_owned()
    }

    /// The number of nodes of the skeleton.
    pub fn node_count(&self) -> usize {
        self.nodes.len()
    }

    /// The name of a node; empty if there is no such node.
    pub fn name(&self, node: usize) -> &str {
        let name = self.nodes.get(node).and_then(|node| {
            let (start, end) = node.name;
            std::str::from_utf8(self.bytes.get(start..end)?).ok()
        });
        name.unwrap_or_default()
    }

    /// The parent of a node. Parents precede their children.
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

    /// The duration in ticks, which is also the last tick.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// A clock to play this clip, at the start of the clip.
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

    /// The number of frames of the source.
    pub fn frame_count(&self) -> usize {
        self.frames
    }

    /// The largest measured distance of a joint from its position, in metres.
    pub fn max_error(&self) -> f64 {
        self.max_error.into()
    }
}
