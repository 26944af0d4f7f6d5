//! Tests the weights of vertices on the player page.

use mocap_render::internals::strongest_four;

#[test]
fn the_weights_of_a_vertex_sum_to_one() {
    let mut ties = vec![(7, 0.1), (1, 0.3), (2, 0.3), (3, 0.2), (4, 0.1)];
    let (joints, weights) = strongest_four(&mut ties);
    assert_eq!(joints[..3], [1, 2, 3]);
    assert_eq!(weights.iter().map(|weight| u32::from(*weight)).sum::<u32>(), 65_535);
    assert_eq!(strongest_four(&mut []).1, [65_535, 0, 0, 0]);
}
