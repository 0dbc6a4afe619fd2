//! The element: partition of unity, Kronecker delta, the polynomials it holds, gradients.

use proptest::prelude::*;
use volmap_runtime::DVec3;
use volmap_runtime::serendipity::{NODES, node, shape, shape_and_gradient};

/// The 32 monomials of the cubic Serendipity space: superlinear degree at most 3 (Arnold and Awanou 2011).
fn monomials() -> Vec<[i32; 3]> {
    let mut out = Vec::new();
    for a in 0..4 {
        for b in 0..4 {
            for c in 0..4 {
                let superlinear: i32 = [a, b, c].into_iter().filter(|&e| e > 1).sum();
                if superlinear <= 3 && [a, b, c].into_iter().filter(|&e| e > 1).count() <= 1 {
                    out.push([a, b, c]);
                }
            }
        }
    }
    out
}

fn monomial(e: [i32; 3], x: DVec3) -> f64 {
    x.x.powi(e[0]) * x.y.powi(e[1]) * x.z.powi(e[2])
}

#[test]
fn nodes_are_kronecker_deltas() {
    for a in 0..NODES {
        for (b, n) in shape(node(a)).into_iter().enumerate() {
            let expected = if a == b { 1.0 } else { 0.0 };
            assert!((n - expected).abs() < 1e-12, "N_{b} at node {a} is {n}");
        }
    }
}

#[test]
fn space_has_32_monomials() {
    assert_eq!(monomials().len(), NODES);
}

proptest! {
    #[test]
    fn partition_of_unity(x in -1.0..=1.0, y in -1.0..=1.0, z in -1.0..=1.0) {
        let xi = DVec3::new(x, y, z);
        prop_assert!((shape(xi).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let slope: DVec3 = shape_and_gradient(xi).1.into_iter().sum();
        prop_assert!(slope.length() < 1e-12);
    }

    #[test]
    fn every_serendipity_monomial_is_reproduced(x in -1.0..=1.0, y in -1.0..=1.0, z in -1.0..=1.0) {
        let xi = DVec3::new(x, y, z);
        let n = shape(xi);
        for e in monomials() {
            let interpolated: f64 = (0..NODES).map(|a| n[a] * monomial(e, node(a))).sum();
            prop_assert!((interpolated - monomial(e, xi)).abs() < 1e-12, "{e:?}");
        }
    }

    #[test]
    fn gradients_are_finite_differences(x in -1.0..=1.0, y in -1.0..=1.0, z in -1.0..=1.0) {
        let xi = DVec3::new(x, y, z);
        let (values, gradients) = shape_and_gradient(xi);
        prop_assert_eq!(values, shape(xi));
        for axis in 0..3 {
            let mut step = DVec3::ZERO;
            step[axis] = 1e-5;
            let (above, below) = (shape(xi + step), shape(xi - step));
            for a in 0..NODES {
                let difference = (above[a] - below[a]) / 2e-5;
                prop_assert!((difference - gradients[a][axis]).abs() < 1e-8);
            }
        }
    }
}
