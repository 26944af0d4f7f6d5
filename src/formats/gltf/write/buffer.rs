//! Builds the buffer of a file, and the accessors into it.

use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Index, Root};
use mocap_scene::error::{Code, Diagnostic, Result};
use serde_json::{Value, json};

use super::super::compression::{Compression, KHR};
use super::super::meshopt::{self, Filter};

/// The use of values. In glTF a view has one use, and only views of vertex data state their use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Usage {
    /// Times and values of animation tracks, which share one view.
    Keys,
    /// Inverse bind matrices.
    BindMatrices,
    /// A vertex attribute.
    Vertices,
    /// Vertex indices.
    Indices,
    /// An image file.
    Image,
}

/// A number type of a buffer.
pub(super) trait Component: Copy + PartialOrd + Into<f64> {
    const TYPE: ComponentType;
    fn append(self, bytes: &mut Vec<u8>);
}

macro_rules! components {
    ($($number:ty => $name:ident),*) => {
        $(impl Component for $number {
            const TYPE: ComponentType = ComponentType::$name;
            fn append(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_le_bytes());
            }
        })*
    };
}
components!(f32 => F32, u8 => U8, i16 => I16, u16 => U16, u32 => U32);

/// The contents of a file before the buffer is built.
#[derive(Clone, Copy, Debug)]
pub(super) struct Base {
    /// The index of the buffer that gets the bytes, and its present length, a multiple of four.
    pub(super) buffer: usize,
    pub(super) bytes: usize,
    /// The index of the [placeholder] that streams need.
    pub(super) placeholder: usize,
    pub(super) views: usize,
    pub(super) accessors: usize,
}

impl Base {
    /// An empty file.
    const NONE: Self = Self {
        buffer: 0,
        bytes: 0,
        placeholder: 1,
        views: 0,
        accessors: 0,
    };
}

impl Default for Base {
    fn default() -> Self {
        Self::NONE
    }
}

/// The finished objects of a file, and the bytes of its buffer.
pub(super) struct Parts {
    pub(super) accessors: Vec<Accessor>,
    pub(super) views: Vec<View>,
    pub(super) bytes: Vec<u8>,
    /// The additional buffer that streams need, and the extension that the file then requires.
    pub(super) streams: Option<(gltf_json::Buffer, &'static str)>,
}

/// Builds the buffer of a file.
#[derive(Default)]
pub(super) struct Buffer {
    base: Base,
    /// An accessor with a number that is not finite.
    not_finite: Option<usize>,
    bytes: Vec<u8>,
    views: Vec<View>,
    last_usage: Option<Usage>,
    accessors: Vec<Accessor>,
    streams: [Stream; STREAMS.len()],
    /// The key times that are already in the buffer.
    times: Vec<(Vec<[f32; 1]>, Index<Accessor>)>,
    /// Accessors of times that are a prefix of another accessor: the same bytes, fewer elements.
    beginnings: Vec<(usize, usize)>,
}

/// The elements of one stream. All tracks with the same filter share it, because a stream and its view take some 200
/// bytes.
#[derive(Default)]
struct Stream {
    /// The bytes before any filter.
    bytes: Vec<u8>,
    accessors: Vec<usize>,
}

/// The streams of a buffer: their filters, and the bytes of an element.
const STREAMS: [(Filter, usize); 4] = [
    (Filter::Quaternion, 8),
    (Filter::Exponential, 12),
    (Filter::None, size_of::<f32>()),
    (Filter::None, size_of::<[f32; 16]>()),
];

impl Buffer {
    /// Starts a buffer for a file that already has contents.
    pub(super) fn after(base: Base) -> Self {
        Self {
            base,
            ..Self::default()
        }
    }

    /// The position of the next byte in the buffer of the file.
    fn end(&self) -> usize {
        self.base.bytes + self.bytes.len()
    }

    /// The file index of one of [`Self::accessors`].
    fn index(&self, accessor: usize) -> Index<Accessor> {
        Index::new((self.base.accessors + accessor) as u32)
    }

    /// The accessor with this file index.
    fn accessor_at(&mut self, index: Index<Accessor>) -> &mut Accessor {
        &mut self.accessors[index.value() - self.base.accessors]
    }

    /// Appends elements of `N` components. The slice must not be empty, because glTF has no empty accessors.
    pub(super) fn push<T: Component, const N: usize>(&mut self, usage: Usage, elements: &[[T; N]]) -> Index<Accessor> {
        let start = self.end();
        self.look_at(elements);
        self.make_room(size_of_val(elements));
        for component in elements.iter().flatten() {
            component.append(&mut self.bytes);
        }
        // Every accessor starts at a multiple of four, which all component sizes divide.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.view(usage, start);
        let view_start = self.views[view].byte_offset.map_or(0, |offset| offset.0);
        let accessor = self.accessor(T::TYPE, N, elements.len());
        self.locate(accessor, view, start - view_start as usize);
        self.index(accessor)
    }

    /// Makes room for bytes. A large buffer grows by a sixteenth, because growth to twice its length, the default,
    /// would leave much memory unused.
    fn make_room(&mut self, bytes: usize) {
        // Bytes of a small buffer, for which growing to twice its length is faster and takes little memory.
        const SMALL: usize = 1 << 20;
        let free = self.bytes.capacity() - self.bytes.len();
        if free < bytes && self.bytes.len() > SMALL {
            self.bytes.reserve_exact(bytes.max(self.bytes.len() / 16));
        }
    }

    /// Appends an image file, with its own view.
    pub(super) fn push_image(&mut self, bytes: &[u8]) -> Index<View> {
        let start = self.end();
        self.bytes.extend_from_slice(bytes);
        let view = self.view(Usage::Image, start);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        Index::new((self.base.views + view) as u32)
    }

    /// Notes a number that is not finite, for [`Buffer::finish`]. Such a number is never written.
    fn look_at<T: Component, const N: usize>(&mut self, elements: &[[T; N]]) {
        let is_finite = elements.iter().flatten().all(|&number| number.into().is_finite());
        if !is_finite {
            self.not_finite
                .get_or_insert(self.base.accessors + self.accessors.len());
        }
    }

    /// An accessor without an offset.
    fn accessor(&mut self, component: ComponentType, components: usize, count: usize) -> usize {
        self.accessors.push(Accessor {
            buffer_view: None,
            byte_offset: None,
            count: USize64::from(count),
            component_type: Checked::Valid(GenericComponentType(component)),
            type_: Checked::Valid(match components {
                1 => Type::Scalar,
                2 => Type::Vec2,
                3 => Type::Vec3,
                4 => Type::Vec4,
                _ => Type::Mat4,
            }),
            min: None,
            max: None,
            normalized: false,
            sparse: None,
            name: None,
            extensions: None,
            extras: None,
        });
        self.accessors.len() - 1
    }

    fn locate(&mut self, accessor: usize, view: usize, offset: usize) {
        let view = Index::new((self.base.views + view) as u32);
        let accessor = &mut self.accessors[accessor];
        accessor.buffer_view = Some(view);
        accessor.byte_offset = Some(USize64::from(offset)).filter(|offset| offset.0 > 0);
    }

    /// Appends elements of `N` numbers, before filtering, to the stream with `filter`. `component` is the type after
    /// decoding, if it differs.
    pub(super) fn push_stream<T: Component, const N: usize>(
        &mut self,
        filter: Filter,
        component: ComponentType,
        elements: &[[T; N]],
    ) -> Index<Accessor> {
        self.look_at(elements);
        let accessor = self.accessor(component, N, elements.len());
        self.accessors[accessor].normalized = component == ComponentType::I16;
        let kind = (filter, size_of::<[T; N]>());
        let stream = STREAMS.iter().position(|other| *other == kind).unwrap_or(0);
        let stream = &mut self.streams[stream];
        stream.accessors.push(accessor);
        for number in elements.iter().flatten() {
            number.append(&mut stream.bytes);
        }
        self.index(accessor)
    }

    /// Appends inverse bind matrices, in a lossless stream if `compression` has streams.
    pub(super) fn push_matrices(&mut self, compression: Compression, matrices: &[[f32; 16]]) -> Index<Accessor> {
        match compression.extension() {
            None => self.push(Usage::BindMatrices, matrices),
            Some(_) => self.push_stream(Filter::None, ComponentType::F32, matrices),
        }
    }

    /// Appends key times, in a stream if `compression` has streams. Times that equal another animation's times, or a
    /// prefix of them, are not stored twice.
    pub(super) fn push_times(&mut self, compression: Compression, times: &[[f32; 1]]) -> Index<Accessor> {
        if let Some((_, same)) = self.times.iter().find(|(known, _)| known == times) {
            return *same;
        }
        let longer = self.times.iter().find(|(known, _)| known.starts_with(times));
        let accessor = if let Some(&(_, whole)) = longer {
            let accessor = self.accessor(ComponentType::F32, 1, times.len());
            self.beginnings.push((accessor, whole.value() - self.base.accessors));
            self.index(accessor)
        } else if compression.extension().is_some() {
            self.push_stream(Filter::None, ComponentType::F32, times)
        } else {
            self.push(Usage::Keys, times)
        };
        // Times increase, so the first is the smallest.
        let bound = |time: Option<&[f32; 1]>| time.map(|time| json!(time.map(f64::from)));
        self.accessor_at(accessor).min = bound(times.first());
        self.accessor_at(accessor).max = bound(times.last());
        self.times.push((times.to_vec(), accessor));
        accessor
    }

    /// Like [`Self::push`], with bounds: the exact decimal values of the smallest and the largest stored number.
    pub(super) fn push_bounded<const N: usize>(&mut self, usage: Usage, elements: &[[f32; N]]) -> Index<Accessor> {
        let index = self.push(usage, elements);
        let bound = |pick: fn(f32, f32) -> f32, start: f32| -> Option<Value> {
            let bounds = elements.iter().fold([start; N], |bounds, element| {
                std::array::from_fn(|axis| pick(bounds[axis], element[axis]))
            });
            Some(json!(bounds.map(f64::from).as_slice()))
        };
        let accessor = self.accessor_at(index);
        accessor.min = bound(f32::min, f32::INFINITY);
        accessor.max = bound(f32::max, f32::NEG_INFINITY);
        index
    }

    /// Like [`Self::push`], for normalized integers: the largest integer means 1.
    pub(super) fn push_normalized<T: Component, const N: usize>(
        &mut self,
        usage: Usage,
        elements: &[[T; N]],
    ) -> Index<Accessor> {
        let index = self.push(usage, elements);
        self.accessor_at(index).normalized = true;
        index
    }

    /// The view for the bytes from `start` on. Consecutive keys share the last view. Other values get a new view.
    fn view(&mut self, usage: Usage, start: usize) -> usize {
        if usage != Usage::Keys || self.last_usage != Some(Usage::Keys) {
            self.views.push(View {
                buffer: Index::new(self.base.buffer as u32),
                byte_length: USize64(0),
                byte_offset: Some(USize64::from(start)).filter(|offset| offset.0 > 0),
                byte_stride: None,
                name: None,
                target: match usage {
                    Usage::Keys | Usage::BindMatrices | Usage::Image => None,
                    Usage::Vertices => Some(Checked::Valid(Target::ArrayBuffer)),
                    Usage::Indices => Some(Checked::Valid(Target::ElementArrayBuffer)),
                },
                extensions: None,
                extras: None,
            });
        }
        self.last_usage = Some(usage);
        let end = self.end() as u64;
        let last = self.views.len() - 1;
        let view = &mut self.views[last];
        view.byte_length = USize64(end - view.byte_offset.map_or(0, |offset| offset.0));
        last
    }

    /// Compresses the streams. Their views refer to an uncompressed buffer that is not written. This buffer is marked
    /// as the fallback, which only readers without the extension need.
    fn finish_streams(&mut self, extension: &'static str) -> Result<Option<(gltf_json::Buffer, &'static str)>> {
        let version = i32::from(extension == KHR);
        let mut fallback = 0;
        for (stream, (filter, stride)) in std::iter::zip(std::mem::take(&mut self.streams), STREAMS) {
            if stream.bytes.is_empty() {
                continue;
            }
            let start = self.end();
            self.bytes.extend(meshopt::encode(&stream.bytes, stride, version)?);
            let mut settings = json!({
                "buffer": self.base.buffer,
                "byteOffset": start,
                "byteLength": self.end() - start,
                "byteStride": stride,
                "mode": "ATTRIBUTES",
                "count": stream.bytes.len() / stride,
            });
            if let Some(filter) = filter.name() {
                settings["filter"] = filter.into();
            }
            self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
            let mut others = serde_json::Map::new();
            others.insert(extension.to_owned(), settings);
            self.views.push(View {
                buffer: Index::new(self.base.placeholder as u32),
                byte_length: USize64::from(stream.bytes.len()),
                byte_offset: Some(USize64::from(fallback)).filter(|offset| offset.0 > 0),
                byte_stride: None,
                name: None,
                target: None,
                extensions: Some(gltf_json::extensions::buffer::View { others }),
                extras: None,
            });
            fallback += stream.bytes.len().next_multiple_of(8);
            let mut offset = 0;
            for accessor in stream.accessors {
                self.locate(accessor, self.views.len() - 1, offset);
                offset += self.accessors[accessor].count.0 as usize * stride;
            }
        }
        Ok((fallback > 0).then(|| (placeholder(fallback, extension), extension)))
    }

    /// Returns the finished parts.
    ///
    /// # Errors
    /// A number is not finite, or the streams cannot be encoded.
    pub(super) fn finish(mut self, compression: Compression) -> Result<Parts> {
        if let Some(accessor) = self.not_finite {
            let message = format!("a number to write into the accessor {accessor} is not finite");
            return Err(Diagnostic::new(Code::Unrepresentable, message).into());
        }
        let streams = match compression.extension() {
            Some(extension) => self.finish_streams(extension)?,
            None => None,
        };
        for (accessor, whole) in std::mem::take(&mut self.beginnings) {
            self.accessors[accessor].buffer_view = self.accessors[whole].buffer_view;
            self.accessors[accessor].byte_offset = self.accessors[whole].byte_offset;
        }
        Ok(Parts {
            accessors: self.accessors,
            views: self.views,
            bytes: self.bytes,
            streams,
        })
    }
}

impl Parts {
    /// Moves everything but the bytes to an empty file, and returns the bytes.
    pub(super) fn into_root(self, root: &mut Root) -> Vec<u8> {
        root.accessors = self.accessors;
        root.buffer_views = self.views;
        if !self.bytes.is_empty() {
            root.buffers.push(buffer(self.bytes.len(), None));
        }
        if let Some((placeholder, extension)) = self.streams {
            root.buffers.push(placeholder);
            root.extensions_used.push(extension.to_owned());
            root.extensions_required.push(extension.to_owned());
        }
        self.bytes
    }
}

/// A buffer of this length.
pub(super) fn buffer(length: usize, uri: Option<String>) -> gltf_json::Buffer {
    gltf_json::Buffer {
        byte_length: USize64::from(length),
        name: None,
        uri,
        extensions: None,
        extras: None,
    }
}

/// A fallback buffer without bytes.
fn placeholder(length: usize, extension: &str) -> gltf_json::Buffer {
    let mut others = serde_json::Map::new();
    others.insert(extension.to_owned(), json!({ "fallback": true }));
    gltf_json::Buffer {
        extensions: Some(gltf_json::extensions::buffer::Buffer { others }),
        ..buffer(length, None)
    }
}
