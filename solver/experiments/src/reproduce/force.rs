//! Pressure force on one particle near the unit cube by density maps and volume maps of few and of many cells: Bender
//! et al. 2020, Fig. 10.

use super::methods::Method;
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_bake::plan::GridChoice;
use volmap_figures::picture::Series;
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure};
use volmap_fluid::shapes::{baked_by, cuboid};
use volmap_runtime::{ClosureKind, DVec3};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "force",
    title: "Pressure force near a plane, Bender Fig. 10",
    about: "A particle moves towards the unit cube's face, along it, and over its edge: jumps and ripples of the force",
    run,
};

/// Particle radius rp and the support radius, metres.
const RADIUS: f64 = 0.025;
const SUPPORT: f64 = 4.0 * RADIUS;
/// Cells across the map; none: as many as scenes bake.
const RESOLUTIONS: [Option<u32>; 4] = [Some(10), Some(20), Some(60), None];
/// Intervals along a way.
const SAMPLES: usize = 8000;

/// The ways, all above the face y = 0 and off the lattices' lines.
const WAYS: [Way; 3] = [
    Way { name: "to the face", begin: [0.0137, 1.2 * SUPPORT, 0.0291], end: [0.0137, 0.0, 0.0291] },
    Way { name: "along the face", begin: [-0.35, RADIUS, 0.0291], end: [0.35, RADIUS, 0.0291] },
    Way { name: "over the edge", begin: [0.35, RADIUS, 0.0291], end: [0.5 + SUPPORT, RADIUS, 0.0291] },
];

/// A straight way of a particle, metres.
struct Way {
    name: &'static str,
    begin: [f64; 3],
    end: [f64; 3],
}

fn methods() -> [Method; 4] {
    let own = BoundaryPressure::Own;
    let [paper, calibrated, mirror] = [ClosureKind::Paper, ClosureKind::Calibrated, ClosureKind::Mirror]
        .map(|closure| Method::maps(closure, own));
    [Method::of(BoundaryMethod::DensityMap, own), paper, calibrated, mirror]
}

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    for method in methods() {
        let mut curves = [Vec::new(), Vec::new(), Vec::new()];
        for (n, cells) in RESOLUTIONS.into_iter().enumerate() {
            if run.short && cells.is_none_or(|cells| cells > 20) {
                continue;
            }
            let grid = cells.map_or("as scenes".into(), |cells| format!("{cells} cells"));
            (run.progress)(&format!("force: {}, {grid}", method.view()));
            let forces = forces(&method, cells)?;
            for ((way, curves), Forces { places, forces }) in WAYS.iter().zip(&mut curves).zip(forces) {
                let case = format!("{}, {grid}: {}", method.view(), way.name);
                outcome.rows.extend(rows(&case, &forces));
                let points = places.iter().zip(&forces).map(|(&x, force)| [x / RADIUS, force.y]);
                curves.push(thinned(grid.clone(), DISTINCT[n], points.collect()));
            }
        }
        let name = method.view().replace("volume map, ", "").replace(' ', "_");
        let [to, along, _] = curves;
        let axis = ["r grad rho_B / rho_0 along the normal", ""];
        let title = format!("Force by {}", method.view());
        outcome.chart(format!("force-{name}.png"), chart(&title, ["Distance from the face", "rp"], axis, to));
        outcome.chart(
            format!("force-{name}-along.png"),
            chart(&title, ["Way along the face", "rp"], axis, along),
        );
    }
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    The unit cube with r = 0.1 m. The force on a particle of given pressure is -2 p / rho_0 times the gradient of \
    rho_B / rho_0 (Eq. 15 with the particle's pressure mirrored), so that gradient times r is shown. Cells are those \
    of the map's whole box: the cube and 2 support radii of the map around it. 10 cells are 1.4 r wide; those of \
    `mirror`, whose maps have a quarter of the radius, 1.1 r. Scenes take r / 4, and r / 8 for `mirror`. A jump is \
    the change in a step of 8,000 along the way beyond the changes in both neighbouring steps; the exact force has \
    none on any of the ways. The force of `paper` falls to 0 at the face by itself.";

/// Forces along a way.
struct Forces {
    /// Places along the way, metres.
    places: Vec<f64>,
    forces: Vec<DVec3>,
}

/// The forces along each of [`WAYS`].
fn forces(method: &Method, cells: Option<u32>) -> Result<Vec<Forces>, Error> {
    let mut settings = method.baking(SUPPORT, false);
    settings.grid = cells.map_or(settings.grid, |cells| GridChoice::Resolution([cells; 3]));
    let cube = baked_by(cuboid(DVec3::new(-0.5, -1.0, -0.5), DVec3::new(0.5, 0.0, 0.5)), settings)?;
    let on_way = |way: &Way| {
        let (begin, end) = (DVec3::from(way.begin), DVec3::from(way.end));
        let places: Vec<DVec3> = (0..=SAMPLES).map(|n| begin.lerp(end, n as f64 / SAMPLES as f64)).collect();
        let body = cube.body("cube", DVec3::ZERO, Motion::Static);
        let walls = method.walls(RADIUS, vec![body], &places)?;
        let axis = usize::from(begin.y == end.y);
        let along = places.iter().map(|x| if axis == 0 { x.y } else { x.x }).collect();
        let force = |gradient: [f32; 3]| -SUPPORT * DVec3::from_array(gradient.map(f64::from));
        Ok(Forces { places: along, forces: walls.iter().map(|wall| force(wall.gradient)).collect() })
    };
    WAYS.iter().map(on_way).collect()
}

/// A curve of every fourth point.
fn thinned(name: String, colour: [u8; 3], points: Vec<[f64; 2]>) -> Series {
    curve(name, colour, points.into_iter().step_by(4).collect())
}

fn rows(case: &str, forces: &[DVec3]) -> Vec<Row> {
    let largest = forces.iter().map(|force| force.length()).fold(0.0, f64::max);
    let normal: Vec<f64> = forces.iter().map(|force| force.y).collect();
    let [low, high] =
        [f64::min, f64::max].map(|pick| normal.iter().copied().reduce(pick).unwrap_or(f64::NAN));
    let sideways = forces.iter().map(|force| force.with_y(0.0).length()).fold(0.0, f64::max);
    let told = |quantity: &str, unit, value| Row::new(case, quantity, unit, value);
    let mut rows = vec![
        told("largest force", "", largest),
        told("largest jump over it", "%", 100.0 * largest_jump(forces) / largest),
    ];
    if case.ends_with("along the face") {
        let mean = normal.iter().sum::<f64>() / normal.len() as f64;
        rows.push(told("normal force, most less least over its mean", "%", 100.0 * (high - low) / mean));
        rows.push(told("force along the face over the mean", "%", 100.0 * sideways / mean));
    }
    if case.ends_with("to the face") {
        let backwards = normal.windows(2).map(|pair| (pair[0] - pair[1]).max(0.0)).sum::<f64>();
        rows.push(told("falls on the way over it, all together", "%", 100.0 * backwards / largest));
    }
    rows
}

/// The largest change between neighbours beyond those before and after it.
fn largest_jump(forces: &[DVec3]) -> f64 {
    let changes: Vec<f64> = forces.windows(2).map(|pair| (pair[1] - pair[0]).length()).collect();
    changes.windows(3).map(|three| three[1] - three[0].max(three[2])).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_seen_and_slopes_are_not() {
        let ramp = |jump: f64| -> Vec<DVec3> {
            (0..100).map(|n| DVec3::Y * (f64::from(n) * 0.1 + if n > 50 { jump } else { 0.0 })).collect()
        };
        assert!(largest_jump(&ramp(0.0)) < 1e-12);
        assert!((largest_jump(&ramp(0.7)) - 0.7).abs() < 1e-12);
    }
}
