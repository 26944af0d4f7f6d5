//! Files that are written completely or not at all.

mod confined;
mod csv_table;
mod part;
mod record;
mod set;

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use mocap_scene::files::{write_file, write_file_with};

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<_> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn a_write_that_fails_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    let fail = |file: &mut dyn Write| {
        file.write_all(b"a part")?;
        Err(io::ErrorKind::StorageFull.into())
    };
    assert!(write_file_with(&path, fail).is_err());
    assert!(names(folder.path()).is_empty());
    fs::write(&path, "older").unwrap();
    assert!(write_file_with(&path, fail).is_err());
    assert_eq!(names(folder.path()), ["a.glb"]);
    assert_eq!(fs::read(&path).unwrap(), b"older");
}

/// A process that is killed while it writes leaves no file.
#[cfg(target_os = "linux")]
#[test]
fn a_file_has_no_name_while_it_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.glb");
    for content in ["older", "new"] {
        let before = names(folder.path());
        write_file_with(&path, |file| {
            file.write_all(content.as_bytes())?;
            assert_eq!(names(folder.path()), before);
            Ok(())
        })
        .unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), content);
        assert_eq!(names(folder.path()), ["a.glb"]);
    }
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_permissions_kept() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("far")).unwrap();
    let [link, far] = ["a.glb", "far/b.glb"].map(|name| folder.path().join(name));
    symlink("far/b.glb", &link).unwrap();
    for bytes in [b"one", b"two"] {
        write_file(&link, bytes).unwrap();
        assert_eq!(fs::read(&far).unwrap(), bytes);
        assert!(link.is_symlink());
        fs::set_permissions(&far, PermissionsExt::from_mode(0o640)).unwrap();
    }
    assert_eq!(fs::metadata(&far).unwrap().mode() & 0o777, 0o640);
    fs::set_permissions(&far, PermissionsExt::from_mode(0o444)).unwrap();
    let error = write_file(&link, b"three").unwrap_err();
    assert!(error.to_string().contains("read-only"), "{error}");
    assert_eq!(fs::read(&far).unwrap(), b"two");
    symlink("loop", folder.path().join("loop")).unwrap();
    assert!(write_file(&folder.path().join("loop"), b"").is_err());
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_to_and_not_replaced() {
    use std::os::unix::fs::FileTypeExt;
    write_file("/dev/null".as_ref(), b"anything").unwrap();
    let error = write_file("/dev/full".as_ref(), b"anything").unwrap_err();
    assert_eq!(error.code().as_str(), "io");
    for device in ["/dev/null", "/dev/full"] {
        assert!(fs::metadata(device).unwrap().file_type().is_char_device());
    }
}
