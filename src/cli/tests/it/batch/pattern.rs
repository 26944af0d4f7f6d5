//! Tests which paths a wildcard matches.

use std::path::Path;

use mocap_cli::internals::{Failure, Fit, Pattern};

fn fit(pattern: &str, path: &str) -> Fit {
    let (base, pattern) = Pattern::of(Path::new(pattern)).map_err(Failure::into_words).unwrap();
    assert_eq!(base, Path::new(""));
    pattern.fit(path.split('/').filter(|name| !name.is_empty()))
}

/// The expected values come from Bash with `globstar` and `dotglob`. Unlike in Bash, a matching folder includes
/// everything below it.
#[test]
fn paths_fit_as_in_a_shell() {
    for (pattern, whole, above, no) in [
        ("*.bvh", "a.bvh .bvh ä.bvh a.bvh/b", "", "a.bvh2 a/b.bvh a.BVH"),
        ("a?c", "abc aäc abc/d", "", "ac abbc"),
        ("*a*b*", "ab xaxbx aab", "", "ba b a"),
        ("[a-cx]1", "a1 b1 x1", "", "d1 -1 a"),
        ("[!a-c]1", "d1 é1", "", "a1 11x"),
        ("[]]x[-]", "]x-", "", "x ]xx"),
        ("[[]1[]]", "[1]", "", "1"),
        ("*/walk/*.bvh", "a/walk/b.bvh", "a a/walk", "a/run walk.bvh/x/y"),
        ("**/*.bvh", "a.bvh a/b.bvh a/b/c.bvh", "a a/b", ""),
        ("[a]/**/b", "a/b a/x/b a/b/c", "a a/x/y", "b x/b"),
        ("**", "a a/b", "", ""),
    ] {
        for (paths, expected) in [(whole, Fit::Whole), (above, Fit::Above), (no, Fit::No)] {
            for path in paths.split_whitespace() {
                assert_eq!(fit(pattern, path), expected, "{pattern} {path}");
            }
        }
    }
    assert_eq!(Pattern::default().fit(["a", "b"]), Fit::Whole);
}

#[test]
fn the_folder_before_a_wildcard_is_no_part_of_the_pattern() {
    for (path, folder, below) in [("/a/b*/c", "/a", "b1/c"), ("../*", "..", "x"), ("a/./[b]", "a", "b")] {
        let (base, pattern) = Pattern::of(Path::new(path)).map_err(Failure::into_words).unwrap();
        assert_eq!(
            (base.as_path(), pattern.fit(below.split('/'))),
            (Path::new(folder), Fit::Whole)
        );
    }
    for path in ["a*/../b", "[a", "[!]", "a**", "**.bvh"] {
        assert!(Pattern::of(Path::new(path)).is_err(), "{path}");
    }
}

#[test]
fn many_wildcards_take_no_longer_than_the_name_allows() {
    let name = "a".repeat(250);
    assert_eq!(fit(&"*a".repeat(100_000), &name), Fit::No);
    assert_eq!(fit(&(["*a".repeat(200), "*b".to_owned()].concat()), &name), Fit::No);
    assert_eq!(fit(&"**/".repeat(20_000), &"a/".repeat(100)), Fit::Whole);
}
