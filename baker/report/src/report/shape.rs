//! Shapes whose volume in the ball is known without a mesh.
//!
//! gamma* depends on the distance alone. Where that is the distance from a plane or from a point, the ball is cut in
//! discs or caps of equal distance, whose areas are elementary: Eq. 12 becomes an integral in one variable of piecewise
//! polynomials, which Gauss-Legendre on the pieces gives to rounding.

use glam::DVec3;
use std::f64::consts::PI;
use std::str::FromStr;
use volmap_bake::primitive::{PlacedPrimitive, Primitive};
use volmap_bake::volume_map::extension::extension;
use volmap_bake::volume_map::quadrature::{Rule, gauss_legendre};

/// A shape with a closed form. Inverted, solid and fluid change places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosedForm {
    /// Which.
    pub kind: ShapeKind,
    /// Inverted.
    pub invert: bool,
}

/// Kinds of shapes; lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeKind {
    /// Below the plane through `point`; `normal` is of length 1 and points into the fluid.
    HalfSpace {
        /// On the plane.
        point: DVec3,
        /// Outwards.
        normal: DVec3,
    },
    /// A ball.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
    /// A box along the axes.
    Box {
        /// Lowest corner.
        low: DVec3,
        /// Highest corner.
        high: DVec3,
    },
}

impl ClosedForm {
    /// That of a shape that was baked; none where its volume in the ball has no closed form, as of cylinders and of
    /// boxes that don't lie along the axes.
    pub fn of(placed: &PlacedPrimitive, invert: bool) -> Option<ClosedForm> {
        let centre = placed.centre();
        let along_axes = || {
            let entries = placed.turn().to_cols_array();
            entries.iter().all(|x| [0.0, 1.0].contains(&x.abs()))
        };
        let kind = match *placed.shape() {
            Primitive::Sphere { radius } => ShapeKind::Sphere { center: centre, radius },
            Primitive::Plane { normal, .. } => ShapeKind::HalfSpace { point: centre, normal: normal.into() },
            Primitive::Box { .. } if along_axes() => {
                let [low, high] = placed.bounds();
                ShapeKind::Box { low, high }
            }
            _ => return None,
        };
        Some(ClosedForm { kind, invert })
    }

    /// Signed distance, negative in the solid.
    pub fn distance(&self, x: DVec3) -> f64 {
        let distance = match self.kind {
            ShapeKind::HalfSpace { point, normal } => (x - point).dot(normal),
            ShapeKind::Sphere { center, radius } => x.distance(center) - radius,
            ShapeKind::Box { low, high } => {
                let outside = (low - x).max(x - high);
                outside.max(DVec3::ZERO).length() + outside.max_element().min(0.0)
            }
        };
        if self.invert { -distance } else { distance }
    }

    /// Eq. 12 of Bender et al. 2020 for a support radius r, m^3. Of a box the distance is in closed form and the
    /// integral by a converged rule.
    pub fn volume(&self, r: f64, x: DVec3) -> f64 {
        let phi = self.distance(x);
        match self.kind {
            // The disc at height t above the point has area pi (r^2 - t^2), and is phi + t from the solid.
            ShapeKind::HalfSpace { .. } => {
                let breaks = [-r, -phi, 0.5 * r - phi, r - phi, r];
                pieces(breaks, [-r, r], |t| PI * (r * r - t * t) * extension(phi + t, 1.0 / r))
            }
            ShapeKind::Sphere { center, radius } => self.near_sphere(r, x.distance(center), radius),
            ShapeKind::Box { .. } => {
                let rule = Rule::Chord(32).points();
                let gamma = |p: DVec3| extension(self.distance(x + r * p), 1.0 / r);
                r.powi(3) * rule.iter().map(|point| point.weight * gamma(point.position)).sum::<f64>()
            }
        }
    }

    /// Points of the ball at distance s from the sphere's centre, which is d away, form a cap of area
    /// pi s (r^2 - (s - d)^2) / d, or a whole sphere where that lies in the ball.
    fn near_sphere(&self, r: f64, d: f64, radius: f64) -> f64 {
        let sign = if self.invert { -1.0 } else { 1.0 };
        let area = |s: f64| match s <= r - d {
            true => 4.0 * PI * s * s,
            false => PI * s * (r * r - (s - d) * (s - d)) / d,
        };
        let breaks = [0.0, 0.5, 1.0].map(|part| radius + sign * part * r);
        let [solid, half, fluid] = breaks;
        let limits = [(d - r).max(0.0), d + r];
        pieces([solid, half, fluid, r - d, limits[1]], limits, |s| {
            area(s) * extension(sign * (s - radius), 1.0 / r)
        })
    }
}

/// Integral between the limits of what is smooth between the breaks.
fn pieces(mut breaks: [f64; 5], [low, high]: [f64; 2], f: impl Fn(f64) -> f64) -> f64 {
    breaks.iter_mut().for_each(|at| *at = at.clamp(low, high));
    breaks.sort_by(f64::total_cmp);
    let rule = gauss_legendre(12);
    let mut from = low;
    let mut sum = 0.0;
    for to in breaks.into_iter().chain([high]) {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        sum += half * rule.iter().map(|(x, w)| w * f(middle + half * x)).sum::<f64>();
        from = to;
    }
    sum
}

impl FromStr for ClosedForm {
    type Err = String;

    /// `sphere:x,y,z,radius`, `halfspace:x,y,z,nx,ny,nz` (a point and the outward normal) or
    /// `box:x,y,z,x,y,z` (two corners); `inverted-` before it exchanges solid and fluid.
    fn from_str(text: &str) -> Result<ClosedForm, String> {
        let usage = || {
            format!(
                "`{text}` is no shape; give sphere:x,y,z,radius, halfspace:x,y,z,nx,ny,nz or box:x0,y0,z0,x1,y1,z1 \
                 (metres), and inverted- before it for a container"
            )
        };
        let (invert, rest) = match text.strip_prefix("inverted-") {
            Some(rest) => (true, rest),
            None => (false, text),
        };
        let (name, list) = rest.split_once(':').ok_or_else(usage)?;
        let numbers: Result<Vec<f64>, _> = list.split(',').map(|field| field.trim().parse()).collect();
        let numbers = numbers.map_err(|_| usage())?;
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(usage());
        }
        let kind = match (name, numbers.as_slice()) {
            ("sphere", &[x, y, z, radius]) if radius > 0.0 => {
                ShapeKind::Sphere { center: DVec3::new(x, y, z), radius }
            }
            ("halfspace", &[x, y, z, a, b, c]) => {
                let normal = DVec3::new(a, b, c).try_normalize().ok_or_else(usage)?;
                ShapeKind::HalfSpace { point: DVec3::new(x, y, z), normal }
            }
            ("box", &[x, y, z, a, b, c]) => {
                let (low, high) = (DVec3::new(x, y, z), DVec3::new(a, b, c));
                if !low.cmplt(high).all() {
                    return Err(usage());
                }
                ShapeKind::Box { low, high }
            }
            _ => return Err(usage()),
        };
        Ok(ClosedForm { kind, invert })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed forms against a rule of the ball on the same distance; the rule's own error is the tolerance.
    #[test]
    fn volumes_are_those_of_a_fine_rule() {
        let r = 0.3;
        let ball = 4.0 / 3.0 * PI * r * r * r;
        let rule = Rule::Chord(48).points();
        for text in
            ["sphere:0,0,0,1", "inverted-sphere:0,0,0,1", "sphere:0,0,0,0.1", "halfspace:0,0,0.9,0,0,2"]
        {
            let shape: ClosedForm = text.parse().unwrap();
            for step in 0..60 {
                let x = DVec3::new(0.1, -0.05, 0.025 * f64::from(step));
                let gamma = |p: DVec3| extension(shape.distance(x + r * p), 1.0 / r);
                let sum: f64 = rule.iter().map(|p| p.weight * gamma(p.position)).sum();
                let (found, expected) = (shape.volume(r, x), r.powi(3) * sum);
                assert!((found - expected).abs() < 1e-4 * ball, "{text} at {x}: {found}, {expected}");
            }
        }
    }

    /// A baked sphere against the overlap of two spheres, and a report that measures it so by itself.
    #[test]
    fn a_baked_sphere_has_the_volume_of_the_closed_form() {
        use volmap_bake::bake::{BakeSettings, bake};
        use volmap_bake::input::{InputSettings, from_shape};
        use volmap_bake::settings::{GridChoice, MapSettings};
        use volmap_bake::watch::Watch;
        let settings = InputSettings::default();
        let input = from_shape(Primitive::Sphere { radius: 0.5 }, &settings).unwrap();
        let placed = input.placed_shape.unwrap();
        let (r, grid) = (0.2, GridChoice::CellSize(0.05));
        let rule = Rule::Chord(20);
        let map = MapSettings { support_radius: Some(r), grid, rule, ..MapSettings::default() };
        let baked =
            bake(input.clone(), &BakeSettings { map, ..BakeSettings::default() }, &Watch::default()).unwrap();
        let form = ClosedForm::of(&placed, false).unwrap();
        assert_eq!(form, "sphere:0,0,0,0.5".parse().unwrap());
        let opened = volmap_runtime::VolumeMap::from_asset(&baked.asset).unwrap();
        let ball = 4.0 / 3.0 * PI * r * r * r;
        for step in 0..40 {
            let x = (0.5 + r * (f64::from(step) / 20.0 - 1.0)) * DVec3::new(2.0, -1.0, 2.0) / 3.0;
            let error = (opened.values(x).volume - form.volume(r, x)) / ball;
            assert!(error.abs() < 3e-3, "{error} of the ball at {x}");
        }
        let small =
            crate::report::ReportSettings { points: 500, mesh_points: 50, pixels: 0, ..Default::default() };
        let report = crate::report::report(&baked.asset, Some(input), &small, &Watch::default()).unwrap();
        let json = serde_json::to_string(&report.findings).unwrap();
        assert!(json.contains("closed form of the shape"), "the closed form is a reference");
    }

    #[test]
    fn volumes_far_in_and_out_are_full_and_empty() {
        let ball = 4.0 / 3.0 * PI;
        let shape: ClosedForm = "sphere:0,0,0,5".parse().unwrap();
        assert!((shape.volume(1.0, DVec3::new(0.0, 3.9, 0.0)) - ball).abs() < 1e-12 * ball);
        assert_eq!(shape.volume(1.0, DVec3::new(0.0, 7.1, 0.0)), 0.0);
        assert!((shape.volume(1.0, DVec3::ZERO) - ball).abs() < 1e-12 * ball);
        let tank: ClosedForm = "inverted-box:-1,-1,-1,1,1,1".parse().unwrap();
        assert_eq!((tank.distance(DVec3::ZERO), tank.distance(DVec3::splat(2.0))), (1.0, -(3f64.sqrt())));
    }

    #[test]
    fn shapes_that_are_none_are_refused() {
        for text in [
            "",
            "sphere",
            "sphere:1,2,3",
            "sphere:0,0,0,-1",
            "cone:0,0,0,1",
            "halfspace:0,0,0,0,0,0",
            "box:0,0,0,1,1,0",
            "sphere:0,0,0,inf",
        ] {
            assert!(text.parse::<ClosedForm>().is_err(), "{text}");
        }
    }
}
