//! A ball that is let go in water at rest: at first it has the acceleration of its buoyancy over its mass and half of
//! that of the water which it displaces.

use super::flow::{GRAVITY, lattice};
use super::{Outcome, Row, Run};
use volmap_fluid::Error;
use volmap_fluid::bodies::{Bodies, BodyDescription, FreeBody, Motion, Weight};
use volmap_fluid::observe::line;
use volmap_fluid::packing::{Packing, settle, spread};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{FluidSettings, SolverSettings, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{Shape, baked, ball, cuboid, volume};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;

/// Particle radius, half of the tank's width, the water's depth and the height of the ball's middle, metres; the ball's
/// radius in rp.
const RP: f64 = 0.0125;
const HALF_WIDTH: f64 = 0.3;
const DEPTH: f64 = 0.45;
const HEIGHT: f64 = 0.25;
const RADII: f64 = 8.0;

/// Lets a ball of a density (kg/m^3) go, whose middle is so many rp off the lattice on each axis.
pub fn release(run: &Run, outcome: &mut Outcome, density: f64, off: f64) -> Result<(), Error> {
    let mut simulation = begin(run, density, off)?;
    let exact = GRAVITY * (1000.0 - density) / (density + 500.0);
    let mut points = vec![[0.0, 0.0]];
    run.until(&mut simulation, 0.1, &mut |simulation, _| {
        points.push([simulation.time(), simulation.bodies().state(1).velocity.y]);
    })?;
    let case = match off {
        0.0 => format!("ball of {density} kg/m^3, released"),
        _ => format!("ball of {density} kg/m^3, {off} rp off, released"),
    };
    let until = |end: f64| -> f64 {
        let first: Vec<[f64; 2]> = points.iter().copied().filter(|[time, _]| *time <= end).collect();
        line(&first)[1] / exact
    };
    let rows = &mut outcome.rows;
    let early = Row::new(&case, "acceleration over the closed form, first 0.05 s", "", until(0.05));
    rows.push(early.between(0.9, 1.1));
    rows.push(Row::new(&case, "the same, first 0.1 s", "", until(0.1)));
    Ok(())
}

/// Water without viscosity around the ball, spread and settled.
fn begin(run: &Run, density: f64, off: f64) -> Result<Simulation, Error> {
    let support = 4.0 * RP;
    let low = DVec3::new(-HALF_WIDTH, 0.0, -HALF_WIDTH);
    let high = DVec3::new(HALF_WIDTH, DEPTH, HALF_WIDTH);
    let tank = baked(cuboid(low, high.with_y(2.0 * DEPTH)), support, true)?;
    // Its sides are out of reach of the tank's.
    let far = DVec3::new(support, 0.0, support);
    let lid = baked(cuboid(low - far - DVec3::Y * support, high + far), support, true)?;
    let shape = baked(ball(RADII * RP, 5), support, false)?;
    let fixed = |shape: &Shape, name: &str| shape.body(name, DVec3::ZERO, Motion::Static);
    let weight = Weight::Density(density);
    let motion = Motion::Free(FreeBody { weight, ..FreeBody::default() });
    let body = shape.body("ball", DVec3::new(0.0, HEIGHT, 0.0) + off * RP, motion);

    let (world, fluid) = (
        World { particle_radius: RP, support_radius: support, ..World::default() },
        FluidSettings { viscosity: 0.0, ..FluidSettings::default() },
    );
    let solver = SolverSettings::default();
    let packing = Packing { world: &world, fluid: &fluid, solver: &solver, watch: run.watch };
    let places = places(low, high, &body, volume(&shape.mesh));
    let spread = spread(packing, vec![fixed(&tank, "tank"), fixed(&lid, "lid"), body.clone()], &places)?;
    let settled = settle(packing, vec![fixed(&tank, "tank"), body.clone()], &spread.positions)?;

    let mut particles = Particles::default();
    particles.add(&settled.positions, &vec![[0.0; 3]; settled.positions.len()]);
    particles.pressures = settled.pressures;
    let bodies = Bodies::new(vec![fixed(&tank, "tank"), body], world.gravity)?;
    Simulation::new(Setup { fluid, solver, ..Setup::new(world, particles, bodies) })
}

/// As many places of the lattice as the box holds beside the ball, those that are farthest from it.
fn places(low: DVec3, high: DVec3, ball: &BodyDescription, displaced: f64) -> Vec<DVec3> {
    let centre = ball.pose.translation;
    let mut places = lattice(low, high, RP);
    let holds = ((high - low).element_product() - displaced) / (2.0 * RP).powi(3);
    places.sort_by(|a, b| b.distance(centre).total_cmp(&a.distance(centre)));
    places.truncate(holds.round() as usize);
    let least = (RADII + 0.5) * RP;
    for place in &mut places {
        let way = *place - centre;
        *place = centre + way.normalize() * way.length().max(least);
    }
    places
}
