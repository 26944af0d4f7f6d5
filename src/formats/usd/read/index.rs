//! The prims of a layer by path, and their inherited properties. One pass finds both, so that many deeply nested prims
//! take no more time and memory than their text.

use std::collections::HashMap;

use crate::usd::parse::{Layer, Prim};

/// The prims of a layer.
pub(super) struct Index<'l> {
    pub(super) layer: &'l Layer<'l>,
    /// Each prim by its parent and its name.
    children: HashMap<(Option<usize>, &'l str), usize>,
    /// The subsets of each mesh.
    pub(super) subsets: HashMap<usize, Vec<&'l Prim>>,
    /// The skeleton that each prim, or its nearest ancestor, states; `Some(None)` if that skeleton does not exist.
    pub(super) skeletons: Vec<Option<Option<usize>>>,
    /// The material that each prim, or its nearest ancestor, states.
    pub(super) materials: Vec<Option<Option<usize>>>,
    /// For each prim, the nearest prim that states an order of joints: the prim itself or an ancestor.
    pub(super) orders: Vec<Option<usize>>,
}

impl<'l> Index<'l> {
    pub(super) fn of(layer: &'l Layer<'l>) -> Self {
        let mut children = HashMap::new();
        let mut subsets: HashMap<usize, Vec<&Prim>> = HashMap::new();
        for (index, prim) in layer.prims.iter().enumerate() {
            // Of two prims with one path, the first counts.
            children.entry((prim.parent, prim.name.as_str())).or_insert(index);
            if let Some(mesh) = prim.parent.filter(|_| prim.kind == "GeomSubset") {
                subsets.entry(mesh).or_default().push(prim);
            }
        }
        let mut found = Self {
            layer,
            children,
            subsets,
            skeletons: Vec::new(),
            materials: Vec::new(),
            orders: Vec::new(),
        };
        let named = |name: &str, prim: usize| {
            let path = layer.prims[prim].texts(name).first()?;
            Some(found.find(path, prim))
        };
        let skeletons = inherited(layer, |prim| named("skel:skeleton", prim));
        let materials = inherited(layer, |prim| named("material:binding", prim));
        let states_order = |prim: usize| !layer.prims[prim].texts("skel:joints").is_empty();
        found.orders = inherited(layer, |prim| states_order(prim).then_some(prim));
        (found.skeletons, found.materials) = (skeletons, materials);
        found
    }

    /// The index of the prim at a path, which may be relative to `from`. A property after the prim is ignored.
    pub(super) fn find(&self, path: &str, from: usize) -> Option<usize> {
        let (path, mut found) = match path.strip_prefix('/') {
            Some(path) => (path, None),
            None => (path, Some(from)),
        };
        let path = path.split('.').next()?;
        for name in path.split('/') {
            found = Some(*self.children.get(&(found, name))?);
        }
        found
    }
}

/// The value that each prim states, or inherits from its nearest ancestor with a value.
fn inherited<T: Copy>(layer: &Layer<'_>, stated: impl Fn(usize) -> Option<T>) -> Vec<Option<T>> {
    let mut found: Vec<Option<T>> = Vec::with_capacity(layer.prims.len());
    for (index, prim) in layer.prims.iter().enumerate() {
        let above = || prim.parent.and_then(|parent| found[parent]);
        let own = stated(index).or_else(above);
        found.push(own);
    }
    found
}
