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

/// Where the nodes are, in thirds of the cell along x, y and z: 0 and 3 at its sides. The one table of their order.
pub const THIRDS: [[u8; 3]; NODES] = {
    let mut thirds = [[0; 3]; NODES];
    let mut node = 0;
    while node < NODES {
        let bits = [node as u8 & 1, node as u8 >> 1 & 1, node as u8 >> 2 & 1];
        // Of an edge the lowest bit is which third, the others are the sides of the other two axes.
        thirds[node] = match node / 8 {
            0 => [3 * bits[0], 3 * bits[1], 3 * bits[2]],
            1 => [1 + bits[0], 3 * bits[1], 3 * bits[2]],
            2 => [3 * bits[1], 1 + bits[0], 3 * bits[2]],
            _ => [3 * bits[1], 3 * bits[2], 1 + bits[0]],
        };
        node += 1;
    }
    thirds
};

/// Reference coordinates of a node, -1 to 1. Panics from 32 on.
pub fn node(index: usize) -> DVec3 {
    const PLACES: [f64; 4] = [-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0];
    DVec3::from(THIRDS[index].map(|third| PLACES[usize::from(third)]))
}

/// The monomials that span the element's space, for who works with polynomials instead of nodes.
///
/// ```text
/// x^a y^b z^c        BASE + a + 2 b + 4 c       a, b, c = 0, 1
/// x^2, x^3 y^b z^c   X2, X3 + b + 2 c           and y^2, y^3 x^a z^c, z^2, z^3 x^a y^b alike
/// ```
pub mod monomials {
    use super::NODES;

    /// Where the products of powers 0 and 1 begin.
    pub const BASE: usize = 0;
    /// Where those with x^2 begin.
    pub const X2: usize = 8;
    /// Where those with x^3 begin.
    pub const X3: usize = 12;
    /// Where those with y^2 begin.
    pub const Y2: usize = 16;
    /// Where those with y^3 begin.
    pub const Y3: usize = 20;
    /// Where those with z^2 begin.
    pub const Z2: usize = 24;
    /// Where those with z^3 begin.
    pub const Z3: usize = 28;

    /// Their powers of x, y and z. The one table of their order.
    pub const POWERS: [[u8; 3]; NODES] = {
        let mut powers = [[0; 3]; NODES];
        let mut at = 0;
        while at < NODES {
            let bits = [at as u8 & 1, at as u8 >> 1 & 1, at as u8 >> 2 & 1];
            powers[at] = match at {
                BASE..X2 => bits,
                X2..Y2 => [2 + bits[2], bits[0], bits[1]],
                Y2..Z2 => [bits[0], 2 + bits[2], bits[1]],
                _ => [bits[0], bits[1], 2 + bits[2]],
            };
            at += 1;
        }
        powers
    };
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
