//! The element: partition of unity, Kronecker delta, the polynomials it holds, gradients.

use proptest::prelude::*;
use volmap_runtime::DVec3;
use volmap_runtime::layout::serendipity::monomials::{BASE, POWERS, X2, X3, Y2, Y3, Z2, Z3};
use volmap_runtime::layout::serendipity::{NODES, node, shape, shape_and_gradient};

fn monomial(e: [u8; 3], x: DVec3) -> f64 {
    x.x.powi(e[0].into()) * x.y.powi(e[1].into()) * x.z.powi(e[2].into())
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

/// Superlinear degree at most 3 (Arnold and Awanou 2011), in three dimensions and with 32 different ones: all of them.
#[test]
fn monomials_are_those_of_the_space() {
    for (at, powers) in POWERS.iter().enumerate() {
        let superlinear: u8 = powers.iter().filter(|&&power| power > 1).sum();
        assert!(superlinear <= 3 && !POWERS[..at].contains(powers), "{powers:?}");
    }
    let first = [(BASE, [0, 0, 0]), (X2, [2, 0, 0]), (X3, [3, 0, 0]), (Y2, [0, 2, 0]), (Y3, [0, 3, 0])];
    for (at, powers) in first.into_iter().chain([(Z2, [0, 0, 2]), (Z3, [0, 0, 3])]) {
        assert_eq!(POWERS[at], powers);
    }
    assert_eq!((POWERS[BASE + 5], POWERS[Y3 + 2]), ([1, 0, 1], [0, 3, 1]));
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
        for e in POWERS {
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
