//! Changes to the structure of a file: counts, strides, offsets, references. Random bytes seldom reach these, because a
//! file with a broken container is refused first.

mod c3d;
mod fbx;
mod gltf;
mod mclip;
mod zip;

use fastrand::Rng;

/// The input with changed structure, in the format of its name. `None` for formats without such changes, and for inputs
/// that are too broken to be parsed.
pub(crate) fn mutate(format: &str, bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    match format {
        "glb" | "gltf" => gltf::mutate(bytes, random),
        "c3d" => c3d::mutate(bytes, random),
        "fbx" => fbx::mutate(bytes, random),
        "mclip" => mclip::mutate(bytes, random),
        "npz" | "pt" | "body" => zip::mutate(bytes, random),
        // A scene of any format, known by its first bytes.
        "fbx_out" if bytes.starts_with(b"Kaydara") => fbx::mutate(bytes, random),
        "fbx_out" if bytes.starts_with(b"glTF") || bytes.starts_with(b"{") => gltf::mutate(bytes, random),
        _ => None,
    }
}

/// A number for a count, an offset or an index: near `now`, or at a limit.
fn number(now: u64, random: &mut Rng) -> u64 {
    const EDGES: [u64; 15] = [
        0,
        1,
        2,
        3,
        255,
        256,
        65_535,
        65_536,
        1_000_000,
        10_000_000,
        1_000_000_000,
        i32::MAX as u64,
        u32::MAX as u64,
        1 << 53,
        u64::MAX,
    ];
    match random.u8(..8) {
        0 => now.wrapping_add(1),
        1 => now.wrapping_sub(1),
        2 => now.saturating_mul(2),
        3 => now / 2,
        4 => random.u64(..=now.max(1)),
        _ => EDGES[random.usize(..EDGES.len())],
    }
}

/// A number at the limit of floating-point numbers.
fn float(random: &mut Rng) -> f32 {
    const EDGES: [f32; 18] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        1e-45,
        2e-41,
        1e-13,
        1e-12,
        9e17,
        1.1e18,
        1e6,
        1e9,
        1e20,
        -1e12,
        3e38,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];
    EDGES[random.usize(..EDGES.len())]
}
