//! Reads variant sets of a prim: the selected variant is read as part of the prim.

use super::{Layer, Parser};
use crate::Failure;

/// The construct that a closing brace ends.
#[derive(Clone)]
pub(super) enum Open {
    Prim(usize),
    /// A variant set of a prim, and its selected variant.
    Set(usize, Option<String>),
    /// The selected variant, which is read as part of the prim.
    Variant(usize),
}

impl Open {
    pub(super) fn prim(&self) -> usize {
        let (Self::Prim(prim) | Self::Set(prim, _) | Self::Variant(prim)) = self;
        *prim
    }
}

impl<'a> Parser<'a> {
    /// Reads `variantSet "model" = {`. The prim selects a variant by `variants = { string model = "high" }`.
    pub(super) fn variant_set(&mut self, prim: usize, layer: &mut Layer<'a>) -> Result<Open, Failure> {
        let set = self.tokens.string()?;
        self.tokens.expect(b'=')?;
        self.tokens.expect(b'{')?;
        let selections = layer.prims[prim].metadata.get("variants");
        let texts = selections.map_or(&[][..], |value| value.texts.as_slice());
        // The strings of a selection are its type, its set and its variant.
        let mut selections = texts.chunks_exact(3);
        let selected = selections.find(|texts| texts[1] == set).map(|texts| texts[2].clone());
        if selected.is_none() {
            layer.unselected.push((prim, set));
        }
        Ok(Open::Set(prim, selected))
    }

    /// Reads the next variant of a set, up to its brace. Skips variants that are not selected.
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
