//! Tests the lists of player pages.

use mocap::Scene;
use mocap::render::{Clip, ListingEntry};

#[test]
fn names_are_text_and_links_are_links() {
    let entry = ListingEntry::failed("<b>.bvh", "no & no");
    let html = ListingEntry::page("a<b", &[entry]);
    assert!(html.contains("<strong>&lt;b&gt;.bvh</strong>") && html.contains("<li>no &amp; no</li>"));
    let scene = Scene::default();
    let clip = Clip {
        name: "a",
        scene: &scene,
    };
    let html = ListingEntry::page("", &[ListingEntry::new(&clip, "a b/#1.html")]);
    assert!(html.contains("href=\"a%20b/%231.html\""), "{html}");
}
