//! Joints that follow other joints: `mimic` in URDF and `equality/joint` in MJCF.

use std::collections::HashMap;

use mocap_scene::error::{Code, Diagnostic, nearest};
use mocap_scene::scene::robot::{Mimic, RobotLink};

use super::Failure;
use super::text::quote;
use super::warnings::Warnings;
use super::xml::Element;

/// The largest difference in radians or metres between the limits of a leader and its followers that counts as
/// rounding.
const ROUNDING: f64 = 1e-9;

/// A follower and its leader, by their names in a file.
pub(super) struct MimicNames<'a, 'input> {
    pub(super) element: Element<'a, 'input>,
    /// The attribute with the leader's name.
    pub(super) attribute: &'static str,
    pub(super) follower: String,
    pub(super) leader: String,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

impl MimicNames<'_, '_> {
    fn diagnostic(&self, message: String) -> Diagnostic {
        self.element
            .at_attribute(self.attribute, Code::InvalidRobot, message)
            .in_joint(self.follower.as_str())
    }

    /// Whether the file has the leader. Warns if the file lacks the leader. Other URDF readers do not look for the
    /// leader, so the follower moves independently there.
    pub(super) fn has_leader(&self, links: &[RobotLink], warnings: &mut Warnings) -> bool {
        let mut names = links.iter().map(|link| link.joint.name.as_str());
        let has_leader = names.any(|name| name == self.leader);
        if !has_leader {
            warnings.push(Code::InvalidRobot, || {
                let name = quote(self.leader.as_bytes());
                let warning = self.diagnostic(format!("no joint is called {name}, so this joint follows no joint"));
                let names = links.iter().map(|link| link.joint.name.as_str());
                match nearest(&self.leader, names) {
                    Some(near) => warning.help(format!("did you mean {near}?")),
                    None => warning,
                }
            });
        }
        has_leader
    }
}

/// Connects followers to free joints, resolves chains, and narrows the limits of the free joints.
pub(super) fn tie(links: &mut [RobotLink], named: &[MimicNames<'_, '_>]) -> Result<(), Failure> {
    let moving = links.iter().enumerate().filter(|(_, link)| link.joint.moves());
    let by_name: HashMap<String, usize> = moving.map(|(index, link)| (link.joint.name.clone(), index)).collect();
    let mut mimic_of = HashMap::new();
    for mimic in named {
        let Some(&follower) = by_name.get(&mimic.follower) else {
            continue;
        };
        let Some(&leader) = by_name.get(&mimic.leader) else {
            let name = quote(mimic.leader.as_bytes());
            let unknown = mimic.diagnostic(format!("no moving joint is called {name}"));
            return Err(Box::new(
                match nearest(&mimic.leader, by_name.keys().map(String::as_str)) {
                    Some(near) => unknown.help(format!("did you mean {near}?")),
                    None => unknown,
                },
            ));
        };
        mimic_of.insert(follower, (leader, mimic));
    }
    let mut followers: Vec<usize> = mimic_of.keys().copied().collect();
    followers.sort_unstable();
    for &first in &followers {
        // The followers from `first` to the nearest free or resolved joint.
        let mut chain = vec![first];
        let mut end = first;
        while let Some(&(leader, mimic)) = mimic_of.get(&end) {
            if links[end].joint.mimic.is_some() {
                break;
            }
            if chain.len() > followers.len() {
                return Err(Box::new(
                    mimic.diagnostic("the joints follow each other in a circle".to_owned()),
                ));
            }
            chain.push(leader);
            end = leader;
        }
        for pair in chain.windows(2).rev() {
            let [follower, leader] = [pair[0], pair[1]];
            let named = mimic_of[&follower].1;
            let above = links[leader].joint.mimic.unwrap_or(Mimic {
                leader,
                multiplier: 1.0,
                offset: 0.0,
            });
            let mimic = Mimic {
                leader: above.leader,
                multiplier: named.multiplier * above.multiplier,
                offset: named.multiplier * above.offset + named.offset,
            };
            if !mimic.multiplier.is_finite() || !mimic.offset.is_finite() {
                let message = "the product of the multipliers of joints that follow each other is too large";
                return Err(Box::new(named.diagnostic(message.to_owned())));
            }
            links[follower].joint.mimic = Some(mimic);
            narrow(links, follower, &mimic).map_err(|message| Box::new(named.diagnostic(message)))?;
        }
    }
    Ok(())
}

/// Narrows the limits of a leader so that its follower stays within the follower's own limits.
fn narrow(links: &mut [RobotLink], follower: usize, mimic: &Mimic) -> Result<(), String> {
    let own = links[follower].joint.limits;
    let leader = &mut links[mimic.leader].joint;
    let (lower, upper) = if mimic.multiplier == 0.0 {
        let is_kept = (own.lower - ROUNDING..=own.upper + ROUNDING).contains(&mimic.offset);
        if is_kept {
            (f64::NEG_INFINITY, f64::INFINITY)
        } else {
            (f64::INFINITY, f64::NEG_INFINITY)
        }
    } else {
        let ends = [own.lower, own.upper].map(|limit| (limit - mimic.offset) / mimic.multiplier);
        (ends[0].min(ends[1]), ends[0].max(ends[1]))
    };
    let (lower, upper) = (lower.max(leader.limits.lower), upper.min(leader.limits.upper));
    // Rounding may swap two equal limits.
    if lower > upper + ROUNDING {
        let name = quote(leader.name.as_bytes());
        return Err(format!(
            "no position of the joint {name} is within both its limits and the limits of the joints that follow it"
        ));
    }
    (leader.limits.lower, leader.limits.upper) = (lower.min(upper), upper);
    if let Some(velocity) = own.velocity.filter(|_| mimic.multiplier != 0.0) {
        let most = velocity / mimic.multiplier.abs();
        leader.limits.velocity = Some(leader.limits.velocity.map_or(most, |own| own.min(most)));
    }
    Ok(())
}
