//! A thick fluid sticks: to a thin grid that it is poured on, Bender et al. 2020, *Implicit Frictional Boundary
//! Handling for SPH*, Fig. 13, and to a body that moves (Fig. 12).

use super::boundaries::VOLUME_MAP;
use crate::validation::flow::lattice;
use crate::validation::grid::{BAR, bars};
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::{BodyDescription, FluidContact, Interpolation, Key, Keys, Motion, Path};
use volmap_fluid::observe::{centre, velocities};
use volmap_fluid::settings::{FluidSettings, ViscosityMethod};
use volmap_fluid::shapes::ball;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{DQuat, DVec3, Sample};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "sticky",
    title: "Sticky boundaries",
    about: "A thick fluid falls on a grid and covers a moving ball: how much stays, with sticking and without",
    run,
};

/// Viscosity of the fluid, m^2/s: 500 kg/(m s) at 1,000 kg/m^3.
const VISCOSITY: f64 = 0.5;
/// Viscosities between fluid and body, m^2/s: none, that of Fig. 12, and 10,000 kg/(m s) as in Fig. 13.
const COEFFICIENTS: [f64; 3] = [0.0, 0.01, 10.0];

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut charts = [const { Vec::new() }; 2];
    let chosen = run.pick(&[0.0, 10.0][..], &COEFFICIENTS);
    for (&coefficient, colour) in chosen.iter().zip(DISTINCT) {
        let label = format!("mu_B = {} kg/(m s)", 1e3 * coefficient);
        let scenes: [(&str, HoldingCase); 2] = [("grid", grid), ("ball", moved)];
        for ((name, scene), curves) in scenes.into_iter().zip(&mut charts) {
            (run.progress)(&format!("sticky: {name}, {label}"));
            let held = scene(run, coefficient)?;
            held.rows(&mut outcome, &format!("{name}, {label}"));
            curves.push(curve(label.clone(), colour, held.points));
        }
    }
    let [grids, balls] = charts;
    let axes = [["Time", "s"], ["Part of the fluid that is held", ""]];
    outcome.chart("sticky-grid.png", chart("A thick fluid on a grid", axes[0], axes[1], grids));
    outcome.chart("sticky-ball.png", chart("A thick fluid on a ball that moves", axes[0], axes[1], balls));
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    Fluid counts as held unless it is lower than 10 cm under the grid, or farther than 8 rp from the ball. It has \
    500 kg/(m s) at 1,000 kg/m^3. A block of 24 x 10 x 24 cm falls from 1 cm on a grid of bars of 3 cm and holes of \
    7.8 cm; a coat of 4 rp covers a ball of 10 cm, which moves 1 m aside in 1 s and stops. The paper shows pictures \
    and gives no figures. mu_B = 10 kg/(m s) is that of its Fig. 12, 10,000 that of Fig. 13.";

/// Simulates with a coefficient mu_B / rho_0, m^2/s.
type HoldingCase = fn(&Run, f64) -> Result<Held, Error>;

/// How much the body holds.
#[derive(Default)]
struct Held {
    /// Time (s), and the part of the fluid that is held.
    points: Vec<[f64; 2]>,
    /// How far the centre of the fluid that is left has fallen, metres; none if none is left.
    fall: Option<f64>,
    /// Mean speed of the fluid over the body's when the body is fastest; none for bodies at rest.
    carried: Option<f64>,
    /// Particles found in the body, mean over steps.
    inside: f64,
    /// Largest depth of a centre in the body, metres.
    depth: f64,
    /// Iterations of the viscous solve, mean over steps.
    iterations: f64,
}

impl Held {
    fn rows(&self, outcome: &mut Outcome, case: &str) {
        let rows = &mut outcome.rows;
        let last = self.points.last().map_or(f64::NAN, |point| point[1]);
        rows.push(Row::new(case, "part of the fluid that is held at the end", "", last));
        if let Some(fall) = self.fall {
            rows.push(Row::new(case, "fall of the fluid's centre", "cm", 1e2 * fall));
        }
        if let Some(carried) = self.carried {
            rows.push(Row::new(case, "mean speed of the fluid over the ball's, half-way", "", carried));
        }
        rows.push(Row::new(case, "particles in the body, mean of steps", "", self.inside));
        rows.push(Row::new(case, "deepest centre in the body", "mm", 1e3 * self.depth));
        rows.push(Row::new(case, "viscous iterations, mean of steps", "", self.iterations));
    }
}

/// A block of fluid falls on a grid.
fn grid(run: &Run, coefficient: f64) -> Result<Held, Error> {
    let radius = run.pick(0.01, 0.0065);
    let grid = VOLUME_MAP.baked(bars(5), radius, false)?;
    let top = 0.5 * BAR + 0.01;
    let places = lattice(DVec3::new(-0.12, top, -0.12), DVec3::new(0.12, top + 0.1, 0.12), radius);
    let body = grid.body("grid", DVec3::ZERO, Motion::Static);
    hold(run, radius, &places, touched(body, coefficient), run.pick(1.0, 2.0), |_, x| x.y > -0.1)
}

/// A ball with a coat of fluid is moved aside.
fn moved(run: &Run, coefficient: f64) -> Result<Held, Error> {
    const BALL: f64 = 0.1;
    let radius = run.pick(0.015, 0.01);
    let shape = VOLUME_MAP.baked(ball(BALL, 5), radius, false)?;
    let coat = BALL + 4.0 * radius;
    let places = lattice(DVec3::splat(-coat), DVec3::splat(coat), radius);
    let places: Vec<DVec3> =
        places.into_iter().filter(|x| x.length() < coat && x.length() > BALL + 0.8 * radius).collect();
    let key = |time: f64, x: f64| Key { time, translation: DVec3::X * x, rotation: DQuat::IDENTITY };
    let keys = Keys {
        keys: vec![key(0.0, 0.0), key(1.0, 1.0)],
        interpolation: Interpolation::Smooth,
        repeat: false,
    };
    let body = shape.body("ball", DVec3::ZERO, Motion::Prescribed(Path::Keys(keys)));
    let reach = BALL + 8.0 * radius;
    hold(run, radius, &places, touched(body, coefficient), run.pick(0.7, 1.5), |simulation, x| {
        x.distance(simulation.bodies().posed()[0].pose.translation) < reach
    })
}

fn touched(body: BodyDescription, viscosity: f64) -> BodyDescription {
    BodyDescription { fluid_contact: FluidContact { viscosity, friction: 0.0 }, ..body }
}

fn hold(
    run: &Run,
    radius: f64,
    places: &[DVec3],
    body: BodyDescription,
    end: f64,
    is_held: impl Fn(&Simulation, DVec3) -> bool,
) -> Result<Held, Error> {
    let rests = body.motion == Motion::Static;
    let mut setup = VOLUME_MAP.setup(radius, vec![body])?;
    setup.fluid = FluidSettings {
        viscosity: VISCOSITY,
        viscosity_method: ViscosityMethod::Implicit,
        ..FluidSettings::default()
    };
    // Fluid that has fallen this far is removed.
    setup.domain = Some([DVec3::new(-3.0, -2.0, -3.0), DVec3::splat(3.0)]);
    setup.particles.add(places, &vec![[0.0; 3]; places.len()]);
    let mut simulation = Simulation::new(setup)?;
    let start = centre(&simulation);
    let mut held = Held::default();
    run.until(&mut simulation, end, &mut |simulation, report| {
        let positions = &simulation.particles().positions;
        let count = positions.iter().filter(|&&x| is_held(simulation, x)).count();
        held.points.push([simulation.time(), count as f64 / places.len() as f64]);
        held.inside += report.inside as f64;
        held.iterations += f64::from(report.viscosity.iterations);
        held.depth = held.depth.max(deepest(simulation));
        if !rests && held.carried.is_none() && simulation.time() >= 0.5 {
            let mean = velocities(simulation).sum::<DVec3>() / positions.len() as f64;
            held.carried = Some(mean.x / simulation.bodies().velocity_at(0, DVec3::ZERO).x);
        }
    })?;
    let steps = held.points.len() as f64;
    (held.inside, held.iterations) = (held.inside / steps, held.iterations / steps);
    let is_gone = simulation.particles().is_empty();
    held.fall = (!is_gone).then(|| (start - centre(&simulation)).y);
    Ok(held)
}

/// Largest depth of a particle's centre in the body, metres.
fn deepest(simulation: &Simulation) -> f64 {
    let body = &simulation.bodies().posed()[0];
    let depth = |&x: &DVec3| match body.sample(x) {
        Sample::Near(near) => -near.distance,
        Sample::DeepInside => f64::INFINITY,
        Sample::Outside => 0.0,
    };
    simulation.particles().positions.iter().map(depth).fold(0.0, f64::max)
}
