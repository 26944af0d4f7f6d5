//! Sets of variants within a prim: the selected variant is read as if it stood in the prim.

use super::{Layer, Parser};
use crate::Failure;

/// What a closing brace ends.
#[derive(Clone)]
pub(super) enum Open {
    Prim(usize),
    /// A set of variants of a prim, and which of them is selected.
    Set(usize, Option<String>),
    /// The selected variant, which is read as if it stood in the prim.
    Variant(usize),
}

impl Open {
    pub(super) fn prim(&self) -> usize {
        let (Self::Prim(prim) | Self::Set(prim, _) | Self::Variant(prim)) = self;
        *prim
    }
}

impl<'a> Parser<'a> {
    /// `variantSet "model" = {`, of which the prim selects one by `variants = { string model = "high" }`.
    pub(super) fn variant_set(&mut self, prim: usize, layer: &mut Layer<'a>) -> Result<Open, Failure> {
        let set = self.tokens.string()?;
        self.tokens.expect(b'=')?;
        self.tokens.expect(b'{')?;
        let selections = layer.prims[prim].metadata.get("variants");
        let texts = selections.map_or(&[][..], |value| value.texts.as_slice());
        // The texts of a selection are its type, its set and its variant.
        let mut selections = texts.chunks_exact(3);
        let selected = selections.find(|texts| texts[1] == set).map(|texts| texts[2].clone());
        if selected.is_none() {
            layer.unselected.push((prim, set));
        }
        Ok(Open::Set(prim, selected))
    }

    /// The next variant of a set, up to its brace; one that is not selected is passed.
    pub(super) fn variant(&mut self, prim: usize, selected: Option<&str>) -> Result<Option<Open>, Failure> {
        let name = self.tokens.string()?;
        if self.tokens.peek() == Some(b'(') {
            self.metadata()?;
        }
        if selected == Some(name.as_str()) {
            self.tokens.expect(b'{')?;
            return Ok(Some(Open::Variant(prim)));
        }
        self.skip_statement()?;
        Ok(None)
    }
}
