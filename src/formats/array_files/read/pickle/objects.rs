//! The objects of a pickle, with little memory for each operation.

use std::ops::{Index, IndexMut};

use super::super::ndarray::{Bytes, Kind, NdArray};

/// The index of an object.
pub(super) type Id = u32;

/// The number of objects to allocate together. A doubling list would take three times its contents while it grows.
const CHUNK: usize = 256;

/// An object of a pickle. The rare variants with much data are behind a pointer.
#[derive(Debug)]
pub(super) enum Object<'a> {
    None,
    Number(f64),
    Text(&'a str),
    Bytes(Bytes<'a>),
    Tuple(Tuple),
    List(Vec<Id>),
    Dict(Vec<(Id, Id)>),
    /// A function or a class, by its name.
    Global(Box<str>),
    /// NumPy's element type, and whether it is big-endian; `None` for the type of objects.
    Dtype(Option<Kind>, bool),
    Array(Box<NdArray<'a>>),
    /// An array whose state is not set yet.
    NewArray,
    /// A PyTorch storage: its element type and its bytes.
    Storage(Box<(Kind, Bytes<'a>)>),
    /// An object with contents: a sparse matrix with its state, or an array of objects with the list of its objects.
    Record(Option<Id>),
}

/// The position of a tuple's items in the list of all items.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tuple {
    begin: Id,
    end: Id,
}

/// The objects of a pickle.
#[derive(Debug, Default)]
pub(super) struct Objects<'a> {
    chunks: Vec<Vec<Object<'a>>>,
    /// The items of all tuples, which are immutable.
    items: Vec<Id>,
}

impl<'a> Objects<'a> {
    /// Adds an object; `None` if there are too many.
    pub(super) fn push(&mut self, object: Object<'a>) -> Option<Id> {
        if self.chunks.last().is_none_or(|chunk| chunk.len() == CHUNK) {
            self.chunks.push(Vec::with_capacity(CHUNK));
        }
        let before = (self.chunks.len() - 1) * CHUNK;
        let chunk = self.chunks.last_mut()?;
        let id = Id::try_from(before + chunk.len()).ok()?;
        chunk.push(object);
        Some(id)
    }

    /// A tuple of these items; `None` if there are too many.
    pub(super) fn tuple(&mut self, items: &[Id]) -> Option<Object<'a>> {
        let begin = Id::try_from(self.items.len()).ok()?;
        self.items.extend(items);
        let end = Id::try_from(self.items.len()).ok()?;
        Some(Object::Tuple(Tuple { begin, end }))
    }

    /// The items of a tuple or a list.
    pub(super) fn items(&self, id: Id) -> Option<&[Id]> {
        match &self[id] {
            Object::Tuple(tuple) => self.items.get(tuple.begin as usize..tuple.end as usize),
            Object::List(items) => Some(items),
            _ => None,
        }
    }

    pub(super) fn text(&self, id: Id) -> Option<&'a str> {
        match self[id] {
            Object::Text(text) => Some(text),
            _ => None,
        }
    }

    pub(super) fn number(&self, id: Id) -> Option<f64> {
        match self[id] {
            Object::Number(number) => Some(number),
            _ => None,
        }
    }
}

impl<'a> Index<Id> for Objects<'a> {
    type Output = Object<'a>;

    fn index(&self, id: Id) -> &Object<'a> {
        &self.chunks[id as usize / CHUNK][id as usize % CHUNK]
    }
}

impl IndexMut<Id> for Objects<'_> {
    fn index_mut(&mut self, id: Id) -> &mut Self::Output {
        &mut self.chunks[id as usize / CHUNK][id as usize % CHUNK]
    }
}

/// Because an object is this small, a pickle takes only a limited memory for each of its bytes.
const _: () = assert!(size_of::<Object<'_>>() <= 32);
