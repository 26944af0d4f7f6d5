//! The codec of `EXT_meshopt_compression` and `KHR_meshopt_compression`: streams of elements, and their filters.
//!
//! Before anything is allocated, the output size is checked against the largest size that a stream of this length can
//! have.

use mocap_scene::error::{Code, Diagnostic};

#[cfg(not(feature = "meshopt"))]
use crate::Failure;

/// The filter of a stream's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Filter {
    /// No filter.
    None,
    /// Unit quaternions as four 16-bit integers.
    Quaternion,
    /// 32-bit floats as a mantissa and an exponent.
    Exponential,
}

impl Filter {
    /// The name in the extension; `None` for the default.
    pub(super) fn name(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Quaternion => Some("QUATERNION"),
            Self::Exponential => Some("EXPONENTIAL"),
        }
    }
}

/// The error of a build without the feature.
#[cfg_attr(feature = "meshopt", allow(dead_code, reason = "for builds without the feature"))]
pub(super) fn missing() -> Diagnostic {
    Diagnostic::new(
        Code::MissingFeature,
        "this build cannot read or write meshopt compression",
    )
    .help("build it with the feature `meshopt`, which needs a C++ compiler")
}

#[cfg(feature = "meshopt")]
pub(super) use self::codec::{decode, encode};

#[cfg(feature = "meshopt")]
mod codec {
    use meshopt::{decode_vertex_buffer, encode_vertex_buffer_level};

    use super::Filter;
    use crate::Failure;
    use crate::gltf::invalid::invalid;
    use mocap_scene::error::{Code, Diagnostic};

    /// The largest number of bytes from one byte of a stream: 256 elements take at least one byte for every four bytes
    /// of an element.
    const MOST_PER_BYTE: usize = 1024;
    /// The number of bytes that the last block may add.
    const LAST_BLOCK: usize = 256 * 256;
    /// The slowest and best level of the encoder. Only version 1 has levels.
    const LEVEL: i32 = 3;

    /// Encodes `bytes` as a stream of elements of `stride` bytes each. `stride` is 4, 8, 12 or 64.
    pub(in crate::gltf) fn encode(bytes: &[u8], stride: usize, version: i32) -> Result<Vec<u8>, Failure> {
        fn stream<const N: usize>(bytes: &[u8], version: i32) -> meshopt::Result<Vec<u8>> {
            encode_vertex_buffer_level(bytes.as_chunks::<N>().0, LEVEL, Some(version))
        }
        let stream = match stride {
            4 => stream::<4>(bytes, version),
            8 => stream::<8>(bytes, version),
            12 => stream::<12>(bytes, version),
            _ => stream::<64>(bytes, version),
        };
        stream.map_err(|error| {
            Diagnostic::new(
                Code::Unrepresentable,
                format!("meshopt cannot encode the keys: {error}"),
            )
            .into()
        })
    }

    /// Decodes the `count` elements of `stride` bytes in `stream`.
    pub(in crate::gltf) fn decode(
        stream: &[u8],
        count: usize,
        stride: usize,
        filter: Filter,
    ) -> Result<Vec<u8>, Failure> {
        let length = count.checked_mul(stride);
        let most = stream.len().saturating_mul(MOST_PER_BYTE).saturating_add(LAST_BLOCK);
        if length.is_none_or(|length| length > most) || count == 0 {
            let message = format!(
                "a meshopt stream of {} bytes cannot hold {count} elements",
                stream.len()
            );
            return Err(invalid("", message).into());
        }
        match (stride, filter) {
            (4, Filter::None) => elements::<4>(stream, count),
            (8, Filter::None) => elements::<8>(stream, count),
            (12, Filter::None) => elements::<12>(stream, count),
            (16, Filter::None) => elements::<16>(stream, count),
            // An inverse bind matrix. Arrays of more than 32 items have no `Default`.
            (64, Filter::None) => Ok(decoded::<[[u8; 16]; 4]>(stream, count)?.as_flattened().concat()),
            (8, Filter::Quaternion) => {
                let mut values = decoded::<[i16; 4]>(stream, count)?;
                meshopt::decode_filter_quat(&mut values);
                Ok(values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect())
            }
            (4, Filter::Exponential) => floats::<1>(stream, count),
            (12, Filter::Exponential) => floats::<3>(stream, count),
            (16, Filter::Exponential) => floats::<4>(stream, count),
            _ => Err(invalid(
                "",
                format!("animations do not use elements of {stride} bytes with this filter"),
            )
            .into()),
        }
    }

    fn decoded<T: Clone + Default>(stream: &[u8], count: usize) -> Result<Vec<T>, Failure> {
        // The decoder's own errors are numbers without meaning for users.
        decode_vertex_buffer(stream, count).map_err(|_| invalid("", "the meshopt stream is damaged").into())
    }

    fn elements<const N: usize>(stream: &[u8], count: usize) -> Result<Vec<u8>, Failure>
    where
        [u8; N]: Default,
    {
        Ok(decoded::<[u8; N]>(stream, count)?.concat())
    }

    fn floats<const N: usize>(stream: &[u8], count: usize) -> Result<Vec<u8>, Failure>
    where
        [u32; N]: Default,
    {
        let mut values = decoded::<[u32; N]>(stream, count)?;
        meshopt::decode_filter_exp(&mut values);
        Ok(values.iter().flatten().flat_map(|value| value.to_le_bytes()).collect())
    }
}

#[cfg(not(feature = "meshopt"))]
pub(super) fn encode(_: &[u8], _: usize, _: i32) -> Result<Vec<u8>, Failure> {
    Err(missing().into())
}

#[cfg(not(feature = "meshopt"))]
pub(super) fn decode(_: &[u8], _: usize, _: usize, _: Filter) -> Result<Vec<u8>, Failure> {
    Err(missing().into())
}
