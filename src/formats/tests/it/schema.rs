//! The JSON of scenes, compared with its schema.

use mocap::Importer;
use mocap::dump::SceneView;
use mocap::process::SkeletonMesh;
use serde_json::{Map, Value, json};

/// A JSON Schema with the keywords that our schema uses. Any other keyword is an error. Libraries for the full standard
/// take longer to compile than everything else here.
struct Schema(Value);

impl Schema {
    fn of_scenes() -> Self {
        Self(serde_json::from_str(SceneView::SCHEMA).unwrap())
    }

    fn check(&self, value: &Value) -> Result<(), String> {
        self.check_against(&self.0, value, "")
    }

    fn check_against(&self, schema: &Value, value: &Value, place: &str) -> Result<(), String> {
        let Some(keywords) = schema.as_object() else {
            return if schema == &json!(false) {
                Err(format!("{place} must not be there"))
            } else {
                Ok(())
            };
        };
        for (keyword, argument) in keywords {
            if !self.holds(keyword, argument, keywords, value, place)? {
                return Err(format!("{place}: {value} breaks {keyword} {argument}"));
            }
        }
        Ok(())
    }

    fn holds(
        &self,
        keyword: &str,
        argument: &Value,
        keywords: &Map<String, Value>,
        value: &Value,
        place: &str,
    ) -> Result<bool, String> {
        let items: &[Value] = value.as_array().map_or(&[], Vec::as_slice);
        let number = value.as_f64();
        let at_least = |size: usize| argument.as_u64().is_some_and(|least| size as u64 >= least);
        let first_rest = keywords
            .get("prefixItems")
            .and_then(Value::as_array)
            .map_or(0, Vec::len);
        Ok(match keyword {
            "$schema" | "$defs" | "title" | "description" => true,
            "$ref" => {
                let path = argument.as_str().and_then(|path| path.strip_prefix('#')).unwrap();
                self.check_against(self.0.pointer(path).unwrap(), value, place)?;
                true
            }
            "anyOf" => {
                let mut choices = argument.as_array().unwrap().iter();
                choices.any(|choice| self.check_against(choice, value, place).is_ok())
            }
            "type" => match argument.as_array() {
                Some(types) => types.iter().any(|name| is_of_type(name, value)),
                None => is_of_type(argument, value),
            },
            "enum" => argument.as_array().unwrap().contains(value),
            "minimum" => number.is_none_or(|number| number >= argument.as_f64().unwrap()),
            "maximum" => number.is_none_or(|number| number <= argument.as_f64().unwrap()),
            "exclusiveMinimum" => number.is_none_or(|number| number > argument.as_f64().unwrap()),
            "minItems" => !value.is_array() || at_least(items.len()),
            "maxItems" => argument.as_u64().is_some_and(|most| items.len() as u64 <= most),
            "uniqueItems" => (1..items.len()).all(|index| !items[..index].contains(&items[index])),
            "prefixItems" => {
                for (schema, item) in argument.as_array().unwrap().iter().zip(items) {
                    self.check_against(schema, item, &format!("{place}/prefix"))?;
                }
                true
            }
            "items" => {
                for (index, item) in items.iter().enumerate().skip(first_rest) {
                    self.check_against(argument, item, &format!("{place}/{index}"))?;
                }
                true
            }
            "properties" => {
                for (name, schema) in argument.as_object().unwrap() {
                    if let Some(property) = value.get(name) {
                        self.check_against(schema, property, &format!("{place}/{name}"))?;
                    }
                }
                true
            }
            "required" => {
                let mut names = argument.as_array().unwrap().iter().filter_map(Value::as_str);
                !value.is_object() || names.all(|name| value.get(name).is_some())
            }
            "additionalProperties" => {
                assert_eq!(argument, &json!(false), "{place}");
                let known = keywords["properties"].as_object().unwrap();
                value
                    .as_object()
                    .is_none_or(|object| object.keys().all(|name| known.contains_key(name)))
            }
            _ => return Err(format!("{place}: the keyword {keyword} is not known here")),
        })
    }
}

fn is_of_type(name: &Value, value: &Value) -> bool {
    match name.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("boolean") => value.is_boolean(),
        Some("null") => value.is_null(),
        Some("number") => value.is_number(),
        Some("integer") => value.is_u64() || value.is_i64(),
        _ => false,
    }
}

fn dumped(file: &str, kind: SkeletonMesh) -> Value {
    let scene = Importer::new()
        .skeleton_mesh(kind)
        .import(format!("../../fixtures/{file}"))
        .unwrap();
    serde_json::to_value(SceneView::new(&scene)).unwrap()
}

#[test]
fn scenes_follow_the_schema() {
    let schema = Schema::of_scenes();
    for file in [
        "real/lecture_Test.bvh",
        "real/additive_root_pose.bvh",
        "real/latin1_name_no_motion.bvh",
        "dialects/two_roots.bvh",
        "dialects/nan_in_motion.bvh",
    ] {
        for kind in [SkeletonMesh::Segmented, SkeletonMesh::Skinned, SkeletonMesh::None] {
            assert_eq!(schema.check(&dumped(file, kind)), Ok(()), "{file}");
        }
    }
}

#[test]
fn the_schema_refuses_what_is_not_a_scene() {
    let schema = Schema::of_scenes();
    let scene = dumped("real/lecture_Test.bvh", SkeletonMesh::Skinned);
    assert_eq!(schema.check(&scene), Ok(()));
    for (pointer, wrong) in [
        ("/nodes/0/matrix", json!([1, 0, 0, 0])),
        ("/nodes/0/parent", json!("Shoulder")),
        ("/nodes/1/kind", json!("bone")),
        ("/meshes/0/bones/0/weights/0", json!([0])),
        ("/meshes/0/vertices/0/2", json!(null)),
        ("/animations/0/channels/0/rotation_keys_xyzw/0", json!([0, [0, 0, 0]])),
        ("/animations/0/ticks_per_second", json!(0)),
        ("/metadata/root_offset", json!("add")),
    ] {
        let mut broken = scene.clone();
        *broken.pointer_mut(pointer).unwrap() = wrong;
        assert!(schema.check(&broken).is_err(), "{pointer}");
    }
}

#[test]
fn the_json_says_what_the_lecture_says() {
    let scene = dumped("real/lecture_Test.bvh", SkeletonMesh::Segmented);
    assert_eq!(scene["nodes"][1]["name"], "Elbow");
    assert_eq!(scene["nodes"][1]["matrix"][3], 2.0);
    assert_eq!(scene["nodes"][3]["kind"], "end_site");
    assert_eq!(scene["meshes"][3]["faces"][7], json!([21, 22, 23]));
    let channels = &scene["animations"][0]["channels"];
    assert_eq!(channels[1]["position_keys"], json!([[0.0, [2.0, 0.0, 0.0]]]));
    let wrist = channels[2]["rotation_keys_xyzw"][9].clone();
    assert_eq!(wrist[0], 9.0);
    let (sin, cos) = 40f64.to_radians().sin_cos();
    assert!((wrist[1][2].as_f64().unwrap() - sin).abs() < 1e-6);
    assert!((wrist[1][3].as_f64().unwrap() - cos).abs() < 1e-6);
}
