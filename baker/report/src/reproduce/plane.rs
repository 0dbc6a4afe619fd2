//! Section 5 of Bender et al. 2020: a particle of radius 0.01 m "was moved in small steps towards a planar boundary
//! until it touches the boundary"; the mean difference of the map's volume (10^3 cells) to the exact intersection of
//! its ball with the half space was 0.000016 m^3.
//!
//! The difference has two parts: gamma* counts fluid within r of the boundary as solid in part, so that Eq. 12 is not
//! the intersection; and the map is not Eq. 12.

use super::{baked, outcome, row, unit_cube_input};
use crate::error::Error;
use crate::experiments::Outcome;
use crate::report::shape::{ClosedForm, ShapeKind};
use glam::DVec3;
use std::f64::consts::PI;
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_bake::watch::Watch;
use volmap_formats::text::number;
use volmap_runtime::VolumeMap;

/// The rule of all of the paper's maps.
const PAPER_RULE: Rule = Rule::GaussLegendre(30);
/// The paper's mean error, m^3.
const PAPER_MEAN: f64 = 1.6e-5;

/// What is measured.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneSettings {
    /// Cells along each axis.
    pub cells: u32,
    /// Radius of the particle, metres; the support radius is four of it.
    pub particle_radius: f64,
    /// Steps of the way.
    pub steps: u32,
}

impl Default for PlaneSettings {
    fn default() -> PlaneSettings {
        PlaneSettings { cells: 10, particle_radius: 0.01, steps: 1000 }
    }
}

/// Means of sizes over the way, m^3.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Means {
    /// Map against the exact intersection.
    pub all: f64,
    /// Eq. 12, exact, against the exact intersection.
    pub extension: f64,
    /// Map against Eq. 12, exact.
    pub map: f64,
    /// The same with its sign: with the part of the extension function it sums up to the signed mean of all.
    pub map_signed: f64,
}

/// Runs the experiment.
///
/// # Errors
/// Settings that can't be used; cancelled.
pub fn measure(settings: &PlaneSettings, watch: &Watch) -> Result<Outcome, Error> {
    watch.step("moving a particle to a plane")?;
    let (n, r) = (settings.cells, 4.0 * settings.particle_radius);
    let mut rows = Vec::new();
    let mut signed = Vec::new();
    for rule in [PAPER_RULE, Rule::default()] {
        let means = means(settings, rule, 2.0 * r, watch)?;
        let of_rule =
            |name: &str, paper, ours| row(format!("{name}, {n}^3 cells, {rule}"), "m^3", paper, ours);
        if rows.is_empty() {
            let from_r = self::means(settings, rule, r, watch)?;
            rows.push(row("mean error by the extension function alone", "m^3", None, means.extension));
            rows.push(row("the same, on the way from r on", "m^3", None, from_r.extension));
        }
        rows.push(of_rule("mean error", Some(PAPER_MEAN), means.all));
        rows.push(of_rule("mean error by the map alone", None, means.map));
        signed.push(format!("{} m^3 ({rule})", number(means.map_signed)));
    }
    let paper_way = paper_way(settings, rows[2].measured);
    rows.push(row("length of the way that would give the paper's mean", "m", None, paper_way));
    Ok(outcome(rows, assumed(settings, &signed)))
}

fn assumed(settings: &PlaneSettings, signed: &[String]) -> Vec<String> {
    let PlaneSettings { particle_radius, cells, steps } = settings;
    vec![
        format!(
            "the way: from 2 r, where the map's volume begins, to {particle_radius} m, where the particle touches, in \
             {steps} steps; the paper doesn't say where it began. Beyond 2 r both volumes are 0, so a longer way \
             lowers the mean; before r the exact one is 0"
        ),
        format!(
            "the plane: a face of the unit cube of Fig. 10, {cells}^3 cells over everything within 2 r of it"
        ),
        format!(
            "the parts are means of sizes. The extension function's is never negative; the map's with its sign is {}, \
             and signed parts add up",
            signed.join(", ")
        ),
    ]
}

/// How far away the way must begin for the paper's mean: beyond 2 r nothing is added to the sum.
fn paper_way(settings: &PlaneSettings, mean: f64) -> f64 {
    7.0 * settings.particle_radius * mean / PAPER_MEAN
}

/// On the way from this distance until the particle touches.
fn means(settings: &PlaneSettings, rule: Rule, start: f64, watch: &Watch) -> Result<Means, Error> {
    let r = 4.0 * settings.particle_radius;
    let map = MapSettings {
        support_radius: Some(r),
        grid: GridChoice::Resolution([settings.cells; 3]),
        rule,
        ..MapSettings::default()
    };
    let asset = baked(unit_cube_input()?, map, watch)?.asset;
    let map = VolumeMap::from_asset(&asset)?;
    let plane =
        ClosedForm { kind: ShapeKind::HalfSpace { point: 0.5 * DVec3::X, normal: DVec3::X }, invert: false };
    let steps = f64::from(settings.steps);
    let mut means = Means::default();
    for step in 0..settings.steps {
        let part = (f64::from(step) + 0.5) / steps;
        let distance = start + part * (settings.particle_radius - start);
        let x = DVec3::new(0.5 + distance, 0.0, 0.0);
        let (ours, extended, exact) = (map.values(x).volume, plane.volume(r, x), cap(r, distance));
        means.all += (ours - exact).abs() / steps;
        means.extension += (extended - exact).abs() / steps;
        means.map += (ours - extended).abs() / steps;
        means.map_signed += (ours - extended) / steps;
    }
    Ok(means)
}

/// Part of a ball that lies beyond a plane at this distance from its centre, which is outside, m^3.
fn cap(r: f64, distance: f64) -> f64 {
    let height = (r - distance).max(0.0);
    PI * height * height * (3.0 * r - height) / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn caps_are_half_a_ball_and_nothing() {
        assert!((cap(0.3, 0.0) - 2.0 / 3.0 * PI * 0.027).abs() < 1e-15);
        assert_eq!((cap(0.3, 0.3), cap(0.3, 0.5)), (0.0, 0.0));
        // By layers of discs.
        let disc = |i: u32| {
            let t = 0.1 + 0.2 * (f64::from(i) + 0.5) / 1e4;
            PI * (0.09 - t * t) * 0.2 / 1e4
        };
        assert!((cap(0.3, 0.1) - (0..10_000).map(disc).sum::<f64>()).abs() < 1e-9);
    }

    /// A plane, so the volume depends on the distance alone; with cells of r / 4 the map is nearly Eq. 12, and the mean
    /// is the extension function's: 2.797e-5 m^3 by a quadrature of its own.
    #[test]
    fn a_fine_map_leaves_the_error_of_the_extension_function() {
        let fine = PlaneSettings { cells: 60, steps: 200, ..PlaneSettings::default() };
        let found = means(&fine, Rule::Chord(12), 0.08, &Watch::default()).unwrap();
        assert!((found.extension - 2.797e-5).abs() < 1e-8, "{found:?}");
        let ball = 4.0 / 3.0 * PI * 0.04f64.powi(3);
        assert!(found.map < 0.002 * ball && (found.all - found.extension).abs() <= found.map, "{found:?}");
    }

    #[test]
    fn parts_of_the_coarse_map_add_up() {
        let settings = PlaneSettings { steps: 200, ..PlaneSettings::default() };
        let Outcome { rows, .. } = measure(&settings, &Watch::default()).unwrap();
        let ours: Vec<f64> = rows.iter().map(|row| row.measured).collect();
        let [extension, from_r, paper, paper_map, default, default_map, way] = ours[..] else {
            panic!("{rows:?}")
        };
        assert!((from_r - 5.812e-5).abs() < 2e-8 && from_r > extension);
        for (all, map) in [(paper, paper_map), (default, default_map)] {
            assert!(all <= extension + map && all >= extension - map && map > 1e-7, "{rows:?}");
        }
        assert!((way * PAPER_MEAN - 0.07 * paper).abs() < 1e-12);
        assert_eq!(rows.iter().filter(|row| row.paper == Some(PAPER_MEAN)).count(), 2);
    }
}
