//! Quadrature over the disc of the support radius.
//!
//! - `gl<p>`, the paper's, in the plane: a tensor product of Gauss-Legendre rules over the square [-r, r]^2, points
//!   outside the disc left out (Bender et al. 2020, section 5). Order p: floor(p / 2) + 1 points an axis.
//! - `disc<n>`: a product rule of the disc itself (Stroud 1971, *Approximate Calculation of Multiple Integrals*,
//!   section 2.6): n Gauss-Legendre points in the radius, weighted by it, and 4 n equispaced angles, turned by half a
//!   step from one radius to the next.

use crate::volume_map::quadrature::gauss_legendre;
use glam::DVec2;
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// Which rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscRule {
    /// Tensor Gauss-Legendre of this polynomial order, masked by the disc.
    GaussLegendre(u32),
    /// Product rule of the disc with this many radii.
    Disc(u32),
}

impl Default for DiscRule {
    fn default() -> Self {
        DiscRule::Disc(16)
    }
}

/// Highest order and number that a rule takes.
const MAX_ORDER: u32 = 300;

/// A point of a rule for the unit disc, and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscPoint {
    /// Place in the unit disc.
    pub position: DVec2,
    /// Weight; the weights of a rule sum to about pi.
    pub weight: f64,
}

impl DiscRule {
    /// The points inside the unit disc, in a fixed order.
    pub fn points(self) -> Vec<DiscPoint> {
        match self {
            DiscRule::GaussLegendre(order) => tensor_points(order),
            DiscRule::Disc(n) => disc_points(n as usize),
        }
    }

    /// Polynomial degree that the rule integrates exactly, an axis (`gl`) or over the disc (`disc`).
    pub fn degree(self) -> u32 {
        match self {
            DiscRule::GaussLegendre(order) => order,
            DiscRule::Disc(n) => 2 * n - 2,
        }
    }

    /// Area that the rule gives the disc of radius r; the exact one is pi r^2.
    pub fn disc_area(self, radius: f64) -> f64 {
        self.points().iter().map(|point| point.weight).sum::<f64>() * radius * radius
    }
}

fn tensor_points(order: u32) -> Vec<DiscPoint> {
    let axis = gauss_legendre(order as usize / 2 + 1);
    let all = axis.iter().flat_map(|&(y, wy)| {
        axis.iter().map(move |&(x, wx)| DiscPoint { position: DVec2::new(x, y), weight: wx * wy })
    });
    all.filter(|point| point.position.length_squared() <= 1.0).collect()
}

fn disc_points(n: usize) -> Vec<DiscPoint> {
    let angles = 4 * n;
    let mut points = Vec::with_capacity(n * angles);
    for (ring, (x, weight)) in gauss_legendre(n).into_iter().enumerate() {
        let radius = 0.5 * (1.0 + x);
        for step in 0..angles {
            let turn = step as f64 + 0.25 + 0.5 * (ring % 2) as f64;
            let position = radius * DVec2::from_angle(2.0 * PI * turn / angles as f64);
            points.push(DiscPoint { position, weight: 0.5 * weight * radius * 2.0 * PI / angles as f64 });
        }
    }
    points
}

impl fmt::Display for DiscRule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            DiscRule::GaussLegendre(order) => write!(f, "gl{order}"),
            DiscRule::Disc(n) => write!(f, "disc{n}"),
        }
    }
}

impl FromStr for DiscRule {
    type Err = String;

    fn from_str(text: &str) -> Result<DiscRule, String> {
        let number = |digits: &str| {
            let n = digits.parse().ok().filter(|n| (1..=MAX_ORDER).contains(n));
            n.ok_or_else(|| format!("`{text}`: the number after the name must be 1 to {MAX_ORDER}"))
        };
        if let Some(digits) = text.strip_prefix("gl") {
            number(digits).map(DiscRule::GaussLegendre)
        } else if let Some(digits) = text.strip_prefix("disc") {
            number(digits).map(DiscRule::Disc)
        } else {
            Err(format!("`{text}` is no rule of the disc; take disc<n>, as disc16, or gl<order>, as gl30"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_over_the_disc_are_exact_to_the_degree() {
        // Of x^a y^b, a and b even: 2 / (a + b + 2) * the integral of cos^a sin^b over a quarter turn, four times.
        let sum = |rule: DiscRule, a: i32, b: i32| -> f64 {
            let term = |p: &DiscPoint| p.weight * p.position.x.powi(a) * p.position.y.powi(b);
            rule.points().iter().map(term).sum()
        };
        for n in [2, 3, 8] {
            let rule = DiscRule::Disc(n);
            assert!((sum(rule, 0, 0) - PI).abs() < 1e-14);
            assert!((sum(rule, 2, 0) - PI / 4.0).abs() < 1e-14 && (sum(rule, 0, 2) - PI / 4.0).abs() < 1e-14);
            assert!(sum(rule, 1, 0).abs() < 1e-14 && sum(rule, 1, 1).abs() < 1e-14);
        }
        assert!((sum(DiscRule::Disc(4), 4, 2) - PI / 64.0).abs() < 1e-14);
        assert!((sum(DiscRule::Disc(1), 2, 0) - PI / 4.0).abs() > 1e-3, "beyond its degree");
    }

    #[test]
    fn tensor_rule_is_the_papers() {
        let points = DiscRule::GaussLegendre(30).points();
        assert!(points.len() < 256 && points.len() > 120, "{} of 16 x 16", points.len());
        let error = |order: u32| (DiscRule::GaussLegendre(order).disc_area(1.0) / PI - 1.0).abs();
        assert!(error(30) < 0.04 && error(300) < 5e-3, "{} {}", error(30), error(300));
    }

    #[test]
    fn names_are_read_back() {
        for rule in [DiscRule::GaussLegendre(30), DiscRule::Disc(16)] {
            assert_eq!(rule.to_string().parse(), Ok(rule));
        }
        for text in ["gl0", "disc301", "ball8", "disc"] {
            assert!(text.parse::<DiscRule>().is_err(), "{text}");
        }
    }
}
