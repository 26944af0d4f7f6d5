//! Tests the surface of drawn capsules.

use mocap::glam::DVec3;
use mocap_retarget::internals::capsule::Capsule;
use mocap_retarget::internals::surface_of;

/// The triangles are inside the capsule, so their volume is slightly smaller than the volume of the capsule.
#[test]
fn a_capsule_is_closed_and_has_its_volume() {
    let (radius, ends) = (0.1, [DVec3::new(0.2, 0.1, 0.0), DVec3::new(0.2, 0.5, 0.3)]);
    let (vertices, _, indices) = surface_of(&[Capsule { ends, radius }]);
    let corner = |index: u32| vertices[index as usize].as_dvec3();
    let triangles = indices.as_chunks::<3>().0.iter();
    let volume: f64 = triangles
        .map(|[a, b, c]| corner(*a).dot(corner(*b).cross(corner(*c))) / 6.0)
        .sum();
    let expected = std::f64::consts::PI * radius * radius * (0.5 + 4.0 / 3.0 * radius);
    assert!((volume.abs() / expected - 0.96).abs() < 0.03, "{volume} {expected}");
}
