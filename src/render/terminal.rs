//! A summary of a file on one screen of a terminal.

use std::fmt::Write;

use mocap_figure::Figure;
use mocap_scene::options::setters;
use mocap_scene::pose::Pose;
use mocap_scene::scene::{NodeId, NodeKind, RotationOrder, Scene};

use super::figure::{Clip, DrawnClip, short};

/// The options of the summary.
///
/// [`Clip::screen`] has an example.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct ScreenOptions {
    /// Characters per line. Default: 80.
    pub width: usize,
    /// The number of lines. In a taller tree the deepest nodes are only counted. Default: 50.
    pub height: usize,
    /// Whether to use colours. Default: `false`.
    pub colour: bool,
}

impl Default for ScreenOptions {
    fn default() -> Self {
        Self {
            width: 80,
            height: 50,
            colour: false,
        }
    }
}

setters! {
    ScreenOptions {
        width: usize,
        height: usize,
        colour: bool,
    }
}

/// A text style.
#[derive(Clone, Copy)]
enum Ink {
    Bold,
    Faint,
    Warning,
}

/// The text of the screen, and its line width.
struct Screen {
    text: String,
    width: usize,
    colour: bool,
}

impl Screen {
    fn inked(&self, ink: Ink, words: &str) -> String {
        let code = match ink {
            Ink::Bold => "1",
            Ink::Faint => "2",
            Ink::Warning => "33",
        };
        if self.colour {
            format!("\x1b[{code}m{words}\x1b[0m")
        } else {
            words.to_owned()
        }
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Prints a label and a paragraph next to it.
    fn labelled(&mut self, label: &str, ink: Option<Ink>, words: &str) {
        let lines = wrapped(words, self.width.saturating_sub(LABEL));
        for (index, line) in lines.iter().enumerate() {
            let label = if index == 0 { label } else { "" };
            let line = ink.map_or_else(|| line.clone(), |ink| self.inked(ink, line));
            let label = self.inked(Ink::Faint, &format!("{label:<LABEL$}"));
            self.line(format!("{label}{line}").trim_end());
        }
    }
}

/// The number of characters for a label: the longest, `joint-positions`, and a space.
const LABEL: usize = 16;

impl Clip<'_> {
    /// A summary of a clip: its size, its joint tree with link lengths, the height of its root over time, the
    /// assumptions and the warnings.
    ///
    /// The tree has one line for every chain of joints without a branch. Lengths are in the file's unit.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use mocap::render::{Clip, ScreenOptions};
    ///
    /// let scene = mocap::import("fixtures/real/lecture_Test.bvh")?;
    /// let text = Clip { name: "Test", scene: &scene }.screen(&ScreenOptions::default());
    /// assert!(text.contains("Shoulder ─ 2 ─ Elbow ─ 1.5 ─ Wrist ─ 0.5 ─ ∙"));
    /// # Ok::<(), mocap::Error>(())
    /// ```
    pub fn screen(&self, options: &ScreenOptions) -> String {
        let clip = self;
        let mut screen = Screen {
            text: String::new(),
            width: options.width.max(40),
            colour: options.colour,
        };
        let heading = screen.inked(Ink::Bold, clip.name);
        screen.line(&format!("{heading}  {}", clip.facts()));
        let rest = below_the_tree(clip, &screen);
        // Four more lines: the heading, an empty line before and after the tree, and the shell prompt.
        let used = rest.lines().count() + 4;
        let most = options.height.saturating_sub(used);
        screen.line("");
        for line in Tree::new(clip.scene).lines(screen.width, most) {
            screen.line(&line);
        }
        screen.line("");
        screen.text.push_str(&rest);
        screen.text
    }
}

/// The orders of Euler angles in a file, the most frequent first. For the other orders, the joints are named.
fn rotation_orders(scene: &Scene) -> Option<String> {
    /// The largest number of named joints.
    const NAMED: usize = 4;
    let joints = |order: RotationOrder| {
        scene
            .nodes
            .iter()
            .filter(move |node| node.rotation_order == Some(order))
    };
    let mut orders = RotationOrder::ALL.map(|order| (order, Vec::from_iter(joints(order).map(|node| &*node.name))));
    orders.sort_by_key(|(_, names)| std::cmp::Reverse(names.len()));
    let words = orders
        .iter()
        .filter(|(_, names)| !names.is_empty())
        .enumerate()
        .map(|(index, (order, names))| {
            let [a, b, c] = order.axes().map(|axis| ["x", "y", "z"][axis]);
            let more = if names.len() > NAMED { ", ..." } else { "" };
            match index {
                0 => format!("R{a} R{b} R{c}"),
                _ => format!("R{a} R{b} R{c} of {}{more}", names[..names.len().min(NAMED)].join(", ")),
            }
        });
    let words = Vec::from_iter(words);
    (!words.is_empty()).then(|| words.join("; "))
}

fn below_the_tree(clip: &Clip<'_>, like: &Screen) -> String {
    let mut screen = Screen {
        text: String::new(),
        ..*like
    };
    if clip.animation().is_some() {
        let (curve, low, high) = root_height(clip, screen.width.saturating_sub(LABEL).min(72));
        screen.labelled("root height", None, &curve);
        screen.labelled("", Some(Ink::Faint), &format!("{} to {}", short(low), short(high)));
    }
    let clips = &clip.scene.animations;
    for (index, animation) in clips.iter().enumerate().filter(|_| clips.len() > 1) {
        let label = if index == 0 { "clips" } else { "" };
        let seconds = animation.duration / animation.ticks_per_second;
        let words = format!(
            "{index} \"{}\": {} frames, {seconds:.3} s",
            animation.name,
            animation.frame_count()
        );
        screen.labelled(label, None, &words);
    }
    if let Some(curves) = clip.scene.face_curves_alone(0) {
        screen.labelled("face", None, &format!("{curves}; nothing else moves"));
    }
    let metadata = &clip.scene.metadata;
    if let Some(used) = &metadata.root_offset {
        let policy = format!("{:?}", used.policy).to_lowercase();
        let words = format!("position channels {policy} the OFFSET: {}", used.reason);
        screen.labelled("root", None, &words);
    }
    if let Some(words) = rotation_orders(clip.scene) {
        screen.labelled("rotations", None, &words);
    }
    for note in metadata
        .assumptions
        .iter()
        .chain(&Figure::new(clip.scene).survey.assumptions())
    {
        screen.labelled(
            note.topic.as_str(),
            None,
            &format!("{}: {}", note.choice, note.explanation()),
        );
    }
    /// The largest number of listed warnings. `mocap check` prints all.
    const MOST: usize = 6;
    let warnings = &clip.scene.warnings;
    for warning in warnings.iter().take(MOST) {
        let line = warning
            .location
            .as_ref()
            .map(|location| format!("line {}: ", location.line));
        screen.labelled(
            "warning",
            Some(Ink::Warning),
            &format!("{}{warning}", line.unwrap_or_default()),
        );
    }
    if warnings.len() > MOST {
        let more = format!("and {} more; `mocap check` prints all", warnings.len() - MOST);
        screen.labelled("", Some(Ink::Warning), &more);
    }
    screen.text
}

/// A chart of the root height: each character shows the mean height in one time interval. Also the lowest and the
/// highest root height.
fn root_height(clip: &Clip<'_>, width: usize) -> (String, f64, f64) {
    const BARS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];

    /// The number of samples for a bar of the chart, which shows their mean.
    const SAMPLES_A_BAR: usize = 4;
    let mut figure = DrawnClip::new(*clip);
    let ticks = figure.ticks(SAMPLES_A_BAR * width);
    let heights: Vec<f64> = ticks
        .into_iter()
        .map(|tick| {
            let positions = figure.positions(tick);
            f64::from(figure.root(&positions).y)
        })
        .collect();
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let per_bar = heights.len().div_ceil(width.max(1)).max(1);
    let bars = heights.chunks(per_bar).map(|chunk| {
        let mean = chunk.iter().sum::<f64>() / chunk.len() as f64;
        let fraction = if high > low { (mean - low) / (high - low) } else { 0.0 };
        BARS[((fraction * 8.0) as usize).min(7)]
    });
    (bars.collect(), low, high)
}

/// The joint tree, with the number of descendants of each joint.
struct Tree<'a> {
    scene: &'a Scene,
    children: Vec<Vec<usize>>,
    /// The number of descendants of each node.
    below: Vec<usize>,
    rest: Pose,
}

/// A chain that is not drawn yet.
struct Branch {
    node: usize,
    /// The number of branches above this chain.
    depth: usize,
    /// The prefixes of the chain's first line and of its further lines.
    first: String,
    next: String,
}

impl<'a> Tree<'a> {
    fn new(scene: &'a Scene) -> Self {
        let mut children = vec![Vec::new(); scene.nodes.len()];
        let mut below = vec![0; scene.nodes.len()];
        for (index, node) in scene.nodes.iter().enumerate() {
            if let Some(parent) = node.parent {
                children[parent.index()].push(index);
            }
        }
        // In reverse order children precede their parents, so every count is complete before it is added to the count
        // of the parent.
        for (index, node) in scene.nodes.iter().enumerate().rev() {
            if let Some(parent) = node.parent {
                below[parent.index()] += below[index] + 1;
            }
        }
        Self {
            scene,
            children,
            below,
            rest: Pose::rest(scene),
        }
    }

    /// One line for every chain, down to the branch depth that fits. Deeper nodes are counted.
    fn lines(&self, width: usize, most: usize) -> Vec<String> {
        /// The largest branch depth to list. No body has deeper branches.
        const DEEPEST: usize = 32;
        let fits = |lines: &Vec<String>| lines.len() <= most;
        let lines = (1..=DEEPEST).rev().map(|depth| self.lines_to(depth, width));
        lines.into_iter().find(fits).unwrap_or_else(|| self.lines_to(0, width))
    }

    /// Uses an explicit list, so that no skeleton can overflow the call stack.
    fn lines_to(&self, deepest: usize, width: usize) -> Vec<String> {
        let mut lines = Vec::new();
        let mut branches: Vec<Branch> = Vec::new();
        if !self.scene.nodes.is_empty() {
            branches.push(Branch {
                node: 0,
                depth: 0,
                first: String::new(),
                next: String::new(),
            });
        }
        while let Some(Branch {
            node,
            depth,
            first,
            next,
        }) = branches.pop()
        {
            let mut chain = vec![node];
            let mut last = node;
            while let [only] = self.children[last].as_slice() {
                last = *only;
                chain.push(last);
            }
            let hidden = if depth < deepest { 0 } else { self.below[last] };
            self.push_chain(&mut lines, width, &chain, hidden, &first, &next);
            if hidden > 0 {
                continue;
            }
            let forks = self.children[last].len();
            for (child_index, &child) in self.children[last].iter().enumerate().rev() {
                let is_last = child_index + 1 == forks;
                branches.push(Branch {
                    node: child,
                    depth: depth + 1,
                    first: format!("{next}{}", if is_last { "└─ " } else { "├─ " }),
                    next: format!("{next}{}", if is_last { "   " } else { "│  " }),
                });
            }
        }
        lines
    }

    /// `Elbow ─ 1.5 ─ Wrist`: names with the link lengths between them. The length of the first node's own link
    /// precedes its name. The number of hidden nodes follows the last name.
    fn push_chain(
        &self,
        lines: &mut Vec<String>,
        width: usize,
        chain: &[usize],
        hidden: usize,
        first: &str,
        next: &str,
    ) {
        let mut line = first.to_owned();
        let mut is_empty = true;
        for &index in chain {
            let node = &self.scene.nodes[index];
            // End sites usually have no name.
            let name = if node.kind == NodeKind::EndSite {
                "∙"
            } else {
                &node.name
            };
            let mut piece = String::new();
            if let Some(length) = self.link_length(index) {
                let dash = if is_empty { "" } else { " ─ " };
                write!(piece, "{dash}{length} ─ ").expect("writing to a string cannot fail");
            }
            piece.push_str(name);
            if hidden > 0 && chain.last() == Some(&index) {
                write!(piece, " … {hidden} more").expect("writing to a string cannot fail");
            }
            if !is_empty && line.chars().count() + piece.chars().count() > width {
                lines.push(std::mem::replace(&mut line, format!("{next}   ")));
                piece = piece.trim_start().to_owned();
            }
            line.push_str(&piece);
            is_empty = false;
        }
        lines.push(line);
    }

    /// The length of the link from the parent, in the file's unit; `None` for the root.
    fn link_length(&self, index: usize) -> Option<String> {
        let parent = self.scene.nodes[index].parent?;
        let length = self
            .rest
            .position(parent)
            .distance(self.rest.position(NodeId::new(index)));
        Some(short(f64::from(length)))
    }
}

/// Wraps words to lines of `width` characters; a longer word gets its own line.
pub fn wrapped(words: &str, width: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in words.split_whitespace() {
        let last = lines.last_mut().expect("there is a first line");
        if !last.is_empty() && last.chars().count() + 1 + word.chars().count() > width {
            lines.push(word.to_owned());
        } else {
            if !last.is_empty() {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    lines
}
