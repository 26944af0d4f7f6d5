//! Corruptions of arrays and tables: of the arrays of `.npz`, and of the rows of `.csv`.

use std::io::{Cursor, Read, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use super::{Files, Plant, of_walk};

const NPZ: &[&str] = &["npz"];
const CSV: &[&str] = &["csv"];

/// Changes the entries of an archive. Each entry is named without the extension.
fn npz(files: &mut Files, change: impl Fn(&str, &mut Vec<u8>) -> Option<()>) -> bool {
    let bytes = files.main();
    let mut archive = ZipArchive::new(Cursor::new(bytes.clone())).unwrap();
    let mut made = ZipWriter::new(Cursor::new(Vec::new()));
    let mut is_there = false;
    for index in 0..archive.len() {
        let mut entry = archive.by_index(index).unwrap();
        let name = entry.name().unwrap().into_owned();
        let mut contents = Vec::new();
        entry.read_to_end(&mut contents).unwrap();
        is_there |= change(name.trim_end_matches(".npy"), &mut contents).is_some();
        let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        made.start_file(name, stored).unwrap();
        made.write_all(&contents).unwrap();
    }
    *bytes = made.finish().unwrap().into_inner();
    is_there
}

/// The offset of an array's numbers.
fn begin(array: &[u8]) -> usize {
    10 + usize::from(u16::from_le_bytes([array[8], array[9]]))
}

/// Changes the numbers of an array of 32-bit floats.
fn floats(files: &mut Files, name: &str, change: impl Fn(usize, f32) -> f32) -> bool {
    npz(files, |found, array| {
        if found != name {
            return None;
        }
        let start = begin(array);
        for (index, number) in array[start..].chunks_exact_mut(4).enumerate() {
            let value = f32::from_le_bytes((&*number).try_into().unwrap());
            number.copy_from_slice(&change(index, value).to_le_bytes());
        }
        Some(())
    })
}

/// Replaces a part of the header with another text of the same length. Each character of the header has four bytes.
fn header(files: &mut Files, from: &str, to: &str) -> bool {
    assert_eq!(from.len(), to.len());
    let wide = |text: &str| -> Vec<u8> { text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect() };
    npz(files, |found, array| {
        if found != "header" {
            return None;
        }
        let place = array.windows(4 * from.len()).position(|window| window == wide(from))?;
        array[place..place + 4 * from.len()].copy_from_slice(&wide(to));
        Some(())
    })
}

/// Changes the lines of a table; the first line is the header.
fn csv(files: &mut Files, change: impl FnOnce(&mut Vec<String>) -> Option<()>) -> bool {
    let bytes = files.main();
    let mut lines: Vec<String> = String::from_utf8(bytes.clone())
        .unwrap()
        .lines()
        .map(str::to_owned)
        .collect();
    let is_there = change(&mut lines).is_some();
    *bytes = (lines.join("\n") + "\n").into_bytes();
    is_there
}

fn cell(line: &mut String, index: usize, change: impl Fn(f64) -> f64) -> Option<()> {
    let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
    let cell = cells.get_mut(index)?;
    *cell = change(cell.parse().ok()?).to_string();
    *line = cells.join(",");
    Some(())
}

/// The last row of the first frame, which belongs to an end site.
fn end_site_row(lines: &[String]) -> Option<usize> {
    lines.iter().rposition(|line| line.starts_with("0,"))
}

pub(super) const PLANTS: &[Plant] = &[
    of_walk("units: another unit stated", NPZ, |files| {
        header(files, r#""metres_per_unit":1.0"#, r#""metres_per_unit":2.0"#)
    }),
    of_walk("units: another up axis stated", NPZ, |files| {
        header(files, r#""up":"y""#, r#""up":"z""#)
    }),
    of_walk("units: another rate stated", NPZ, |files| {
        npz(files, |found, array| {
            let at = begin(array);
            let is_rate = found == "frame_rate";
            is_rate.then(|| array[at..at + 8].copy_from_slice(&60_f64.to_le_bytes()))
        })
    }),
    of_walk("file: a joint renamed", NPZ, |files| {
        header(files, r#""name":"Head""#, r#""name":"Heap""#)
    }),
    of_walk("file: another parent in the header", NPZ, |files| {
        header(files, r#""parent":3,"#, r#""parent":2,"#)
    }),
    of_walk("file: a joint below another", NPZ, |files| {
        npz(files, |found, array| {
            let at = begin(array) + 4 * 9;
            (found == "parents").then(|| array[at..at + 4].copy_from_slice(&2_i32.to_le_bytes()))
        })
    }),
    of_walk("file: an offset scaled", NPZ, |files| {
        floats(
            files,
            "offsets",
            |index, value| if index / 3 == 5 { value * 1.1 } else { value },
        )
    }),
    of_walk("file: one frame wrong", NPZ, |files| {
        floats(
            files,
            "positions",
            |index, value| if index == 3000 { value + 0.05 } else { value },
        )
    }),
    of_walk("file: one rotation wrong", NPZ, |files| {
        floats(
            files,
            "rotations",
            |index, value| if index == 1204 { value + 0.3 } else { value },
        )
    }),
    of_walk("file: an end site moved", NPZ, |files| {
        // The last of 38 joints and end sites, in the third frame.
        floats(files, "positions", |index, value| {
            if index == 3 * (3 * 38 - 1) { value + 0.05 } else { value }
        })
    }),
    of_walk("file: a column swapped", NPZ, |files| {
        npz(files, |found, array| {
            let start = begin(array);
            let swap = |row: &mut [u8]| (0..4).for_each(|byte| row.swap(byte, 8 + byte));
            (found == "positions").then(|| array[start..].chunks_exact_mut(12).for_each(swap))
        })
    }),
    of_walk("file: velocities halved", NPZ, |files| {
        floats(files, "velocities", |_, value| value * 0.5)
    }),
    of_walk("file: another source named", NPZ, |files| {
        header(files, r#""sha256":""#, r#""sha265":""#)
    }),
    of_walk("units: another unit stated", CSV, |files| {
        csv(files, |lines| {
            lines[0] = lines[0].replacen(r#""metres_per_unit":1.0"#, r#""metres_per_unit":0.01"#, 1);
            Some(())
        })
    }),
    of_walk("units: another up axis stated", CSV, |files| {
        csv(files, |lines| {
            lines[0] = lines[0].replacen(r#""up":"y""#, r#""up":"z""#, 1);
            Some(())
        })
    }),
    of_walk("file: a joint renamed", CSV, |files| {
        csv(files, |lines| {
            lines.iter_mut().for_each(|line| *line = line.replace("Head", "Heap"));
            Some(())
        })
    }),
    of_walk("file: times shifted", CSV, |files| {
        csv(files, |lines| {
            lines
                .iter_mut()
                .skip(2)
                .try_for_each(|line| cell(line, 1, |time| time + 0.1))
        })
    }),
    of_walk("file: one frame wrong", CSV, |files| {
        csv(files, |lines| cell(&mut lines[800], 3, |value| value + 0.05))
    }),
    of_walk("file: one rotation wrong", CSV, |files| {
        csv(files, |lines| cell(&mut lines[800], 8, |value| value + 0.3))
    }),
    of_walk("file: an end site moved", CSV, |files| {
        csv(files, |lines| {
            let row = end_site_row(lines)?;
            cell(&mut lines[row], 4, |value| value + 0.05)
        })
    }),
    of_walk("file: a column swapped", CSV, |files| {
        csv(files, |lines| {
            for line in lines.iter_mut().skip(2) {
                let mut cells: Vec<&str> = line.split(',').collect();
                cells.swap(3, 5);
                *line = cells.join(",");
            }
            Some(())
        })
    }),
    of_walk("file: columns swapped with their names", CSV, |files| {
        csv(files, |lines| {
            for line in lines.iter_mut().skip(1) {
                let mut cells: Vec<&str> = line.split(',').collect();
                cells.swap(3, 5);
                *line = cells.join(",");
            }
            Some(())
        })
    }),
    of_walk("file: a row dropped", CSV, |files| {
        csv(files, |lines| {
            lines.remove(500);
            Some(())
        })
    }),
    of_walk("file: velocities halved", CSV, |files| {
        csv(files, |lines| {
            let column = lines[1].split(',').position(|name| name == "vy")?;
            lines
                .iter_mut()
                .skip(2)
                .try_for_each(|line| cell(line, column, |value| value * 0.5))
        })
    }),
];
