//! `mocap pack --to hf`: the files of a dataset. The new folder is complete or absent.
//! `tools/python/tests/test_dataset.py` reads a dataset with the library `datasets`.

use std::fs;

use mocap::arrays::table::arrow_array::{Array, cast::AsArray};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use crate::program::Folder;

fn takes() -> Folder {
    let folder = Folder::of_real(&["cmu_short.bvh"]);
    let motion = folder.read("cmu_short.bvh");
    for name in ["a.bvh", "walks/b.bvh", "walks/c.bvh"] {
        folder.write(&format!("takes/{name}"), &motion);
    }
    folder.write("takes/walks/LICENSE", b"Use it for anything.");
    folder.write("takes/bad|name.bvh", &motion[..900]);
    folder
}

fn names(folder: &Folder, below: &str) -> Vec<String> {
    let entries = fs::read_dir(folder.path(below)).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_dataset_has_shards_a_card_and_licences() {
    let folder = takes();
    let output = folder.run("pack takes -o out --to hf --license cc-by-4.0");
    assert_eq!(output.status.code(), Some(3), "a file of four is broken");
    assert_eq!(names(&folder, "out"), ["README.md", "data", "licenses"]);
    assert_eq!(names(&folder, "out/data"), ["train-00000-of-00001.parquet"]);
    assert_eq!(folder.read("out/licenses/walks/LICENSE"), b"Use it for anything.");

    let file = fs::File::open(folder.path("out/data/train-00000-of-00001.parquet")).unwrap();
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().build().unwrap();
    let batches: Vec<_> = reader.map(Result::unwrap).collect();
    let [batch] = &batches[..] else {
        panic!("one batch");
    };
    let clips = batch.column_by_name("clip").unwrap().as_string::<i32>();
    let clips: Vec<_> = (0..clips.len()).map(|row| clips.value(row)).collect();
    assert_eq!(clips, ["a.bvh", "walks/b.bvh", "walks/c.bvh"]);
    assert!(batch.column_by_name("error").is_none());

    let card = String::from_utf8(folder.read("out/README.md")).unwrap();
    let header = card.strip_prefix("---\n").unwrap().split("\n---\n").next().unwrap();
    for line in [
        "license: cc-by-4.0",
        "- n<1K",
        "    path: data/train-*",
        "    num_examples: 3",
        "  - name: positions\n    sequence:\n      sequence: float32\n      length: 3",
        "  - name: frame_rate\n    dtype: float64",
    ] {
        assert!(header.contains(line), "{line}: {header}");
    }
    assert!(card.contains("Lengths are in m."), "{card}");
    assert!(
        card.contains("| walks | 2 |") && card.contains(r"| bad\|name.bvh |"),
        "{card}"
    );
}

#[test]
fn a_table_of_rows_for_each_joint_is_a_dataset_too() {
    let folder = takes();
    folder.succeeds("pack takes/walks -o out --to hf --table long --out-unit cm --out-up z --rot euler");
    let card = String::from_utf8(folder.read("out/README.md")).unwrap();
    assert!(card.contains("| `x` | float32 | cm | position |"), "{card}");
    assert!(card.contains("| `ex` | float32 | degree | rotation |"), "{card}");
    assert!(card.contains("right-handed, with +Z up"), "{card}");
    assert!(card.contains("license: unknown"), "{card}");
    // The card shows the statements of mocap.toml.
    folder.write(
        "takes/walks/mocap.toml",
        b"licence = \"CC-BY-4.0\"\n[files.\"b*\"]\nperson = \"Anna\"\n",
    );
    folder.succeeds("pack takes/walks -o stated --to hf");
    let card = String::from_utf8(folder.read("stated/README.md")).unwrap();
    assert!(card.contains("license: cc-by-4.0\n"), "{card}");
    assert!(card.contains("| CC-BY-4.0 |  | Anna, not stated: 1 clip |"), "{card}");
}

#[test]
fn what_is_there_stays_as_it_is() {
    let folder = takes();
    folder.write("mine/notes.txt", b"mine");
    folder.refuses(
        "pack takes -o mine --to hf",
        1,
        "notes.txt: error[output-exists]: the output would replace the folder of this file, and mocap has no record of the file",
    );
    folder.refuses(
        "pack takes -o cmu_short.bvh --to hf",
        1,
        "cmu_short.bvh: error[output-exists]",
    );
    folder.refuses(
        "pack takes/walks -o mine --to hf --force",
        2,
        "--force would do nothing",
    );
    folder.refuses(
        "pack takes/walks -o new --to hf --resume",
        2,
        "--resume would do nothing",
    );
    folder.refuses(
        "pack takes/walks -o new --to hf --inventory",
        2,
        "a dataset has motions",
    );
    folder.refuses(
        "pack takes/walks -o new --to hf --license CC_BY",
        2,
        "--license is not an identifier",
    );
    folder.refuses(
        "pack takes/walks -o new --license cc-by-4.0",
        2,
        "--license would do nothing",
    );
    assert_eq!(folder.read("mine/notes.txt"), b"mine");
    // If no file can be read, no dataset is written.
    assert_eq!(
        folder.run("pack takes/bad|name.bvh -o new --to hf").status.code(),
        Some(1)
    );
    assert_eq!(names(&folder, ""), ["cmu_short.bvh", "mine", "takes"]);
    // An empty folder is accepted.
    fs::create_dir(folder.path("empty")).unwrap();
    folder.succeeds("pack takes/walks -o empty --to hf");
}

#[test]
fn an_earlier_dataset_is_replaced_where_nobody_changed_it() {
    let folder = takes();
    folder.succeeds("pack takes/walks -o out --to hf --part-size 1");
    let output = folder.run("pack takes/a.bvh -o out --to hf --license cc0-1.0");
    assert!(output.status.success(), "{output:?}");
    let told = String::from_utf8(output.stderr).unwrap();
    assert!(told.contains("out: replaced an earlier output of mocap"), "{told}");
    assert_eq!(
        names(&folder, "out"),
        ["README.md", "data"],
        "the licences were of other clips"
    );
    let card = String::from_utf8(folder.read("out/README.md")).unwrap();
    assert!(
        card.contains("license: cc0-1.0") && card.contains("num_examples: 1"),
        "{card}"
    );

    folder.refuses(
        "pack out/data/train-00000-of-00001.parquet takes -o out --to hf",
        1,
        "output-is-input",
    );
    // The folder would replace each of these files.
    let refuses = |lost: &str| {
        let output = folder.run("pack takes/walks -o out --to hf");
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{told}");
        assert!(told.contains(&format!("{lost}: error[output-exists]")), "{told}");
    };
    folder.write("out/README.md", format!("{card}\nRecorded in spring.\n").as_bytes());
    refuses("out/README.md");
    folder.write("out/README.md", card.as_bytes());
    folder.write("out/data/.gitattributes", b"*.parquet filter=lfs");
    refuses("out/data/.gitattributes");
    fs::remove_file(folder.path("out/data/.gitattributes")).unwrap();
    folder.succeeds("convert takes/a.bvh out/data/walk.bvh --fps 30");
    refuses("out/data/walk.bvh");
    fs::remove_file(folder.path("out/data/walk.bvh")).unwrap();
    folder.succeeds("pack takes/walks -o out --to hf");
    assert_eq!(names(&folder, ""), ["cmu_short.bvh", "out", "takes"]);
}
