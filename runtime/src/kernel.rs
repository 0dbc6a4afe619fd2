//! SPH kernels W: of compact support, radially symmetric, integral 1 in three dimensions, or in two.
//!
//! Cubic spline: Monaghan 2005, *Smoothed Particle Hydrodynamics*, in the form of Koschier et al. 2019, Eq. 4.
//! Wendland C2: Wendland 1995; Dehnen and Aly 2012, Table 1. Poly6 and Spiky: Mueller et al. 2003, *Particle-Based
//! Fluid Simulation for Interactive Applications*, Eq. 20 and 21.

mod lattice;

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;
use volmap_formats::asset::Dimension;

/// SPH kernels, all scaled to the support radius.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(rename_all = "snake_case"))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum KernelKind {
    /// Cubic spline (Monaghan 1992), the usual one.
    #[default]
    CubicSpline,
    /// Wendland's C2 function (Wendland 1995), (1 - q)^4 (4 q + 1).
    WendlandC2,
    /// Spiky (Mueller et al. 2003), (1 - q)^3; its slope doesn't vanish at the centre.
    Spiky,
    /// Poly6 (Mueller et al. 2003), (1 - q^2)^3.
    Poly6,
}

impl KernelKind {
    /// All of them.
    pub const ALL: [KernelKind; 4] =
        [KernelKind::CubicSpline, KernelKind::WendlandC2, KernelKind::Spiky, KernelKind::Poly6];

    /// W at distance q >= 0 from the centre, for support radius 1 (so, with q = d / r, r^3 W).
    #[inline]
    pub fn unit_value(self, q: f64) -> f64 {
        let rest = (1.0 - q).max(0.0);
        match self {
            KernelKind::CubicSpline if q <= 0.5 => 8.0 / PI * (6.0 * (q * q * q - q * q) + 1.0),
            KernelKind::CubicSpline => 16.0 / PI * rest.powi(3),
            KernelKind::WendlandC2 => 10.5 / PI * rest.powi(4) * (4.0 * q + 1.0),
            KernelKind::Spiky => 15.0 / PI * rest.powi(3),
            KernelKind::Poly6 => 315.0 / (64.0 * PI) * (1.0 - q * q).max(0.0).powi(3),
        }
    }

    /// dW/dq for support radius 1 (r^4 W'); at most 0.
    #[inline]
    pub fn unit_derivative(self, q: f64) -> f64 {
        let rest = (1.0 - q).max(0.0);
        match self {
            KernelKind::CubicSpline if q <= 0.5 => 48.0 / PI * q * (3.0 * q - 2.0),
            KernelKind::CubicSpline => -48.0 / PI * rest.powi(2),
            KernelKind::WendlandC2 => -210.0 / PI * q * rest.powi(3),
            KernelKind::Spiky => -45.0 / PI * rest.powi(2),
            KernelKind::Poly6 => -945.0 / (32.0 * PI) * q * (1.0 - q * q).max(0.0).powi(2),
        }
    }

    /// W in two dimensions over W in three, both for support radius 1: the thickness (in support radii) of the layer of
    /// space that stands for the plane. Sums of area times the one are sums of area times thickness times the other.
    pub fn plane_thickness(self) -> f64 {
        match self {
            KernelKind::CubicSpline => 5.0 / 7.0,
            KernelKind::WendlandC2 | KernelKind::Spiky => 2.0 / 3.0,
            KernelKind::Poly6 => 256.0 / 315.0,
        }
    }

    /// [`KernelKind::unit_value`] of the kernel in two dimensions (r^2 W).
    pub fn unit_value_in_plane(self, q: f64) -> f64 {
        self.plane_thickness() * self.unit_value(q)
    }

    /// pi times the integral of W along a line from the centre outwards, for support radius 1.
    pub fn line_integral(self) -> f64 {
        match self {
            KernelKind::CubicSpline => 3.0,
            KernelKind::WendlandC2 => 3.5,
            KernelKind::Spiky => 3.75,
            KernelKind::Poly6 => 2.25,
        }
    }

    /// W_1: the integral of W over a plane at distance z >= 0 from the centre, for support radius 1.
    #[inline]
    pub fn sheet_integral(self, z: f64) -> f64 {
        let u = (1.0 - z).max(0.0);
        // The integral of v^3 (1 - v).
        let cubic = |v: f64| v.powi(4) * (0.25 - 0.2 * v);
        match self {
            KernelKind::CubicSpline => 32.0 * cubic(u) - 4.0 * cubic((1.0 - 2.0 * z).max(0.0)),
            KernelKind::WendlandC2 => u.powi(5) * (21.0 - 31.5 * u + 12.0 * u * u),
            KernelKind::Spiky => 30.0 * cubic(u),
            KernelKind::Poly6 => 315.0 / 256.0 * (1.0 - z * z).max(0.0).powi(4),
        }
    }

    /// Its name, as files and messages have it.
    pub const fn name(self) -> &'static str {
        match self {
            KernelKind::CubicSpline => "cubic_spline",
            KernelKind::WendlandC2 => "wendland_c2",
            KernelKind::Spiky => "spiky",
            KernelKind::Poly6 => "poly6",
        }
    }
}

impl fmt::Display for KernelKind {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for KernelKind {
    type Err = String;

    /// Of its name; `cubic-spline`, `wendland-c2`, `cubic` and `wendland`, which older files have, are understood too.
    fn from_str(text: &str) -> Result<KernelKind, String> {
        match text {
            "cubic-spline" | "cubic" => return Ok(KernelKind::CubicSpline),
            "wendland-c2" | "wendland" => return Ok(KernelKind::WendlandC2),
            _ => {}
        }
        let known = KernelKind::ALL.into_iter().find(|kind| kind.name() == text);
        known.ok_or_else(|| {
            format!("`{text}` is no kernel; take {}", KernelKind::ALL.map(KernelKind::name).join(", "))
        })
    }
}

/// By its name, as [`FromStr`] reads it; an error lists the names of today alone.
#[cfg(feature = "serde")]
impl<'de> serde::Deserialize<'de> for KernelKind {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<KernelKind, D::Error> {
        const ALL: [KernelKind; 4] = KernelKind::ALL;
        const NAMES: &[&str] = &[ALL[0].name(), ALL[1].name(), ALL[2].name(), ALL[3].name()];
        let text = std::borrow::Cow::<str>::deserialize(deserializer)?;
        text.parse().map_err(|_| serde::de::Error::unknown_variant(&text, NAMES))
    }
}

/// A kernel of a given size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    dimension: Dimension,
    kind: KernelKind,
    support_radius: f64,
    per_radius: f64,
    value_scale: f64,
    derivative_scale: f64,
}

impl Kernel {
    /// A kernel that is 0 from `support_radius` on (metres, positive and finite).
    pub fn new(kind: KernelKind, support_radius: f64) -> Kernel {
        Kernel::scaled(Dimension::Three, kind, support_radius, (1.0 / support_radius).powi(3))
    }

    /// The same in two dimensions: integral 1 in the plane, values in 1/m^2 and derivatives in 1/m^3.
    pub fn in_plane(kind: KernelKind, support_radius: f64) -> Kernel {
        let scale = kind.plane_thickness() * support_radius.powi(-2);
        Kernel::scaled(Dimension::Two, kind, support_radius, scale)
    }

    fn scaled(dimension: Dimension, kind: KernelKind, support_radius: f64, value_scale: f64) -> Kernel {
        let per_radius = 1.0 / support_radius;
        let derivative_scale = value_scale * per_radius;
        Kernel { dimension, kind, support_radius, per_radius, value_scale, derivative_scale }
    }

    /// In how many dimensions its integral is 1.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// Its shape.
    pub fn kind(&self) -> KernelKind {
        self.kind
    }

    /// Support radius r, metres.
    pub fn support_radius(&self) -> f64 {
        self.support_radius
    }

    /// W at `distance` >= 0 from the centre (metres), 1/m^3.
    #[inline]
    pub fn value(&self, distance: f64) -> f64 {
        self.value_scale * self.kind.unit_value(distance * self.per_radius)
    }

    /// W' at `distance` >= 0 from the centre (metres), 1/m^4; at most 0.
    #[inline]
    pub fn derivative(&self, distance: f64) -> f64 {
        self.derivative_scale * self.kind.unit_derivative(distance * self.per_radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::integrate;

    const RADIUS: f64 = 0.1;

    #[test]
    fn integral_over_space_is_1() {
        for kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, RADIUS);
            let shell = |d: f64| 4.0 * PI * d * d * kernel.value(d);
            let sum = integrate(0.0, 0.5 * RADIUS, shell) + integrate(0.5 * RADIUS, RADIUS, shell);
            assert!((sum - 1.0).abs() < 1e-14, "{kind}: {sum}");
        }
    }

    #[test]
    fn integral_over_the_plane_is_1() {
        for kind in KernelKind::ALL {
            let kernel = Kernel::in_plane(kind, RADIUS);
            let ring = |d: f64| 2.0 * PI * d * kernel.value(d);
            let sum = integrate(0.0, 0.5 * RADIUS, ring) + integrate(0.5 * RADIUS, RADIUS, ring);
            assert!((sum - 1.0).abs() < 1e-14, "{kind}: {sum}");
        }
    }

    #[test]
    fn derivative_is_that_of_the_value() {
        for kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, RADIUS);
            for d in (1..240).map(|n| f64::from(n) * 0.0005 + 0.00012) {
                let difference = (kernel.value(d + 1e-7) - kernel.value(d - 1e-7)) / 2e-7;
                let error = (kernel.derivative(d) - difference).abs();
                assert!(error < 1e-6 * kernel.value(0.0) / RADIUS, "{kind} at {d}: {error}");
            }
        }
    }

    #[test]
    fn nothing_from_the_support_radius_on() {
        for kind in KernelKind::ALL {
            let kernel = Kernel::new(kind, RADIUS);
            for d in [RADIUS, 1.5 * RADIUS, 1e9] {
                assert_eq!((kernel.value(d), kernel.derivative(d).abs()), (0.0, 0.0), "{kind} at {d}");
            }
        }
    }

    #[test]
    fn integrals_over_lines_and_sheets_are_those_of_the_value() {
        for kind in KernelKind::ALL {
            let line = PI
                * (integrate(0.0, 0.5, |q| kind.unit_value(q)) + integrate(0.5, 1.0, |q| kind.unit_value(q)));
            assert!((line - kind.line_integral()).abs() < 1e-14, "{kind}: {line}");
            for z in [0.0, 0.2, 0.5, 0.7, 1.0, 1.2_f64] {
                let ring = |s: f64| 2.0 * PI * s * kind.unit_value(s);
                let (low, middle) = (z.min(1.0), z.clamp(0.5, 1.0));
                let sum = integrate(low, middle, ring) + integrate(middle, 1.0, ring);
                assert!((sum - kind.sheet_integral(z)).abs() < 1e-14, "{kind} at {z}: {sum}");
            }
        }
    }

    #[test]
    fn names_are_read_back_and_old_ones_understood() {
        for kind in KernelKind::ALL {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
        for (old, kind) in [
            ("cubic-spline", KernelKind::CubicSpline),
            ("cubic", KernelKind::CubicSpline),
            ("wendland-c2", KernelKind::WendlandC2),
            ("wendland", KernelKind::WendlandC2),
        ] {
            assert_eq!(old.parse(), Ok(kind));
        }
        assert!("quintic".parse::<KernelKind>().unwrap_err().contains("cubic_spline, wendland_c2"));
    }
}
