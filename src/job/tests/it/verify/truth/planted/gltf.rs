//! Corruptions of glTF: of its JSON, and of the numbers in its buffer.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::{Files, Plant, of_character, of_walk, onto};

const NEW: &[&str] = &["glb", "gltf", "vrma"];
const KEPT: &[&str] = &["glb", "gltf"];

/// The beginning of an embedded buffer in the JSON.
const DATA: &str = "data:application/octet-stream;base64,";

/// A file, split into its parts.
struct Gltf {
    json: Value,
    /// The first buffer.
    bin: Vec<u8>,
    /// The binary chunk of a `.glb`, if the chunk is not the first buffer.
    chunk: Vec<u8>,
}

impl Gltf {
    fn read(files: &Files) -> Self {
        let bytes = &files.all[&files.main];
        let length = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize;
        let (text, chunk) = match bytes.starts_with(b"glTF") {
            true => bytes[20..].split_at(length(12)),
            false => (bytes.as_slice(), &[][..]),
        };
        let chunk = chunk.get(8..).unwrap_or_default().to_vec();
        let json: Value = serde_json::from_slice(text).unwrap();
        let uri = json["buffers"][0]["uri"].as_str();
        let bin = match uri.map(|uri| uri.strip_prefix(DATA).ok_or(uri)) {
            Some(Ok(data)) => STANDARD.decode(data).unwrap(),
            Some(Err(file)) => files.all[file].clone(),
            None => chunk.clone(),
        };
        Self { json, bin, chunk }
    }

    fn write(mut self, files: &mut Files) {
        let buffer = &mut self.json["buffers"][0];
        match buffer["uri"]
            .as_str()
            .map(|uri| (uri.starts_with(DATA), uri.to_owned()))
        {
            Some((true, _)) => buffer["uri"] = format!("{DATA}{}", STANDARD.encode(self.bin)).into(),
            Some((false, file)) => drop(files.all.insert(file, self.bin)),
            None => self.chunk = self.bin,
        }
        let mut text = self.json.to_string().into_bytes();
        if files.extension() == "gltf" {
            *files.main() = text;
            return;
        }
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunks = [(b"JSON", text), (b"BIN\0", self.chunk)];
        let chunks = chunks.into_iter().filter(|(_, chunk)| !chunk.is_empty());
        let chunks: Vec<u8> = chunks
            .flat_map(|(kind, chunk)| [&(chunk.len() as u32).to_le_bytes(), &kind[..], &chunk].concat())
            .collect();
        let length = (12 + chunks.len() as u32).to_le_bytes();
        *files.main() = [&b"glTF\x02\0\0\0"[..], &length, &chunks].concat();
    }

    fn list(&mut self, name: &str) -> &mut Vec<Value> {
        self.json[name].as_array_mut().unwrap()
    }

    fn clip(&mut self) -> &mut Value {
        &mut self.json["animations"][0]
    }

    /// The offset and the bytes of an accessor.
    fn bytes(&mut self, accessor: &Value) -> &mut [u8] {
        let accessor = &self.json["accessors"][accessor.as_u64().unwrap() as usize];
        let number = |value: &Value| value.as_u64().unwrap_or_default() as usize;
        let view = &self.json["bufferViews"][number(&accessor["bufferView"])];
        let start = number(&view["byteOffset"]) + number(&accessor["byteOffset"]);
        let width = match accessor["type"].as_str().unwrap() {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let size = match number(&accessor["componentType"]) {
            5120 | 5121 => 1,
            5122 | 5123 => 2,
            _ => 4,
        };
        let length = width * size * number(&accessor["count"]);
        &mut self.bin[start..start + length]
    }

    /// Changes the numbers of an accessor of floats.
    fn floats(&mut self, accessor: &Value, change: impl Fn(usize, f32) -> f32) {
        let numbers = self.bytes(accessor).chunks_exact_mut(4).enumerate();
        for (index, number) in numbers {
            let value = f32::from_le_bytes((&*number).try_into().unwrap());
            number.copy_from_slice(&change(index, value).to_le_bytes());
        }
    }

    /// The samplers of the first clip whose channels animate this path, with their nodes. The nodes that move most come
    /// first.
    fn samplers(&mut self, path: &str) -> Vec<(usize, usize)> {
        let clip = self.clip().clone();
        let channels = clip["channels"].as_array().unwrap().iter();
        let channels = channels.filter(|channel| channel["target"]["path"] == path);
        let number = |value: &Value| value.as_u64().unwrap() as usize;
        let mut found: Vec<_> = channels
            .map(|channel| {
                let (sampler, node) = (number(&channel["sampler"]), number(&channel["target"]["node"]));
                let bytes = self.bytes(&clip["samplers"][sampler]["output"]).to_vec();
                let keys: Vec<f32> = bytes
                    .chunks_exact(4)
                    .map(|bytes| f32::from_le_bytes(bytes.try_into().unwrap()))
                    .collect();
                let width = if path == "rotation" { 4 } else { 3 };
                let first = &keys[..width];
                let off = |key: &[f32]| {
                    std::iter::zip(key, first)
                        .map(|(a, b)| (a - b).abs())
                        .fold(0.0, f32::max)
                };
                (keys.chunks_exact(width).map(off).fold(0.0, f32::max), sampler, node)
            })
            .collect();
        found.sort_by(|a, b| b.0.total_cmp(&a.0));
        found.into_iter().map(|(_, sampler, node)| (sampler, node)).collect()
    }

    fn output(&mut self, sampler: usize) -> Value {
        self.clip()["samplers"][sampler]["output"].clone()
    }

    fn primitive(&mut self) -> &mut Value {
        &mut self.json["meshes"][0]["primitives"][0]
    }
}

/// Applies a change to a file.
fn with(files: &mut Files, change: impl FnOnce(&mut Gltf) -> Option<()>) -> bool {
    let mut file = Gltf::read(files);
    let is_there = change(&mut file).is_some();
    file.write(files);
    is_there
}

fn exchange_joints(file: &mut Gltf) -> Option<()> {
    // These buffers are in separate files.
    let joints = file.json["skins"][0]["joints"].as_array_mut()?;
    let last = joints.len() - 1;
    joints.swap(0, last);
    Some(())
}

fn move_bind(file: &mut Gltf) -> Option<()> {
    let accessor = file.json["skins"].get(0)?["inverseBindMatrices"].clone();
    // The Y of the second joint's translation.
    file.floats(
        &accessor,
        |index, value| if index == 16 + 13 { value + 0.1 } else { value },
    );
    Some(())
}

fn scale_vertices(file: &mut Gltf) -> Option<()> {
    let accessor = file.json["meshes"].get(0)?["primitives"][0]["attributes"]["POSITION"].clone();
    file.floats(&accessor, |_, value| value * 1.1);
    Some(())
}

fn remove(value: &mut Value, key: &str) -> Option<()> {
    value.as_object_mut()?.remove(key).map(drop)
}

pub(super) const PLANTS: &[Plant] = &[
    of_walk("file: a joint renamed", NEW, |files| {
        with(files, |file| {
            let node = file
                .list("nodes")
                .iter_mut()
                .rev()
                .find(|node| node["children"].is_array())?;
            let name = format!("{}_another", node["name"].as_str()?);
            node["name"] = name.into();
            remove(&mut node["extras"], "source_name").or(Some(()))
        })
    }),
    of_walk("file: a joint below another", NEW, |files| {
        with(files, |file| {
            let parents: Vec<usize> = (0..file.list("nodes").len())
                .filter(|node| file.json["nodes"][node]["children"].is_array())
                .collect();
            let (first, last) = (*parents.first()?, *parents.last()?);
            let child = file.json["nodes"][last]["children"].as_array_mut()?.remove(0);
            file.json["nodes"][first]["children"].as_array_mut()?.push(child);
            if file.json["nodes"][last]["children"].as_array()?.is_empty() {
                remove(&mut file.json["nodes"][last], "children")?;
            }
            Some(())
        })
    }),
    of_walk("file: an offset scaled", NEW, |files| {
        with(files, |file| {
            let moved: Vec<usize> = file.samplers("translation").into_iter().map(|(_, node)| node).collect();
            let nodes = file.list("nodes").iter_mut().enumerate();
            let still = nodes.filter(|(index, node)| !moved.contains(index) && node["children"].is_array());
            let node = still.max_by(|a, b| {
                let longest = |node: &Value| node["translation"][1].as_f64().unwrap_or_default().abs();
                longest(a.1).total_cmp(&longest(b.1))
            });
            for number in node?.1["translation"].as_array_mut()? {
                *number = json!(number.as_f64()? * 1.1);
            }
            Some(())
        })
    }),
    of_walk("file: one frame wrong", NEW, |files| {
        with(files, |file| {
            let (sampler, _) = *file.samplers("rotation").first()?;
            let output = file.output(sampler);
            let half = file.bytes(&output).len() / 32;
            file.floats(&output, |index, value| {
                if index / 4 == half && index % 4 < 3 {
                    -value
                } else {
                    value
                }
            });
            Some(())
        })
    }),
    of_walk("file: times shifted", NEW, |files| {
        with(files, |file| {
            let samplers = file.clip()["samplers"].as_array()?.clone();
            let mut inputs: Vec<Value> = samplers.iter().map(|sampler| sampler["input"].clone()).collect();
            inputs.sort_by_key(Value::as_u64);
            inputs.dedup();
            for input in inputs {
                file.floats(&input, |_, value| value + 0.1);
                let accessor = &mut file.json["accessors"][input.as_u64()? as usize];
                for bound in ["min", "max"] {
                    accessor[bound][0] = json!(accessor[bound][0].as_f64()? + 0.1);
                }
            }
            Some(())
        })
    }),
    of_walk("file: channels exchanged", NEW, |files| {
        with(files, |file| {
            let busiest = file.samplers("rotation");
            let (a, b) = (busiest.first()?.1, busiest.get(1)?.1);
            for channel in file.clip()["channels"].as_array_mut()? {
                let target = &mut channel["target"];
                if target["path"] == "rotation" {
                    let node = target["node"].as_u64()? as usize;
                    target["node"] = json!(if node == a {
                        b
                    } else if node == b {
                        a
                    } else {
                        node
                    });
                }
            }
            Some(())
        })
    }),
    of_walk("file: keys held until the next", NEW, |files| {
        with(files, |file| {
            for sampler in file.clip()["samplers"].as_array_mut()? {
                sampler["interpolation"] = "STEP".into();
            }
            Some(())
        })
    }),
    of_walk("file: the clip lost", NEW, |files| {
        with(files, |file| remove(&mut file.json, "animations"))
    }),
    of_walk("file: lengths in centimetres", NEW, |files| {
        with(files, |file| {
            for node in file.list("nodes") {
                for number in node["translation"].as_array_mut().into_iter().flatten() {
                    *number = json!(number.as_f64()? * 100.0);
                }
            }
            for (sampler, _) in file.samplers("translation") {
                let output = file.output(sampler);
                file.floats(&output, |_, value| value * 100.0);
            }
            Some(())
        })
    }),
    of_walk("file: another source named", NEW, |files| {
        with(files, |file| {
            let source = &mut file.json["asset"]["extras"]["mocap"]["source"];
            source["sha256"] = source["sha256"].as_str()?.chars().rev().collect::<String>().into();
            Some(())
        })
    }),
    of_walk("skin: joints exchanged", &["glb", "gltf"], |files| {
        with(files, exchange_joints)
    }),
    of_walk("skin: an inverse bind matrix moved", &["glb", "gltf"], |files| {
        with(files, move_bind)
    }),
    of_character("skin: joints exchanged", KEPT, |files| with(files, exchange_joints)),
    of_character("skin: an inverse bind matrix moved", KEPT, |files| {
        with(files, move_bind)
    }),
    of_character("skin: the inverse bind matrices lost", KEPT, |files| {
        with(files, |file| remove(&mut file.json["skins"][0], "inverseBindMatrices"))
    }),
    of_character("skin: weights of other joints", KEPT, |files| {
        with(files, |file| {
            let accessor = file.primitive()["attributes"]["WEIGHTS_0"].clone();
            file.floats(
                &accessor,
                |index, value| if index % 4 < 2 { 1.0 - value } else { value },
            );
            Some(())
        })
    }),
    of_character("mesh: vertices scaled", KEPT, |files| with(files, scale_vertices)),
    of_character("mesh: a vertex moved", KEPT, |files| {
        with(files, |file| {
            let accessor = file.primitive()["attributes"]["POSITION"].clone();
            file.floats(&accessor, |index, value| if index == 3 { value + 0.05 } else { value });
            Some(())
        })
    }),
    of_character("mesh: texture coordinates exchanged", KEPT, |files| {
        with(files, |file| {
            let accessor = file.primitive()["attributes"]["TEXCOORD_0"].clone();
            file.floats(&accessor, |_, value| 1.0 - value);
            Some(())
        })
    }),
    of_character("mesh: a face lost", KEPT, |files| {
        with(files, |file| {
            let accessor = file.primitive()["indices"].as_u64()? as usize;
            let count = &mut file.json["accessors"][accessor]["count"];
            *count = json!(count.as_u64()? - 3);
            Some(())
        })
    }),
    of_character("mesh: the mesh lost", KEPT, |files| {
        with(files, |file| {
            let node = file.list("nodes").iter_mut().find(|node| !node["mesh"].is_null())?;
            remove(node, "skin")?;
            remove(node, "mesh")
        })
    }),
    of_character("mesh: a morph target lost", KEPT, |files| {
        with(files, |file| remove(file.primitive(), "targets"))
    }),
    of_character("mesh: a morph target halved", KEPT, |files| {
        with(files, |file| {
            let accessor = file.primitive()["targets"][0]["POSITION"].clone();
            file.floats(&accessor, |_, value| value * 0.5);
            Some(())
        })
    }),
    of_character("material: the material lost", KEPT, |files| {
        with(files, |file| remove(file.primitive(), "material"))
    }),
    of_character("material: another colour", KEPT, |files| {
        with(files, |file| {
            file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = json!([1.0, 0.0, 0.0, 1.0]);
            Some(())
        })
    }),
    of_character("material: the texture lost", KEPT, |files| {
        with(files, |file| {
            remove(
                &mut file.json["materials"][0]["pbrMetallicRoughness"],
                "baseColorTexture",
            )
        })
    }),
    of_character("material: another image", KEPT, |files| {
        with(files, |file| {
            let view = file.json["images"][0]["bufferView"].as_u64()? as usize;
            let start = file.json["bufferViews"][view]["byteOffset"].as_u64()? as usize;
            file.bin[start + 20] ^= 0xff;
            Some(())
        })
    }),
    of_character("file: a clip lost", KEPT, |files| {
        with(files, |file| file.list("animations").pop().map(drop))
    }),
    of_character("file: names of clips exchanged", KEPT, |files| {
        with(files, |file| {
            let names = [0, 1].map(|clip| file.json["animations"][clip]["name"].clone());
            let [first, second] = names;
            file.json["animations"][0]["name"] = second;
            file.json["animations"][1]["name"] = first;
            Some(())
        })
    }),
    onto("skin: joints exchanged", &["glb"], |files| with(files, exchange_joints)),
    onto("skin: an inverse bind matrix moved", &["glb"], |files| {
        with(files, move_bind)
    }),
    onto("mesh: vertices scaled", &["glb"], |files| with(files, scale_vertices)),
    onto("mesh: a morph target lost", &["glb"], |files| {
        with(files, |file| remove(file.primitive(), "targets"))
    }),
    onto("material: the material lost", &["glb"], |files| {
        with(files, |file| remove(file.primitive(), "material"))
    }),
    onto("material: the texture lost", &["glb"], |files| {
        with(files, |file| {
            remove(
                &mut file.json["materials"][0]["pbrMetallicRoughness"],
                "baseColorTexture",
            )
        })
    }),
];
