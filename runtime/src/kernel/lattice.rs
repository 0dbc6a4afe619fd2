//! What particles on a lattice add up to: the sum that is 1 in a continuum.

use super::KernelKind;
use volmap_formats::asset::Dimension;

/// Spacings in a support radius above which the lattice is as good as a continuum, and long to sum over.
const FINEST: f64 = 16.0;

impl KernelKind {
    /// The density of a full cubic lattice (square in two dimensions), in parts of what its particles have: the sum of
    /// a^d W over all of it, seen from one of its points. `spacing` is the lattice's edge a in support radii. 1 in a
    /// continuum; on the coarse lattices that fluids are made of up to several times that, the more the sharper the
    /// kernel's peak is. A fluid whose sums over neighbours, and whose boundary's densities by an integral of W, are
    /// divided by it begins at rest.
    ///
    /// 1 where the lattice is finer than 1/16, too.
    pub fn lattice_sum(self, dimension: Dimension, spacing: f64) -> f64 {
        self.sum(dimension, spacing, |q| self.unit_value(q))
    }

    /// How much that density grows with the lattice's, in parts of what it would in a continuum: minus the sum of
    /// a^d q W'(q) over the dimensions. The particle itself, however dense, adds nothing to it.
    pub fn lattice_response(self, dimension: Dimension, spacing: f64) -> f64 {
        let count = dimension.count() as f64;
        self.sum(dimension, spacing, |q| -q * self.unit_derivative(q) / count)
    }

    /// The kernel whose gradient pushes particles apart where this one gives their density: itself, but for poly6, by
    /// whose own slope they would end up in pairs, as it vanishes around the centre. Müller et al. 2003 have the spiky
    /// kernel's with it.
    pub fn of_gradients(self) -> KernelKind {
        match self {
            KernelKind::Poly6 => KernelKind::Spiky,
            own => own,
        }
    }

    fn sum(self, dimension: Dimension, spacing: f64, term: impl Fn(f64) -> f64) -> f64 {
        if !(spacing * FINEST >= 1.0 && spacing.is_finite()) {
            return 1.0;
        }
        let reach = (1.0 / spacing) as i32;
        let plane = || (-reach..=reach).flat_map(move |i| (-reach..=reach).map(move |j| i * i + j * j));
        let value = |square: i32| term(spacing * f64::from(square).sqrt());
        let sum: f64 = match dimension {
            Dimension::Two => self.plane_thickness() * plane().map(value).sum::<f64>(),
            Dimension::Three => {
                (-reach..=reach).flat_map(|k| plane().map(move |square| square + k * k)).map(value).sum()
            }
        };
        sum * spacing.powi(dimension.count() as i32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cubic_spline_on_the_usual_lattice_is_at_rest() {
        // By shells: 1, 6, 12 and 8 neighbours at 0, 1/2, 1/2^(1/2) and 3^(1/2)/2 of the support radius.
        let shell = |q: f64| 2.0 * (1.0 - q).powi(3);
        let shells = 1.0 + 6.0 * 0.25 + 12.0 * shell(0.5_f64.sqrt()) + 8.0 * shell(0.75_f64.sqrt());
        let sum = KernelKind::CubicSpline.lattice_sum(Dimension::Three, 0.5);
        assert!((sum - shells / std::f64::consts::PI).abs() < 1e-14, "{sum}");
        assert!((sum - 1.0).abs() < 3e-5, "{sum}");
    }

    #[test]
    fn fine_lattices_are_a_continuum_and_coarse_ones_a_particle() {
        for kind in KernelKind::ALL {
            for dimension in [Dimension::Two, Dimension::Three] {
                let sum = |spacing| kind.lattice_sum(dimension, spacing);
                assert!((sum(1.0 / 15.0) - 1.0).abs() < 3e-3, "{kind}: {}", sum(1.0 / 15.0));
                let response = |spacing| kind.lattice_response(dimension, spacing);
                assert!((response(1.0 / 15.0) - 1.0).abs() < 3e-3, "{kind}: {}", response(1.0 / 15.0));
                // It is the slope of the density over the logarithm of the lattice's, by d.
                let slope = |a: f64| {
                    let per_volume =
                        |a: f64| kind.lattice_sum(dimension, a) / a.powi(dimension.count() as i32);
                    (per_volume(a * 0.999_999) - per_volume(a * 1.000_001)) / 2e-6
                };
                let volume = 0.5_f64.powi(dimension.count() as i32);
                let expected = slope(0.5) * volume / dimension.count() as f64;
                assert!((response(0.5) - expected).abs() < 1e-5, "{kind}: {} {expected}", response(0.5));
                assert_eq!(sum(1e-3), 1.0);
                // Nobody in reach but the particle itself.
                let thickness = if dimension == Dimension::Two { kind.plane_thickness() } else { 1.0 };
                assert!((sum(1.0) / (thickness * kind.unit_value(0.0)) - 1.0).abs() < 1e-15, "{kind}");
            }
        }
    }
}
