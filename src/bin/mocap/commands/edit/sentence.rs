//! What a step changed, in a sentence with units.

use mocap::edit::EditReport;
use serde_json::Value;

/// A line for a step: its name, and what it changed.
pub(super) fn sentence(report: &EditReport) -> String {
    let name = report.step.split(':').next().unwrap_or_default();
    let changed = Changed(&report.changed);
    let with = report
        .with
        .as_ref()
        .map(|file| format!(" with {file}"))
        .unwrap_or_default();
    format!("{name}{with}: {}", changed.words(name))
}

/// The report of a step's function: metres, seconds and degrees.
struct Changed<'a>(&'a Value);

impl Changed<'_> {
    fn number(&self, key: &str) -> f64 {
        self.0[key].as_f64().unwrap_or_default()
    }

    fn count(&self, key: &str) -> usize {
        self.0[key]
            .as_array()
            .map_or_else(|| self.number(key) as usize, Vec::len)
    }

    fn text(&self, key: &str) -> &str {
        self.0[key].as_str().unwrap_or_default()
    }

    fn centimetres(&self, key: &str) -> String {
        format!("{:.1} cm", 100.0 * self.number(key))
    }

    fn metres(&self, key: &str) -> String {
        format!("{:.2} m", self.number(key))
    }

    fn degrees(&self, key: &str) -> String {
        format!("{:.1} degrees", self.number(key))
    }

    fn words(&self, name: &str) -> String {
        match name {
            "foot-lock" => {
                let mut words = format!(
                    "{} contacts; the feet slid {} in them, now {}; feet shifted by {} at most, hips lowered by {} at most",
                    self.count("contacts"),
                    self.centimetres("slide_before"),
                    self.centimetres("slide_after"),
                    self.centimetres("largest_shift"),
                    self.centimetres("hips_lowered"),
                );
                if !self.text("largest_other_joint").is_empty() {
                    let by = self.centimetres("largest_other_change");
                    words += &format!(
                        "; of the other joints {} moved most, by {by}",
                        self.text("largest_other_joint")
                    );
                }
                words
            }
            "mirror" => {
                let alone = self.count("without_partner");
                let alone = if alone > 0 {
                    format!(", {alone} joints of one side have no partner")
                } else {
                    String::new()
                };
                let off = self.centimetres("largest_asymmetry");
                let joint = self.text("asymmetric_joint");
                let off = match joint {
                    "" => String::new(),
                    joint => format!("; {joint} is farthest from the mirror image, by {off}"),
                };
                format!("{} pairs of joints exchanged{alone}{off}", self.count("pairs"))
            }
            "smooth" => format!(
                "rotations changed by {} at most ({}), positions by {} at most",
                self.degrees("largest_rotation"),
                self.text("joint"),
                self.centimetres("largest_position"),
            ),
            "despike" => format!(
                "{} values replaced, in {} frames of {} joints; a rotation jumped by {} at most",
                self.count("replaced"),
                self.count("frames"),
                self.count("joints"),
                self.degrees("largest_rotation"),
            ),
            "fill" => format!(
                "{} gaps filled, {} longer ones left; rotations changed by {} at most",
                self.count("gaps"),
                self.count("longer"),
                self.degrees("largest_rotation"),
            ),
            "loop" => format!(
                "from frame {} to frame {}; {} faded out after the seam at most; {} over the ground a cycle; {} on the ground at both ends",
                self.count("first"),
                self.count("last"),
                self.degrees("largest_rotation"),
                self.metres("distance"),
                match self.0["contacts_agree"].as_bool() {
                    Some(true) => "the same feet are",
                    _ => "not the same feet are",
                },
            ),
            "concat" => format!(
                "{} frames, the seam at frame {}; {} faded out after it at most; the second motion was moved by {}",
                self.count("frames"),
                self.count("seam"),
                self.degrees("largest_rotation"),
                self.metres("moved"),
            ),
            "blend" => format!(
                "{} frames; shifted in time by {:.2} s at most to align the two",
                self.count("frames"),
                self.number("largest_time_shift"),
            ),
            "layer" => format!("{} joints in {} frames", self.count("joints"), self.count("frames")),
            "warp" if self.0["points_before"].is_array() => format!(
                "the path was {} long, now {}; moved by {} at most, turned by {} at most",
                self.metres("length_before"),
                self.metres("length"),
                self.metres("largest_shift"),
                self.degrees("largest_turn"),
            ),
            "warp" => format!(
                "{:.2} s, now {:.2} s; speeds from {:.2} to {:.2} times",
                self.number("seconds_before"),
                self.number("seconds"),
                self.number("slowest"),
                self.number("fastest"),
            ),
            "in-between" => format!(
                "{} key frames; rotations changed by {} at most, positions by {} at most",
                self.count("keys"),
                self.degrees("largest_rotation"),
                self.centimetres("largest_position"),
            ),
            _ => self.0.to_string(),
        }
    }
}
