//! Where a cell is judged, and what its polynomials are there.

use glam::DVec3;
use std::sync::LazyLock;
use volmap_runtime::layout::serendipity::{NODES, shape};

/// How many there are.
pub const COUNT: usize = 27;
/// Rounded up to whole vectors.
const PADDED: usize = 28;

/// In quarters of a cell's edges: the midpoints of its edges, of its faces and its own, which are corners of its children,
/// and those of its children.
pub const PROBES: [[u8; 3]; COUNT] = {
    let mut points = [[0; 3]; COUNT];
    let (mut count, mut n) = (0, 0);
    while n < COUNT {
        let half = [n % 3, n / 3 % 3, n / 9];
        if n == 13 {
            points[18] = [2; 3];
        } else if half[0] == 1 || half[1] == 1 || half[2] == 1 {
            points[count] = [2 * half[0] as u8, 2 * half[1] as u8, 2 * half[2] as u8];
            count += 1;
        } else {
            // A corner; the child's midpoint there.
            points[19 + half[0] / 2 + half[1] + 2 * half[2]] =
                [1 + half[0] as u8, 1 + half[1] as u8, 1 + half[2] as u8];
        }
        n += 1;
    }
    points
};

/// The 32 shape functions at the probes; by probe, and by function.
static OF_PROBE: LazyLock<[[f64; NODES]; COUNT]> =
    LazyLock::new(|| std::array::from_fn(|probe| shape(place(probe))));
static OF_NODE: LazyLock<[[f64; PADDED]; NODES]> = LazyLock::new(|| {
    let at = |node: usize, probe: usize| if probe < COUNT { OF_PROBE[probe][node] } else { 0.0 };
    std::array::from_fn(|node| std::array::from_fn(|probe| at(node, probe)))
});

/// Reference coordinates of a probe.
pub fn place(probe: usize) -> DVec3 {
    DVec3::from(PROBES[probe].map(|quarter| 0.5 * f64::from(quarter) - 1.0))
}

/// Values at the probes of the polynomial with these values at the nodes.
pub fn values(nodes: &[f64; NODES]) -> [f64; COUNT] {
    // Function by function: the sums don't wait for each other.
    let mut sums = [0.0; PADDED];
    for (value, functions) in nodes.iter().zip(&*OF_NODE) {
        sums.iter_mut().zip(functions).for_each(|(sum, function)| *sum += value * function);
    }
    std::array::from_fn(|probe| sums[probe])
}

/// The transposed of [`values`].
pub fn shared_out(probes: &[f64; COUNT]) -> [f64; NODES] {
    let mut sums = [0.0; NODES];
    for (value, functions) in probes.iter().zip(&*OF_PROBE) {
        sums.iter_mut().zip(functions).for_each(|(sum, function)| *sum += value * function);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_runtime::layout::serendipity::node;

    #[test]
    fn values_at_probes_are_those_of_the_polynomial_and_shares_their_transposed() {
        let cubic = |x: DVec3| 1.0 + x.x * x.x * x.x * x.y * x.z - 2.0 * x.y * x.y + x.x * x.z;
        let nodes: [f64; NODES] = std::array::from_fn(|a| cubic(node(a)));
        let at_probes = values(&nodes);
        for (probe, value) in at_probes.iter().enumerate() {
            assert!((value - cubic(place(probe))).abs() < 1e-14, "{probe}");
        }
        let weights: [f64; COUNT] = std::array::from_fn(|probe| (probe as f64).sin());
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        assert!((product(&at_probes, &weights) - product(&nodes, &shared_out(&weights))).abs() < 1e-13);
    }
}
