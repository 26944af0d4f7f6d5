//! The largest strongly connected component of a graph, by Tarjan's algorithm (1972).
//!
//! The nodes are the frames of all clips. Each frame has an edge to the next frame, and an edge for each transition
//! that leaves the frame. Only frames where transitions begin or end are examined. A frame between two frames of a
//! component belongs to the same component.

use super::{GraphTransition, MotionGraph};

/// For each clip, the first and the last frame in the largest component. The largest component has the most frames; of
/// equally large components, the first counts. The largest component must have a transition.
pub(super) fn largest(graph: &MotionGraph) -> Vec<Option<[usize; 2]>> {
    let points = points(graph);
    let edges = edges(&points, &graph.transitions);
    let component = components(&edges);
    let mut sizes = vec![0; component.iter().map(|component| component + 1).max().unwrap_or(0)];
    for (node, point) in points.iter().enumerate() {
        let before = node.checked_sub(1).map(|before| (points[before], component[before]));
        sizes[component[node]] += match before {
            // Also counts the frames between the two points.
            Some((before, own)) if before[0] == point[0] && own == component[node] => point[1] - before[1],
            _ => 1,
        };
    }
    // A component of a single node has no cycle, unless the node has an edge to itself.
    let mut has_edge = vec![false; sizes.len()];
    for (from, to) in edges.iter().enumerate() {
        has_edge[component[from]] |= to.iter().any(|to| component[*to] == component[from]);
    }
    let mut by_size: Vec<usize> = (0..sizes.len()).collect();
    let mut first = vec![usize::MAX; sizes.len()];
    for (node, own) in component.iter().enumerate().rev() {
        first[*own] = node;
    }
    by_size.sort_by_key(|wanted| (std::cmp::Reverse(sizes[*wanted]), first[*wanted]));
    let mut parts = vec![None; graph.clips.len()];
    let Some(best) = by_size.into_iter().find(|wanted| has_edge[*wanted]) else {
        return parts;
    };
    for ([clip, frame], _) in points.iter().zip(&component).filter(|(_, own)| **own == best) {
        let part = parts[*clip].get_or_insert([*frame, *frame]);
        part[1] = *frame;
    }
    parts
}

/// The frames where transitions begin or end, in order.
fn points(graph: &MotionGraph) -> Vec<[usize; 2]> {
    let ends = graph
        .transitions
        .iter()
        .flat_map(|transition| [transition.from, transition.to]);
    let mut points: Vec<[usize; 2]> = ends.collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// For each point, the points to which its edges lead.
fn edges(points: &[[usize; 2]], transitions: &[GraphTransition]) -> Vec<Vec<usize>> {
    let follows = |pair: &[[usize; 2]]| pair[0][0] == pair[1][0];
    let mut edges: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for (node, _) in points.windows(2).enumerate().filter(|(_, pair)| follows(pair)) {
        edges[node].push(node + 1);
    }
    for transition in transitions {
        if let (Ok(from), Ok(to)) = (
            points.binary_search(&transition.from),
            points.binary_search(&transition.to),
        ) {
            edges[from].push(to);
        }
    }
    edges
}

/// The number of the component of each node.
fn components(edges: &[Vec<usize>]) -> Vec<usize> {
    /// The number of a node that was not visited. No graph has so many components.
    const NEW: usize = usize::MAX;
    let count = edges.len();
    let (mut order, mut low, mut component) = (vec![NEW; count], vec![0; count], vec![NEW; count]);
    let (mut open, mut next, mut found) = (Vec::new(), 0, 0);
    // The nodes on the path from the start of the search to the current node, each with the number of its edges that
    // the search has followed.
    let mut path: Vec<(usize, usize)> = Vec::new();
    for start in 0..count {
        if order[start] == NEW {
            path.push((start, 0));
        }
        while let Some((node, followed)) = path.last_mut() {
            let node = *node;
            if *followed == 0 && order[node] == NEW {
                (order[node], low[node]) = (next, next);
                next += 1;
                open.push(node);
            }
            if let Some(&to) = edges[node].get(*followed) {
                *followed += 1;
                if order[to] == NEW {
                    path.push((to, 0));
                } else if component[to] == NEW {
                    low[node] = low[node].min(order[to]);
                }
                continue;
            }
            path.pop();
            if let Some((parent, _)) = path.last() {
                low[*parent] = low[*parent].min(low[node]);
            }
            if low[node] == order[node] {
                while let Some(member) = open.pop() {
                    component[member] = found;
                    if member == node {
                        break;
                    }
                }
                found += 1;
            }
        }
    }
    component
}
