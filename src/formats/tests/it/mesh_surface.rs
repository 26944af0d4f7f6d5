//! Tests the triangles of mesh files.

use std::path::Path;

use mocap::glam::DVec3;
use mocap::scene::Mesh;
use mocap_formats::internals::mesh_surface::{corners, mesh_of, push_polygon};

const TEXT: &str = "solid s\nfacet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 0 2 0\n endloop\nendfacet\nendsolid s\n";

fn volume(mesh: &Mesh) -> f32 {
    let at = |index: u32| mesh.vertices[index as usize];
    let triangles = mesh.indices.as_chunks::<3>().0.iter();
    triangles.map(|[a, b, c]| at(*a).dot(at(*b).cross(at(*c))) / 6.0).sum()
}

#[test]
fn a_triangle_is_the_same_in_every_format() {
    let expected = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y];
    let mut binary = vec![0; 80];
    binary.extend(1_u32.to_le_bytes());
    let numbers = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0];
    binary.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    binary.extend([0, 0]);
    let dae = r#"<COLLADA><asset><unit meter="0.5"/></asset><library_geometries><geometry id="g"><mesh>
        <source id="p"><float_array id="a" count="9">0 0 0 2 0 0 0 4 0</float_array><technique_common>
        <accessor source="a" count="3" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="p"/></vertices>
        <triangles count="1"><input semantic="VERTEX" source="v" offset="0"/><input semantic="NORMAL" source="n" offset="1"/>
        <p>0 7 1 7 2 7</p></triangles></mesh></geometry></library_geometries></COLLADA>"#.replace("source=\"", "source=\"#");
    for (name, bytes) in [
        ("a.stl", binary.as_slice()),
        ("b.STL", TEXT.as_bytes()),
        ("a.obj", b"# o\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 2 0\nf 2/1/1 3//4 -1\n"),
        ("a.dae", dae.as_bytes()),
    ] {
        assert_eq!(
            corners(bytes, Path::new(name)).as_deref(),
            Some(&expected[..]),
            "{name}"
        );
        // A truncated file gives no mesh and no panic.
        for end in 0..bytes.len() {
            let _ = corners(&bytes[..end], Path::new(name));
        }
    }
    assert_eq!(corners(b"v 0 0 0\nf 1 2 3\n", Path::new("a.obj")), None);
    assert_eq!(corners(TEXT.replace('2', "NaN").as_bytes(), Path::new("a.stl")), None);
}

#[test]
fn a_mirrored_box_keeps_its_outside_outside() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let read = corners(text.as_bytes(), Path::new("box.obj")).unwrap();
    for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 2.0)] {
        let mesh = mesh_of(read.clone(), scale).unwrap();
        assert!((volume(&mesh) - scale.element_product().abs() as f32).abs() < 1e-6);
        // Each corner has a normal for each of its three sides.
        assert_eq!(mesh.vertices.len(), 24);
        assert!(mesh.normals.iter().all(|normal| normal.abs().max_element() > 0.999_999));
    }
}

#[test]
fn a_fine_ball_is_drawn_with_fewer_triangles() {
    const ROWS: usize = 200;
    let at = |row: usize, column: usize| {
        let (up, round) = (
            std::f64::consts::PI * row as f64 / ROWS as f64,
            std::f64::consts::TAU * column as f64 / ROWS as f64,
        );
        DVec3::new(up.sin() * round.cos(), up.sin() * round.sin(), up.cos())
    };
    let mut fine = Vec::new();
    for row in 0..ROWS {
        for column in 0..ROWS {
            push_polygon(
                &[
                    at(row, column),
                    at(row + 1, column),
                    at(row + 1, column + 1),
                    at(row, column + 1),
                ],
                &mut fine,
            );
        }
    }
    let mesh = mesh_of(fine.clone(), DVec3::ONE).unwrap();
    assert!(
        mesh.indices.len() * 2 < fine.len(),
        "{} of {}",
        mesh.indices.len(),
        fine.len()
    );
    let ball = 4.0 / 3.0 * std::f32::consts::PI;
    assert!((volume(&mesh) / ball - 1.0).abs() < 0.02, "{}", volume(&mesh));
    assert!(mesh.vertices.iter().all(|vertex| (vertex.length() - 1.0).abs() < 0.02));
}
