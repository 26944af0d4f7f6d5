//! Figures at the limits of what can be drawn.

use mocap::render::{Clip, Drawing, MovieOptions, PlotOptions, SheetOptions};
use mocap::scene::NodeId;
use mocap::{Importer, Scene};

/// A figure without a size once caused an infinite scale.
#[test]
fn every_number_of_a_picture_is_finite() {
    let point = "HIERARCHY ROOT a { OFFSET 0 0 0 CHANNELS 3 Xrotation Yrotation Zrotation }\nMOTION\n";
    let texts = [
        format!("{point}Frames: 0\nFrame Time: 0.1\n"),
        format!("{point}Frames: 1\nFrame Time: 0.1\n0 0 0\n"),
    ];
    let mut scenes: Vec<(String, Scene)> = Vec::new();
    for text in texts {
        scenes.push((text.clone(), Importer::new().read(text.as_bytes(), "a.bvh").unwrap()));
    }
    for folder in ["made", "dialects", "robots"] {
        for entry in std::fs::read_dir(format!("../../fixtures/{folder}")).unwrap() {
            let path = entry.unwrap().path();
            let read = Importer::new().import(&path);
            scenes.extend(read.ok().map(|scene| (path.display().to_string(), scene)));
        }
    }
    assert!(scenes.len() > 50, "{}", scenes.len());
    for (name, scene) in &scenes {
        let clip = Clip { name: "a", scene };
        let joints = [NodeId::new(0)];
        for drawing in [
            Drawing::sheet(&[clip], &SheetOptions::new()),
            Drawing::plot(&clip, &joints, &PlotOptions::new()),
        ] {
            let svg = drawing.to_svg();
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        }
        let options = MovieOptions::new().width(64).height(48);
        assert!(mocap::render::Movie::new(clip, &options).is_ok(), "{name}");
    }
}
