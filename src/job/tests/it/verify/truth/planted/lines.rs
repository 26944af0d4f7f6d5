//! Corruptions of text formats: of their lines.

use super::{Files, Plant, of_character, of_walk, onto};

const BVH: &[&str] = &["bvh"];
const TRC: &[&str] = &["trc"];
/// An archive stores its stage uncompressed, and each change keeps the length.
const USD: &[&str] = &["usda", "usdz"];

/// Changes the lines of a file.
fn with(files: &mut Files, change: impl FnOnce(&mut Vec<String>) -> Option<()>) -> bool {
    let bytes = files.main();
    let text = String::from_utf8(bytes.clone()).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let is_there = change(&mut lines).is_some();
    *bytes = (lines.join("\n") + "\n").into_bytes();
    is_there
}

/// The `at`th line with this beginning, apart from leading blanks.
fn line<'a>(lines: &'a mut [String], start: &str, at: usize) -> Option<&'a mut String> {
    lines
        .iter_mut()
        .filter(|line| line.trim_start().starts_with(start))
        .nth(at)
}

/// Changes a word of a line.
fn word(line: &mut String, index: usize, separator: char, change: impl Fn(f64) -> f64) -> Option<()> {
    let mut words: Vec<String> = line.split(separator).map(str::to_owned).collect();
    let word = words.get_mut(index)?;
    *word = change(word.parse().ok()?).to_string();
    *line = words.join(&separator.to_string());
    Some(())
}

/// Changes the stage of USD as text. A change in an archive keeps the length and updates the checksum, so that the
/// archive stays valid.
fn usd(files: &mut Files, change: impl FnOnce(&mut String) -> Option<()>) -> bool {
    let is_archive = files.extension() == "usdz";
    let bytes = files.main();
    let start = b"#usda 1.0";
    let begin = bytes.windows(start.len()).position(|window| window == start).unwrap();
    let length = match is_archive {
        true => u32::from_le_bytes(bytes[22..26].try_into().unwrap()) as usize,
        false => bytes.len() - begin,
    };
    let mut text = String::from_utf8(bytes[begin..begin + length].to_vec()).unwrap();
    let is_there = change(&mut text).is_some();
    if !is_archive {
        *bytes = text.into_bytes();
        return is_there;
    }
    while text.len() < length {
        text.push('\n');
    }
    if text.len() > length {
        // A longer text fits only if it replaces line breaks at the end.
        return false;
    }
    bytes[begin..begin + length].copy_from_slice(text.as_bytes());
    let sum = zlib_rs::crc32::crc32(0, text.as_bytes()).to_le_bytes();
    let listed = bytes.windows(4).position(|window| window == b"PK\x01\x02").unwrap();
    bytes[14..18].copy_from_slice(&sum);
    bytes[listed + 16..listed + 20].copy_from_slice(&sum);
    is_there
}

/// The range between the brackets after `name`.
fn list(text: &str, name: &str) -> Option<std::ops::Range<usize>> {
    let start = text.find(name)? + name.len();
    let open = start + text[start..].find(['[', '('])? + 1;
    let close = open + text[open..].find([']', '\n'])?;
    Some(open..close)
}

/// Replaces the first `from` after `name` with `to` of the same length.
fn exchange(text: &mut String, name: &str, from: &str, to: &str) -> Option<()> {
    let place = text.find(name)?;
    let at = place + text[place..].find(from)?;
    text.replace_range(at..at + from.len(), to);
    Some(())
}

/// Changes the numbers of a list. Each number is written with as many characters as before, or with three.
fn in_list(text: &mut String, name: &str, change: impl Fn(usize, f64) -> f64) -> Option<()> {
    let range = list(text, name)?;
    let (mut made, mut index) = (String::new(), 0);
    let part = &text[range.clone()];
    let is_part = |c: char| c.is_ascii_digit() || "+-.e".contains(c);
    let mut rest = part;
    while let Some(start) = rest.find(is_part) {
        made += &rest[..start];
        rest = &rest[start..];
        let end = rest.find(|c: char| !is_part(c)).unwrap_or(rest.len());
        let (number, after) = rest.split_at(end);
        let value: f64 = number.parse().ok()?;
        let changed = change(index, value);
        let shown = match changed == value {
            true => number.to_owned(),
            false => changed.to_string().chars().take(number.len().max(3)).collect(),
        };
        made += &shown;
        rest = after;
        index += 1;
    }
    made += rest;
    text.replace_range(range, &made);
    Some(())
}

fn scale_points(text: &mut String) -> Option<()> {
    in_list(text, "point3f[] points", |_, value| value * 2.0)
}

fn exchange_joints(text: &mut String) -> Option<()> {
    in_list(text, "primvars:skel:jointIndices", |_, value| match value as i64 {
        0 => 1.0,
        1 => 0.0,
        _ => value,
    })
}

fn move_bind(text: &mut String) -> Option<()> {
    in_list(text, "bindTransforms", |index, value| {
        if index == 16 + 13 { value + 1.0 } else { value }
    })
}

fn lose_material(text: &mut String) -> Option<()> {
    exchange(text, "", "rel material:binding", "rel material_binding")
}

fn lose_texture(text: &mut String) -> Option<()> {
    exchange(text, "", "inputs:diffuseColor.connect", "inputs:diffuseCOLOR.connect")
}

pub(super) const PLANTS: &[Plant] = &[
    of_walk("file: a joint renamed", BVH, |files| {
        with(files, |lines| {
            line(lines, "JOINT", 5)?.push_str("_another");
            Some(())
        })
    }),
    of_walk("file: an offset scaled", BVH, |files| {
        with(files, |lines| {
            let line = line(lines, "OFFSET", 3)?;
            let numbers: Vec<f64> = line
                .split_whitespace()
                .skip(1)
                .map(|word| word.parse().unwrap())
                .collect();
            *line = format!("OFFSET {} {} {}", numbers[0] * 1.1, numbers[1] * 1.1, numbers[2] * 1.1);
            numbers.iter().any(|number| number.abs() > 1.0).then_some(())
        })
    }),
    of_walk("file: one frame wrong", BVH, |files| {
        with(files, |lines| {
            let last = lines.len() - 4;
            word(&mut lines[last], 10, ' ', |value| value + 30.0)
        })
    }),
    of_walk("file: a row dropped", BVH, |files| {
        with(files, |lines| {
            lines.pop();
            let frames = line(lines, "Frames:", 0)?;
            let count: usize = frames.split_whitespace().nth(1)?.parse().ok()?;
            *frames = format!("Frames: {}", count - 1);
            Some(())
        })
    }),
    of_walk("file: a column swapped", BVH, |files| {
        with(files, |lines| {
            let channels = line(lines, "CHANNELS 6", 0)?;
            *channels = channels
                .replacen("Xposition", "Q", 1)
                .replacen("Zposition", "Xposition", 1)
                .replacen('Q', "Zposition", 1);
            Some(())
        })
    }),
    of_walk("units: another rate stated", BVH, |files| {
        with(files, |lines| {
            *line(lines, "Frame Time:", 0)? = "Frame Time: 0.0166667".to_owned();
            Some(())
        })
    }),
    of_walk("units: another unit stated", TRC, |files| {
        with(files, |lines| {
            lines[2] = lines[2].replace("\tmm\t", "\tcm\t");
            Some(())
        })
    }),
    of_walk("units: another rate stated", TRC, |files| {
        with(files, |lines| word(&mut lines[2], 0, '\t', |rate| rate / 2.0))
    }),
    of_walk("units: another number of frames stated", TRC, |files| {
        with(files, |lines| word(&mut lines[2], 2, '\t', |frames| frames - 1.0))
    }),
    of_walk("file: a joint renamed", TRC, |files| {
        with(files, |lines| {
            lines[3] = lines[3].replacen("\tHead\t", "\tHat\t", 1);
            Some(())
        })
    }),
    of_walk("file: one frame wrong", TRC, |files| {
        with(files, |lines| word(&mut lines[9], 8, '\t', |value| value + 20.0))
    }),
    of_walk("file: times shifted", TRC, |files| {
        with(files, |lines| {
            let rows = lines
                .iter_mut()
                .skip(5)
                .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()));
            rows.into_iter()
                .try_for_each(|row| word(row, 1, '\t', |time| time + 0.1))
        })
    }),
    of_walk("file: a row dropped", TRC, |files| {
        with(files, |lines| {
            lines.remove(10);
            Some(())
        })
    }),
    of_walk("file: a column swapped", TRC, |files| {
        with(files, |lines| {
            for row in lines
                .iter_mut()
                .skip(5)
                .filter(|line| line.starts_with(|c: char| c.is_ascii_digit()))
            {
                let mut cells: Vec<&str> = row.split('\t').collect();
                cells.swap(2, 4);
                *row = cells.join("\t");
            }
            Some(())
        })
    }),
    of_walk("units: another unit stated", USD, |files| {
        usd(files, |text| {
            exchange(text, "", "metersPerUnit = 1\n", "metersPerUnit = 2\n")
        })
    }),
    of_walk("units: another unit stated, 100 times smaller", &["usda"], |files| {
        usd(files, |text| {
            exchange(text, "", "metersPerUnit = 1\n", "metersPerUnit = 0.01\n")
        })
    }),
    of_walk("units: no unit stated", USD, |files| {
        usd(files, |text| exchange(text, "", "metersPerUnit = 1\n", "\n"))
    }),
    of_walk("units: another up axis stated", USD, |files| {
        usd(files, |text| exchange(text, "", "upAxis = \"Y\"", "upAxis = \"Z\""))
    }),
    of_walk("units: another rate stated", USD, |files| {
        usd(files, |text| {
            let at = text.find("timeCodesPerSecond = ")?;
            let end = at + text[at..].find('\n')?;
            text.replace_range(at..end, "timeCodesPerSecond = 60");
            Some(())
        })
    }),
    of_walk("units: an end before the last frame stated", USD, |files| {
        usd(files, |text| {
            let at = text.find("endTimeCode = ")?;
            let end = at + text[at..].find('\n')?;
            text.replace_range(at..end, "endTimeCode = 5");
            Some(())
        })
    }),
    of_walk("file: a joint renamed", USD, |files| {
        usd(files, |text| exchange(text, "jointNames", "\"Head\"", "\"Heap\""))
    }),
    of_walk("file: one frame wrong", USD, |files| {
        usd(files, |text| {
            let rotations = text.find("rotations.timeSamples")?;
            let tenth = rotations + text[rotations..].find(" 10: [(")? + " 10: [(".len();
            // The W of the first joint.
            let end = tenth + text[tenth..].find(',')?;
            let other: String = "0.12345678901234567".chars().take(end - tenth).collect();
            text.replace_range(tenth..end, &other);
            (end - tenth > 3).then_some(())
        })
    }),
    of_walk("file: an offset scaled", USD, |files| {
        // Changes the value in one frame only.
        usd(files, |text| {
            in_list(text, "translations.timeSamples", |index, value| {
                if index > 5 { value * 0.5 } else { value }
            })
        })
    }),
    of_character("skin: joints exchanged", USD, |files| usd(files, exchange_joints)),
    of_character("skin: an inverse bind matrix moved", USD, |files| usd(files, move_bind)),
    of_character("skin: weights of other joints", USD, |files| {
        usd(files, |text| {
            in_list(
                text,
                "primvars:skel:jointWeights",
                |index, value| if index == 8 { 0.9 } else { value },
            )
        })
    }),
    of_character("mesh: vertices scaled", USD, |files| usd(files, scale_points)),
    of_character("mesh: a vertex moved", USD, |files| {
        usd(files, |text| {
            in_list(
                text,
                "point3f[] points",
                |index, value| {
                    if index == 3 { value + 0.2 } else { value }
                },
            )
        })
    }),
    of_character("mesh: texture coordinates exchanged", USD, |files| {
        usd(files, |text| in_list(text, "primvars:st", |_, value| 1.0 - value))
    }),
    of_character("mesh: the mesh elsewhere", USD, |files| {
        usd(files, |text| {
            in_list(
                text,
                "geomBindTransform",
                |index, value| if index == 13 { 5.0 } else { value },
            )
        })
    }),
    of_character("material: the material lost", USD, |files| usd(files, lose_material)),
    of_character("material: the texture lost", USD, |files| usd(files, lose_texture)),
    of_character("material: another image", &["usda"], |files| {
        let Some(image) = files.all.keys().find(|name| name.ends_with(".png")).cloned() else {
            return false;
        };
        files.all.get_mut(&image).unwrap()[24] ^= 0xff;
        true
    }),
    onto("skin: joints exchanged", USD, |files| usd(files, exchange_joints)),
    onto("mesh: vertices scaled", USD, |files| usd(files, scale_points)),
    onto("material: the texture lost", USD, |files| usd(files, lose_texture)),
];
