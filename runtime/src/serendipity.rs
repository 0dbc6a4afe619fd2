//! The cubic Serendipity hexahedron: 32 nodes, 8 at the corners and 2 on each edge, at its thirds.
//! Zienkiewicz and Taylor, *The Finite Element Method*, vol. 1, section 8.7; used for maps by Koschier and
//! Bender 2017 and Bender et al. 2020, section 5. Reference cell [-1, 1]^3.
//!
//! Order of the nodes, with d = 0 or 1 for the lower or upper side of an axis, t = 0 or 1 for the lower or upper
//! third:
//!
//! ```text
//!  0 ..  8  corners   dx + 2 dy + 4 dz
//!  8 .. 16  x-edges    8 + t + 2 dy + 4 dz
//! 16 .. 24  y-edges   16 + t + 2 dx + 4 dz
//! 24 .. 32  z-edges   24 + t + 2 dx + 4 dy
//! ```

use glam::DVec3;

/// Nodes of the element.
pub const NODES: usize = 32;

/// Reference coordinates of a node.
pub fn node(index: usize) -> DVec3 {
    let side = |bit: usize| if index >> bit & 1 == 0 { -1.0 } else { 1.0 };
    let third = side(0) / 3.0;
    match index / 8 {
        0 => DVec3::new(side(0), side(1), side(2)),
        1 => DVec3::new(third, side(1), side(2)),
        2 => DVec3::new(side(1), third, side(2)),
        3 => DVec3::new(side(1), side(2), third),
        _ => panic!("a cubic Serendipity element has 32 nodes, not a node {index}"),
    }
}

/// Factors of one axis: linear (1 - x, 1 + x), and cubic of the edge nodes 9/64 (1 - x^2)(1 -+ 3x).
struct Axis {
    linear: [f64; 2],
    edge: [f64; 2],
}

impl Axis {
    fn new(x: f64) -> Axis {
        let bubble = 9.0 / 64.0 * (1.0 - x * x);
        Axis { linear: [1.0 - x, 1.0 + x], edge: [bubble * (1.0 - 3.0 * x), bubble * (1.0 + 3.0 * x)] }
    }

    /// Derivatives of the factors.
    fn derivative(x: f64) -> Axis {
        let cubic = |s: f64| 9.0 / 64.0 * (-2.0 * x * (1.0 + s * 3.0 * x) + (1.0 - x * x) * s * 3.0);
        Axis { linear: [-1.0, 1.0], edge: [cubic(-1.0), cubic(1.0)] }
    }
}

/// Values of the 32 shape functions at `xi`; they sum to 1.
pub fn shape(xi: DVec3) -> [f64; NODES] {
    let axes = [Axis::new(xi.x), Axis::new(xi.y), Axis::new(xi.z)];
    let mut n = products(&axes);
    let corner = (9.0 * xi.length_squared() - 19.0) / 64.0;
    n[..8].iter_mut().for_each(|value| *value *= corner);
    n
}

/// Values and gradients (with respect to `xi`) of the 32 shape functions.
pub fn shape_and_gradient(xi: DVec3) -> ([f64; NODES], [DVec3; NODES]) {
    let axes = || [Axis::new(xi.x), Axis::new(xi.y), Axis::new(xi.z)];
    let with = |axis: usize, x: f64| {
        let mut changed = axes();
        changed[axis] = Axis::derivative(x);
        products(&changed)
    };
    let mut value = products(&axes());
    let partial = [with(0, xi.x), with(1, xi.y), with(2, xi.z)];
    let mut gradient = [DVec3::ZERO; NODES];
    for (a, g) in gradient.iter_mut().enumerate() {
        *g = DVec3::new(partial[0][a], partial[1][a], partial[2][a]);
    }
    let corner = (9.0 * xi.length_squared() - 19.0) / 64.0;
    for a in 0..8 {
        gradient[a] = gradient[a] * corner + value[a] * (18.0 / 64.0) * xi;
        value[a] *= corner;
    }
    (value, gradient)
}

/// Products of the axes' factors, in the order of the nodes; the corners still without their quadratic factor.
fn products([x, y, z]: &[Axis; 3]) -> [f64; NODES] {
    let mut out = [0.0; NODES];
    for high in 0..2 {
        for low in 0..2 {
            let yz = y.linear[low] * z.linear[high];
            let xz = x.linear[low] * z.linear[high];
            let xy = x.linear[low] * y.linear[high];
            for t in 0..2 {
                let at = t + 2 * low + 4 * high;
                out[at] = x.linear[t] * yz;
                out[8 + at] = x.edge[t] * yz;
                out[16 + at] = y.edge[t] * xz;
                out[24 + at] = z.edge[t] * xy;
            }
        }
    }
    out
}
