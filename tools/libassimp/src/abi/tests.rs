//! Compares the layouts with Debian's headers.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use super::*;

/// The C++ compiler compares every size and every offset with Debian's headers.
#[test]
fn layouts_are_those_of_the_headers() {
    let mut source = String::from(
        "#include <cstddef>\n#include <assimp/cimport.h>\n#include <assimp/cexport.h>\n#include <assimp/scene.h>\n\
         #include <assimp/cfileio.h>\n#include <assimp/importerdesc.h>\n#include <assimp/BaseImporter.h>\n",
    );
    for (name, size, fields) in LAYOUT {
        writeln!(source, "static_assert(sizeof({name}) == {size}, \"{name}\");").unwrap();
        for (field, offset) in *fields {
            writeln!(
                source,
                "static_assert(offsetof({name}, {field}) == {offset}, \"{name}::{field}\");"
            )
            .unwrap();
        }
    }
    for (name, size) in [
        ("aiMatrix4x4", size_of::<aiMatrix4x4>()),
        ("aiMatrix3x3", size_of::<aiMatrix3x3>()),
        ("aiVector3D", size_of::<aiVector3D>()),
        ("aiQuaternion", size_of::<aiQuaternion>()),
        ("aiColor4D", size_of::<aiColor4D>()),
        ("aiAABB", size_of::<[aiVector3D; 2]>()),
        ("aiReturn", size_of::<aiReturn>()),
        ("Assimp::BaseImporter", crate::system_importer::BASE),
    ] {
        writeln!(source, "static_assert(sizeof({name}) == {size}, \"{name}\");").unwrap();
    }

    let mut compiler = Command::new("c++")
        .args(["-std=c++17", "-Wno-invalid-offsetof", "-fsyntax-only", "-x", "c++", "-"])
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    compiler.stdin.take().unwrap().write_all(source.as_bytes()).unwrap();
    assert!(compiler.wait().unwrap().success(), "{source}");
}

#[test]
fn a_long_text_is_cut_where_assimp_cuts_it() {
    let text = aiString::new(&"a".repeat(2000));
    assert_eq!((text.length, text.data[1022], text.data[1023]), (1023, b'a', 0));
    assert_eq!(text.to_text().len(), 1023);
}
