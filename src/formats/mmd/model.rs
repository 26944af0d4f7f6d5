//! Reads the bones and morph names of a `.pmx` file.
//!
//! ```text
//! file     := "PMX ", version f32, u8, and as many bytes: encoding (0 UTF-16, 1 UTF-8), further texture coordinates,
//!             bytes of an index of a vertex, a texture, a material, a bone, a morph, a body; name, English name,
//!             comment, English comment; vertices, indices, textures, materials, bones, morphs, and unread data
//! text     := i32 of bytes, bytes
//! bone     := name, English name, position, parent, layer i32, flags u16, tail (position or bone), and by flags: bone
//!             and ratio f32 of what it inherits; a fixed axis; local axes x and z; a key i32; IK
//! IK       := bone that it brings to itself, loops i32, largest angle of a step f32, i32, and as many: link, u8, and
//!             where that is 1, the least and the largest angles about x, y, z
//! morph    := name, English name, panel u8, kind u8, i32, and as many offsets, whose bytes follow from the kind
//! ```
//!
//! The format is described by its author, Kyokuhoku P, in the PMX 2.1 specification.

use glam::DVec3;
use mocap_scene::error::{Code, Diagnostic};
use mocap_scene::limits::{Limits, is_plausible, limit_exceeded};

use super::bytes::{Cursor, invalid};
use super::{MODEL_HEAD, is_old_model};
use crate::Failure;

/// Flags of a bone.
const TAIL_IS_BONE: u16 = 0x0001;
const HAS_IK: u16 = 0x0020;
const INHERITS_ROTATION: u16 = 0x0100;
const INHERITS_POSITION: u16 = 0x0200;
const HAS_FIXED_AXIS: u16 = 0x0400;
const HAS_LOCAL_AXES: u16 = 0x0800;
const IS_AFTER_PHYSICS: u16 = 0x1000;
const HAS_EXTERNAL_PARENT: u16 = 0x2000;

/// The smallest size of a bone in bytes: empty strings and no options.
const BONE_BYTES: usize = 8 + 12 + 1 + 4 + 2 + 1;

/// The smallest size of a morph in bytes.
const MORPH_BYTES: usize = 8 + 1 + 1 + 4;

/// The smallest size of a texture entry in bytes. An entry is a file name, and an empty name has only the 4 bytes of
/// its length.
const TEXT_BYTES: usize = 4;

/// The smallest size of a material in bytes.
const MATERIAL_BYTES: usize = 8 + MATERIAL_NUMBERS;
/// The size in bytes of a material's colours, flags and edge.
const MATERIAL_NUMBERS: usize = 16 + 12 + 4 + 12 + 1 + 16 + 4;

/// A right-handed model, in its own unit.
#[derive(Clone, Debug, Default)]
pub struct Model {
    pub(super) name: String,
    pub bones: Vec<Bone>,
    pub(super) morphs: Vec<String>,
    /// The number of vertices of the model's mesh, which is not read.
    pub(super) vertices: usize,
}

#[derive(Clone, Debug, Default)]
pub struct Bone {
    pub name: String,
    /// The model-space position at rest.
    pub position: DVec3,
    pub parent: Option<usize>,
    /// Bones of lower layers are posed first. Bones after the physics come last.
    pub(super) layer: i32,
    pub(super) is_after_physics: bool,
    /// The unit axis of a bone with a single rotation axis.
    pub(super) axis: Option<DVec3>,
    pub(super) inherits: Option<Inherits>,
    pub(super) ik: Option<Ik>,
}

/// The share of another bone's rotation and position that a bone inherits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inherits {
    pub(super) source: usize,
    pub(super) ratio: f64,
    pub(super) rotation: bool,
    pub(super) position: bool,
}

/// Inverse kinematics, which rotates links so that the target bone reaches this bone.
#[derive(Clone, Debug)]
pub(super) struct Ik {
    pub(super) target: usize,
    pub(super) loops: usize,
    /// The largest angle of a step, in radians.
    pub(super) step: f64,
    /// The links, from the target to the root.
    pub(super) links: Vec<Link>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    pub(super) bone: usize,
    /// The smallest and the largest angles about x, y and z, in radians.
    pub(super) limits: Option<[DVec3; 2]>,
}

/// The largest number of loops in MMD.
const MOST_LOOPS: i32 = 255;

impl Model {
    pub fn find(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|bone| bone.name == name)
    }
}

pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Model, Failure> {
    if !bytes.starts_with(MODEL_HEAD) {
        return Err(match is_old_model(bytes) {
            true => Diagnostic::new(Code::UnreadableFormat, "the file is PMD or PMX 1.0, which are not read")
                .help("save it as PMX 2.0 in an editor of models")
                .into(),
            false => invalid("the file does not begin with \"PMX \", as a model of MikuMikuDance does"),
        });
    }
    let mut reader = Reader::new(bytes)?;
    let mut model = Model {
        name: reader.text()?,
        ..Model::default()
    };
    for _ in 0..3 {
        reader.pass_text()?;
    }
    model.vertices = reader.pass_vertices()?;
    let indices = reader.cursor.count("indices", reader.size(VERTEX))?;
    reader.cursor.take(indices * reader.size(VERTEX))?;
    for _ in 0..reader.cursor.count("textures", TEXT_BYTES)? {
        reader.pass_text()?;
    }
    for _ in 0..reader.cursor.count("materials", MATERIAL_BYTES)? {
        reader.pass_material()?;
    }
    let bones = reader.cursor.count("bones", BONE_BYTES)?;
    if bones > limits.max_nodes {
        let most = format!("at most {} bones", limits.max_nodes);
        return Err(limit_exceeded(most, bones.to_string()).into());
    }
    for index in 0..bones {
        model.bones.push(reader.bone(index, bones, limits)?);
    }
    if model.bones.is_empty() {
        return Err(invalid("the model has no bones"));
    }
    check_parents(&model.bones, limits)?;
    for _ in 0..reader.cursor.count("morphs", MORPH_BYTES)? {
        let morph = reader.morph(limits)?;
        model.morphs.push(morph);
    }
    if model.bones.len() + model.morphs.len() > limits.max_nodes {
        let most = format!("at most {} bones and morphs", limits.max_nodes);
        return Err(limit_exceeded(most, (model.bones.len() + model.morphs.len()).to_string()).into());
    }
    Ok(model)
}

/// Refuses bones that are their own ancestors, and chains that are too long.
fn check_parents(bones: &[Bone], limits: &Limits) -> Result<(), Failure> {
    let mut depths: Vec<usize> = vec![0; bones.len()];
    let mut chain = Vec::new();
    for bone in 0..bones.len() {
        let mut at = Some(bone);
        while let Some(index) = at.filter(|index| depths[*index] == 0) {
            if chain.len() > bones.len() {
                let message = "a bone is its own ancestor";
                return Err(Diagnostic::new(Code::InvalidMmd, message)
                    .in_joint(&bones[bone].name)
                    .help("give the bone another parent in an editor of models")
                    .into());
            }
            chain.push(index);
            at = bones[index].parent;
        }
        let mut depth = at.map_or(0, |index| depths[index]);
        while let Some(index) = chain.pop() {
            depth += 1;
            depths[index] = depth;
        }
        if depth > limits.max_depth {
            let most = format!("at most {} bones above each other", limits.max_depth);
            return Err(limit_exceeded(most, depth.to_string()).into());
        }
    }
    Ok(())
}

/// The header position of the vertex index size.
const VERTEX: usize = 0;

/// The header position of the texture index size.
const TEXTURE: usize = 1;

/// The header position of the material index size.
const MATERIAL: usize = 2;

/// The header position of the bone index size.
const BONE: usize = 3;

/// The header position of the morph index size.
const MORPH: usize = 4;

/// The header position of the rigid body index size.
const BODY: usize = 5;

struct Reader<'a> {
    cursor: Cursor<'a>,
    is_utf8: bool,
    further_coordinates: usize,
    sizes: [usize; 6],
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8]) -> Result<Self, Failure> {
        let mut cursor = Cursor::new(bytes);
        cursor.take(MODEL_HEAD.len())?;
        let version = cursor.real()?;
        // The versions 2.0 and 2.1 are 32-bit floats.
        if !(1.99..2.2).contains(&version) {
            let message = format!("PMX {version} is not read");
            return Err(Diagnostic::new(Code::UnreadableFormat, message)
                .expected_found("2.0 or 2.1", format!("{version}"))
                .help("save it as PMX 2.0 in an editor of models")
                .into());
        }
        let count = cursor.byte()?;
        let globals = cursor.take(usize::from(count))?;
        let &[encoding, further, ref sizes @ ..] = globals else {
            return Err(invalid("the header of the model is too short"));
        };
        let sizes: Vec<usize> = sizes.iter().take(6).map(|size| usize::from(*size)).collect();
        let sizes: [usize; 6] = sizes
            .try_into()
            .map_err(|_| invalid("the header of the model is too short"))?;
        if let Some(wrong) = sizes.iter().find(|size| ![1, 2, 4].contains(*size)) {
            return Err(invalid(format!(
                "an index must have 1, 2 or 4 bytes, but the header states {wrong}"
            )));
        }
        // In every version a vertex has at most four further texture coordinates.
        if encoding > 1 || further > 4 {
            return Err(invalid(format!(
                "the header of the model is broken: it states the encoding {encoding} and {further} further texture \
                 coordinates"
            )));
        }
        Ok(Self {
            cursor,
            is_utf8: encoding == 1,
            further_coordinates: usize::from(further),
            sizes,
        })
    }

    fn size(&self, of: usize) -> usize {
        self.sizes[of]
    }

    fn pass_text(&mut self) -> Result<&'a [u8], Failure> {
        let length = self.cursor.count("bytes of a string", 1)?;
        self.cursor.take(length)
    }

    fn text(&mut self) -> Result<String, Failure> {
        let bytes = self.pass_text()?;
        if self.is_utf8 {
            return Ok(String::from_utf8_lossy(bytes).into_owned());
        }
        let (pairs, _) = bytes.as_chunks::<2>();
        let units = pairs.iter().map(|pair| u16::from_le_bytes(*pair));
        Ok(char::decode_utf16(units)
            .map(|unit| unit.unwrap_or(char::REPLACEMENT_CHARACTER))
            .collect())
    }

    /// An index of a bone or another item; `None` for -1, which means no item.
    fn index(&mut self, of: usize) -> Result<Option<usize>, Failure> {
        let index = match self.size(of) {
            1 => i64::from(self.cursor.byte()?.cast_signed()),
            2 => i64::from(self.cursor.short()?.cast_signed()),
            _ => i64::from(self.cursor.int()?),
        };
        Ok(usize::try_from(index).ok())
    }

    fn bone_index(&mut self, count: usize, owner: &str) -> Result<Option<usize>, Failure> {
        match self.index(BONE)? {
            Some(index) if index >= count => Err(Diagnostic::new(
                Code::InvalidMmd,
                format!("a bone refers to the bone number {index}, but the model has {count} bones"),
            )
            .in_joint(owner)
            .help(super::EXPORT_AGAIN)
            .into()),
            index => Ok(index),
        }
    }

    fn pass_vertices(&mut self) -> Result<usize, Failure> {
        let bone = self.size(BONE);
        // Position, normal and coordinates. The weights follow.
        let fixed = 12 + 12 + 8 + 16 * self.further_coordinates;
        let count = self.cursor.count("vertices", fixed + 1 + bone + 4)?;
        for _ in 0..count {
            self.cursor.take(fixed)?;
            let weights = match self.cursor.byte()? {
                0 => bone,
                1 => 2 * bone + 4,
                2 | 4 => 4 * bone + 16,
                3 => 2 * bone + 4 + 36,
                kind => {
                    return Err(invalid(format!(
                        "a vertex has weights of kind {kind}, but the kinds are 0 to 4"
                    )));
                }
            };
            // The edge scale, 4 bytes, follows the weights.
            self.cursor.take(weights + 4)?;
        }
        Ok(count)
    }

    fn pass_material(&mut self) -> Result<(), Failure> {
        self.pass_text()?;
        self.pass_text()?;
        self.cursor.take(MATERIAL_NUMBERS)?;
        let texture = self.size(TEXTURE);
        self.cursor.take(2 * texture + 1)?;
        let toon = if self.cursor.byte()? == 0 { texture } else { 1 };
        self.cursor.take(toon)?;
        self.pass_text()?;
        self.cursor.take(4)?;
        Ok(())
    }

    fn bone(&mut self, index: usize, count: usize, limits: &Limits) -> Result<Bone, Failure> {
        let name = self.name(limits)?;
        let position = self.cursor.position()?;
        if !position.to_array().into_iter().all(is_plausible) {
            return Err(
                Diagnostic::new(Code::NumberRange, "the position of a bone is not a usable number")
                    .in_joint(name)
                    .help(super::EXPORT_AGAIN)
                    .into(),
            );
        }
        let parent = self.bone_index(count, &name)?.filter(|parent| *parent != index);
        let (layer, flags) = (self.cursor.int()?, self.cursor.short()?);
        let has = |flag: u16| flags & flag != 0;
        match has(TAIL_IS_BONE) {
            true => drop(self.index(BONE)?),
            false => drop(self.cursor.numbers()?),
        }
        let mut bone = Bone {
            position,
            parent,
            layer,
            is_after_physics: has(IS_AFTER_PHYSICS),
            ..Bone::default()
        };
        if has(INHERITS_ROTATION) || has(INHERITS_POSITION) {
            let (source, ratio) = (self.bone_index(count, &name)?, self.cursor.real()?);
            bone.inherits = source.filter(|_| is_plausible(ratio)).map(|source| Inherits {
                source,
                ratio,
                rotation: has(INHERITS_ROTATION),
                position: has(INHERITS_POSITION),
            });
        }
        if has(HAS_FIXED_AXIS) {
            // A rotation axis: mirroring z changes the signs of x and y.
            let axis = self.cursor.numbers()? * DVec3::new(-1.0, -1.0, 1.0);
            bone.axis = axis.try_normalize();
        }
        let further = [(HAS_LOCAL_AXES, 24), (HAS_EXTERNAL_PARENT, 4)];
        for (_, bytes) in further.into_iter().filter(|(flag, _)| has(*flag)) {
            self.cursor.take(bytes)?;
        }
        if has(HAS_IK) {
            bone.ik = self.ik(count, &name)?;
        }
        Ok(Bone { name, ..bone })
    }

    fn ik(&mut self, count: usize, owner: &str) -> Result<Option<Ik>, Failure> {
        let target = self.bone_index(count, owner)?;
        let loops = self.cursor.int()?.clamp(0, MOST_LOOPS);
        let step = self.cursor.real()?;
        let mut links = Vec::new();
        for _ in 0..self.cursor.count("links of an IK", self.size(BONE) + 1)? {
            let bone = self.bone_index(count, owner)?;
            let limits = match self.cursor.byte()? {
                0 => None,
                _ => Some([self.cursor.numbers()?, self.cursor.numbers()?]),
            };
            let are_numbers = |limits: &[DVec3; 2]| limits.iter().all(|limit| limit.is_finite());
            if let Some(bone) = bone {
                let limits = limits.filter(are_numbers).map(right_handed);
                links.push(Link { bone, limits });
            }
        }
        Ok(target.filter(|_| step.is_finite()).map(|target| Ik {
            target,
            loops: usize::try_from(loops).unwrap_or(0),
            step: step.abs(),
            links,
        }))
    }

    /// A name, followed by the English name.
    fn name(&mut self, limits: &Limits) -> Result<String, Failure> {
        let name = self.text()?;
        self.pass_text()?;
        if name.len() > limits.max_name_bytes {
            let most = format!("at most {} bytes in a name", limits.max_name_bytes);
            return Err(limit_exceeded(most, name.len().to_string()).into());
        }
        Ok(name)
    }

    fn morph(&mut self, limits: &Limits) -> Result<String, Failure> {
        let name = self.name(limits)?;
        self.cursor.byte()?;
        let kind = self.cursor.byte()?;
        let bytes = match kind {
            0 | 9 => self.size(MORPH) + 4,
            1 => self.size(VERTEX) + 12,
            2 => self.size(BONE) + 28,
            3..=7 => self.size(VERTEX) + 16,
            8 => self.size(MATERIAL) + 1 + 4 * 28,
            10 => self.size(BODY) + 1 + 24,
            _ => return Err(invalid(format!("a morph is of kind {kind}, but the kinds are 0 to 10"))),
        };
        let count = self.cursor.count("offsets of a morph", bytes)?;
        self.cursor.take(count * bytes)?;
        Ok(name)
    }
}

/// Mirroring z reverses the angles about x and y.
fn right_handed([least, largest]: [DVec3; 2]) -> [DVec3; 2] {
    [
        DVec3::new(-largest.x, -largest.y, least.z),
        DVec3::new(-least.x, -least.y, largest.z),
    ]
}
