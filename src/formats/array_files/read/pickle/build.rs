//! Builds the objects that the known functions and classes return.

use std::collections::HashMap;

use super::super::ndarray::{Bytes, Kind, NdArray};
use super::objects::{Id, Object, Objects};
use super::refused;
use crate::Failure;

/// Classes whose objects are kept as the dictionary of their state: SciPy's sparse matrices.
const RECORDS: &[&str] = &["csc_matrix", "csr_matrix", "csc_array", "csr_array"];

/// The function or class with this name.
pub(super) fn global<'a>(module: &str, name: &str) -> Result<Object<'a>, Failure> {
    let is_numpy = |below: &str| {
        ["numpy.core.", "numpy._core."]
            .iter()
            .any(|core| module.strip_prefix(core) == Some(below))
    };
    let known = match name {
        "_reconstruct" | "scalar" => is_numpy("multiarray"),
        "_frombuffer" => is_numpy("numeric"),
        "ndarray" | "dtype" | "frombuffer" | "array" | "reshape" => module == "numpy",
        "encode" => module == "_codecs",
        "OrderedDict" => module == "collections",
        "NumpyArrayWrapper" => module == "joblib.numpy_pickle",
        "_rebuild_tensor_v2" | "_rebuild_parameter" => module == "torch._utils",
        "Size" => module == "torch",
        name if RECORDS.contains(&name) => module.starts_with("scipy.sparse"),
        name => module == "torch" && storage_kind(name).is_some(),
    };
    match known {
        true => Ok(Object::Global(name.into())),
        false => Err(refused(&format!("{module}.{name}"))),
    }
}

/// The element type of a PyTorch storage.
fn storage_kind(name: &str) -> Option<Kind> {
    Some(match name.strip_suffix("Storage")? {
        "Double" => Kind::Float(8),
        "Float" => Kind::Float(4),
        "Half" => Kind::Float(2),
        "BFloat16" => Kind::Bfloat16,
        "Long" => Kind::Int(8),
        "Int" => Kind::Int(4),
        "Short" => Kind::Int(2),
        "Char" => Kind::Int(1),
        "Byte" => Kind::Uint(1),
        "Bool" => Kind::Bool,
        _ => return None,
    })
}

/// The whole numbers of a tuple or a list.
fn sizes(objects: &Objects<'_>, id: Id) -> Option<Vec<usize>> {
    /// The largest number of axes. Motions have fewer axes. The limit also bounds the memory of a pickle that repeats
    /// an array in five bytes.
    const MOST_AXES: usize = 6;
    let items = objects.items(id).filter(|items| items.len() <= MOST_AXES)?;
    let size = |id: &Id| {
        objects
            .number(*id)
            .filter(|size| (0.0..9e15).contains(size))
            .map(|size| size as usize)
    };
    items.iter().map(size).collect()
}

/// The result of calling a known function.
pub(super) fn call<'a>(
    objects: &Objects<'a>,
    encoded: &mut HashMap<Id, Bytes<'a>>,
    function: Id,
    arguments: Id,
) -> Result<Object<'a>, String> {
    let Object::Global(name) = &objects[function] else {
        return Err("the called object is not a function".to_owned());
    };
    let arguments = objects.items(arguments).ok_or("the arguments are not a tuple")?;
    let wrong = || format!("the arguments of {name} are not valid");
    let name = &**name;
    match name {
        "_reconstruct" | "NumpyArrayWrapper" => Ok(Object::NewArray),
        "OrderedDict" => Ok(Object::Dict(Vec::new())),
        "Size" => Ok(Object::Record(Some(*arguments.first().ok_or_else(wrong)?))),
        "dtype" => {
            let letters = arguments.first().and_then(|id| objects.text(*id)).ok_or_else(wrong)?;
            dtype(letters).ok_or_else(|| format!("arrays of the type \"{letters}\" are not read"))
        }
        "scalar" => {
            let [kind, bytes] = arguments else { return Err(wrong()) };
            array(objects, *kind, Vec::new(), false, *bytes).ok_or_else(wrong)?
        }
        "_frombuffer" => {
            let [buffer, kind, shape, order] = arguments else {
                return Err(wrong());
            };
            let shape = sizes(objects, *shape).ok_or_else(wrong)?;
            let is_fortran = objects.text(*order) == Some("F");
            array(objects, *kind, shape, is_fortran, *buffer).ok_or_else(wrong)?
        }
        // The form in which `mocap robot` writes arrays.
        "frombuffer" => flat(objects, arguments).ok_or_else(wrong)?,
        "array" | "reshape" => {
            let Some(Object::Array(array)) = arguments.first().map(|id| &objects[*id]) else {
                return Err(wrong());
            };
            match arguments {
                [_] if name == "array" => Ok(Object::Array(array.clone())),
                [_, shape] if name == "reshape" && array.shape.len() == 1 => {
                    let shape = sizes(objects, *shape).ok_or_else(wrong)?;
                    of_bytes((array.kind, array.big_endian), shape, false, &array.bytes)
                }
                _ => Err(wrong()),
            }
        }
        // In old protocols, Python 3 writes bytes as Latin-1 text.
        "encode" => {
            let id = *arguments.first().ok_or_else(wrong)?;
            let letters = objects.text(id).ok_or_else(wrong)?;
            Ok(Object::Bytes(latin(letters, id, encoded).ok_or_else(wrong)?))
        }
        "_rebuild_tensor_v2" => tensor(objects, arguments).ok_or_else(wrong)?,
        "_rebuild_parameter" => Ok(Object::Record(Some(*arguments.first().ok_or_else(wrong)?))),
        name if RECORDS.contains(&name) => Ok(Object::Record(None)),
        _ => Err(wrong()),
    }
}

/// The bytes of a Latin-1 text. A memoized text is encoded once, however often it is used.
fn latin<'a>(letters: &'a str, id: Id, encoded: &mut HashMap<Id, Bytes<'a>>) -> Option<Bytes<'a>> {
    if letters.is_ascii() {
        return Some(Bytes::File(letters.as_bytes()));
    }
    if let Some(bytes) = encoded.get(&id) {
        return Some(bytes.clone());
    }
    let bytes: Option<Vec<u8>> = letters.chars().map(|letter| u8::try_from(letter).ok()).collect();
    let bytes = Bytes::made(bytes?);
    encoded.insert(id, bytes.clone());
    Some(bytes)
}

/// The NumPy type with these letters, such as `f8`.
fn dtype<'a>(letters: &str) -> Option<Object<'a>> {
    let (big_endian, letters) = match letters.split_at_checked(1) {
        Some((">", rest)) => (true, rest),
        Some(("<" | "|" | "=", rest)) => (false, rest),
        _ => (false, letters),
    };
    match letters {
        "O" | "O8" => Some(Object::Dtype(None, false)),
        letters => Some(Object::Dtype(Some(Kind::of_numpy(letters)?), big_endian)),
    }
}

type Built<'a> = Result<Object<'a>, String>;

/// A NumPy array of the type `kind` with the bytes of `buffer`.
fn array<'a>(objects: &Objects<'a>, kind: Id, shape: Vec<usize>, is_fortran: bool, buffer: Id) -> Option<Built<'a>> {
    let (Object::Dtype(kind, big_endian), Object::Bytes(bytes)) = (&objects[kind], &objects[buffer]) else {
        return None;
    };
    Some(of_bytes(((*kind)?, *big_endian), shape, is_fortran, bytes))
}

fn of_bytes<'a>(kind: (Kind, bool), shape: Vec<usize>, is_fortran: bool, bytes: &Bytes<'a>) -> Built<'a> {
    let array = NdArray::new("of the pickle", kind, shape, is_fortran, bytes.clone());
    array
        .map(|array| Object::Array(Box::new(array)))
        .map_err(|failure| failure.message.clone())
}

/// The one-dimensional array of all bytes of a buffer.
fn flat<'a>(objects: &Objects<'a>, arguments: &[Id]) -> Option<Built<'a>> {
    let [buffer, kind] = arguments else { return None };
    let (Object::Bytes(bytes), Some(Object::Dtype(Some(kind), big_endian))) =
        (&objects[*buffer], dtype(objects.text(*kind)?))
    else {
        return None;
    };
    let count = bytes.len() / kind.size().max(1);
    Some(of_bytes((kind, big_endian), vec![count], false, bytes))
}

/// A tensor: the storage, the offset of its first element, its shape and its strides.
fn tensor<'a>(objects: &Objects<'a>, arguments: &[Id]) -> Option<Built<'a>> {
    let [storage, offset, shape, strides, ..] = arguments else {
        return None;
    };
    let Object::Storage(storage) = &objects[*storage] else {
        return None;
    };
    let (kind, bytes) = &**storage;
    let offset = objects.number(*offset).filter(|offset| (0.0..9e15).contains(offset))? as usize;
    let (shape, strides) = (sizes(objects, *shape)?, sizes(objects, *strides)?);
    let begin = offset.saturating_mul(kind.size()).min(bytes.len());
    if shape.len() != strides.len() {
        return None;
    }
    let bytes = bytes.after(begin);
    let array = NdArray {
        shape,
        kind: *kind,
        big_endian: false,
        strides,
        bytes,
    };
    let checked = array.check("of the pickle").map_err(|failure| failure.message.clone());
    Some(checked.map(|()| Object::Array(Box::new(array))))
}

/// The description of an array whose bytes follow in the file, as joblib writes it.
pub(super) struct RawArray {
    kind: (Kind, bool),
    shape: Vec<usize>,
    is_fortran: bool,
    /// Whether a gap precedes the bytes. The length of the gap comes first.
    pub(super) has_gap: bool,
}

impl RawArray {
    /// The description in the state of an array. `None` if the object is no array, or the state is not joblib's.
    pub(super) fn of(objects: &Objects<'_>, object: Id, state: Id) -> Option<Self> {
        let (Object::NewArray, Object::Dict(state)) = (&objects[object], &objects[state]) else {
            return None;
        };
        let value = |name: &str| state.iter().find(|(key, _)| objects.text(*key) == Some(name));
        let Object::Dtype(kind, big_endian) = &objects[value("dtype")?.1] else {
            return None;
        };
        Some(Self {
            kind: ((*kind)?, *big_endian),
            shape: sizes(objects, value("shape")?.1)?,
            is_fortran: objects.text(value("order")?.1) == Some("F"),
            has_gap: value("numpy_array_alignment_bytes").is_some_and(|(_, bytes)| objects.number(*bytes).is_some()),
        })
    }

    /// The size of the array in bytes.
    pub(super) fn size(&self) -> usize {
        self.shape
            .iter()
            .fold(self.kind.0.size(), |size, count| size.saturating_mul(*count))
    }

    /// The array with these bytes.
    pub(super) fn with<'a>(self, bytes: &'a [u8]) -> Result<Object<'a>, String> {
        of_bytes(self.kind, self.shape, self.is_fortran, &Bytes::File(bytes))
    }
}

/// The object with its state; `None` if the state has nothing that is needed.
pub(super) fn set_state<'a>(objects: &Objects<'a>, object: Id, state: Id) -> Result<Option<Object<'a>>, String> {
    match &objects[object] {
        Object::NewArray => {
            let wrong = || "the state of an array does not have NumPy's form".to_owned();
            let Some([.., shape, kind, order, data]) = objects.items(state) else {
                return Err(wrong());
            };
            let shape = sizes(objects, *shape).ok_or_else(wrong)?;
            // An array of objects becomes the list of its objects.
            if let Object::Dtype(None, _) = &objects[*kind] {
                return Ok(Some(Object::Record(Some(*data))));
            }
            let is_fortran = objects.number(*order) == Some(1.0);
            array(objects, *kind, shape, is_fortran, *data)
                .ok_or_else(wrong)?
                .map(Some)
        }
        // The state of an element type begins with its version and its byte order.
        Object::Dtype(kind, _) => {
            let order = objects.items(state).and_then(|state| objects.text(*state.get(1)?));
            Ok(Some(Object::Dtype(*kind, order == Some(">"))))
        }
        Object::Record(_) => Ok(Some(Object::Record(Some(state)))),
        Object::Dict(_) => Ok(None),
        _ => Err("the pickle sets the state of an object that cannot have a state".to_owned()),
    }
}

/// The type and the key of a storage, from ("storage", type, key, device, elements).
pub(super) fn storage(objects: &Objects<'_>, id: Id) -> Result<(Kind, String), String> {
    let wrong = || "its reference is not a PyTorch storage".to_owned();
    let Some([word, kind, key, ..]) = objects.items(id) else {
        return Err(wrong());
    };
    let Object::Global(kind) = &objects[*kind] else {
        return Err(wrong());
    };
    match (objects.text(*word), storage_kind(kind), objects.text(*key)) {
        (Some("storage"), Some(kind), Some(key)) => Ok((kind, key.to_owned())),
        _ => Err(wrong()),
    }
}
