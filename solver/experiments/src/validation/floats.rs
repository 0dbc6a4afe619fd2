//! Balls and boxes in water: Archimedes. A floating body displaces its weight of water; one that is held under
//! water is pushed up by the weight of what it displaces.

use super::flow::{GRAVITY, lattice, liquid_of, volume_below};
use super::released::release;
use super::{Experiment, Outcome, Row, Run, chart, curve};
use volmap_bake::random::Random;
use volmap_figures::picture::colours::DISTINCT;
use volmap_fluid::Error;
use volmap_fluid::bodies::{BodyDescription, FreeBody, Motion, Weight};
use volmap_fluid::observe::line;
use volmap_fluid::settings::{FluidSettings, World};
use volmap_fluid::shapes::{Shape, baked, ball, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, KernelKind, Pose, VolumeMap};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "floats",
    title: "Archimedes",
    about: "A ball and a box held under water, floating in water and mercury, and a ball released under water",
    run,
};

/// Half the tank's width, and the water's depth without a body, metres.
const HALF_WIDTH: f64 = 0.4;
const DEPTH: f64 = 0.6;
/// Densities of water and mercury, kg/m^3.
const RHO: f64 = 1000.0;
const MERCURY: f64 = 13534.0;

/// Half of the ball's and the box's width, metres.
const HALF: f64 = 0.16;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    held(run, &mut outcome)?;
    let mut curves = Vec::new();
    let parts: &[f64] = run.pick(&[0.5], &[0.1, 0.25, 0.5, 0.75, 0.9]);
    for (liquid, rest_density) in [("", RHO), (" in mercury", MERCURY)] {
        for (across, most) in [(8.0, 0.04), (16.0, 0.02)] {
            let tank = Tank { rest_density, ..Tank::of(2.0 * HALF / across)? };
            for (name, shape) in [("ball", tank.baked(ball(HALF, 5))?), ("box", tank.baked(cube())?)] {
                for &part in parts {
                    let density = part * rest_density;
                    let case = format!("{name}{liquid}, {across} rp, {} kg/m^3", density.round());
                    (run.progress)(&format!("floats: {case}"));
                    let floating = Floating { case: &case, density, most };
                    let points = floating.run(run, &mut outcome, &tank, &shape)?;
                    if rest_density == RHO {
                        let colour = DISTINCT[curves.len() % DISTINCT.len()];
                        curves.push(curve(case.clone(), colour, points));
                    }
                }
            }
        }
    }
    let released: &[(f64, f64)] =
        run.pick(&[(500.0, 0.0)], &[(500.0, 0.0), (500.0, 1.0), (2000.0, 0.0), (100.0, 0.0)]);
    for &(density, off) in released {
        (run.progress)(&format!("floats: ball of {density} kg/m^3 released under water"));
        release(run, &mut outcome, density, off)?;
    }
    let axes = [["Time", "s"], ["Submerged part less Archimedes'", "of the whole"]];
    outcome.chart("floats.png", chart("Floating bodies", axes[0], axes[1], curves));
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

/// Bodies that are held under water.
fn held(run: &Run, outcome: &mut Outcome) -> Result<(), Error> {
    let tank = Tank::of(run.pick(0.02, 0.04 / 3.0))?;
    let all = [("ball", tank.baked(ball(HALF, 5))?), ("box", tank.baked(cube())?)];
    for (name, shape) in &all[..run.pick(1, 2)] {
        (run.progress)(&format!("floats: {name} held under water"));
        held_under_water(run, outcome, &tank, name, shape)?;
    }
    Ok(())
}

const NOTE: &str = "\
    The water level is where the water would stand at rest density. That of the pressure is p / (rho g) + y, of \
    particles that are far from body, walls, floor and surface; the highest particles lie some rp/2 lower. Means are \
    over the second half of each run. Particles begin up to 0.3 rp off the lattice: on the lattice, water at rest is \
    a crystal that may carry a body.";

fn cube() -> TriangleMesh {
    cuboid(DVec3::splat(-HALF), DVec3::splat(HALF))
}

fn hollow() -> TriangleMesh {
    cuboid(DVec3::new(-HALF_WIDTH, 0.0, -HALF_WIDTH), DVec3::new(HALF_WIDTH, 1.2, HALF_WIDTH))
}

struct Tank {
    shape: Shape,
    /// Particle radius, metres.
    radius: f64,
    /// Of what is in it, kg/m^3.
    rest_density: f64,
    /// Of the sums over neighbours, and its support radius in rp.
    kernel: (KernelKind, f64),
}

/// A ball of half the water's density floats in water of a kernel and its support radius (rp).
pub(super) fn of_kernel(
    run: &Run,
    outcome: &mut Outcome,
    case: &str,
    kernel: (KernelKind, f64),
) -> Result<(), Error> {
    let radius = 0.02;
    let support = kernel.1 * radius;
    let tank = Tank { shape: baked(hollow(), support, true)?, radius, rest_density: RHO, kernel };
    let ball = tank.baked(ball(HALF, 5))?;
    // As long as the short form: the ball has come to rest by then.
    let floating = Floating { case: &format!("{case}, 500 kg/m^3"), density: 500.0, most: 0.03 };
    floating.run(&Run { short: true, ..*run }, outcome, &tank, &ball)?;
    Ok(())
}

impl Tank {
    /// Of water, for particles of a radius (metres) with the default kernel.
    fn of(radius: f64) -> Result<Tank, Error> {
        let kernel = (KernelKind::CubicSpline, 4.0);
        Ok(Tank { shape: baked(hollow(), 4.0 * radius, true)?, radius, rest_density: RHO, kernel })
    }

    fn baked(&self, mesh: TriangleMesh) -> Result<Shape, Error> {
        baked(mesh, self.kernel.1 * self.radius, false)
    }

    /// The liquid with a body in it; free bodies only.
    fn with(&self, body: BodyDescription) -> Result<Simulation, Error> {
        let (size, radius) = (DVec3::new(HALF_WIDTH, DEPTH, HALF_WIDTH), self.radius);
        let clear = |map: &VolumeMap, x: DVec3| map.values(x).distance > 0.9 * radius;
        let mut places = lattice(DVec3::new(-size.x, 0.0, -size.z), size, radius);
        places.retain(|&x| clear(&body.map, body.pose.to_map(x)));
        disturb(&mut places, radius);
        let tank = self.shape.body("tank", DVec3::ZERO, Motion::Static);
        let (kernel, support) = self.kernel;
        let world =
            World { particle_radius: radius, support_radius: support * radius, kernel, ..World::default() };
        let fluid = FluidSettings { rest_density: self.rest_density, ..FluidSettings::default() };
        liquid_of(world, fluid, &places, vec![tank, body])
    }
}

/// Moves every particle by up to 0.3 rp along each axis, at random.
fn disturb(places: &mut [DVec3], radius: f64) {
    let mut random = Random::knuth(1);
    for place in places {
        *place += 0.3 * radius * DVec3::new(random.signed(), random.signed(), random.signed());
    }
}

/// A free motion, fixed on the chosen axes.
fn free(density: f64, locked: bool) -> Motion {
    Motion::Free(FreeBody {
        weight: Weight::Density(density),
        locked_translation: [locked; 3],
        locked_rotation: [locked; 3],
        ..FreeBody::default()
    })
}

/// The force on a fixed body, over the weight of the water that it displaces.
fn held_under_water(
    run: &Run,
    outcome: &mut Outcome,
    tank: &Tank,
    name: &str,
    shape: &Shape,
) -> Result<(), Error> {
    let end = run.pick(2.0, 3.0);
    let body = shape.body(name, DVec3::new(0.0, 0.3, 0.0), free(RHO, true));
    let displaced = RHO * GRAVITY * volume_below(&shape.mesh, body.pose, 9.0);
    let mut simulation = tank.with(body)?;
    let (mut push, mut time) = (DVec3::ZERO, 0.0);
    run.until(&mut simulation, end, &mut |simulation, report| {
        if simulation.time() > 0.5 * end {
            push += report.dt * simulation.body_forces()[1][0];
            time += report.dt;
        }
    })?;
    let push = push / time / displaced;
    let case = format!("{name}, held");
    outcome.rows.push(Row::new(&case, "lift over weight of displaced water", "", push.y).between(0.97, 1.03));
    outcome
        .rows
        .push(Row::new(&case, "force sideways over the same", "", push.x.hypot(push.z)).at_most(0.02));
    outcome.rows.push(Row::new(&case, "slope of pressure over rho g", "", -pressure_line(&simulation)[1]));
    outcome.rows.push(Row::new(
        &case,
        "water's density by counting, over rho_0",
        "",
        counted_density(&simulation),
    ));
    Ok(())
}

/// Radius of the particles, which are cubes of the lattice, metres.
fn radius(simulation: &Simulation) -> f64 {
    0.5 * simulation.particle_volume().cbrt()
}

/// Offset (metres) and slope, about -1, of p / (rho g) over y, of particles far from body, walls, floor and surface.
fn pressure_line(simulation: &Simulation) -> [f64; 2] {
    let rp = radius(simulation);
    let far = |x: &DVec3| {
        let aside = x.x.abs().max(x.z.abs());
        aside > 0.27 && aside < HALF_WIDTH - 3.0 * rp && x.y > 4.0 * rp && x.y < DEPTH - 6.0 * rp
    };
    let pressures = simulation.pressures();
    let density = simulation.particle_mass() / simulation.particle_volume();
    let all = simulation.particles().positions.iter().zip(&pressures).filter(|(x, _)| far(x));
    let points: Vec<[f64; 2]> = all.map(|(x, &p)| [x.y, f64::from(p) / (density * GRAVITY)]).collect();
    line(&points)
}

/// Mass of the particles in a frame around the body, over its volume and rho_0; each counts as the part of its cube
/// that is in the frame.
fn counted_density(simulation: &Simulation) -> f64 {
    let rp = radius(simulation);
    let [low, high] = [4.0 * rp, DEPTH - 8.0 * rp];
    let [inner, outer] = [0.25, HALF_WIDTH - 3.0 * rp];
    let part = |x: f64, from: f64, to: f64| (((x + rp).min(to) - (x - rp).max(from)) / (2.0 * rp)).max(0.0);
    let square = |x: &DVec3, half: f64| part(x.x, -half, half) * part(x.z, -half, half);
    let all = simulation.particles().positions.iter();
    let count: f64 = all.map(|x| part(x.y, low, high) * (square(x, outer) - square(x, inner))).sum();
    count * simulation.particle_volume() / ((high - low) * 4.0 * (outer * outer - inner * inner))
}

/// Where the water would stand if all of it had its rest density: its volume and that of the body below the level, over
/// the tank's floor, metres.
fn level_by_volume(simulation: &Simulation, shape: &Shape, pose: Pose) -> f64 {
    let water = simulation.particles().len() as f64 * simulation.particle_volume();
    let area = (2.0 * HALF_WIDTH).powi(2);
    let (mut low, mut high) = (water / area, water / area + 1.0);
    for _ in 0..50 {
        let level = 0.5 * (low + high);
        let holds = area * level - volume_below(&shape.mesh, pose, level);
        if holds < water { low = level } else { high = level }
    }
    0.5 * (low + high)
}

/// Mean height of the highest particles in columns far from the body and the walls, and a particle radius.
fn surface_level(simulation: &Simulation) -> f64 {
    let side = 4.0 * radius(simulation);
    let mut tops = std::collections::BTreeMap::new();
    for x in &simulation.particles().positions {
        if x.x.abs().max(x.z.abs()) > 0.27 {
            let column = ((x.x / side).floor() as i64, (x.z / side).floor() as i64);
            let top = tops.entry(column).or_insert(f64::NEG_INFINITY);
            *top = x.y.max(*top);
        }
    }
    tops.values().sum::<f64>() / tops.len() as f64 + radius(simulation)
}

/// A body that floats.
struct Floating<'a> {
    case: &'a str,
    density: f64,
    /// By how much its submerged part may differ from Archimedes', in parts of the whole.
    most: f64,
}

impl Floating<'_> {
    /// The submerged part less Archimedes' with time.
    fn run(
        &self,
        run: &Run,
        outcome: &mut Outcome,
        tank: &Tank,
        shape: &Shape,
    ) -> Result<Vec<[f64; 2]>, Error> {
        let end = run.pick(1.6, 3.0);
        let part = self.density / tank.rest_density;
        // It begins a little higher than it floats.
        let height = DEPTH + 2.0 * HALF * (0.5 - part) + 0.05;
        let body = shape.body("body", DVec3::new(0.0, height, 0.0), free(self.density, false));
        let mut simulation = tank.with(body)?;
        let whole = volume_below(&shape.mesh, Default::default(), 9.0);
        let (mut points, mut sums, mut time, mut speed) = (Vec::new(), [0.0; 3], 0.0, 0.0f64);
        run.until(&mut simulation, end, &mut |simulation, report| {
            let state = simulation.bodies().state(1);
            speed = speed.max(state.velocity.length());
            let [offset, slope] = pressure_line(simulation);
            let by_volume = level_by_volume(simulation, shape, state.pose);
            let levels = [by_volume, -offset / slope, surface_level(simulation)];
            let submerged = levels.map(|level| volume_below(&shape.mesh, state.pose, level) / whole);
            points.push([simulation.time(), submerged[0] - part]);
            if simulation.time() > 0.5 * end {
                time += report.dt;
                sums.iter_mut().zip(submerged).for_each(|(sum, part)| *sum += report.dt * part);
            }
        })?;
        let rows = &mut outcome.rows;
        let [by_volume, by_pressure, by_surface] = sums.map(|sum| sum / time);
        let less = Row::new(self.case, "submerged part less Archimedes'", "", by_volume - part);
        rows.push(less.between(-self.most, self.most));
        rows.push(Row::new(self.case, "submerged part over Archimedes'", "", by_volume / part));
        rows.push(Row::new(self.case, "the same by the pressure's level", "", by_pressure / part));
        rows.push(Row::new(self.case, "the same by the highest particles", "", by_surface / part));
        rows.push(Row::new(self.case, "largest speed", "m/s", speed).at_most(3.0));
        let end = simulation.bodies().state(1).velocity.length();
        rows.push(Row::new(self.case, "speed at the end", "m/s", end));
        Ok(points)
    }
}
