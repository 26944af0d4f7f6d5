//! Binary FBX: parses the records, changes them, and writes them with correct offsets and lengths. Then some offsets
//! and lengths change too.

use std::ops::Range;

use fastrand::Rng;
use miniz_oxide::deflate::compress_to_vec_zlib;
use miniz_oxide::inflate::decompress_to_vec_zlib_with_limit;

use super::{float, number};

/// Before the version; the records begin after it.
const HEAD: &[u8] = b"Kaydara FBX Binary  \0\x1a\0";

/// In this version and later versions, offsets and lengths have 64 bits.
const WIDE: u32 = 7500;

/// The largest depth of records, and of a chain of connected objects.
const LONGEST_CHAIN: usize = 3000;

/// The largest number of copies of a part of the file.
const MOST_COPIES: usize = 300;

/// The size of the longest file in bytes: copies of copies would exceed any size.
const LONGEST: usize = 1 << 20;

/// The size of the largest array that is parsed or made, in bytes.
const LARGEST_ARRAY: usize = 4 << 20;

#[derive(Clone, Default)]
struct Record {
    name: Vec<u8>,
    properties: Vec<Property>,
    records: Vec<Record>,
}

#[derive(Clone)]
enum Property {
    /// A number, by the letter of its type.
    Number(u8, Vec<u8>),
    /// A string or bytes.
    Text(u8, Vec<u8>),
    Array {
        kind: u8,
        count: u32,
        encoding: u32,
        bytes: Vec<u8>,
    },
}

/// The records from `at` up to an empty record or the end of the bytes.
struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_wide: bool,
}

pub(super) fn mutate(bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    let version = u32::from_le_bytes(*bytes.strip_prefix(HEAD)?.first_chunk()?);
    let mut reader = Reader {
        bytes,
        at: HEAD.len() + 4,
        is_wide: version >= WIDE,
    };
    let mut root = Record {
        records: reader.records(bytes.len())?,
        ..Record::default()
    };
    let foot = &bytes[reader.at..];
    for _ in 0..random.usize(1..=4) {
        change(&mut root, random);
    }
    let mut writer = Writer {
        bytes: bytes[..HEAD.len() + 4].to_vec(),
        fields: Vec::new(),
        is_wide: version >= WIDE,
    };
    root.records.iter().for_each(|record| writer.record(record));
    writer.empty_record();
    writer.bytes.extend(foot);
    let Writer { mut bytes, fields, .. } = writer;
    // In half of the files, the lengths of records are wrong.
    for _ in 0..random.usize(..=2) * usize::from(random.bool()) {
        let place = fields.get(random.usize(..fields.len().max(1)))?.clone();
        let field = bytes.get_mut(place)?;
        let mut now = [0; 8];
        now[..field.len()].copy_from_slice(field);
        let changed = number(u64::from_le_bytes(now), random).to_le_bytes();
        field.copy_from_slice(&changed[..field.len()]);
    }
    bytes.truncate(LONGEST);
    Some(bytes)
}

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let bytes = *self.bytes.get(self.at..)?.first_chunk()?;
        self.at += N;
        Some(bytes)
    }

    fn take_list(&mut self, length: usize) -> Option<Vec<u8>> {
        let bytes = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(bytes.to_vec())
    }

    fn length(&mut self) -> Option<usize> {
        match self.is_wide {
            true => usize::try_from(u64::from_le_bytes(self.take()?)).ok(),
            false => Some(u32::from_le_bytes(self.take()?) as usize),
        }
    }

    fn records(&mut self, end: usize) -> Option<Vec<Record>> {
        let mut records = Vec::new();
        while self.at < end {
            let (next, count, _) = (self.length()?, self.length()?, self.length()?);
            let [name] = self.take()?;
            if next == 0 {
                break;
            }
            let name = self.take_list(usize::from(name))?;
            let properties = (0..count).map(|_| self.property()).collect::<Option<_>>()?;
            records.push(Record {
                name,
                properties,
                records: self.records(next)?,
            });
            // Broken seeds are useless, and would make the recursion endless.
            if self.at != next {
                return None;
            }
        }
        Some(records)
    }

    fn property(&mut self) -> Option<Property> {
        let [kind] = self.take()?;
        Some(match kind {
            b'B' | b'C' => Property::Number(kind, self.take_list(1)?),
            b'Y' => Property::Number(kind, self.take_list(2)?),
            b'I' | b'F' => Property::Number(kind, self.take_list(4)?),
            b'L' | b'D' => Property::Number(kind, self.take_list(8)?),
            b'S' | b'R' => {
                let length = u32::from_le_bytes(self.take()?) as usize;
                Property::Text(kind, self.take_list(length)?)
            }
            b'b' | b'c' | b'i' | b'f' | b'l' | b'd' => {
                let [count, encoding, length] = [self.take()?, self.take()?, self.take()?].map(u32::from_le_bytes);
                Property::Array {
                    kind,
                    count,
                    encoding,
                    bytes: self.take_list(length as usize)?,
                }
            }
            _ => return None,
        })
    }
}

/// Writes records, and keeps the positions of their offsets and lengths.
struct Writer {
    bytes: Vec<u8>,
    fields: Vec<Range<usize>>,
    is_wide: bool,
}

impl Writer {
    fn width(&self) -> usize {
        if self.is_wide { 8 } else { 4 }
    }

    fn field(&mut self, bytes: &[u8]) {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        self.fields.push(start..self.bytes.len());
    }

    fn empty_record(&mut self) {
        self.bytes.resize(self.bytes.len() + 3 * self.width() + 1, 0);
    }

    fn record(&mut self, record: &Record) {
        let (start, width) = (self.bytes.len(), self.width());
        self.field(&[0; 8][..width]);
        self.field(&(record.properties.len() as u64).to_le_bytes()[..width]);
        self.field(&[0; 8][..width]);
        self.field(&[record.name.len() as u8]);
        self.bytes.extend(&record.name);
        let before = self.bytes.len();
        record.properties.iter().for_each(|property| self.property(property));
        let length = self.bytes.len() - before;
        if !record.records.is_empty() {
            record.records.iter().for_each(|record| self.record(record));
            self.empty_record();
        }
        let end = self.bytes.len();
        for (place, value) in [(start, end), (start + 2 * width, length)] {
            self.bytes[place..place + width].copy_from_slice(&(value as u64).to_le_bytes()[..width]);
        }
    }

    fn property(&mut self, property: &Property) {
        match property {
            Property::Number(kind, bytes) => {
                self.field(&[*kind]);
                self.bytes.extend(bytes);
            }
            Property::Text(kind, bytes) => {
                self.bytes.push(*kind);
                self.field(&(bytes.len() as u32).to_le_bytes());
                self.bytes.extend(bytes);
            }
            Property::Array {
                kind,
                count,
                encoding,
                bytes,
            } => {
                self.field(&[*kind]);
                for value in [*count, *encoding, bytes.len() as u32] {
                    self.field(&value.to_le_bytes());
                }
                self.bytes.extend(bytes);
            }
        }
    }
}

fn change(root: &mut Record, random: &mut Rng) {
    match random.u8(..14) {
        0 | 1 => change_property(root, random),
        2 | 3 => change_array(root, random),
        4 => rename(root, random),
        5 => nest(root, random),
        6 | 7 => copy_a_part(root, random),
        8..=11 => connect(root, random),
        12 => chain_objects(root, random),
        _ => {
            let parent = somewhere(root, random);
            if !parent.records.is_empty() {
                let place = random.usize(..parent.records.len());
                parent.records.remove(place);
            }
        }
    }
}

/// One of the records; records near the root are more likely.
fn somewhere<'a>(record: &'a mut Record, random: &mut Rng) -> &'a mut Record {
    if record.records.is_empty() || random.u8(..4) == 0 {
        return record;
    }
    let place = random.usize(..record.records.len());
    somewhere(&mut record.records[place], random)
}

fn change_property(root: &mut Record, random: &mut Rng) {
    let record = somewhere(root, random);
    if record.properties.is_empty() {
        return;
    }
    let place = random.usize(..record.properties.len());
    match (&mut record.properties[place], random.u8(..8)) {
        (_, 0) => drop(record.properties.remove(place)),
        (property, 1) => {
            let copy = property.clone();
            record.properties.insert(place, copy);
        }
        (Property::Number(kind, bytes), _) => *bytes = edge(*kind, bytes, random),
        (Property::Text(_, bytes), 2) => bytes.clear(),
        (Property::Text(_, bytes), 3) => *bytes = vec![b'a'; random.usize(..100_000)],
        (Property::Text(_, bytes), _) => *bytes = word(random),
        (Property::Array { encoding, .. }, _) => *encoding = random.u32(..3),
    }
}

/// A number of this type at a limit, or near the present number.
fn edge(kind: u8, now: &[u8], random: &mut Rng) -> Vec<u8> {
    match kind {
        b'F' | b'f' => float(random).to_le_bytes().to_vec(),
        b'D' | b'd' => match random.u8(..4) {
            0 => 1e300_f64.to_le_bytes().to_vec(),
            _ => f64::from(float(random)).to_le_bytes().to_vec(),
        },
        _ => {
            let mut wide = [0; 8];
            wide[..now.len()].copy_from_slice(now);
            let changed = number(u64::from_le_bytes(wide), random);
            changed.to_le_bytes()[..now.len()].to_vec()
        }
    }
}

/// A random word from the names and types that occur in FBX files.
fn word(random: &mut Rng) -> Vec<u8> {
    const WORDS: [&[u8]; 22] = [
        b"",
        b"Model",
        b"LimbNode",
        b"Null",
        b"Root",
        b"Mesh",
        b"Cluster",
        b"Skin",
        b"Shape",
        b"AnimStack",
        b"AnimLayer",
        b"AnimCurveNode",
        b"Lcl Translation",
        b"Lcl Rotation",
        b"Lcl Scaling",
        b"RotationOrder",
        b"InheritType",
        b"d|X",
        b"OO",
        b"OP",
        b"a\0\x01Model",
        b"\xff\xfe",
    ];
    WORDS[random.usize(..WORDS.len())].to_vec()
}

/// Changes the values, their number, their type, or their encoding, and keeps the array valid.
fn change_array(root: &mut Record, random: &mut Rng) {
    let record = somewhere(root, random);
    let arrays = record.properties.iter_mut().filter_map(|property| match property {
        Property::Array {
            kind,
            count,
            encoding,
            bytes,
        } => Some((kind, count, encoding, bytes)),
        _ => None,
    });
    let arrays: Vec<_> = arrays.collect();
    let chosen = random.usize(..arrays.len().max(1));
    let Some((kind, count, encoding, bytes)) = arrays.into_iter().nth(chosen) else {
        return;
    };
    let mut values = match encoding {
        1 => decompress_to_vec_zlib_with_limit(bytes, LARGEST_ARRAY).unwrap_or_default(),
        _ => bytes.clone(),
    };
    if random.u8(..8) == 0 {
        *kind = b"bcifld"[random.usize(..6)];
    }
    let size = match *kind {
        b'b' | b'c' => 1,
        b'i' | b'f' => 4,
        _ => 8,
    };
    match random.u8(..6) {
        0 => values.truncate(size * random.usize(..=values.len() / size)),
        1 => values.resize(LARGEST_ARRAY / random.usize(1..=64), random.u8(..2)),
        2 => values = values.repeat(random.usize(..4)),
        _ => {
            for _ in 0..random.usize(1..=8) {
                let place = size * random.usize(..=values.len() / size);
                if let Some(value) = values.get_mut(place..place + size) {
                    let changed = edge(*kind, value, random);
                    value.copy_from_slice(&changed);
                }
            }
        }
    }
    values.truncate(LARGEST_ARRAY);
    *count = (values.len() / size) as u32;
    *encoding = u32::from(random.bool() || values.len() > LONGEST / 4);
    *bytes = match encoding {
        1 => compress_to_vec_zlib(&values, 1),
        _ => values,
    };
}

fn rename(root: &mut Record, random: &mut Rng) {
    let other = somewhere(root, random).name.clone();
    let record = somewhere(root, random);
    record.name = match random.u8(..4) {
        0 => vec![random.u8(..); random.usize(..=255)],
        1 => word(random),
        _ => other,
    };
}

/// Nests records in each other.
fn nest(root: &mut Record, random: &mut Rng) {
    let record = somewhere(root, random);
    for _ in 0..random.usize(..LONGEST_CHAIN) {
        let inner = std::mem::take(record);
        *record = Record {
            name: inner.name.clone(),
            properties: Vec::new(),
            records: vec![inner],
        };
    }
}

fn copy_a_part(root: &mut Record, random: &mut Rng) {
    let part = somewhere(root, random).clone();
    let copies = random.usize(1..=MOST_COPIES).min(LONGEST / size(&part));
    let parent = somewhere(root, random);
    parent.records.extend(std::iter::repeat_n(part, copies));
}

/// The approximate size of the record in bytes.
fn size(record: &Record) -> usize {
    let of_properties = record.properties.iter().map(|property| match property {
        Property::Number(_, bytes) | Property::Text(_, bytes) | Property::Array { bytes, .. } => 1 + bytes.len(),
    });
    13 + of_properties.sum::<usize>() + record.records.iter().map(size).sum::<usize>()
}

fn section<'a>(root: &'a mut Record, name: &[u8]) -> Option<&'a mut Vec<Record>> {
    let mut sections = root.records.iter_mut();
    let found = sections.find(|section| section.name == name)?;
    Some(&mut found.records)
}

/// The IDs of the objects of this kind, or of all objects. Connections refer to these IDs.
fn objects(root: &mut Record, kind: Option<&[u8]>) -> Vec<Property> {
    let objects = section(root, b"Objects").map(std::mem::take).unwrap_or_default();
    let wanted = objects
        .iter()
        .filter(|object| kind.is_none_or(|kind| object.name == kind));
    let ids = wanted.filter_map(|object| object.properties.first().cloned()).collect();
    if let Some(place) = section(root, b"Objects") {
        *place = objects;
    }
    ids
}

fn connection(child: &Property, parent: &Property, property: Option<&[u8]>) -> Record {
    let kind = if property.is_some() { "OP" } else { "OO" };
    let mut properties = vec![Property::Text(b'S', kind.into()), child.clone(), parent.clone()];
    properties.extend(property.map(|name| Property::Text(b'S', name.to_vec())));
    Record {
        name: b"C".to_vec(),
        properties,
        records: Vec::new(),
    }
}

/// Connects objects with themselves, with their present neighbours again, or in a circle.
fn connect(root: &mut Record, random: &mut Rng) {
    const KINDS: [Option<&[u8]>; 5] = [
        None,
        Some(b"Model"),
        Some(b"Deformer"),
        Some(b"AnimationCurveNode"),
        Some(b"Geometry"),
    ];
    let kind = KINDS[random.usize(..KINDS.len())];
    let ids = objects(root, kind);
    let Some(connections) = section(root, b"Connections").filter(|_| !ids.is_empty()) else {
        return;
    };
    let mut any = || ids[random.usize(..ids.len())].clone();
    let (first, second, third) = (any(), any(), any());
    let place = random.usize(..connections.len().max(1));
    match (random.u8(..6), connections.get_mut(place)) {
        (0, Some(found)) if found.properties.len() > 2 => found.properties.swap(1, 2),
        (1, Some(found)) if found.properties.len() > 2 => found.properties[random.usize(1..=2)] = first,
        (2, _) => connections.insert(0, connection(&first, &first, None)),
        (3, _) => connections.push(connection(&first, &second, Some(&word(random)))),
        (4, _) => random.shuffle(connections),
        _ => {
            let circle = [(&first, &second), (&second, &third), (&third, &first)];
            let circle = circle.map(|(child, parent)| connection(child, parent, None));
            // A reader may use the first of several parents, or the last.
            let place = if random.bool() { 0 } else { connections.len() };
            connections.splice(place..place, circle);
        }
    }
}

/// Copies of an object with their own IDs, each connected with the copy before.
fn chain_objects(root: &mut Record, random: &mut Rng) {
    let Some(objects) = section(root, b"Objects").filter(|objects| !objects.is_empty()) else {
        return;
    };
    let part = objects[random.usize(..objects.len())].clone();
    let Some(Property::Number(b'L', _)) = part.properties.first() else {
        return;
    };
    let length = random.usize(1..LONGEST_CHAIN).min(LONGEST / 2 / size(&part));
    let id = |index: usize| Property::Number(b'L', (9_000_000_000 + index as i64).to_le_bytes().to_vec());
    objects.extend((0..length).map(|index| {
        let mut copy = part.clone();
        copy.properties[0] = id(index);
        copy
    }));
    let first = connection(&id(0), &part.properties[0], None);
    let chain = (1..length).map(|index| connection(&id(index), &id(index - 1), None));
    if let Some(connections) = section(root, b"Connections") {
        connections.push(first);
        connections.extend(chain);
    }
}
