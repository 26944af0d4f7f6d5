//! The convex hull of points in a plane.

use glam::DVec2;

/// The corners of the convex hull, anticlockwise: A. M. Andrew's monotone chain, the lower side and then the upper
/// side. Empty if all points coincide.
pub fn convex_hull(points: &mut [DVec2]) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut hull: Vec<DVec2> = Vec::with_capacity(2 * points.len());
    for half in [false, true] {
        let begin = hull.len();
        let order: Box<dyn Iterator<Item = &DVec2>> = if half {
            Box::new(points.iter().rev())
        } else {
            Box::new(points.iter())
        };
        for &point in order {
            while let &[.., a, b] = &hull[begin..]
                && (b - a).perp_dot(point - b) <= 0.0
            {
                hull.pop();
            }
            hull.push(point);
        }
        hull.pop();
    }
    hull
}

/// The area of a polygon with anticlockwise corners.
pub fn area(corners: &[DVec2]) -> f64 {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    0.5 * edges.map(|(a, b)| a.perp_dot(*b)).sum::<f64>()
}
