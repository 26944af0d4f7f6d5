//! The stack machine that executes the operations of a pickle.

use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic};

use super::super::ndarray::Bytes;
use super::build::{self, RawArray};
use super::objects::{Id, Object, Objects};
use super::{Pickle, Storages, broken};
use crate::Failure;

const TOO_MANY: &str = "the pickle has too many objects";

pub(super) struct Machine<'s, 'a> {
    bytes: &'a [u8],
    at: usize,
    objects: Objects<'a>,
    stack: Vec<Id>,
    /// The stack height at each mark.
    marks: Vec<usize>,
    memo: HashMap<u32, Id>,
    /// The immutable values, stored once: none, true, false, the empty tuple.
    constants: HashMap<u8, Id>,
    /// The Latin-1 bytes of each string that was encoded, by the id of the string's object.
    encoded: HashMap<Id, Bytes<'a>>,
    storages: Storages<'s, 'a>,
}

impl<'s, 'a> Machine<'s, 'a> {
    pub(super) fn new(bytes: &'a [u8], storages: Storages<'s, 'a>) -> Self {
        Self {
            bytes,
            at: 0,
            objects: Objects::default(),
            stack: Vec::new(),
            marks: Vec::new(),
            memo: HashMap::new(),
            constants: HashMap::new(),
            encoded: HashMap::new(),
            storages,
        }
    }

    /// Runs until the operation STOP.
    pub(super) fn run(mut self) -> Result<Pickle<'a>, Failure> {
        loop {
            let operation = self.byte()?;
            if operation == b'.' {
                let result = self.pop()?;
                return Ok(Pickle {
                    objects: self.objects,
                    result,
                    size: self.bytes.len(),
                });
            }
            let done = self.constant(operation)?
                || self.scalar(operation)?
                || self.collection(operation)?
                || self.memo(operation)?;
            if !done {
                self.object(operation)?;
            }
        }
    }

    /// One-byte operations that push an immutable value.
    fn constant(&mut self, operation: u8) -> Result<bool, Failure> {
        if let Some(id) = self.constants.get(&operation) {
            self.stack.push(*id);
            return Ok(true);
        }
        let object = match operation {
            b'N' => Object::None,
            0x88 => Object::Number(1.0),
            0x89 => Object::Number(0.0),
            b')' => self.tuple(&[])?,
            _ => return Ok(false),
        };
        let id = self.push(object)?;
        self.constants.insert(operation, id);
        Ok(true)
    }

    /// Operations that push a number or a string.
    fn scalar(&mut self, operation: u8) -> Result<bool, Failure> {
        let number = |value: f64| Object::Number(value);
        let object = match operation {
            b'K' => number(f64::from(self.byte()?)),
            b'M' => number(self.unsigned(2)? as f64),
            b'J' => number(f64::from((self.unsigned(4)? as u32).cast_signed())),
            b'G' => {
                let bytes = self.take(8)?;
                number(f64::from_be_bytes(bytes.try_into().unwrap_or_default()))
            }
            0x8a => {
                let length = usize::from(self.byte()?);
                number(long(self.take(length)?))
            }
            b'I' | b'L' | b'F' => number(self.decimal()?),
            b'U' => self.text(1)?,
            b'T' | b'X' => self.text(4)?,
            0x8c => self.text(1)?,
            0x8d => self.text(8)?,
            b'S' | b'V' => {
                let line = self.line()?;
                Object::Text(line.trim_matches(['\'', '"']))
            }
            b'C' => self.raw(1)?,
            b'B' => self.raw(4)?,
            0x8e | 0x96 => self.raw(8)?,
            _ => return Ok(false),
        };
        self.push(object)?;
        Ok(true)
    }

    /// Operations on lists, tuples and dictionaries.
    fn collection(&mut self, operation: u8) -> Result<bool, Failure> {
        match operation {
            b'(' => self.marks.push(self.stack.len()),
            b']' => drop(self.push(Object::List(Vec::new()))?),
            b'}' => drop(self.push(Object::Dict(Vec::new()))?),
            b'l' => {
                let items = self.above_mark()?;
                self.push(Object::List(items))?;
            }
            b't' => {
                let items = self.above_mark()?;
                let tuple = self.tuple(&items)?;
                self.push(tuple)?;
            }
            b'd' => {
                let items = self.above_mark()?;
                self.push(Object::Dict(pairs(&items)))?;
            }
            0x85..=0x87 => {
                let count = usize::from(operation - 0x84);
                let items = self.top(count)?;
                let tuple = self.tuple(&items)?;
                self.push(tuple)?;
            }
            b'a' => {
                let item = self.pop()?;
                self.append(&[item])?;
            }
            b'e' => {
                let items = self.above_mark()?;
                self.append(&items)?;
            }
            b's' => {
                let items = self.top(2)?;
                self.set(&items)?;
            }
            b'u' => {
                let items = self.above_mark()?;
                self.set(&items)?;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Operations on the memo, and operations that this reader ignores.
    fn memo(&mut self, operation: u8) -> Result<bool, Failure> {
        match operation {
            b'q' => {
                let key = self.unsigned(1)? as u32;
                self.remember(key)?;
            }
            b'r' => {
                let key = self.unsigned(4)? as u32;
                self.remember(key)?;
            }
            b'p' => {
                let key = self.decimal_key()?;
                self.remember(key)?;
            }
            0x94 => {
                let key = self.memo.len() as u32;
                self.remember(key)?;
            }
            b'h' => {
                let key = self.unsigned(1)? as u32;
                self.recall(key)?;
            }
            b'j' => {
                let key = self.unsigned(4)? as u32;
                self.recall(key)?;
            }
            b'g' => {
                let key = self.decimal_key()?;
                self.recall(key)?;
            }
            0x80 => drop(self.byte()?),
            0x95 => drop(self.take(8)?),
            b'0' => drop(self.pop()?),
            b'1' => drop(self.above_mark()?),
            b'2' => {
                let top = self.pop()?;
                self.stack.extend([top, top]);
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Operations that name functions or classes, and operations that call them.
    fn object(&mut self, operation: u8) -> Result<(), Failure> {
        match operation {
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                let global = build::global(module, name)?;
                self.push(global)?;
            }
            0x93 => {
                let items = self.top(2)?;
                let [module, name] = [0, 1].map(|index| self.objects.text(items[index]));
                let (Some(module), Some(name)) = (module, name) else {
                    return Err(broken(self.at, "the name of a function or a class is not text"));
                };
                let global = build::global(module, name)?;
                self.push(global)?;
            }
            b'R' | 0x81 => {
                let items = self.top(2)?;
                let object = build::call(&self.objects, &mut self.encoded, items[0], items[1]);
                let object = object.map_err(|message| broken(self.at, &message))?;
                self.push(object)?;
            }
            b'b' => {
                let state = self.pop()?;
                let object = self.last()?;
                let built = match RawArray::of(&self.objects, object, state) {
                    Some(array) => {
                        let gap = if array.has_gap { self.byte()? } else { 0 };
                        self.take(usize::from(gap))?;
                        let bytes = self.take(array.size())?;
                        array.with(bytes).map(Some)
                    }
                    None => build::set_state(&self.objects, object, state),
                };
                let built = built.map_err(|message| broken(self.at, &message))?;
                if let Some(built) = built {
                    self.objects[object] = built;
                }
            }
            b'Q' => {
                let id = self.pop()?;
                let named = build::storage(&self.objects, id);
                let (kind, key) = named.map_err(|message| broken(self.at, &message))?;
                let bytes = (self.storages)(&key)?;
                self.push(Object::Storage(Box::new((kind, bytes))))?;
            }
            other => {
                let message = format!("the operation {other:#04x} is not known");
                return Err(broken(self.at, &message));
            }
        }
        Ok(())
    }

    fn push(&mut self, object: Object<'a>) -> Result<Id, Failure> {
        let id = self.objects.push(object).ok_or_else(|| broken(self.at, TOO_MANY))?;
        self.stack.push(id);
        Ok(id)
    }

    fn tuple(&mut self, items: &[Id]) -> Result<Object<'a>, Failure> {
        self.objects.tuple(items).ok_or_else(|| broken(self.at, TOO_MANY))
    }

    /// The index of the lowest object above the last mark. Objects below the mark may not be popped.
    fn floor(&self) -> usize {
        self.marks.last().copied().unwrap_or(0)
    }

    fn pop(&mut self) -> Result<Id, Failure> {
        let is_there = self.stack.len() > self.floor();
        let top = is_there.then(|| self.stack.pop()).flatten();
        top.ok_or_else(|| broken(self.at, "an operation needs more objects than the stack has"))
    }

    fn last(&self) -> Result<Id, Failure> {
        let last = self.stack.last().copied();
        last.ok_or_else(|| broken(self.at, "an operation needs more objects than the stack has"))
    }

    fn top(&mut self, count: usize) -> Result<Vec<Id>, Failure> {
        let begin = self
            .stack
            .len()
            .checked_sub(count)
            .filter(|begin| *begin >= self.floor());
        let begin = begin.ok_or_else(|| broken(self.at, "an operation needs more objects than the stack has"))?;
        Ok(self.stack.split_off(begin))
    }

    fn above_mark(&mut self) -> Result<Vec<Id>, Failure> {
        let mark = self
            .marks
            .pop()
            .ok_or_else(|| broken(self.at, "an operation needs a mark, but the stack has none"))?;
        Ok(self.stack.split_off(mark.min(self.stack.len())))
    }

    fn append(&mut self, items: &[Id]) -> Result<(), Failure> {
        let list = self.last()?;
        match &mut self.objects[list] {
            Object::List(list) => list.extend(items),
            _ => return Err(broken(self.at, "an item is appended to an object that is not a list")),
        }
        Ok(())
    }

    fn set(&mut self, items: &[Id]) -> Result<(), Failure> {
        let dictionary = self.last()?;
        match &mut self.objects[dictionary] {
            Object::Dict(dictionary) => dictionary.extend(pairs(items)),
            _ => return Err(broken(self.at, "an entry is set in an object that is not a dictionary")),
        }
        Ok(())
    }

    fn remember(&mut self, key: u32) -> Result<(), Failure> {
        let top = self.last()?;
        self.memo.insert(key, top);
        Ok(())
    }

    fn recall(&mut self, key: u32) -> Result<(), Failure> {
        let id = self.memo.get(&key).copied();
        self.stack
            .push(id.ok_or_else(|| broken(self.at, "the memo does not have the object that the pickle repeats"))?);
        Ok(())
    }

    fn byte(&mut self) -> Result<u8, Failure> {
        Ok(self.take(1)?[0])
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8], Failure> {
        let taken = self.bytes.get(self.at..self.at.saturating_add(count)).ok_or_else(|| {
            Box::new(
                Diagnostic::new(Code::UnexpectedEnd, "the pickle ends before its STOP operation")
                    .expected_found(
                        format!("{count} bytes at byte {}", self.at),
                        format!("{} bytes in all", self.bytes.len()),
                    )
                    .help("the file is cut off: export or download it again"),
            )
        })?;
        self.at += count;
        Ok(taken)
    }

    fn unsigned(&mut self, size: usize) -> Result<u64, Failure> {
        let mut eight = [0; 8];
        eight[..size].copy_from_slice(self.take(size)?);
        Ok(u64::from_le_bytes(eight))
    }

    fn raw(&mut self, size: usize) -> Result<Object<'a>, Failure> {
        let length = usize::try_from(self.unsigned(size)?).unwrap_or(usize::MAX);
        Ok(Object::Bytes(Bytes::File(self.take(length)?)))
    }

    /// A string in UTF-8. Python 2 strings are bytes.
    fn text(&mut self, size: usize) -> Result<Object<'a>, Failure> {
        let length = usize::try_from(self.unsigned(size)?).unwrap_or(usize::MAX);
        let bytes = self.take(length)?;
        Ok(match std::str::from_utf8(bytes) {
            Ok(text) => Object::Text(text),
            Err(_) => Object::Bytes(Bytes::File(bytes)),
        })
    }

    fn line(&mut self) -> Result<&'a str, Failure> {
        let rest = &self.bytes[self.at..];
        let end = memchr::memchr(b'\n', rest).ok_or_else(|| broken(self.at, "a line does not end"))?;
        let line = std::str::from_utf8(&rest[..end]).map_err(|_| broken(self.at, "a line is not text"))?;
        self.at += end + 1;
        Ok(line.trim_end_matches('\r'))
    }

    /// The memo number of an object.
    fn decimal_key(&mut self) -> Result<u32, Failure> {
        let key = self.line()?.parse();
        key.map_err(|_| broken(self.at, "the memo number of an object is not a whole number"))
    }

    /// A number in decimal digits, as in protocol 0. `I01` is true.
    fn decimal(&mut self) -> Result<f64, Failure> {
        let line = self.line()?;
        let number = line.trim_end_matches('L').parse();
        number.map_err(|_| broken(self.at, "a number in decimal digits cannot be parsed"))
    }
}

fn pairs(items: &[Id]) -> Vec<(Id, Id)> {
    items
        .as_chunks::<2>()
        .0
        .iter()
        .map(|[key, value]| (*key, *value))
        .collect()
}

/// An integer in two's complement, lowest byte first.
fn long(bytes: &[u8]) -> f64 {
    let sum = |sum: f64, byte: &u8| sum * 256.0 + f64::from(*byte);
    let size = bytes.iter().rev().fold(0.0, sum);
    match bytes.last() {
        Some(0x80..) => size - 256_f64.powi(bytes.len() as i32),
        _ => size,
    }
}
