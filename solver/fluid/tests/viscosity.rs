//! Implicit viscosity and the drag of bodies in the whole step: closed forms of viscous flow, conservation, sticking,
//! friction.
//!
//! Weiler et al. 2018, *A Physically Consistent Implicit Viscosity Solver for SPH Fluids*; Bender et al. 2020,
//! section 4.4.

use std::f64::consts::PI;
use volmap_fluid::bodies::{
    Bodies, BodyDescription, FluidContact, FreeBody, Interpolation, Key, Keys, Motion, Path, Weight,
};
use volmap_fluid::observe::{centre, kinetic_energy, momenta, velocities};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{FluidSettings, SolverSettings, ViscosityMethod, World};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{self, Shape, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{DQuat, DVec3, Pose};

const RP: f64 = 0.025;
const SPACING: f64 = 2.0 * RP;
const RADIUS: f64 = 4.0 * RP;

/// A block of particles from a corner on, the first RP away from it.
fn block(corner: DVec3, counts: [u32; 3]) -> Vec<DVec3> {
    let [nx, ny, nz] = counts;
    let at = move |n: u32| DVec3::new((n % nx).into(), (n / nx % ny).into(), (n / nx / ny).into());
    (0..nx * ny * nz).map(|n| corner + RP + SPACING * at(n)).collect()
}

/// A thick fluid and bodies; both pressure solves are off, so that the fluid's velocity is that of viscosity alone.
fn thick(viscosity: f64, gravity: DVec3, bodies: Vec<BodyDescription>) -> Setup {
    let mut solver = SolverSettings::default();
    solver.density.enabled = false;
    solver.divergence.enabled = false;
    let world = World { particle_radius: RP, support_radius: RADIUS, gravity, ..World::default() };
    let bodies = Bodies::new(bodies, gravity).unwrap();
    Setup {
        fluid: FluidSettings {
            viscosity,
            viscosity_method: ViscosityMethod::Implicit,
            ..FluidSettings::default()
        },
        solver,
        domain: Some([DVec3::splat(-50.0), DVec3::splat(50.0)]),
        ..Setup::new(world, Particles::default(), bodies)
    }
}

fn fill(setup: &mut Setup, places: &[DVec3], velocity: impl Fn(DVec3) -> DVec3) {
    let velocities: Vec<[f32; 3]> = places.iter().map(|&x| velocity(x).as_vec3().to_array()).collect();
    setup.particles.add(places, &velocities);
}

fn steps(simulation: &mut Simulation, count: u32) {
    for _ in 0..count {
        let report = simulation.step().unwrap();
        assert!(report.viscosity.error <= SolverSettings::default().viscosity.max_error, "{report:?}");
    }
}

fn baked(min: [f64; 3], max: [f64; 3]) -> Shape {
    shapes::baked(cuboid(DVec3::from(min), DVec3::from(max)), RADIUS, false).unwrap()
}

fn touched(body: BodyDescription, viscosity: f64, friction: f64) -> BodyDescription {
    BodyDescription { fluid_contact: FluidContact { viscosity, friction }, ..body }
}

/// How viscous Eq. 16 makes a cubic lattice of spacing r/2, in parts of nu: for a shear wave, cos(k . x) along
/// `direction`, the sum of its terms over nu k^2. Along the lattice's axes it is 0.7, along its diagonals more; 1 is
/// the mean over all directions.
fn lattice_part(wave: DVec3, direction: DVec3) -> f64 {
    let offsets = (-2..=2).flat_map(|x| (-2..=2).flat_map(move |y| (-2..=2).map(move |z| [x, y, z])));
    let term = |at: [i32; 3]| {
        let x = SPACING * DVec3::from_array(at.map(f64::from));
        let q = x.length() / RADIUS;
        // The cubic spline's slope.
        let falls = match q {
            q if q == 0.0 || q >= 1.0 => return 0.0,
            q if q <= 0.5 => 2.0 * q - 3.0 * q * q,
            q => (1.0 - q).powi(2),
        };
        let slope = 48.0 / PI / RADIUS.powi(4) * falls / x.length();
        let square = x.length_squared() + 0.01 * RADIUS * RADIUS;
        10.0 * SPACING.powi(3) * slope / square * x.dot(direction).powi(2) * (1.0 - wave.dot(x).cos())
    };
    offsets.map(term).sum::<f64>() / wave.length_squared()
}

/// A wave so long that only the lattice counts, along its axes.
fn along_axes() -> f64 {
    lattice_part(1e-2 * DVec3::Y, DVec3::X)
}

/// v = a cos(k . x) decays as exp(-nu k^2 t), in implicit steps as (1 + dt nu k^2)^-n; these are 8 times as long as
/// explicit ones. The rate of decay, in parts of that.
fn decay(wave: DVec3, direction: DVec3) -> f64 {
    let viscosity = 4.0;
    let mut setup = thick(viscosity, DVec3::ZERO, Vec::new());
    let counts = [24, 24, 19];
    let middle = 0.5 * SPACING * DVec3::from_array(counts.map(f64::from));
    let phase = |x: DVec3| wave.dot(x - middle).cos();
    fill(&mut setup, &block(DVec3::ZERO, counts), |x| 1e-3 * phase(x) * direction);
    let dt = 8.0 * RADIUS * RADIUS / (120.0 * viscosity);
    setup.solver.time_step.adaptive = false;
    setup.solver.time_step.initial = dt;
    let mut simulation = Simulation::new(setup).unwrap();
    let count = 6;
    steps(&mut simulation, count);
    // Far from the surface, where neighbours are missing.
    let inner = |x: DVec3| (x - middle).abs().cmplt(DVec3::new(4.1, 4.1, 3.1) * SPACING).all();
    let (mut sum, mut square) = (0.0, 0.0);
    for (x, v) in simulation.particles().positions.iter().zip(velocities(&simulation)) {
        if inner(*x) {
            (sum, square) = (sum + v.dot(direction) * phase(*x), square + phase(*x) * phase(*x));
        }
    }
    let each = (sum / square / 1e-3).powf(-1.0 / f64::from(count));
    (each - 1.0) / (dt * viscosity * wave.length_squared())
}

#[test]
fn a_shear_wave_decays_as_it_should() {
    let half = 0.5f64.sqrt();
    let diagonals = [DVec3::new(half, half, 0.0), DVec3::new(half, -half, 0.0)];
    for ([wave, direction], part) in [([DVec3::Y, DVec3::X], 0.69), (diagonals, 1.45)] {
        let wave = 2.0 * PI / (16.0 * SPACING) * wave;
        let (got, exact) = (decay(wave, direction), lattice_part(wave, direction));
        assert!((exact - part).abs() < 0.03, "{exact}");
        assert!((got / exact - 1.0).abs() < 0.02, "{got} {exact}");
    }
    // The mean over all directions of wave and velocity, and a long wave.
    let turns = (0..2000).map(|n: u32| {
        let [a, b, c] = [0.7549, 0.5698, 0.3247].map(|step| (f64::from(n) * step).fract());
        // A uniform rotation (Shoemake 1992).
        let (u, v) = ((1.0 - a).sqrt(), a.sqrt());
        let (b, c) = ((2.0 * PI * b).sin_cos(), (2.0 * PI * c).sin_cos());
        let turn = DQuat::from_xyzw(u * b.0, u * b.1, v * c.0, v * c.1);
        lattice_part(1e-2 * (turn * DVec3::Y), turn * DVec3::X)
    });
    let mean = turns.sum::<f64>() / 2000.0;
    assert!((mean - 1.0).abs() < 0.04, "{mean}");
}

/// Fluid between two plates, far from their ends: velocities along x at each height above the lower plate.
fn between_plates(mut setup: Setup, layers: u32, dt: f64, count: u32) -> (Vec<[f64; 2]>, Simulation) {
    fill(&mut setup, &block(DVec3::new(-15.0, 0.0, -9.0) * SPACING, [30, layers, 18]), |_| DVec3::ZERO);
    setup.solver.time_step.adaptive = false;
    setup.solver.time_step.initial = dt;
    let mut simulation = Simulation::new(setup).unwrap();
    steps(&mut simulation, count);
    let mut profile = vec![[0.0; 2]; layers as usize];
    let mut number = vec![0.0; layers as usize];
    for (x, v) in simulation.particles().positions.iter().zip(velocities(&simulation)) {
        if x.x.abs() < 2.0 * SPACING && x.z.abs() < 2.0 * SPACING {
            let layer = (x.y / SPACING) as usize;
            profile[layer] = [profile[layer][0] + x.y, profile[layer][1] + v.x];
            number[layer] += 1.0;
        }
    }
    (profile.iter().zip(number).map(|([y, v], n)| [y / n, v / n]).collect(), simulation)
}

fn plates(height: f64, viscosity: f64, top: Motion) -> Vec<BodyDescription> {
    let plate = baked([-1.0, -0.1, -0.7], [1.0, 0.1, 0.7]);
    [(-0.1, Motion::Static), (height + 0.1, top)]
        .map(|(y, motion)| touched(plate.body("plate", DVec3::Y * y, motion), viscosity, 0.0))
        .into()
}

/// No slip needs 0.155 of the fluid's viscosity at the wall, if the first layer lies RP from it: 1 / the sum over the
/// layers of 2 rp lambda(y) y, lambda the rate of Eq. 16 over nu_B at their heights y = rp and 3 rp.
const NO_SLIP: f64 = 0.155;

#[test]
fn no_slip_is_a_balance_of_forces() {
    let slows = |height: f64| SPACING * half_space_rate(height) * height;
    assert!((NO_SLIP * (slows(RP) + slows(3.0 * RP)) - 1.0).abs() < 2e-3);
}

/// v = g / (2 nu) y (H - y).
#[test]
fn flow_between_plates_is_a_parabola() {
    let (layers, viscosity, gravity) = (8, 2.0, 0.05);
    let height = f64::from(layers) * SPACING;
    let seen = viscosity * along_axes();
    let bodies = plates(height, NO_SLIP * seen, Motion::Static);
    let setup = thick(viscosity, DVec3::X * gravity, bodies);
    // Until nothing changes: (H / pi)^2 over what is left of nu is 0.012 s.
    let (profile, _) = between_plates(setup, layers, 1e-2, 15);
    let most = gravity * height * height / (8.0 * seen);
    for [y, v] in profile {
        let exact = gravity / (2.0 * seen) * y * (height - y);
        assert!((v - exact).abs() < 0.05 * most, "at {y} m: {} {}", v / most, exact / most);
    }
}

/// v = U y / H, and the plates are pulled by rho nu U / H for each area.
#[test]
fn flow_under_a_moving_plate_is_a_line() {
    let (layers, viscosity, speed) = (8, 2.0, 0.01);
    let height = f64::from(layers) * SPACING;
    let key = |time: f64| Key {
        time,
        translation: DVec3::new(speed * time, height + 0.1, 0.0),
        rotation: DQuat::IDENTITY,
    };
    let keys = Keys { keys: vec![key(0.0), key(10.0)], interpolation: Interpolation::Linear, repeat: false };
    let seen = viscosity * along_axes();
    let mut bodies = plates(height, NO_SLIP * seen, Motion::Prescribed(Path::Keys(keys)));
    // Keyframes are poses in the world.
    bodies[1].pose = Pose::default();
    let (profile, simulation) = between_plates(thick(viscosity, DVec3::ZERO, bodies), layers, 1e-2, 15);
    for [y, v] in profile {
        let exact = speed * y / height;
        assert!((v - exact).abs() < 0.05 * speed, "at {y} m: {} {}", v / speed, exact / speed);
    }
    // Less at the open ends.
    let area = 30.0 * 18.0 * SPACING * SPACING;
    let stress = 1000.0 * seen * speed / height;
    let [low, high] = [0, 1].map(|body| simulation.body_forces()[body][0].x / (area * stress));
    assert!((low + high).abs() < 0.01 && (0.8..1.02).contains(&low), "{low} {high}");
}

/// A block that is thrown, turns and is stirred becomes rigid, and loses none of its momenta.
#[test]
fn a_stiff_block_keeps_its_momenta() {
    for viscosity in [5.0, 1e9] {
        thrown_and_stirred(viscosity);
    }
}

fn thrown_and_stirred(viscosity: f64) {
    let mut setup = thick(viscosity, DVec3::ZERO, Vec::new());
    setup.solver.viscosity.max_error = 1e-2;
    let spin = DVec3::new(0.5, -1.0, 2.0);
    let stir = |x: DVec3| 0.3 * DVec3::new((61.0 * x.y).sin(), (47.0 * x.z).cos(), (83.0 * x.x).sin());
    fill(&mut setup, &block(DVec3::ZERO, [10, 9, 8]), |x| {
        DVec3::new(1.0, 0.5, 0.0) + spin.cross(x) + stir(x)
    });
    let mut simulation = Simulation::new(setup).unwrap();
    let [momentum, angular] = momenta(&simulation);
    let stirred = away(&simulation);
    let (before, mut energy) = (centre(&simulation), kinetic_energy(&simulation));
    for _ in 0..20 {
        let old = momenta(&simulation)[1];
        let report = simulation.step().unwrap();
        let [now, turn] = momenta(&simulation);
        assert!((now - momentum).length() < 1e-6 * momentum.length(), "{now} {momentum}");
        // Places are rounded to 1e-7 of the block's size, and forces are a hundred times the velocities' change.
        assert!((turn - old).length() < 1e-5 * angular.length(), "{turn} {old}");
        // The residual that is added back has 1e-2 of the velocities at most.
        let left = kinetic_energy(&simulation);
        assert!(left <= energy * (1.0 + 1e-4), "{left} {energy}");
        energy = left;
        assert!(report.viscosity.iterations > 0);
    }
    assert!(before.distance(centre(&simulation)) > 0.01);
    assert!(away(&simulation) < 0.1 * stirred, "{} of {stirred} m/s", away(&simulation));
}

/// The largest speed of a particle towards or away from the centre, which a rigid body doesn't have.
fn away(simulation: &Simulation) -> f64 {
    let (middle, count) = (centre(simulation), simulation.particles().len() as f64);
    let mean = momenta(simulation)[0] / (simulation.particle_mass() * count);
    let speed = |(x, v): (&DVec3, DVec3)| (v - mean).dot((*x - middle).normalize()).abs();
    simulation.particles().positions.iter().zip(velocities(simulation)).map(speed).fold(0.0, f64::max)
}

/// A drop on a plate that stands upright, with pressure and all: how far its centre falls in a fifth of a second.
fn fall(viscosity: f64, friction: f64) -> f64 {
    let plate = baked([-0.2, -1.0, -0.4], [0.0, 0.6, 0.4]);
    let body = touched(plate.body("plate", DVec3::ZERO, Motion::Static), viscosity, friction);
    let mut setup = thick(2.0, DVec3::NEG_Y * 9.81, vec![body]);
    setup.solver.density.enabled = true;
    setup.solver.divergence.enabled = true;
    fill(&mut setup, &block(DVec3::new(0.0, 0.0, -0.2), [3, 8, 8]), |_| DVec3::ZERO);
    let mut simulation = Simulation::new(setup).unwrap();
    let start = centre(&simulation);
    while simulation.time() < 0.2 {
        simulation.step().unwrap();
    }
    start.y - centre(&simulation).y
}

#[test]
fn a_drop_sticks_to_an_upright_plate() {
    let free = 0.5 * 9.81 * 0.2 * 0.2;
    let (loose, stuck, rubbed) = (fall(0.0, 0.0), fall(20.0, 0.0), fall(0.0, 20.0));
    assert!((loose / free - 1.0).abs() < 0.04, "{loose} of {free}");
    assert!(stuck < 0.1 * free, "{stuck} of {free}");
    assert!(rubbed < 0.15 * free, "tangential friction holds as well: {rubbed} of {free}");
    let glued = fall(1e9, 1e9);
    assert!(glued < 0.05 * free, "{glued} of {free}");
}

/// One layer of particles on a plane, each alone: v (1 + dt lambda)^-n, lambda by Eq. 19 for a half space's volume.
#[test]
fn tangential_friction_slows_as_its_closed_form_says() {
    let plane = baked([-1.0, -0.2, -1.0], [1.0, 0.0, 1.0]);
    let friction = 0.02;
    let body = touched(plane.body("plane", DVec3::ZERO, Motion::Static), 0.0, friction);
    let mut setup = thick(0.0, DVec3::ZERO, vec![body]);
    setup.fluid.viscosity_method = ViscosityMethod::Explicit;
    let height = RP;
    let places: Vec<DVec3> = (0..9).map(|n| DVec3::new(-0.5 + 0.11 * f64::from(n), height, 0.1)).collect();
    fill(&mut setup, &places, |_| DVec3::new(0.01, 0.0, -0.02));
    setup.solver.time_step.adaptive = false;
    setup.solver.time_step.initial = 2e-3;
    let mut simulation = Simulation::new(setup).unwrap();
    steps(&mut simulation, 20);
    let lost = 1.0 + 2e-3 * friction * half_space_rate(height);
    for v in velocities(&simulation) {
        let exact = DVec3::new(0.01, 0.0, -0.02) / lost.powi(20);
        assert!((v - exact).length() < 0.02 * exact.length(), "{v} {exact}");
    }
}

/// The rate of Eq. 19 for each friction, 1/m^2, at a height over a plane; cubic spline, volume by Eq. 12 and 13.
fn half_space_rate(height: f64) -> f64 {
    let extension = |d: f64| match d / RADIUS {
        q if q <= 0.0 => 1.0,
        q if q <= 0.5 => 6.0 * (q.powi(3) - q.powi(2)) + 1.0,
        q => 2.0 * (1.0 - q.min(1.0)).powi(3),
    };
    const PARTS: u32 = 4000;
    let slice = |n: u32| {
        let z = RADIUS * ((f64::from(n) + 0.5) * 2.0 / f64::from(PARTS) - 1.0);
        PI * (RADIUS * RADIUS - z * z) * extension(height + z) * 2.0 * RADIUS / f64::from(PARTS)
    };
    let volume: f64 = (0..PARTS).map(slice).sum();
    let along = 0.5 * RADIUS;
    let distance = along.hypot(height);
    let q = distance / RADIUS;
    let slope = 48.0 / PI / RADIUS.powi(4) * (1.0 - q).powi(2);
    2.0 * 10.0 * 0.25 * volume * along * along * slope
        / distance
        / (distance * distance + 0.01 * RADIUS * RADIUS)
}

/// Fig. 14 of Bender et al. 2020, of a stiff fluid instead of an elastic cube: the more friction, the shorter the way.
#[test]
fn the_way_slid_falls_with_the_coefficient() {
    let plane = baked([-1.0, -0.2, -0.5], [1.5, 0.0, 0.5]);
    let way = |friction: f64| {
        let body = touched(plane.body("plane", DVec3::ZERO, Motion::Static), 0.0, friction);
        let mut setup = thick(1.0, DVec3::NEG_Y * 9.81, vec![body]);
        setup.solver.density.enabled = true;
        setup.solver.divergence.enabled = true;
        fill(&mut setup, &block(DVec3::new(-0.8, 0.0, -0.1), [4, 4, 4]), |_| 2.0 * DVec3::X);
        let mut simulation = Simulation::new(setup).unwrap();
        let start = centre(&simulation);
        while simulation.time() < 0.3 {
            simulation.step().unwrap();
        }
        (centre(&simulation) - start).x
    };
    let frictions = [0.0, 0.00025, 0.0005, 0.001, 0.002, 0.004];
    let ways = frictions.map(way);
    for pair in ways.windows(2) {
        assert!(pair[1] < 0.95 * pair[0], "{ways:?}");
    }
    // One layer of four is at RP from the plane, and slows all: v (1 - exp(-lambda t)) / lambda.
    for (friction, way) in frictions.into_iter().zip(ways) {
        let lambda = friction * half_space_rate(RP) / 4.0;
        let exact = if lambda > 0.0 { 2.0 * (1.0 - (-0.3 * lambda).exp()) / lambda } else { 0.6 };
        assert!((way / exact - 1.0).abs() < 0.2, "{friction}: {way} {exact}");
    }
}

/// A light cube flies into a block of fluid that sticks to it; nothing else is there.
#[test]
fn fluid_and_free_body_keep_their_momentum() {
    let cube = baked([-0.15; 3], [0.15; 3]);
    for method in [ViscosityMethod::Implicit, ViscosityMethod::Explicit] {
        let free = FreeBody {
            weight: Weight::Density(100.0),
            velocity: DVec3::new(-1.0, 0.3, 0.0),
            angular_velocity: DVec3::new(0.0, 3.0, 2.0),
            ..FreeBody::default()
        };
        let body = cube.body("cube", DVec3::new(0.6, 0.3, 0.3), Motion::Free(free));
        let mut setup = thick(1.0, DVec3::ZERO, vec![touched(body, 2.0, 0.5)]);
        setup.fluid.viscosity_method = method;
        setup.solver.density.enabled = true;
        setup.solver.divergence.enabled = true;
        if method == ViscosityMethod::Explicit {
            setup.fluid.viscosity = 0.05;
        }
        fill(&mut setup, &block(DVec3::ZERO, [8, 11, 10]), |_| DVec3::X);
        let mut simulation = Simulation::new(setup).unwrap();
        let state = |simulation: &Simulation| {
            let ([momentum, angular], body) = (momenta(simulation), simulation.bodies().totals());
            let energy = kinetic_energy(simulation) + body.kinetic_energy;
            ([momentum + body.momentum, angular + body.angular_momentum], energy)
        };
        let ([momentum, angular], energy) = state(&simulation);
        let mut iterations = 0;
        while simulation.time() < 0.2 {
            let report = simulation.step().unwrap();
            iterations += report.viscosity.iterations;
            assert!(report.viscosity.error <= 1e-3, "{report:?}");
            let ([now, turn], left) = state(&simulation);
            assert!((now - momentum).length() < 3e-6 * momentum.length(), "{method:?} {}", now - momentum);
            assert!((turn - angular).length() < 5e-3 * angular.length(), "{method:?} {}", turn - angular);
            assert!(left < energy * 1.001, "{left} {energy}");
        }
        let (velocity, fluid) = (simulation.bodies().state(0).velocity, momenta(&simulation)[0]);
        let mean = fluid / (simulation.particle_mass() * simulation.particles().len() as f64);
        assert!(
            iterations > 10 && velocity.x > 0.5 * mean.x,
            "the fluid carries the cube along: {velocity} {mean}"
        );
    }
}
