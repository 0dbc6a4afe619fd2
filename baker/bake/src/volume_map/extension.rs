//! The cubic extension function gamma*, Eq. 13 of Bender et al. 2020.

/// gamma*(Phi) = C(Phi) / C(0) for 0 < Phi < r, 1 inside the solid, 0 beyond r; C is the cubic spline kernel of
/// support radius r (Monaghan 2005). Takes Phi and 1 / r.
#[inline(always)]
pub fn extension(phi: f64, inverse_radius: f64) -> f64 {
    let q = (phi * inverse_radius).clamp(0.0, 1.0);
    let rest = 1.0 - q;
    // Both branches are cheaper than a jump.
    let near = 6.0 * (q * q * q - q * q) + 1.0;
    let far = 2.0 * rest * rest * rest;
    if q <= 0.5 { near } else { far }
}

#[cfg(test)]
mod tests {
    use super::extension;

    #[test]
    fn extension_is_the_normalised_cubic_spline() {
        let r = 0.3;
        let at = |phi: f64| extension(phi, 1.0 / r);
        assert_eq!((at(-1.0), at(0.0), at(r), at(7.0)), (1.0, 1.0, 0.0, 0.0));
        assert!((at(0.5 * r) - 0.25).abs() < 1e-15);
        // Continuously differentiable at 0, r/2 and r.
        for phi in [0.0, 0.5 * r, r] {
            let slope = |a: f64, b: f64| (at(b) - at(a)) / (b - a);
            let (left, right) = (slope(phi - 1e-6, phi), slope(phi, phi + 1e-6));
            assert!((left - right).abs() < 1e-3, "slopes {left} and {right} at {phi}");
        }
    }
}
