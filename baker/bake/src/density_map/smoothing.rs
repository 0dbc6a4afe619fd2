//! SPH kernels W that a density map may be baked for: those of the runtime that the asset has a name for.

use std::fmt;
use std::str::FromStr;
use volmap_runtime::KernelKind;

/// Which kernel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Smoothing {
    /// Cubic spline.
    #[default]
    CubicSpline,
    /// Wendland C2.
    WendlandC2,
}

impl Smoothing {
    /// W at distance q from the centre, for support radius 1 (so, with q = |xi| / r, r^3 W).
    pub fn value(self, q: f64) -> f64 {
        self.kind().unit_value(q)
    }

    /// The same in two dimensions (r^2 W).
    pub fn value_in_plane(self, q: f64) -> f64 {
        self.kind().plane_thickness() * self.kind().unit_value(q)
    }

    fn kind(self) -> KernelKind {
        match self {
            Smoothing::CubicSpline => KernelKind::CubicSpline,
            Smoothing::WendlandC2 => KernelKind::WendlandC2,
        }
    }
}

impl fmt::Display for Smoothing {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Smoothing::CubicSpline => "cubic_spline",
            Smoothing::WendlandC2 => "wendland_c2",
        })
    }
}

impl FromStr for Smoothing {
    type Err = String;

    fn from_str(text: &str) -> Result<Smoothing, String> {
        match text {
            "cubic" | "cubic_spline" => Ok(Smoothing::CubicSpline),
            "wendland" | "wendland_c2" => Ok(Smoothing::WendlandC2),
            _ => Err(format!("`{text}` is no kernel; take cubic (cubic spline) or wendland (Wendland C2)")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume_map::quadrature::gauss_legendre;
    use std::f64::consts::PI;

    #[test]
    fn kernels_have_integral_1_and_end_smoothly() {
        for kernel in [Smoothing::CubicSpline, Smoothing::WendlandC2] {
            let half = |low: f64| {
                let shell = |(x, w): (f64, f64)| {
                    let q = low + 0.25 * (1.0 + x);
                    0.25 * w * 4.0 * PI * q * q * kernel.value(q)
                };
                gauss_legendre(8).into_iter().map(shell).sum::<f64>()
            };
            assert!((half(0.0) + half(0.5) - 1.0).abs() < 1e-14, "{kernel}");
            assert_eq!((kernel.value(1.0), kernel.value(1.5)), (0.0, 0.0));
            for q in [0.5, 1.0] {
                let slope = |a: f64, b: f64| (kernel.value(b) - kernel.value(a)) / (b - a);
                assert!((slope(q - 1e-6, q) - slope(q, q + 1e-6)).abs() < 1e-4, "{kernel} at {q}");
            }
            assert_eq!(kernel.to_string().parse(), Ok(kernel));
        }
        assert!("poly6".parse::<Smoothing>().is_err());
    }
}
