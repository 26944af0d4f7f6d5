//! The prims of a layer by their paths, and what they have from prims above them. One pass finds both, so that many
//! prims far below each other take no more time and memory than their text.

use std::collections::HashMap;

use crate::usd::parse::{Layer, Prim};

/// The prims of a layer.
pub(super) struct Index<'l> {
    pub(super) layer: &'l Layer<'l>,
    /// Each prim by the prim above it and its name.
    children: HashMap<(Option<usize>, &'l str), usize>,
    /// The subsets of each mesh.
    pub(super) subsets: HashMap<usize, Vec<&'l Prim>>,
    /// Of each prim the skeleton that it or the nearest prim above it names; `Some(None)` where that is not there.
    pub(super) skeletons: Vec<Option<Option<usize>>>,
    /// The material likewise.
    pub(super) materials: Vec<Option<Option<usize>>>,
    /// Of each prim the nearest one that states an order of joints, itself among them.
    pub(super) orders: Vec<Option<usize>>,
}

impl<'l> Index<'l> {
    pub(super) fn of(layer: &'l Layer<'l>) -> Self {
        let mut children = HashMap::new();
        let mut subsets: HashMap<usize, Vec<&Prim>> = HashMap::new();
        for (index, prim) in layer.prims.iter().enumerate() {
            // Of two prims of one path the first is meant.
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

    /// The index of the prim at a path, which may begin at `from`; a property behind the prim is passed over.
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

/// What each prim states itself, or has from the nearest prim above it.
fn inherited<T: Copy>(layer: &Layer<'_>, stated: impl Fn(usize) -> Option<T>) -> Vec<Option<T>> {
    let mut found: Vec<Option<T>> = Vec::with_capacity(layer.prims.len());
    for (index, prim) in layer.prims.iter().enumerate() {
        let above = || prim.parent.and_then(|parent| found[parent]);
        let own = stated(index).or_else(above);
        found.push(own);
    }
    found
}
