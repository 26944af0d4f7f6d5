//! Reads the section with the parent of each bone, and sorts the bones depth-first.

use mocap_scene::error::{Code, Diagnostic, nearest};
use mocap_scene::limits::{Limits, limit_exceeded};

use super::{Bone, Reader};
use crate::Failure;
use crate::text::{Word, decode_name, quote};

impl Reader<'_, '_> {
    pub(super) fn read_hierarchy(&mut self) -> Result<(), Failure> {
        let begin = match self.next_in_section() {
            Some(line) if line[0].is("begin") => line[0],
            Some(line) => return Err(self.lines.unexpected(line[0], "begin")),
            None => return Err(self.lines.ended("the hierarchy is empty", "begin")),
        };
        loop {
            match self.next_in_section() {
                None => return Err(self.unclosed("hierarchy", begin)),
                Some(line) if line[0].is("end") => return Ok(()),
                Some(line) => self.read_family(&line)?,
            }
        }
    }

    /// Reads a bone and its children.
    fn read_family(&mut self, line: &[Word<'_>]) -> Result<(), Failure> {
        let parent = self.find(line[0])?;
        for &word in &line[1..] {
            let child = self.find(word)?;
            if child == 0 || self.bones[child].parent.is_some() {
                let message = format!("{} already has a parent", quote(word.bytes));
                return Err(Box::new(self.lines.at(word, Code::UnexpectedToken, message).help(
                    "name each bone once, after its parent, and do not name the root as a child",
                )));
            }
            self.bones[child].parent = Some(parent);
            self.bones[parent].is_leaf = false;
            self.children[parent].push(child);
        }
        Ok(())
    }

    fn find(&self, word: Word<'_>) -> Result<usize, Failure> {
        let name = decode_name(word.bytes);
        let index = self.index_of.get(&name).copied();
        index.ok_or_else(|| {
            let message = format!("no bone is called {}", quote(word.bytes));
            let diagnostic = self
                .lines
                .at(word, Code::UnexpectedToken, message)
                .expected_found("the name of a bone in :bonedata, or root", quote(word.bytes));
            let names = self.bones.iter().map(|bone| bone.name.as_str());
            Box::new(match nearest(&name, names) {
                Some(near) => diagnostic.help(format!("did you mean {near}?")),
                None => diagnostic.help("add the bone to :bonedata, or remove it here"),
            })
        })
    }

    /// The bones in depth-first order, as in a scene: each follows its parent, or the subtree of a sibling.
    pub(super) fn depth_first(&self) -> Result<Vec<Bone>, Failure> {
        let Limits {
            max_nodes, max_depth, ..
        } = *self.limits;
        let mut ordered: Vec<Bone> = Vec::with_capacity(self.bones.len());
        let mut is_reached = vec![false; self.bones.len()];
        let mut nodes = 0;
        // The bone, the new index of its parent, and its depth. An explicit list, so that no file can overflow the call
        // stack.
        let mut open = vec![(0, None, 1)];
        while let Some((index, parent, depth)) = open.pop() {
            let bone = &self.bones[index];
            nodes += if bone.is_leaf { 2 } else { 1 };
            let exceeded = if nodes > max_nodes {
                Some((max_nodes, "nodes"))
            } else if depth > max_depth {
                Some((max_depth, "nested bones"))
            } else {
                None
            };
            if let Some((limit, what)) = exceeded {
                let diagnostic = limit_exceeded(format!("at most {limit} {what}"), format!("more than {limit}"));
                return Err(Box::new(diagnostic.in_joint(&bone.name)));
            }
            let own = Some(ordered.len());
            is_reached[index] = true;
            ordered.push(Bone { parent, ..bone.clone() });
            let children = self.children[index].iter().rev();
            open.extend(children.map(|&child| (child, own, depth + 1)));
        }
        let is_loose = |&index: &usize| !is_reached[index];
        let loose: Vec<usize> = (0..self.bones.len()).filter(is_loose).collect();
        // Report a bone without a parent rather than its descendants.
        let hangs_nowhere = loose.iter().find(|&&index| self.bones[index].parent.is_none());
        match hangs_nowhere.or(loose.first()) {
            Some(&index) => Err(Box::new(self.unreached(index))),
            None => Ok(ordered),
        }
    }

    /// The error for a bone that is not reachable from the root.
    fn unreached(&self, index: usize) -> Diagnostic {
        let bone = &self.bones[index];
        let (code, message, help) = match bone.parent {
            None => (
                Code::MissingKeyword,
                "a bone is not in the hierarchy",
                "name it in :hierarchy after its parent",
            ),
            Some(_) => (
                Code::UnexpectedToken,
                "the hierarchy has a cycle",
                "every chain of bones must lead back to the root",
            ),
        };
        let diagnostic = self.lines.at(self.named_at[index], code, message);
        diagnostic.in_joint(&bone.name).help(help)
    }
}
