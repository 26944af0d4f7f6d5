//! Tests that near triangles hide far triangles.

use mocap::glam::Vec2;
use mocap::render::Drawing;
use mocap_render::internals::surface::{Buffer, SAMPLES};
use mocap_render::internals::theme;

fn empty() -> Drawing {
    Drawing::new(20, 20, theme::PAPER, "")
}

fn triangle(depth: f32, shift: f32) -> [(Vec2, f32); 3] {
    [[2.0, 2.0], [12.0, 2.0], [2.0, 12.0]].map(|[x, y]| (Vec2::new(x + shift, y), depth))
}

/// A triangle has half of the area of its bounding box. Nearer triangles hide farther triangles, in any order.
#[test]
fn the_nearest_triangle_is_seen() {
    for order in [[0, 1], [1, 0]] {
        let mut buffer = Buffer::around([[0.0, 0.0], [20.0, 20.0]].into_iter(), &empty()).unwrap();
        let both = [(triangle(1.0, 0.0), 3), (triangle(2.0, 4.0), 9)];
        for (corners, shade) in order.map(|which| both[which]) {
            buffer.fill(corners, |_| Some([shade; 3]));
        }
        let count = |shade: u8| buffer.colors.iter().filter(|found| **found == [shade; 3]).count();
        let of_all = (10 * 10 / 2 * SAMPLES * SAMPLES) as f32;
        assert!((count(9) as f32 / of_all - 1.0).abs() < 0.06, "{}", count(9));
        // The visible part: 50 minus the overlap, a triangle of 6 x 6.
        assert!((count(3) as f32 / of_all - 32.0 / 50.0).abs() < 0.06, "{}", count(3));
    }
}

#[test]
fn what_is_not_finite_or_outside_is_not_painted() {
    let mut buffer = Buffer::around([[0.0, 0.0], [20.0, 20.0]].into_iter(), &empty()).unwrap();
    for corners in [triangle(f32::NAN, 0.0), triangle(1.0, f32::NAN), triangle(1.0, 1e9)] {
        buffer.fill(corners, |_| Some([5; 3]));
    }
    buffer.fill(triangle(1.0, 0.0), |_| None);
    assert!(buffer.colors.iter().all(|color| *color == [0; 3]));
    assert!(Buffer::around([[-9.0, 3.0], [-2.0, 5.0]].into_iter(), &empty()).is_none());
    assert!(Buffer::around([[f32::NAN, 3.0]].into_iter(), &empty()).is_none());
}
