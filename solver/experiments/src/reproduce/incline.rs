//! Single particles slide down a plane: Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*, Fig. 7. A
//! plane made of particles is bumpy and throws them about, a map is smooth.

use super::boundaries::{BLUE_NOISE, DENSITY_MAP, Named, PAPER_MAP, PARTICLES, VOLUME_MAP};
use crate::validation::flow::GRAVITY;
use crate::validation::incline::{RP, starts, turned};
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::shapes::cuboid;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "incline",
    title: "Inclined plane",
    about: "Single particles dropped on a slope: how far they are thrown aside, on boundary particles and on maps",
    run,
};

/// Angle of the plane.
const DEGREES: f64 = 30.0;
/// How far a particle slides without friction, metres.
const WAY: f64 = 3.0;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let (mut paths, mut heights) = (Vec::new(), Vec::new());
    let methods = run.pick(
        &[BLUE_NOISE, PARTICLES, VOLUME_MAP][..],
        &[BLUE_NOISE, PARTICLES, DENSITY_MAP, PAPER_MAP, VOLUME_MAP],
    );
    for (method, colour) in methods.iter().zip(DISTINCT) {
        (run.progress)(&format!("incline: {}", method.name));
        let slide = slide(run, method)?;
        slide.rows(&mut outcome, method.name);
        let part = |pick: fn(&DVec3) -> [f64; 2]| slide.path(pick);
        paths.push(curve(method.name, colour, part(|way| [-way.x, way.z / RP])));
        heights.push(curve(method.name, colour, part(|way| [-way.x, way.y / RP])));
    }
    let across = ["Way down", "m"];
    let axes = [across, ["To the side", "rp"]];
    outcome.chart("incline-paths.png", chart("Particles on a slope, from above", axes[0], axes[1], paths));
    let axes = [across, ["Height over the plane", "rp"]];
    outcome.chart(
        "incline-heights.png",
        chart("Particles on a slope, from the side", axes[0], axes[1], heights),
    );
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    64 particles of rp = 25 mm, 4.3 rp apart, so that each is alone, dropped from 1.2 rp; 30 degrees, 3 m. The paper \
    shows pictures and gives no figures; it doesn't name the size of its grid.";

/// The particles' ways at all steps, in the plane's axes: up the slope from the start, height, to the side.
struct Slide {
    steps: Vec<Vec<DVec3>>,
    /// How far they should have come, metres.
    ideal: f64,
}

fn slide(run: &Run, method: &Named) -> Result<Slide, Error> {
    let plane = method.baked(cuboid(DVec3::new(-3.0, -0.15, -1.0), DVec3::new(2.0, 0.0, 1.0)), RP, false)?;
    let (body, rotation) = turned(&plane, DEGREES);
    let starts = starts(1.0);
    let mut setup = method.setup(RP, vec![body])?;
    let places: Vec<DVec3> = starts.iter().map(|&x| rotation * x).collect();
    setup.particles.add(&places, &vec![[0.0; 3]; places.len()]);
    let mut simulation = Simulation::new(setup)?;
    let acceleration = GRAVITY * DEGREES.to_radians().sin();
    let mut steps = Vec::new();
    run.until(&mut simulation, (2.0 * WAY / acceleration).sqrt(), &mut |simulation, _| {
        let particles = simulation.particles();
        let mut ways = vec![DVec3::NAN; starts.len()];
        for (&x, &id) in particles.positions.iter().zip(&particles.ids) {
            let own = rotation.conjugate() * x;
            ways[id as usize] = (own - starts[id as usize]).with_y(own.y);
        }
        steps.push(ways);
    })?;
    Ok(Slide { steps, ideal: 0.5 * acceleration * simulation.time().powi(2) })
}

impl Slide {
    /// A curve for each particle, with gaps between them.
    fn path(&self, pick: fn(&DVec3) -> [f64; 2]) -> Vec<[f64; 2]> {
        let count = self.steps.first().map_or(0, Vec::len);
        let one = |n: usize| self.steps.iter().step_by(4).map(move |ways| pick(&ways[n]));
        (0..count).flat_map(|n| one(n).chain([[f64::NAN; 2]])).collect()
    }

    fn rows(&self, outcome: &mut Outcome, case: &str) {
        let Some(ways) = self.steps.last() else { return };
        let count = ways.len() as f64;
        let mean = -ways.iter().map(|way| way.x).sum::<f64>() / count;
        let spread = (ways.iter().map(|way| (way.x + mean).powi(2)).sum::<f64>() / count).sqrt();
        let aside = (ways.iter().map(|way| way.z * way.z).sum::<f64>() / count).sqrt();
        let farthest = ways.iter().map(|way| way.z.abs()).fold(0.0, f64::max);
        let late = self.steps[self.steps.len() / 3..].iter().flatten().map(|way| way.y);
        let [lowest, highest] = late.fold([f64::INFINITY, 0.0], |[a, b], y| [y.min(a), y.max(b)]);
        let rows = &mut outcome.rows;
        rows.push(Row::new(case, "rms to the side", "rp", aside / RP));
        rows.push(Row::new(case, "farthest to the side", "rp", farthest / RP));
        rows.push(Row::new(case, "spread of the ways down, over the way", "", spread / mean));
        rows.push(Row::new(case, "way down over g sin(slope) t^2 / 2", "", mean / self.ideal));
        rows.push(Row::new(case, "least height after a third of the steps", "rp", lowest / RP));
        rows.push(Row::new(case, "greatest height after a third of the steps", "rp", highest / RP));
    }
}
