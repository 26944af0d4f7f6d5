//! Tests suggestions for misspelled words.

use mocap_scene::error::nearest;
use mocap_scene::internals::edit_distance;

#[test]
fn a_misspelled_name_finds_its_neighbour() {
    let names = ["Xposition", "Yrotation", "lfemur", "ltibia", "arm"];
    let nearest = |misspelled| nearest(misspelled, names.into_iter());
    assert_eq!(nearest("Xpositon"), Some("Xposition"));
    assert_eq!(nearest("YRotatoin"), Some("Yrotation"));
    assert_eq!(nearest("yrot"), None);
    assert_eq!(nearest("Lfemor"), Some("lfemur"));
    assert_eq!(nearest("leg"), None);
    assert_eq!(nearest("amr"), Some("arm"));
    assert_eq!(edit_distance("kitten", "sitting"), 3);
    assert_eq!(edit_distance("wakl", "walk"), 1);
    // Optimal string alignment never changes a letter that it has exchanged.
    assert_eq!(edit_distance("ca", "abc"), 3);
    assert_eq!(edit_distance("", "arm"), 3);
}
