//! The one buffer of a file, and the accessors into it.

use gltf::json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf::json::buffer::{Target, View};
use gltf::json::validation::{Checked, USize64};
use gltf::json::{Index, Root};
use serde_json::{Value, json};

/// What values are for. glTF wants views to keep to one use, and only vertex data to say so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Usage {
    /// Times and values of animation tracks; all of them share one view.
    Keys,
    /// Inverse bind matrices.
    BindMatrices,
    /// A vertex attribute.
    Vertices,
    /// Vertex indices.
    Indices,
}

/// A number that a buffer can hold.
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
components!(f32 => F32, u8 => U8, u16 => U16, u32 => U32);

/// Grows the buffer of a file.
#[derive(Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<View>,
    last_usage: Option<Usage>,
    accessors: Vec<Accessor>,
}

impl Buffer {
    /// Appends elements of `N` components. The slice is never empty: glTF has no empty accessor.
    pub(super) fn push<T: Component, const N: usize>(&mut self, usage: Usage, elements: &[[T; N]]) -> Index<Accessor> {
        let start = self.bytes.len();
        for component in elements.iter().flatten() {
            component.append(&mut self.bytes);
        }
        // Every accessor starts at a multiple of four, which all component sizes divide.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = self.view(usage, start);
        let view_start = self.views[view].byte_offset.map_or(0, |offset| offset.0);
        self.accessors.push(Accessor {
            buffer_view: Some(Index::new(view as u32)),
            byte_offset: Some(start as u64 - view_start)
                .filter(|offset| *offset > 0)
                .map(USize64),
            count: USize64::from(elements.len()),
            component_type: Checked::Valid(GenericComponentType(T::TYPE)),
            type_: Checked::Valid(match N {
                1 => Type::Scalar,
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
        Index::new(self.accessors.len() as u32 - 1)
    }

    /// As [`Self::push`], with bounds: the exact decimal value of the smallest and the largest stored number.
    pub(super) fn push_bounded<const N: usize>(&mut self, usage: Usage, elements: &[[f32; N]]) -> Index<Accessor> {
        let index = self.push(usage, elements);
        let bound = |pick: fn(f32, f32) -> f32, start: f32| -> Option<Value> {
            let bounds = elements.iter().fold([start; N], |bounds, element| {
                std::array::from_fn(|axis| pick(bounds[axis], element[axis]))
            });
            Some(json!(bounds.map(f64::from).as_slice()))
        };
        let accessor = &mut self.accessors[index.value()];
        accessor.min = bound(f32::min, f32::INFINITY);
        accessor.max = bound(f32::max, f32::NEG_INFINITY);
        index
    }

    /// As [`Self::push`], where the largest integer stands for 1.
    pub(super) fn push_normalized<const N: usize>(&mut self, usage: Usage, elements: &[[u8; N]]) -> Index<Accessor> {
        let index = self.push(usage, elements);
        self.accessors[index.value()].normalized = true;
        index
    }

    /// The view that holds the bytes from `start` on: the last one where keys follow keys, else a new one.
    fn view(&mut self, usage: Usage, start: usize) -> usize {
        if usage != Usage::Keys || self.last_usage != Some(Usage::Keys) {
            self.views.push(View {
                buffer: Index::new(0),
                byte_length: USize64(0),
                byte_offset: Some(USize64::from(start)).filter(|offset| offset.0 > 0),
                byte_stride: None,
                name: None,
                target: match usage {
                    Usage::Keys | Usage::BindMatrices => None,
                    Usage::Vertices => Some(Checked::Valid(Target::ArrayBuffer)),
                    Usage::Indices => Some(Checked::Valid(Target::ElementArrayBuffer)),
                },
                extensions: None,
                extras: None,
            });
        }
        self.last_usage = Some(usage);
        let end = self.bytes.len() as u64;
        let last = self.views.len() - 1;
        let view = &mut self.views[last];
        view.byte_length = USize64(end - view.byte_offset.map_or(0, |offset| offset.0));
        last
    }

    /// Hands views, accessors and the buffer to `root`, and gives the bytes.
    pub(super) fn finish(self, root: &mut Root) -> Vec<u8> {
        root.accessors = self.accessors;
        root.buffer_views = self.views;
        if !self.bytes.is_empty() {
            root.buffers.push(gltf::json::Buffer {
                byte_length: USize64::from(self.bytes.len()),
                name: None,
                uri: None,
                extensions: None,
                extras: None,
            });
        }
        self.bytes
    }
}
