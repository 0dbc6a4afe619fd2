//! Quadrature over the ball of the support radius.
//!
//! - `gl<p>`, the paper's: a tensor product of Gauss-Legendre rules over the cube [-r, r]^3, points outside the ball
//!   left out (Bender et al. 2020, section 5). Order p means exact for polynomials of degree p an axis, so
//!   floor(p / 2) + 1 points an axis: 16 for order 30, the paper's 4,096 points.
//! - `ball<n>`: a product rule of the ball itself (Stroud 1971, *Approximate Calculation of Multiple Integrals*,
//!   section 2.6): Gauss-Jacobi in the radius with weight s^2, n Gauss-Legendre points in cos theta, 2 n equispaced
//!   in phi. Exact for the volume; its error doesn't come from the ball's edge.
//! - `chord<n>`, a product rule of the ball too, made of chords along x: n Gauss-Legendre points on each, and for the
//!   chords a rule of the disc, Gauss-Jacobi in the squared distance t from the axis with the chords' weight
//!   (1 - t)^(1/2), ceil(n/2) of them, and ceil(5n/4) equispaced azimuths, turned by half a step from one distance to
//!   the next. As accurate as `ball<n>` with less than half of the points, and points in a row cost the lattice little.

use glam::DVec3;
use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

/// Which rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Tensor Gauss-Legendre of this polynomial order, masked by the ball.
    GaussLegendre(u32),
    /// Product rule of the ball with this many points in cos theta.
    Ball(u32),
    /// Product rule of the ball with this many points on each chord.
    Chord(u32),
}

impl Default for Rule {
    fn default() -> Self {
        Rule::Chord(8)
    }
}

/// Highest order and number that [`Rule`] takes.
const MAX_ORDER: u32 = 300;
const MAX_BALL: u32 = 128;

/// A point of a rule for the unit ball, and its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Place in the unit ball.
    pub position: DVec3,
    /// Weight; the weights of a rule sum to about 4/3 pi.
    pub weight: f64,
}

impl Rule {
    /// The points inside the unit ball, in a fixed order.
    pub fn points(self) -> Vec<Point> {
        match self {
            Rule::GaussLegendre(order) => tensor_points(order),
            Rule::Ball(n) => ball_points(n),
            Rule::Chord(n) => chord_points(n as usize),
        }
    }

    /// Polynomial degree that the rule integrates exactly, an axis (`gl`) or over the ball (`ball`, `chord`).
    pub fn degree(self) -> u32 {
        match self {
            Rule::GaussLegendre(order) => order,
            Rule::Ball(n) => (2 * n - 1).min(2 * (3 * n).div_ceil(4) - 1),
            Rule::Chord(n) => (2 * n - 1).min((5 * n).div_ceil(4) - 1),
        }
    }

    /// Volume that the rule gives the ball of radius r; the exact one is 4/3 pi r^3.
    pub fn ball_volume(self, radius: f64) -> f64 {
        self.points().iter().map(|point| point.weight).sum::<f64>() * radius.powi(3)
    }
}

/// The points along a curve on which neighbours lie close together (Morton 1966), for searches that profit from it.
pub fn along_curve(mut points: Vec<Point>) -> Vec<Point> {
    // Bits of the three coordinates in turn, the highest first.
    let place = |point: &Point| {
        let cell = ((point.position + 1.0) * 512.0).clamp(DVec3::ZERO, DVec3::splat(1023.0)).as_uvec3();
        (0..30).rev().fold(0, |code, bit| code << 1 | cell[bit % 3] >> (bit / 3) & 1)
    };
    points.sort_by_cached_key(place);
    points
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Rule::GaussLegendre(order) => write!(f, "gl{order}"),
            Rule::Ball(n) => write!(f, "ball{n}"),
            Rule::Chord(n) => write!(f, "chord{n}"),
        }
    }
}

impl FromStr for Rule {
    type Err = String;

    fn from_str(text: &str) -> Result<Rule, String> {
        let number = |digits: &str, max: u32| {
            let n = digits.parse().ok().filter(|n| (1..=max).contains(n));
            n.ok_or_else(|| format!("`{text}`: the number after the name must be 1 to {max}"))
        };
        if let Some(digits) = text.strip_prefix("gl") {
            number(digits, MAX_ORDER).map(Rule::GaussLegendre)
        } else if let Some(digits) = text.strip_prefix("ball") {
            number(digits, MAX_BALL).map(Rule::Ball)
        } else if let Some(digits) = text.strip_prefix("chord") {
            number(digits, MAX_BALL).map(Rule::Chord)
        } else {
            Err(format!(
                "`{text}` is no quadrature; take gl<order>, as gl30, chord<n>, as chord8, or ball<n>, as ball8"
            ))
        }
    }
}

fn tensor_points(order: u32) -> Vec<Point> {
    let axis = gauss_legendre(order as usize / 2 + 1);
    let mut points = Vec::new();
    for &(z, wz) in &axis {
        for &(y, wy) in &axis {
            for &(x, wx) in &axis {
                let position = DVec3::new(x, y, z);
                if position.length_squared() <= 1.0 {
                    points.push(Point { position, weight: wx * wy * wz });
                }
            }
        }
    }
    points
}

fn ball_points(n: u32) -> Vec<Point> {
    let n = n as usize;
    let radii = gauss_radius((3 * n).div_ceil(4));
    let cosines = gauss_legendre(n);
    let mut points = Vec::new();
    for &(s, ws) in &radii {
        for &(cosine, wc) in &cosines {
            let across = s * (1.0 - cosine * cosine).sqrt();
            for step in 0..2 * n {
                let (sin, cos) = (PI * (step as f64 + 0.5) / n as f64).sin_cos();
                let position = DVec3::new(across * cos, across * sin, s * cosine);
                points.push(Point { position, weight: ws * wc * PI / n as f64 });
            }
        }
    }
    points
}

fn chord_points(n: usize) -> Vec<Point> {
    let azimuths = (5 * n).div_ceil(4);
    let on_chord = gauss_legendre(n);
    let mut points = Vec::new();
    for (ring, (x, factor)) in gauss_jacobi(n.div_ceil(2), 0.5).into_iter().enumerate() {
        // With 1 - t = (1 + x) / 2 the weight is ((1 + x) / 2)^(1/2), whose Jacobi weights are the factors.
        let (half_length, from_axis) = ((0.5 * (1.0 + x)).sqrt(), (0.5 * (1.0 - x)).sqrt());
        for step in 0..azimuths {
            let turn = step as f64 + 0.25 + 0.5 * (ring % 2) as f64;
            let (sin, cos) = (2.0 * PI * turn / azimuths as f64).sin_cos();
            for &(along, weight) in &on_chord {
                let position = DVec3::new(half_length * along, from_axis * cos, from_axis * sin);
                points.push(Point { position, weight: 0.5 * factor * 2.0 * PI / azimuths as f64 * weight });
            }
        }
    }
    points
}

/// Nodes and weights of the n-point Gauss-Legendre rule on [-1, 1], ascending.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    gauss_jacobi(n, 0.0).into_iter().map(|(x, factor)| (x, 2.0 * factor)).collect()
}

/// Nodes and weights of the n-point Gauss rule for the integral of s^2 f(s) over [0, 1], ascending.
fn gauss_radius(n: usize) -> Vec<(f64, f64)> {
    // With s = (1 + x) / 2 the weight is (1 + x)^2 / 8, whose Jacobi weights are 8 times the factor.
    gauss_jacobi(n, 2.0).into_iter().map(|(x, factor)| (0.5 * (1.0 + x), factor)).collect()
}

/// Roots x of the Jacobi polynomial P_n^(0, beta), ascending, with 1 / ((1 - x^2) P_n'(x)^2).
/// Hale and Townsend 2013, Eq. 2.6, for alpha = 0, where the constant is 2^(beta + 1).
fn gauss_jacobi(n: usize, beta: f64) -> Vec<(f64, f64)> {
    let mut rule = Vec::with_capacity(n);
    // The roots interlace in theta with spacing of about pi / n: a scan this fine brackets every one.
    let steps = 16 * n + 16;
    let at = |step: usize| -(PI * step as f64 / steps as f64).cos();
    let mut below = (at(0), jacobi(n, beta, at(0)).0);
    for step in 1..=steps {
        let above = (at(step), jacobi(n, beta, at(step)).0);
        if below.1 == 0.0 || below.1 * above.1 < 0.0 {
            let x = root(n, beta, below.0, above.0);
            let slope = jacobi(n, beta, x).1;
            rule.push((x, 1.0 / ((1.0 - x * x) * slope * slope)));
        }
        below = above;
    }
    debug_assert_eq!(rule.len(), n);
    rule
}

/// Newton's method, held in the bracket by bisection.
fn root(n: usize, beta: f64, mut low: f64, mut high: f64) -> f64 {
    let sign_low = jacobi(n, beta, low).0.signum();
    let mut x = 0.5 * (low + high);
    for _ in 0..100 {
        let (value, slope) = jacobi(n, beta, x);
        if value.signum() == sign_low {
            low = x;
        } else {
            high = x;
        }
        let newton = x - value / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= f64::EPSILON * x.abs() {
            return next;
        }
        x = next;
    }
    x
}

/// P_n^(0, beta)(x) and its derivative, by the three-term recurrence (Abramowitz and Stegun 22.7.1, 22.8.1).
fn jacobi(n: usize, beta: f64, x: f64) -> (f64, f64) {
    let (mut previous, mut current) = (1.0, 0.5 * ((beta + 2.0) * x - beta));
    if n == 0 {
        return (1.0, 0.0);
    }
    for m in 1..n {
        let m = m as f64;
        let s = 2.0 * m + beta;
        let a = 2.0 * (m + 1.0) * (m + beta + 1.0) * s;
        let b = (s + 1.0) * (-beta * beta + s * (s + 2.0) * x);
        let c = 2.0 * m * (m + beta) * (s + 2.0);
        (previous, current) = (current, (b * current - c * previous) / a);
    }
    let n = n as f64;
    let s = 2.0 * n + beta;
    let slope = (n * (-beta - s * x) * current + 2.0 * n * (n + beta) * previous) / (s * (1.0 - x * x));
    (current, slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gauss_legendre_is_exact_to_rounding_up_to_64_points() {
        for n in 1..=64 {
            let rule = gauss_legendre(n);
            assert_eq!(rule.len(), n);
            // x^k to its exact integral.
            for k in (0..2 * n as i32).step_by(2) {
                let integral: f64 = rule.iter().map(|(x, w)| w * x.powi(k)).sum();
                assert!((integral - 2.0 / f64::from(k + 1)).abs() < 1e-14, "n {n}, x^{k}: {integral}");
            }
            for (a, b) in rule.iter().zip(rule.iter().rev()) {
                assert!((a.0 + b.0).abs() < 1e-15 && (a.1 - b.1).abs() < 1e-14, "n {n} not symmetric");
            }
        }
    }

    #[test]
    fn gauss_legendre_is_that_of_40_digits() {
        let mut rows = 0;
        for line in include_str!("../../tests/data/gauss_legendre.csv").lines().skip(1) {
            let numbers: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            let [n, x, w] = numbers[..] else { panic!("{line}") };
            let rule = gauss_legendre(n as usize);
            let found = rule.iter().find(|(node, _)| (node - x).abs() < 1e-14);
            let (_, weight) = found.unwrap_or_else(|| panic!("n {n}: no node {x}"));
            assert!((weight - w).abs() < 1e-14, "n {n}: weight {weight} of node {x}");
            rows += 1;
        }
        assert_eq!(rows, (1..=64usize).map(|n| n.div_ceil(2)).sum::<usize>());
    }

    #[test]
    fn radial_rule_is_exact() {
        for n in 1..=32 {
            let rule = gauss_radius(n);
            for k in 0..2 * n as i32 {
                let integral: f64 = rule.iter().map(|(s, w)| w * s.powi(k)).sum();
                assert!((integral - 1.0 / f64::from(k + 3)).abs() < 1e-14, "n {n}, s^{k}");
            }
        }
    }

    #[test]
    fn rules_have_the_points_and_volumes_of_the_design_notes() {
        let relative = |rule: Rule| rule.ball_volume(1.0) / (4.0 / 3.0 * PI) - 1.0;
        for (order, points, error) in [(30, 1008, 0.026), (50, 3952, -0.0087), (100, 29103, -0.00026)] {
            let rule = Rule::GaussLegendre(order);
            assert_eq!(rule.points().len(), points);
            assert!((relative(rule) - error).abs() < 0.03 * error.abs(), "{rule}: {}", relative(rule));
        }
        for (n, points) in [(6, 360), (8, 768), (10, 1600)] {
            assert_eq!(Rule::Ball(n).points().len(), points);
            assert!(relative(Rule::Ball(n)).abs() < 1e-14);
        }
        for (n, points) in [(1, 2), (4, 40), (6, 144), (8, 320), (12, 1080)] {
            assert_eq!(Rule::Chord(n).points().len(), points);
            assert!(relative(Rule::Chord(n)).abs() < 1e-14);
        }
    }

    #[test]
    fn half_space_errors_are_those_of_the_design_notes() {
        // Integral of gamma* over the ball at height d above the half space, r = 1, by a 1-D rule that is exact.
        let exact = |d: f64| {
            let mut sum = 0.0;
            let breaks = [-1.0f64, -d, 0.5 - d, 1.0 - d, 1.0].map(|z| z.clamp(-1.0, 1.0));
            for piece in breaks.windows(2) {
                let (middle, half) = (0.5 * (piece[0] + piece[1]), 0.5 * (piece[1] - piece[0]));
                for (x, w) in gauss_legendre(8) {
                    let z = middle + half * x;
                    let disc = PI * (1.0 - z * z);
                    sum += half * w * disc * crate::volume_map::extension::extension(d + z, 1.0);
                }
            }
            sum
        };
        let worst = |rule: Rule| {
            let points = rule.points();
            let error = |step: i32| {
                let d = f64::from(step) * 0.01 - 1.0;
                let g = |p: &Point| crate::volume_map::extension::extension(d + p.position.y, 1.0);
                let sum: f64 = points.iter().map(|p| p.weight * g(p)).sum();
                (sum - exact(d)).abs() / (4.0 / 3.0 * PI)
            };
            (0..300).map(error).fold(0.0, f64::max)
        };
        for (rule, limit) in [
            (Rule::GaussLegendre(30), 0.0265),
            (Rule::GaussLegendre(100), 0.0004),
            (Rule::Ball(6), 0.002),
            (Rule::Ball(10), 0.0005),
            (Rule::Ball(24), 0.00003),
            (Rule::Chord(6), 0.0035),
            (Rule::Chord(8), 0.0015),
            (Rule::Chord(12), 0.0006),
        ] {
            assert!(worst(rule) < limit, "{rule}: {}", worst(rule));
        }
    }

    #[test]
    fn rules_of_the_ball_are_exact_to_their_degree() {
        // The integral of x^a y^b z^c over the unit ball, a, b, c even: Folland 2001.
        let gamma_half =
            |k: i32| (1..k).filter(|i| (i + k) % 2 == 0).map(|i| f64::from(i) / 2.0).product::<f64>();
        let root_pi = |k: i32| if k % 2 == 1 { PI.sqrt() } else { 1.0 };
        let gamma = |k: i32| gamma_half(k) * root_pi(k);
        let exact = |[a, b, c]: [i32; 3]| {
            let sum = a + b + c;
            2.0 * gamma(a + 1) * gamma(b + 1) * gamma(c + 1) / gamma(sum + 3) / f64::from(sum + 3)
        };
        for rule in [Rule::Ball(3), Rule::Ball(6), Rule::Chord(4), Rule::Chord(7), Rule::Chord(8)] {
            let (points, degree) = (rule.points(), rule.degree() as i32);
            for powers in (0..=degree).flat_map(|a| (0..=degree - a).map(move |b| (a, b))) {
                for c in 0..=degree - powers.0 - powers.1 {
                    let powers = [powers.0, powers.1, c];
                    let term = |p: &Point| (0..3).map(|i| p.position[i].powi(powers[i])).product::<f64>();
                    let sum: f64 = points.iter().map(|p| p.weight * term(p)).sum();
                    let expected = if powers.iter().any(|k| k % 2 == 1) { 0.0 } else { exact(powers) };
                    assert!((sum - expected).abs() < 1e-14, "{rule} {powers:?}: {sum} {expected}");
                }
            }
        }
    }

    #[test]
    fn names_round_trip() {
        for name in ["gl30", "gl1", "gl100", "ball8", "chord8"] {
            assert_eq!(name.parse::<Rule>().unwrap().to_string(), name);
        }
        for name in ["gl", "gl0", "gl-3", "gl301", "ball", "ball129", "chord0", "simpson", ""] {
            assert!(name.parse::<Rule>().is_err(), "{name}");
        }
    }
}
