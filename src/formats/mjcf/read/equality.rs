//! Joint equalities. A linear equality makes a joint follow another joint.

use std::collections::HashSet;

use mocap_scene::error::Code;
use mocap_scene::scene::robot::RobotLink;

use crate::Failure;
use crate::mimic::{self, MimicNames};
use crate::warnings::Warnings;
use crate::xml::Element;

/// Connects joints by `equality/joint`: the position of joint1 is a polynomial of the position of joint2.
pub(super) fn tie_joints(
    root: &Element<'_, '_>,
    links: &mut [RobotLink],
    has_other_bodies: bool,
    warnings: &mut Warnings,
) -> Result<(), Failure> {
    let names: HashSet<String> = links.iter().map(|link| link.joint.name.clone()).collect();
    let mut followers = HashSet::new();
    let mut mimics = Vec::new();
    for element in root.all("equality").flat_map(|equality| equality.all("joint")) {
        if element.attribute("active") == Some("false") {
            continue;
        }
        let follower = element.required("joint1")?;
        let mut left_out = |message: &'static str| {
            warnings.push(Code::IgnoredChannel, || {
                element.diagnostic(Code::IgnoredChannel, message).in_joint(follower)
            });
        };
        let Some(leader) = element.attribute("joint2") else {
            left_out("an equality that fixes a joint is not supported: the joint is free");
            continue;
        };
        let terms = match element.attribute("polycoef") {
            Some(value) => element.parse_numbers("polycoef", value, 1, 5)?,
            None => Vec::new(),
        };
        if terms.iter().skip(2).any(|term| *term != 0.0) {
            left_out("an equality of joints with terms above the linear one is not supported: the joints are free");
            continue;
        }
        let is_known = |name: &str| names.contains(name);
        if !is_known(follower) {
            // The joint may belong to a body that was not read.
            if has_other_bodies {
                continue;
            }
            let message = "joint1 of the equality is not a joint of the robot";
            return Err(Box::new(
                element
                    .at_attribute("joint1", Code::InvalidRobot, message)
                    .in_joint(follower),
            ));
        }
        if !followers.insert(follower) {
            left_out("two equalities make a joint follow other joints: only the first equality was read");
            continue;
        }
        mimics.push(MimicNames {
            element,
            attribute: "joint2",
            follower: follower.to_owned(),
            leader: leader.to_owned(),
            offset: terms.first().copied().unwrap_or(0.0),
            multiplier: terms.get(1).copied().unwrap_or(1.0),
        });
    }
    mimic::tie(links, &mimics)
}
