//! Blocks slide on a plane with tangential friction: Bender et al. 2020, *Implicit Frictional Boundary Handling for
//! SPH*, Fig. 14 (elastic cubes), its six coefficients.

use super::boundaries::VOLUME_MAP;
use super::rigid::Rigid;
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use std::f64::consts::PI;
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::{BodyDescription, FluidContact, Motion};
use volmap_fluid::shapes::{Shape, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_fluid::viscosity::drag::Drag;
use volmap_runtime::{DVec3, Kernel, KernelKind, Surface};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "friction",
    title: "Tangential friction",
    about: "Rigid blocks of particles slide at 5 m/s with the paper's six coefficients: how far they come",
    run,
};

const RP: f64 = 0.0125;
const RADIUS: f64 = 4.0 * RP;
const REST_DENSITY: f64 = 1000.0;
/// Particles along each side of a block, and upwards. Higher blocks pitch: see the notes.
const SIDE: u32 = 9;
const LAYERS: u32 = 3;
/// Speed at the start, m/s.
const SPEED: f64 = 5.0;
/// mu_B, kg/(m s): the paper's six, and none.
const COEFFICIENTS: [f64; 7] = [0.0, 0.0125, 0.025, 0.05, 0.1, 0.2, 0.4];
/// A block is put back by this on the same plane, metres; and half the plane's length and width.
const PERIOD: f64 = 0.5;
const HALF: f64 = 0.5;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let plane =
        VOLUME_MAP.baked(cuboid(DVec3::new(-HALF, -0.08, -HALF), DVec3::new(HALF, 0.0, HALF)), RP, false)?;
    let mut curves = Vec::new();
    let mut ways = Vec::new();
    for (coefficient, colour) in COEFFICIENTS.into_iter().zip(DISTINCT) {
        (run.progress)(&format!("friction: {coefficient} kg/(m s)"));
        let slide = slide(run, &plane, coefficient)?;
        let case = format!("mu_B = {coefficient} kg/(m s)");
        slide.rows(&mut outcome, &case);
        ways.push(slide.way);
        curves.push(curve(case, colour, slide.speeds));
    }
    let falls = ways.windows(2).all(|pair| pair[1] < pair[0]);
    let row = Row::new("all", "the way falls with the coefficient", "", f64::from(u8::from(falls)));
    outcome.rows.push(row.paper(1.0).at_least(1.0));
    let axes = [["Time", "s"], ["Speed", "m/s"]];
    outcome.chart("friction.png", chart("Blocks that slide with friction", axes[0], axes[1], curves));
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    The paper's cubes are elastic, and it gives no figures but the coefficients and the speed. Ours are rigid blocks \
    of 9 x 3 x 9 particles of rp = 12.5 mm, without the two seconds before the friction begins. Friction here is a \
    drag proportional to the speed, whatever the weight. The closed form is v / lambda (1 - exp(-lambda t)), with \
    lambda the rate of Eq. 19 for a half space at the heights of the layers. Cubes of 6^3 particles pitch from 0.2 \
    kg/(m s) on: their front edge sinks, and the closed form for level blocks doesn't hold.";

struct Slide {
    speeds: Vec<[f64; 2]>,
    way: f64,
    /// The way by the closed form, metres.
    exact: f64,
    /// Height of the lowest layer at the end, metres.
    height: f64,
    aside: f64,
    /// Largest angle between its axis and the vertical, degrees.
    tilt: f64,
}

fn slide(run: &Run, plane: &Shape, coefficient: f64) -> Result<Slide, Error> {
    let contact = FluidContact { viscosity: 0.0, friction: coefficient / REST_DENSITY };
    let body = BodyDescription { fluid_contact: contact, ..plane.body("plane", DVec3::ZERO, Motion::Static) };
    let at = |n: u32| DVec3::new((n % SIDE).into(), (n / SIDE / SIDE).into(), (n / SIDE % SIDE).into());
    let shift = DVec3::new(-f64::from(SIDE), 0.0, -f64::from(SIDE)) * RP;
    let places: Vec<DVec3> = (0..SIDE * SIDE * LAYERS).map(|n| shift + RP + 2.0 * RP * at(n)).collect();
    let mut rigid = Rigid::new(&places, DVec3::X * SPEED, DVec3::ZERO);
    let mut setup = VOLUME_MAP.setup(RP, vec![body])?;
    let (places, velocities) = rigid.particles();
    setup.particles.add(&places, &velocities);
    let mut simulation = Simulation::new(setup)?;
    let (start, mut travelled) = (rigid.centre, DVec3::ZERO);
    let (mut speeds, mut tilt) = (vec![[0.0, SPEED]], 0.0f64);
    while simulation.time() < run.pick(1.0, 4.0) - 1e-9 {
        run.watch.check()?;
        rigid.step(&mut simulation)?;
        let back = PERIOD * (rigid.centre / PERIOD).round().with_y(0.0);
        if back != DVec3::ZERO {
            rigid.centre -= back;
            travelled += back;
            rigid.place(&mut simulation);
        }
        speeds.push([simulation.time(), rigid.velocity.x]);
        tilt = tilt.max((rigid.rotation * DVec3::Y).angle_between(DVec3::Y).to_degrees());
    }
    let way = rigid.centre + travelled - start;
    let height = rigid.centre.y - f64::from(LAYERS - 1) * RP;
    let layers = (0..LAYERS).map(|n| rate(height + 2.0 * RP * f64::from(n), contact)).sum::<f64>();
    let (lambda, time) = (layers / f64::from(LAYERS), simulation.time());
    let part = if lambda > 0.0 { -(-lambda * time).exp_m1() / lambda } else { time };
    Ok(Slide { speeds, way: way.x, exact: SPEED * part, height, aside: way.z.abs(), tilt })
}

impl Slide {
    fn rows(&self, outcome: &mut Outcome, case: &str) {
        let rows = &mut outcome.rows;
        rows.push(Row::new(case, "way", "m", self.way));
        rows.push(
            Row::new(case, "way over the closed form's", "", self.way / self.exact).between(0.97, 1.03),
        );
        rows.push(Row::new(case, "speed at the end", "m/s", self.speeds.last().map_or(f64::NAN, |at| at[1])));
        rows.push(Row::new(case, "lowest layer over the plane", "rp", self.height / RP));
        rows.push(Row::new(case, "to the side", "mm", 1e3 * self.aside));
        rows.push(Row::new(case, "largest tilt", "degrees", self.tilt));
    }
}

/// Rate at which a particle at a height over a half space loses its speed, 1/s.
fn rate(height: f64, contact: FluidContact) -> f64 {
    let kernel = Kernel::new(KernelKind::CubicSpline, RADIUS);
    let wall = Surface {
        distance: height,
        normal: DVec3::Y,
        closest_point: DVec3::ZERO,
        volume: half_space_volume(height),
    };
    let drag = Drag::new([0, 0], DVec3::Y * height, &wall, contact, &kernel);
    drag.map_or(0.0, |drag| drag.tangential)
}

/// Eq. 12 and 13 for a half space, by slices of the ball.
fn half_space_volume(height: f64) -> f64 {
    const SLICES: u32 = 4000;
    let extension = |d: f64| match d / RADIUS {
        q if q <= 0.0 => 1.0,
        q if q <= 0.5 => 6.0 * (q.powi(3) - q.powi(2)) + 1.0,
        q => 2.0 * (1.0 - q.min(1.0)).powi(3),
    };
    let width = 2.0 * RADIUS / f64::from(SLICES);
    let slice = |n: u32| {
        let z = (f64::from(n) + 0.5) * width - RADIUS;
        PI * (RADIUS * RADIUS - z * z) * extension(height + z) * width
    };
    (0..SLICES).map(slice).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_deep_in_a_half_space_is_full() {
        let ball = 4.0 / 3.0 * PI * RADIUS.powi(3);
        assert!((half_space_volume(-RADIUS) / ball - 1.0).abs() < 1e-6);
        assert_eq!(half_space_volume(2.0 * RADIUS), 0.0);
    }
}
