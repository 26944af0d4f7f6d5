//! The contents of pictures, and the hashes of their bytes.

use std::fs;

use crate::sample::Sample;
use mocap::figure::Figure;
use mocap::render::{
    Clip, Drawing, Movie, MovieOptions, Page, PageClip, PlotOptions, ScreenOptions, SheetOptions, TPoseClip,
};
use mocap::retarget::robot::{add_links, robot_scene};
use mocap::scene::report::SourceLines;
use mocap::scene::{NodeId, Scene};

fn import(name: &str) -> Scene {
    mocap::import(format!("../../fixtures/real/{name}.bvh")).unwrap()
}

fn node(scene: &Scene, name: &str) -> NodeId {
    NodeId::new(scene.nodes.iter().position(|node| node.name == name).unwrap())
}

/// FNV-1a in 64 bits: enough to notice a changed byte.
fn hash(bytes: &[u8]) -> String {
    let hash = bytes.iter().fold(0xCBF2_9CE4_8422_2325_u64, |hash, &byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01B3)
    });
    format!("{hash:016x}")
}

/// Hashes of pictures that a person has checked. Look at the new picture before you change a hash: the files are
/// written to `target/pictures`.
#[test]
fn pictures_stay_the_same_to_the_byte() {
    let expected = fs::read_to_string("tests/it/pictures.txt").unwrap();
    let folder = format!("{}/pictures", env!("CARGO_TARGET_TMPDIR"));
    fs::create_dir_all(&folder).unwrap();
    let mut found = String::new();
    let mut keep = |name: String, bytes: &[u8]| {
        fs::write(format!("{folder}/{name}"), bytes).unwrap();
        found += &format!("{} {name}\n", hash(bytes));
    };
    let files = [
        ("cmu_12_01_walk", "LeftLeg"),
        ("z_up_dab", "LeftArm"),
        ("lecture_Test", "Elbow"),
    ];
    let files = Sample::new().some(files, 3);
    for &(name, joint) in &files {
        let scene = import(name);
        let clip = Clip { name, scene: &scene };
        let drawing = Drawing::sheet(&[clip], &SheetOptions::default());
        keep(format!("{name}.sheet.png"), &drawing.to_png().unwrap());
        keep(format!("{name}.sheet.svg"), drawing.to_svg().as_bytes());
        let drawing = Drawing::plot(&clip, &[node(&scene, joint)], &PlotOptions::default());
        keep(format!("{name}.plot.svg"), drawing.to_svg().as_bytes());
        let options = MovieOptions::new().width(240).height(240).frames_per_second(10.0);
        let mut movie = Movie::new(clip, &options).unwrap();
        keep(format!("{name}.gif"), &movie.to_gif().unwrap());
        keep(format!("{name}.apng"), &movie.to_apng().unwrap());
    }
    // Lines `HASH NAME.KIND` of the chosen files.
    let is_chosen = |line: &&str| files.iter().any(|(name, _)| line.contains(&format!(" {name}.")));
    let expected: Vec<_> = expected.lines().filter(is_chosen).collect();
    assert_eq!(
        found.lines().collect::<Vec<_>>(),
        expected,
        "look at the pictures in {folder} before you accept them"
    );
}

#[test]
fn a_film_is_as_long_as_its_clip() {
    let scene = import("cmu_short");
    let clip = Clip {
        name: "short",
        scene: &scene,
    };
    for (rate, speed) in [(25.0, 1.0), (30.0, 0.5)] {
        let options = MovieOptions::new()
            .width(64)
            .height(48)
            .frames_per_second(rate)
            .speed(speed);
        let mut movie = Movie::new(clip, &options).unwrap();
        let bytes = movie.to_gif().unwrap();
        let mut decoder = gif::DecodeOptions::new().read_info(bytes.as_slice()).unwrap();
        assert_eq!((decoder.width(), decoder.height()), (64, 48));
        let (mut pictures, mut hundredths) = (0, 0);
        while let Some(frame) = decoder.read_next_frame().unwrap() {
            pictures += 1;
            hundredths += u32::from(frame.delay);
        }
        assert_eq!(pictures, movie.picture_count());
        let seconds = f64::from(hundredths) / 100.0;
        let expected = clip.seconds() / speed;
        assert!((seconds - expected).abs() < 1.5 / rate, "{seconds} s for {expected} s");

        let bytes = movie.to_apng().unwrap();
        let reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
        assert_eq!(
            reader.info().animation_control().unwrap().num_frames as usize,
            movie.picture_count()
        );
    }
}

#[test]
fn sizes_and_rates_that_cannot_be_are_refused() {
    let scene = import("cmu_short");
    let clip = Clip {
        name: "short",
        scene: &scene,
    };
    let defaults = MovieOptions::default();
    let codes = [
        defaults.width(0),
        defaults.height(1 << 20),
        defaults.frames_per_second(0.0),
        defaults.speed(f64::NAN),
        defaults.speed(1e-9),
    ]
    .map(|options| {
        let error = Movie::new(clip, &options)
            .and_then(|mut movie| movie.to_gif())
            .unwrap_err();
        error.code().as_str()
    });
    assert_eq!(
        codes,
        [
            "invalid-value",
            "invalid-value",
            "invalid-value",
            "invalid-value",
            "limit-exceeded"
        ]
    );
}

#[test]
fn every_fixture_can_be_drawn() {
    for folder in ["real", "dialects"] {
        for entry in fs::read_dir(format!("../../fixtures/{folder}")).unwrap() {
            let path = entry.unwrap().path();
            let Some(scene) = mocap::import(&path).ok() else {
                continue;
            };
            let clip = Clip {
                name: "it",
                scene: &scene,
            };
            let options = SheetOptions::new().poses(2).width(500);
            assert!(
                Drawing::sheet(&[clip], &options).to_svg().find("NaN").is_none(),
                "{}",
                path.display()
            );
            let last = NodeId::new(scene.nodes.len() - 1);
            assert!(
                Drawing::plot(&clip, &[last], &PlotOptions::default())
                    .to_svg()
                    .find("NaN")
                    .is_none()
            );
            assert!(clip.screen(&ScreenOptions::default()).contains("it  "));
        }
    }
}

/// The expected orders are in the CHANNELS of the files.
#[test]
fn a_screen_names_the_orders_of_rotations() {
    let shown = |file: &str| {
        let scene = mocap::import(format!("../../fixtures/real/{file}.bvh")).unwrap();
        let screen = Clip {
            name: "it",
            scene: &scene,
        }
        .screen(&ScreenOptions::default());
        let line = screen.lines().find_map(|line| line.strip_prefix("rotations"));
        line.map(|line| line.trim().to_owned())
    };
    assert_eq!(shown("cmu_12_01_walk").as_deref(), Some("Rz Ry Rx"));
    let mixed = shown("cmu_mixed_rotation_orders").unwrap();
    assert!(mixed.contains("; R") && mixed.contains(" of "), "{mixed}");
}

#[test]
fn a_screen_is_as_wide_and_as_high_as_the_terminal() {
    let scene = import("makehuman_zombie_walk");
    let clip = Clip {
        name: "zombie",
        scene: &scene,
    };
    for width in [60, 80, 120] {
        let options = ScreenOptions::new().width(width);
        let text = clip.screen(&options);
        let widest = text.lines().map(|line| line.chars().count()).max().unwrap();
        assert!(widest <= width, "{widest} > {width}:\n{text}");
        assert!(!text.contains('\x1b'));
    }
    let options = ScreenOptions::new().height(24).colour(true);
    let text = clip.screen(&options);
    assert!(text.lines().count() < 24, "{text}");
    assert!(text.contains(" more\n") && text.contains("\x1b[1mzombie\x1b[0m"));
}

#[test]
fn a_page_names_no_other_address() {
    let scene = import("cmu_short");
    let glb = mocap::gltf::GltfOptions::default().write_glb(&scene).unwrap();
    let name = "</script><b>";
    let html = Page::new(&[PageClip::new(Clip { name, scene: &scene }).glb(&glb[..])]).html;
    for foreign in ["http:", "https:", "//cdn", "src=", "@import", "url(", "<b>"] {
        assert!(!html.contains(foreign), "{foreign}");
    }
}

#[test]
fn a_node_knows_its_lines() {
    let lines = |name, offset, channels| {
        Some(SourceLines {
            name,
            offset: Some(offset),
            channels,
        })
    };
    let found: Vec<_> = import("lecture_Test").nodes.iter().map(|node| node.source).collect();
    let expected = [
        lines(2, 4, Some(5)),
        lines(6, 8, Some(9)),
        lines(10, 12, Some(13)),
        lines(14, 16, None),
    ];
    assert_eq!(found, expected);
    // One long line, with any line ending.
    let scene = mocap::import("../../fixtures/dialects/hierarchy_on_one_line.bvh").unwrap();
    assert_eq!(
        scene.nodes[1].source.unwrap().offset,
        scene.nodes[0].source.unwrap().offset
    );
}

#[test]
fn a_t_pose_has_a_row_a_skeleton_and_the_names_of_its_bones() {
    let scenes = ["rokoko_dance", "z_up_dab"].map(import);
    let found: Vec<_> = scenes.iter().map(Figure::new).collect();
    let clips: Vec<_> = scenes
        .iter()
        .zip(&found)
        .map(|(scene, figure)| TPoseClip {
            name: "it",
            scene,
            figure,
            t_pose: figure.t_pose(scene).unwrap(),
        })
        .collect();
    let [one, two] = [&clips[..1], &clips].map(|clips| Drawing::t_pose_sheet(clips, 1600));
    assert!(two.height > one.height && two.width == one.width);
    let svg = two.to_svg();
    for name in [
        "hips",
        "head",
        "leftUpperArm",
        "rightLowerArm",
        "leftFoot",
        "computed from the bones",
        "the rest pose is a T-pose",
    ] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
    assert!(!svg.contains("NaN"));
}

/// The pixels of a sheet of a scene.
fn pixels(scene: &Scene) -> Vec<[u8; 3]> {
    let drawing = Drawing::sheet(&[Clip { name: "it", scene }], &SheetOptions::new().poses(2).width(600));
    let png = drawing.to_png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut bytes).unwrap();
    bytes.as_chunks::<3>().0.to_vec()
}

/// The skin of this character is brown with its texture, and grey without a texture.
#[test]
fn a_skin_has_the_colours_of_its_texture() {
    let importer = mocap::Importer::new()
        .skeleton_mesh(mocap::SkeletonMesh::Own)
        .gltf_meshes(true);
    let mut hero = importer.import("../../fixtures/characters/human_vrm0.vrm").unwrap();
    let is_brown = |[red, green, blue]: &[u8; 3]| *red > *green && *green > *blue && red - blue > 30;
    let brown = |hero: &Scene| pixels(hero).iter().filter(|pixel| is_brown(pixel)).count();
    let textured = brown(&hero);
    assert!(textured > 1000, "{textured}");
    let film = Movie::new(
        Clip {
            name: "it",
            scene: &hero,
        },
        &MovieOptions::new(),
    )
    .unwrap()
    .to_gif()
    .unwrap();
    let palette = &film[13..13 + 3 * 256];
    let in_palette = palette
        .as_chunks::<3>()
        .0
        .iter()
        .filter(|pixel| is_brown(pixel))
        .count();
    assert!(in_palette > 50, "{in_palette}");
    hero.materials.iter_mut().for_each(|material| material.surface = None);
    assert!(5 * brown(&hero) < textured, "{}", brown(&hero));
}

/// Links are wider than bones, so they cover more pixels.
#[test]
fn a_robot_is_drawn_with_its_links() {
    let robot = mocap::Importer::new()
        .import_robot("../../fixtures/robots/g1_29dof_rev_1_0.urdf")
        .unwrap();
    let bones = robot_scene(&robot);
    let mut links = bones.clone();
    add_links(&robot, &mut links);
    assert_eq!(links.validate(), []);
    let painted = |scene: &Scene| {
        pixels(scene)
            .iter()
            .filter(|pixel| pixel.iter().all(|part| *part < 200))
            .count()
    };
    let (bones, links) = (painted(&bones), painted(&links));
    assert!(links > 2 * bones, "{links} {bones}");
}
