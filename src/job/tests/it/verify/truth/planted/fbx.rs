//! Corruptions of binary FBX: of elements, values and arrays.

use super::{Files, Plant, of_character, of_walk, onto};

const FBX: &[&str] = &["fbx"];

/// The bytes before the first element: the magic and the version.
const HEADER: usize = 27;

#[derive(Clone)]
enum Value {
    /// The type code of a value, and its bytes without the code.
    Plain(u8, Vec<u8>),
    /// The type code of an array, and the bytes of its numbers.
    Array(u8, Vec<u8>),
}

struct Element {
    name: String,
    values: Vec<Value>,
    children: Vec<Self>,
    is_block: bool,
}

struct Fbx {
    header: Vec<u8>,
    elements: Vec<Element>,
    footer: Vec<u8>,
}

/// The width of a number in the header of an element.
fn width(header: &[u8]) -> usize {
    let version = u32::from_le_bytes(header[23..27].try_into().unwrap());
    if version >= 7500 { 8 } else { 4 }
}

fn number(bytes: &[u8]) -> usize {
    let mut all = [0; 8];
    all[..bytes.len()].copy_from_slice(bytes);
    u64::from_le_bytes(all) as usize
}

impl Fbx {
    fn read(bytes: &[u8]) -> Self {
        let header = bytes[..HEADER].to_vec();
        let mut at = HEADER;
        let mut elements = Vec::new();
        while let Some(element) = Element::read(bytes, &mut at, width(&header)) {
            elements.push(element);
        }
        let footer = bytes[at..].to_vec();
        Self {
            header,
            elements,
            footer,
        }
    }

    fn write(&self) -> Vec<u8> {
        let mut bytes = self.header.clone();
        let width = width(&self.header);
        for element in &self.elements {
            element.write(&mut bytes, width);
        }
        bytes.extend(vec![0; 3 * width + 1]);
        bytes.extend(&self.footer);
        bytes
    }

    fn section(&mut self, name: &str) -> &mut Vec<Element> {
        let found = self.elements.iter_mut().find(|element| element.name == name);
        &mut found.unwrap().children
    }

    /// The objects of a kind, such as `Model`, and of a class, such as `LimbNode`.
    fn objects(&mut self, kind: &str, class: &str) -> Vec<&mut Element> {
        let objects = self.section("Objects").iter_mut();
        objects
            .filter(|object| object.name == kind && (class.is_empty() || object.text(2) == class))
            .collect()
    }

    fn ids(&mut self, kind: &str, class: &str) -> Vec<i64> {
        self.objects(kind, class).iter().map(|object| object.long(0)).collect()
    }

    /// A property of an object, or of the settings.
    fn setting(&mut self, name: &str) -> &mut Element {
        let settings = self.section("GlobalSettings").iter_mut();
        property(
            settings
                .into_iter()
                .find(|element| element.name == "Properties70")
                .unwrap(),
            name,
        )
        .unwrap()
    }

    fn connections(&mut self) -> &mut Vec<Element> {
        self.section("Connections")
    }
}

fn property<'a>(properties: &'a mut Element, name: &str) -> Option<&'a mut Element> {
    properties.children.iter_mut().find(|property| property.text(0) == name)
}

impl Element {
    fn read(bytes: &[u8], at: &mut usize, width: usize) -> Option<Self> {
        let field = |index: usize| number(&bytes[*at + index * width..][..width]);
        let (end, count) = (field(0), field(1));
        let name_length = usize::from(bytes[*at + 3 * width]);
        *at += 3 * width + 1;
        if end == 0 {
            return None;
        }
        let name = String::from_utf8(bytes[*at..*at + name_length].to_vec()).unwrap();
        *at += name_length;
        let values = (0..count).map(|_| Value::read(bytes, at)).collect();
        let mut children = Vec::new();
        let is_block = *at < end;
        if is_block {
            while let Some(child) = Self::read(bytes, at, width) {
                children.push(child);
            }
        }
        assert_eq!(*at, end, "{name}");
        Some(Self {
            name,
            values,
            children,
            is_block,
        })
    }

    fn write(&self, bytes: &mut Vec<u8>, width: usize) {
        let start = bytes.len();
        let mut values = Vec::new();
        self.values.iter().for_each(|value| value.write(&mut values));
        bytes.extend(vec![0; 3 * width]);
        bytes.push(self.name.len() as u8);
        bytes.extend(self.name.as_bytes());
        bytes.extend(&values);
        for child in &self.children {
            child.write(bytes, width);
        }
        if self.is_block {
            bytes.extend(vec![0; 3 * width + 1]);
        }
        let end = bytes.len();
        for (index, number) in [end, self.values.len(), values.len()].into_iter().enumerate() {
            let place = start + index * width;
            bytes[place..place + width].copy_from_slice(&(number as u64).to_le_bytes()[..width]);
        }
    }

    fn child(&mut self, name: &str) -> Option<&mut Self> {
        self.children.iter_mut().find(|child| child.name == name)
    }

    fn long(&self, value: usize) -> i64 {
        match &self.values[value] {
            Value::Plain(b'L', bytes) => i64::from_le_bytes(bytes.as_slice().try_into().unwrap()),
            _ => panic!("{} has no number {value}", self.name),
        }
    }

    fn set_long(&mut self, value: usize, number: i64) {
        self.values[value] = Value::Plain(b'L', number.to_le_bytes().to_vec());
    }

    /// A text, up to the separator before its class.
    fn text(&self, value: usize) -> String {
        match self.values.get(value) {
            Some(Value::Plain(b'S', bytes)) => {
                let text = String::from_utf8_lossy(&bytes[4..]);
                text.split('\0').next().unwrap().to_owned()
            }
            _ => String::new(),
        }
    }

    /// Changes the numbers of a property, which follow its four texts.
    fn change(&mut self, change: impl Fn(f64) -> f64) {
        for value in &mut self.values[4..] {
            match value {
                Value::Plain(b'D', bytes) => {
                    let number = f64::from_le_bytes(bytes.as_slice().try_into().unwrap());
                    *bytes = change(number).to_le_bytes().to_vec();
                }
                Value::Plain(b'I', bytes) => {
                    let number = i32::from_le_bytes(bytes.as_slice().try_into().unwrap());
                    *bytes = (change(f64::from(number)) as i32).to_le_bytes().to_vec();
                }
                _ => {}
            }
        }
    }

    /// Changes the numbers in the array of a child.
    fn array(&mut self, name: &str, change: impl Fn(usize, f64) -> f64) -> Option<()> {
        let Value::Array(code, bytes) = self.child(name)?.values.first_mut()? else {
            return None;
        };
        let size = if b"dl".contains(code) { 8 } else { 4 };
        for (index, number) in bytes.chunks_exact_mut(size).enumerate() {
            match code {
                b'd' => {
                    let value = f64::from_le_bytes((&*number).try_into().unwrap());
                    number.copy_from_slice(&change(index, value).to_le_bytes());
                }
                b'l' => {
                    let value = i64::from_le_bytes((&*number).try_into().unwrap());
                    number.copy_from_slice(&(change(index, value as f64) as i64).to_le_bytes());
                }
                b'f' => {
                    let value = f32::from_le_bytes((&*number).try_into().unwrap());
                    number.copy_from_slice(&(change(index, value.into()) as f32).to_le_bytes());
                }
                _ => {
                    let value = i32::from_le_bytes((&*number).try_into().unwrap());
                    number.copy_from_slice(&(change(index, value.into()) as i32).to_le_bytes());
                }
            }
        }
        Some(())
    }
}

impl Value {
    fn read(bytes: &[u8], at: &mut usize) -> Self {
        let code = bytes[*at];
        *at += 1;
        let plain = match code {
            b'C' | b'B' => 1,
            b'Y' => 2,
            b'I' | b'F' => 4,
            b'L' | b'D' => 8,
            b'S' | b'R' => 4 + number(&bytes[*at..*at + 4]),
            _ => {
                let [count, encoding, length] = [0, 4, 8].map(|offset| number(&bytes[*at + offset..][..4]));
                let data = &bytes[*at + 12..][..length];
                *at += 12 + length;
                let size = if b"dl".contains(&code) { 8 } else { 4 };
                let size = if code == b'b' { 1 } else { size };
                let mut numbers = vec![0; count * size];
                match encoding {
                    0 => numbers.copy_from_slice(data),
                    _ => {
                        let config = zlib_rs::InflateConfig::default();
                        let (_, code) = zlib_rs::decompress_slice(&mut numbers, data, config);
                        assert_eq!(code, zlib_rs::ReturnCode::Ok);
                    }
                }
                return Self::Array(code, numbers);
            }
        };
        *at += plain;
        Self::Plain(code, bytes[*at - plain..*at].to_vec())
    }

    fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::Plain(code, bytes) => {
                out.push(*code);
                out.extend(bytes);
            }
            Self::Array(code, bytes) => {
                out.push(*code);
                let size = if b"dl".contains(code) { 8 } else { 4 };
                let size = if *code == b'b' { 1 } else { size };
                for number in [bytes.len() / size, 0, bytes.len()] {
                    out.extend((number as u32).to_le_bytes());
                }
                out.extend(bytes);
            }
        }
    }
}

fn with(files: &mut Files, change: impl FnOnce(&mut Fbx) -> Option<()>) -> bool {
    let mut file = Fbx::read(files.main());
    let is_there = change(&mut file).is_some();
    *files.main() = file.write();
    is_there
}

/// Removes the connections from the first objects to the second.
fn disconnect(file: &mut Fbx, objects: &[i64], owners: &[i64]) -> Option<()> {
    let connections = file.connections();
    let before = connections.len();
    connections.retain(|link| !(objects.contains(&link.long(1)) && owners.contains(&link.long(2))));
    (connections.len() < before).then_some(())
}

/// Exchanges the joints of two clusters.
fn exchange_joints(file: &mut Fbx) -> Option<()> {
    let (clusters, models) = (file.ids("Deformer", "Cluster"), file.ids("Model", ""));
    let connections = file.connections().iter_mut();
    let mut tied: Vec<&mut Element> = connections
        .filter(|link| models.contains(&link.long(1)) && clusters.contains(&link.long(2)))
        .collect();
    let (first, second) = (tied.first()?.long(1), tied.get(1)?.long(1));
    tied[0].set_long(1, second);
    tied[1].set_long(1, first);
    Some(())
}

fn move_bind(file: &mut Fbx) -> Option<()> {
    let mut clusters = file.objects("Deformer", "Cluster");
    clusters.get_mut(1)?.array(
        "TransformLink",
        |index, value| if index == 13 { value + 10.0 } else { value },
    )
}

fn scale_vertices(file: &mut Fbx) -> Option<()> {
    file.objects("Geometry", "Mesh")
        .first_mut()?
        .array("Vertices", |_, value| value * 1.1)
}

fn lose_material(file: &mut Fbx) -> Option<()> {
    let (materials, models) = (file.ids("Material", ""), file.ids("Model", ""));
    disconnect(file, &materials, &models)
}

fn lose_texture(file: &mut Fbx) -> Option<()> {
    let (textures, materials) = (file.ids("Texture", ""), file.ids("Material", ""));
    disconnect(file, &textures, &materials)
}

pub(super) const PLANTS: &[Plant] = &[
    of_walk("units: another unit stated", FBX, |files| {
        with(files, |file| {
            file.setting("UnitScaleFactor").change(|unit| unit * 100.0);
            Some(())
        })
    }),
    of_walk("units: another up axis stated", FBX, |files| {
        with(files, |file| {
            file.setting("UpAxis").change(|_| 2.0);
            file.setting("FrontAxis").change(|_| 1.0);
            file.setting("FrontAxisSign").change(|_| -1.0);
            Some(())
        })
    }),
    of_walk("units: another front axis stated", FBX, |files| {
        with(files, |file| {
            file.setting("FrontAxisSign").change(|_| -1.0);
            file.setting("CoordAxisSign").change(|_| -1.0);
            Some(())
        })
    }),
    of_walk("file: a joint renamed", FBX, |files| {
        with(files, |file| {
            let mut joints = file.objects("Model", "LimbNode");
            let joint = joints.last_mut()?;
            let name = format!("{}_another\0\x01Model", joint.text(1));
            let length = (name.len() as u32).to_le_bytes();
            joint.values[1] = Value::Plain(b'S', [&length, name.as_bytes()].concat());
            if let Some(properties) = joint.child("Properties70") {
                properties
                    .children
                    .retain(|property| property.text(0) != "mocap_source_name");
            }
            Some(())
        })
    }),
    of_walk("file: a joint below another", FBX, |files| {
        with(files, |file| {
            let joints = file.ids("Model", "LimbNode");
            let (root, moved) = (*joints.first()?, *joints.last()?);
            let mut links = file.connections().iter_mut();
            let link = links.find(|link| link.long(1) == moved && joints.contains(&link.long(2)))?;
            link.set_long(2, root);
            Some(())
        })
    }),
    of_walk("file: an offset scaled", FBX, |files| {
        with(files, |file| {
            let mut joints = file.objects("Model", "LimbNode");
            let longest = |joint: &&mut Element| {
                let properties = joint.children.iter().find(|child| child.name == "Properties70")?;
                let offset = properties
                    .children
                    .iter()
                    .find(|property| property.text(0) == "Lcl Translation")?;
                let numbers = offset.values[4..].iter().filter_map(|value| match value {
                    Value::Plain(b'D', bytes) => Some(f64::from_le_bytes(bytes.as_slice().try_into().ok()?).abs()),
                    _ => None,
                });
                numbers.max_by(f64::total_cmp)
            };
            let joint = joints
                .iter_mut()
                .skip(1)
                .max_by(|a, b| longest(a).partial_cmp(&longest(b)).unwrap())?;
            property(joint.child("Properties70")?, "Lcl Translation")?.change(|value| value * 1.1);
            Some(())
        })
    }),
    of_walk("file: one frame wrong", FBX, |files| {
        with(files, |file| {
            let mut curves = file.objects("AnimationCurve", "");
            let longest = |curve: &&mut Element| match &curve
                .children
                .iter()
                .find(|child| child.name == "KeyValueFloat")
                .unwrap()
                .values[0]
            {
                Value::Array(_, bytes) => bytes.len(),
                Value::Plain(..) => 0,
            };
            let curve = curves.iter_mut().max_by_key(|curve| longest(curve))?;
            let half = longest(curve) / 8;
            curve.array(
                "KeyValueFloat",
                |index, value| if index == half { value + 40.0 } else { value },
            )
        })
    }),
    of_walk("file: times shifted", FBX, |files| {
        with(files, |file| {
            // A tenth of a second.
            const SHIFT: f64 = 4_618_615_800.0;
            let mut curves = file.objects("AnimationCurve", "");
            curves
                .iter_mut()
                .try_for_each(|curve| curve.array("KeyTime", |_, value| value + SHIFT))
        })
    }),
    of_walk("file: channels exchanged", FBX, |files| {
        with(files, |file| {
            let nodes = file.ids("AnimationCurveNode", "");
            let links = file.connections().iter_mut();
            let mut curves: Vec<&mut Element> = links
                .filter(|link| link.text(3) == "d|X" && nodes.contains(&link.long(2)))
                .collect();
            let count = curves.len();
            let (first, second) = (curves.first()?.long(1), curves.get(count / 2)?.long(1));
            curves[0].set_long(1, second);
            curves[count / 2].set_long(1, first);
            (first != second).then_some(())
        })
    }),
    of_walk("file: the clip lost", FBX, |files| {
        with(files, |file| {
            let (nodes, layers) = (file.ids("AnimationCurveNode", ""), file.ids("AnimationLayer", ""));
            disconnect(file, &nodes, &layers)
        })
    }),
    of_walk("skin: joints exchanged", FBX, |files| with(files, exchange_joints)),
    of_walk("skin: an inverse bind matrix moved", FBX, |files| {
        with(files, move_bind)
    }),
    of_character("skin: joints exchanged", FBX, |files| with(files, exchange_joints)),
    of_character("skin: an inverse bind matrix moved", FBX, |files| {
        with(files, move_bind)
    }),
    of_character("skin: weights of other joints", FBX, |files| {
        with(files, |file| {
            let mut clusters = file.objects("Deformer", "Cluster");
            clusters.first_mut()?.array("Weights", |_, value| value * 0.25)
        })
    }),
    of_character("mesh: vertices scaled", FBX, |files| with(files, scale_vertices)),
    of_character("mesh: a vertex moved", FBX, |files| {
        with(files, |file| {
            let mut meshes = file.objects("Geometry", "Mesh");
            meshes
                .first_mut()?
                .array("Vertices", |index, value| if index == 3 { value + 5.0 } else { value })
        })
    }),
    of_character("mesh: texture coordinates exchanged", FBX, |files| {
        with(files, |file| {
            let mut meshes = file.objects("Geometry", "Mesh");
            meshes
                .first_mut()?
                .child("LayerElementUV")?
                .array("UV", |_, value| 1.0 - value)
        })
    }),
    of_character("mesh: a face lost", FBX, |files| {
        with(files, |file| {
            let mut meshes = file.objects("Geometry", "Mesh");
            let corners = meshes.first_mut()?.child("PolygonVertexIndex")?;
            let Value::Array(_, bytes) = corners.values.first_mut()? else {
                return None;
            };
            bytes.truncate(bytes.len() - 12);
            Some(())
        })
    }),
    of_character("material: the material lost", FBX, |files| with(files, lose_material)),
    of_character("material: the texture lost", FBX, |files| with(files, lose_texture)),
    of_character("material: another image", FBX, |files| {
        with(files, |file| {
            let mut videos = file.objects("Video", "");
            let Value::Plain(b'R', bytes) = videos.first_mut()?.child("Content")?.values.first_mut()? else {
                return None;
            };
            bytes[24] ^= 0xff;
            Some(())
        })
    }),
    onto("skin: joints exchanged", FBX, |files| with(files, exchange_joints)),
    onto("skin: an inverse bind matrix moved", FBX, |files| {
        with(files, move_bind)
    }),
    onto("mesh: vertices scaled", FBX, |files| with(files, scale_vertices)),
    // If a material has a texture, its colour is the texture.
    onto("material: another colour", FBX, |files| {
        with(files, |file| {
            let mut materials = file.objects("Material", "");
            materials.iter_mut().try_for_each(|material| {
                property(material.child("Properties70")?, "DiffuseColor")?.change(|value| value * 0.5);
                Some(())
            })
        })
    }),
    onto("material: the material lost", FBX, |files| with(files, lose_material)),
    onto("material: the texture lost", FBX, |files| with(files, lose_texture)),
];
