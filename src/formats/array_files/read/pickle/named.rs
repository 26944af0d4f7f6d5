//! The arrays of a pickle, with the path of dictionaries to each.

use super::super::ndarray::{Bytes, Entries, Kind, NdArray};
use super::Pickle;
use super::objects::{Id, Object, Objects};

/// The largest nesting depth of dictionaries to search.
const DEEPEST: usize = 8;

/// The largest number of bytes of a name to use.
const LONGEST: usize = 256;

/// The least number of bytes of an array in a pickle: its name, its shape and its type. A pickle that repeats an array
/// by its memo number has fewer bytes per array.
const LEAST: usize = 32;

/// The number of objects to visit in a small pickle.
const FEW: usize = 4096;

/// The arrays of a pickle, in order, named `outer.inner`. Numbers and strings become arrays of one element, lists of
/// numbers and of strings become arrays of one axis. Other objects have no name.
pub(in super::super) fn entries<'a>(pickle: &Pickle<'a>) -> Entries<'a> {
    let mut finder = Finder {
        objects: &pickle.objects,
        found: Entries::default(),
        most: pickle.size / LEAST,
        left: pickle.size.saturating_mul(2).saturating_add(FEW),
    };
    finder.visit(String::new(), pickle.result, 0);
    finder.found
}

struct Finder<'p, 'a> {
    objects: &'p Objects<'a>,
    found: Entries<'a>,
    /// The largest number of arrays to list.
    most: usize,
    /// The number of objects and bytes that may still be visited. The limit is needed because a pickle can refer to one
    /// object a thousand times.
    left: usize,
}

impl<'a> Finder<'_, 'a> {
    fn visit(&mut self, name: String, id: Id, depth: usize) {
        if self.left == 0 || self.found.arrays.len() >= self.most {
            self.found.is_cut = true;
            return;
        }
        if depth > DEEPEST {
            return;
        }
        self.left -= 1;
        match &self.objects[id] {
            Object::Array(array) => self.found.arrays.push((name, NdArray::clone(array))),
            Object::Number(number) => {
                let bytes = number.to_le_bytes().to_vec();
                self.add(name, Kind::Float(8), Vec::new(), bytes);
            }
            Object::Text(text) => self.add_texts(name, Vec::new(), &[text]),
            Object::Dict(pairs) => {
                for (key, value) in pairs {
                    let key = match &self.objects[*key] {
                        Object::Text(text) if text.len() <= LONGEST => text.to_string(),
                        Object::Number(number) => number.to_string(),
                        _ => continue,
                    };
                    self.visit(join(&name, &key), *value, depth + 1);
                }
            }
            Object::Record(Some(state)) => self.visit(name, *state, depth + 1),
            Object::List(_) | Object::Tuple(_) => {
                let items = self.objects.items(id).unwrap_or_default();
                self.list(name, items, depth);
            }
            _ => {}
        }
    }

    fn list(&mut self, name: String, items: &[Id], depth: usize) {
        if items.len() > self.left {
            self.found.is_cut = true;
            return;
        }
        self.left -= items.len();
        let objects = self.objects;
        if items.iter().all(|id| objects.number(*id).is_some()) {
            let numbers = items.iter().filter_map(|id| objects.number(*id));
            let mut bytes = Vec::with_capacity(8 * items.len());
            numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
            self.add(name, Kind::Float(8), vec![items.len()], bytes);
        } else if items.iter().all(|id| objects.text(*id).is_some()) {
            let texts: Vec<&str> = items.iter().filter_map(|id| objects.text(*id)).collect();
            self.add_texts(name, vec![items.len()], &texts);
        } else {
            for (index, item) in items.iter().enumerate() {
                self.visit(join(&name, &index.to_string()), *item, depth + 1);
            }
        }
    }

    fn add_texts(&mut self, name: String, shape: Vec<usize>, texts: &[&str]) {
        let length = texts.iter().map(|text| text.len()).max().unwrap_or(0);
        // Strings of different lengths are padded to the length of the longest string.
        let size = length.saturating_mul(texts.len());
        if size > self.left {
            return;
        }
        self.left -= size;
        let mut bytes = vec![0; length * texts.len()];
        for (index, text) in texts.iter().enumerate() {
            bytes[index * length..][..text.len()].copy_from_slice(text.as_bytes());
        }
        self.add(name, Kind::Bytes(length), shape, bytes);
    }

    fn add(&mut self, name: String, kind: Kind, shape: Vec<usize>, bytes: Vec<u8>) {
        if let Ok(array) = NdArray::new(&name, (kind, false), shape, false, Bytes::made(bytes)) {
            self.found.arrays.push((name, array));
        }
    }
}

fn join(outer: &str, inner: &str) -> String {
    match outer {
        "" => inner.to_owned(),
        outer => format!("{outer}.{inner}"),
    }
}
