//! The scenes of this crate, compared with the scenes of Assimp 5.2.5, number by number and line by line.
//!
//! A row of [`explained::EXPLAINED`] must explain every difference, and every row must explain a difference.

mod compare;
mod explained;
mod truth;

use mocap::Importer;
use mocap::dump::Layout;
use mocap::process::{KeyTolerance, SkeletonMesh};
use mocap::scene::Scene;

use compare::Comparison;
use explained::{EXPLAINED, EXPLAINED_LINES, is_explained_by};
use truth::{Flags, Truth};

/// The scene as Assimp imports it without post-processing.
fn raw(file: &str) -> Scene {
    Importer::new()
        .skeleton_mesh(SkeletonMesh::Skinned)
        .collapse_keys(false)
        .import(truth::path(&format!("real/{file}.bvh")))
        .unwrap()
}

/// The scene after the processing steps that the course requires.
fn processed(file: &str) -> Scene {
    let mut scene = raw(file);
    scene.find_degenerates();
    scene.remove_sizeless_meshes();
    scene.collapse_keys(KeyTolerance::default());
    scene.join_identical_vertices();
    scene.debone();
    scene
}

fn ours(file: &str, flags: Flags) -> Scene {
    match flags {
        Flags::None => raw(file),
        Flags::MaxQualityDebone => processed(file),
    }
}

/// The largest coordinate of the mesh that Assimp makes first. The rounding of this mesh also appears in the normals.
fn reach(file: &str) -> f64 {
    let vertices = raw(file).meshes.remove(0).vertices;
    f64::from(
        vertices
            .iter()
            .map(|vertex| vertex.abs().max_element())
            .fold(0.0, f32::max),
    )
}

#[test]
fn every_difference_from_assimp_is_explained() {
    let mut used = vec![false; EXPLAINED.len()];
    let mut unexplained = Vec::new();
    for (file, flags) in truth::answers() {
        let scene = ours(&file, flags);
        assert_eq!(scene.validate(), [], "{file}");
        let comparison = Comparison::new(&file, flags, reach(&file));
        for difference in comparison.run(&scene, &Truth::read(&file, flags)) {
            let rows: Vec<usize> = (0..EXPLAINED.len())
                .filter(|&row| is_explained_by(&difference, &EXPLAINED[row]))
                .collect();
            if rows.is_empty() {
                unexplained.push(difference.to_string());
            }
            for row in rows {
                used[row] = true;
            }
        }
    }
    assert!(unexplained.is_empty(), "unexplained:\n{}", unexplained.join("\n"));
    let idle: Vec<_> = EXPLAINED
        .iter()
        .zip(used)
        .filter(|(_, used)| !used)
        .map(|(row, _)| row)
        .collect();
    assert!(idle.is_empty(), "rows that explain nothing: {idle:#?}");
}

#[test]
fn the_lectures_text_is_assimps_line_by_line() {
    let layouts = [
        (Layout::Y2017, "2017"),
        (Layout::Y2018, "2018"),
        (Layout::Y2019, "2019"),
        (Layout::Y2021, "2021"),
    ];
    for flags in [Flags::None, Flags::MaxQualityDebone] {
        let scene = ours("lecture_Test", flags);
        for (layout, year) in layouts {
            let name = format!("assimp/lecture_Test.{}.course{year}.txt", flags.name());
            let mut expected = String::from_utf8(truth::fixture(&name)).unwrap();
            for (theirs, ours, _) in EXPLAINED_LINES {
                assert_eq!(expected.matches(theirs).count(), 1, "{name}: {theirs}");
                expected = expected.replace(theirs, ours);
            }
            assert_eq!(layout.text(&scene, layout.sections()), expected, "{name}");
        }
    }
}
