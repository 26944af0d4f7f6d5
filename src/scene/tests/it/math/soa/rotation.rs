//! Tests rotations as structures of arrays.

use std::f32::consts::{FRAC_PI_2, PI};

use mocap::glam::{DQuat, EulerRot, Quat, Vec3};
use mocap_scene::math::quaternion::twist;
use mocap_scene::math::soa::{Quaternions, Vectors};

type Rotations = Quaternions<f32, 8>;

fn is_near(found: [f32; 4], expected: Quat) {
    let found = Quat::from_array(found);
    assert!(found.abs_diff_eq(expected, 1e-6), "{found}, not {expected}");
}

#[test]
fn the_shortest_rotations_turn_about_the_cross_product_by_the_angle() {
    let from = Vec3::new(0.6, 0.0, -0.8);
    let aside = Vec3::new(0.0, 1.0, 0.0);
    let angles = [0.0, 1e-4, 0.3, FRAC_PI_2, 2.0, 3.0, 3.13, -1.0_f32];
    let to = angles.map(|angle| 7.0 * (from * angle.cos() + aside * angle.sin()));
    let found = Rotations::arc(Vectors::all(from.to_array()), Vectors::of(|lane| to[lane].to_array()));
    for (lane, to) in to.into_iter().enumerate() {
        // glam's own arc is the identity for angles within 0.04 degrees.
        let (from, to) = (from.as_dvec3(), to.as_dvec3());
        let axis = from.cross(to);
        let angle = axis.length().atan2(from.dot(to));
        let exact = axis.try_normalize().map(|axis| DQuat::from_axis_angle(axis, angle));
        is_near(found.lane(lane), exact.unwrap_or(DQuat::IDENTITY).as_quat());
    }
}

#[test]
fn directions_without_a_shortest_rotation_do_no_harm_to_others() {
    let from = Vec3::Y;
    let to = [
        Vec3::ZERO,
        -Vec3::Y,
        Vec3::X,
        Vec3::splat(f32::NAN),
        Vec3::splat(f32::INFINITY),
        -2.0 * Vec3::Y + 1e-6 * Vec3::X,
        Vec3::Y,
        1e-30 * Vec3::Y,
    ];
    let found = Rotations::arc(Vectors::all(from.to_array()), Vectors::of(|lane| to[lane].to_array()));
    for lane in [0, 3, 4, 6, 7] {
        is_near(found.lane(lane), Quat::IDENTITY);
    }
    is_near(found.lane(2), Quat::from_rotation_arc(Vec3::Y, Vec3::X));
    for lane in [1, 5] {
        let turned = Quat::from_array(found.lane(lane)) * from;
        assert!(turned.abs_diff_eq(-Vec3::Y, 1e-5), "{turned}");
    }
}

#[test]
fn between_rotations_lies_what_lies_there_for_glam() {
    let from = Quat::from_euler(EulerRot::XYZ, 0.3, -1.0, 2.0);
    let axis = Vec3::new(0.48, -0.6, 0.64);
    let angles = [0.0, 1e-5, 0.01, 0.5, 1.5, 2.5, PI - 0.01, -2.9_f32];
    for sign in [1.0, -1.0] {
        let to = angles.map(|angle| Quat::from_axis_angle(axis, angle) * from * sign);
        for fraction in [0.0, 0.2, 0.5, 0.75, 1.0] {
            let many = Rotations::all(from.to_array());
            let found = many.slerp(Rotations::of(|lane| to[lane].to_array()), fraction);
            for (lane, to) in to.into_iter().enumerate() {
                is_near(found.lane(lane), from.slerp(to, fraction));
            }
        }
    }
}

#[test]
fn twists_are_those_of_one_rotation() {
    let axis = Vec3::new(0.6, 0.0, -0.8);
    let angles = [0.0, 0.5, -2.0, 3.0, PI, 1.0, -0.1, 2.2_f32];
    let turned = angles.map(|angle| Quat::from_euler(EulerRot::YXZ, angle, 0.4 * angle, -angle));
    let turned = turned.map(|rotation| {
        if rotation == turned[4] {
            Quat::from_axis_angle(Vec3::Y, PI)
        } else {
            rotation
        }
    });
    let found = Rotations::of(|lane| turned[lane].to_array()).twist(axis.to_array());
    for (lane, turned) in turned.into_iter().enumerate() {
        is_near(found.lane(lane), twist(turned, axis));
    }
}
