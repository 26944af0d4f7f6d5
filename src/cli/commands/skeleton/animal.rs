//! The parts of an animal on four legs, in the report of `mocap skeleton`.

use mocap::Scene;
use mocap::figure::Confidence;
use mocap::figure::report::Quadruped;
use mocap::scene::NodeId;
use serde::Serialize;

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct QuadrupedReport {
    /// The confidence in which legs are front legs, and which side is left.
    pub(super) confidence: Confidence,
    pub(super) reason: String,
    /// The part from the pelvis to the head, the tail, and the legs from the trunk to the paw.
    pub(super) parts: Vec<PartReport>,
}

#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(super) struct PartReport {
    /// The name of the part, such as `spine` or `leftForeElbow`.
    pub(super) part: String,
    /// The joints, the nearest to the pelvis first.
    pub(super) joints: Vec<String>,
}

impl QuadrupedReport {
    pub(super) fn new(scene: &Scene, found: &Quadruped) -> Self {
        let part = |part: String, joints: &[NodeId]| PartReport {
            part,
            joints: joints
                .iter()
                .map(|node| scene.nodes[node.index()].name.clone())
                .collect(),
        };
        let head: Vec<NodeId> = found.head.into_iter().collect();
        let trunk = [
            ("pelvis", &[found.pelvis][..]),
            ("spine", &found.spine),
            ("withers", &[found.withers]),
            ("neck", &found.neck),
            ("head", &head),
            ("tail", &found.tail),
        ];
        let mut parts: Vec<PartReport> = trunk
            .into_iter()
            .map(|(name, joints)| part(name.to_owned(), joints))
            .collect();
        for leg in &found.legs {
            for (segment, joint) in leg.segments() {
                let (first, rest) = segment.split_at(1);
                let name = format!("{}{}{rest}", leg.as_str(), first.to_uppercase());
                parts.push(part(name, &[joint]));
            }
        }
        parts.retain(|part| !part.joints.is_empty());
        Self {
            confidence: found.confidence,
            reason: found.reason.clone(),
            parts,
        }
    }
}
