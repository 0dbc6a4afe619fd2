//! A random scene from a number: fluid, bodies, emitters and settings across their allowed range.

use crate::methods::{self, PRESSURES, View};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::sync::{Arc, LazyLock, Mutex, OnceLock};
use volmap_fluid::Error;
use volmap_fluid::bodies::{
    Bodies, BodyDescription, ContactMaterial, FluidContact, FreeBody, Interpolation, Key, Keys, Motion, Path,
    Spin, Weight,
};
use volmap_fluid::emitter::{Emitter, Jet};
use volmap_fluid::forces::viscosity::viscous_weights;
use volmap_fluid::lattice::fill_box;
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{
    BoundaryMethod, BoundaryPressure, FluidSettings, MOST_RELAXATION, SolveSettings, SolverSettings,
    TimeStepSettings, ViscosityMethod, World,
};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{Shape, ball, cuboid};
use volmap_fluid::simulation::Simulation;
use volmap_runtime::{ClosureKind, DQuat, DVec3, KernelKind, Pose};

/// Particles at most, of blocks; emitters add some.
pub const MOST_PARTICLES: usize = 500;
pub const RP: f64 = 0.025;
/// What moves less than this counts as still, m/s.
const STILL: f64 = 0.05;
/// From here on viscosity is solved for in double precision.
const DOUBLE_PRECISION: f64 = 1e4;
/// Two blocks are so many rp apart: as near as a lattice's particles they would begin pressed together.
const APART: f64 = 2.5;
/// Half of the edge of the tank, and of the space that all is put into without one, metres.
const HALF: f64 = 0.35;

/// A scene, and what is known of it.
pub struct Scene {
    /// Before its first step.
    pub simulation: Simulation,
    /// m/s^2.
    pub gravity: DVec3,
    /// Whether the boundary's pressure is the default.
    pub has_default_pressure: bool,
    /// What its energy is compared with, joule.
    pub energy: f64,
    /// How often over viscosity takes a particle's velocity in a step, where that is solved for in single precision.
    pub stiffness: f64,
    /// Whether some body does what it is told, or an emitter gives energy.
    pub is_driven: bool,
    /// Whether something static takes momentum, or something driven gives it.
    pub has_ground: bool,
    /// Whether there are emitters.
    pub emits: bool,
    /// Largest speed of a prescribed body, m/s.
    pub driving_speed: f64,
    /// Steps to go.
    pub steps: usize,
    /// What it is like, in words.
    pub words: String,
}

/// SplitMix64 (Steele et al. 2014).
pub struct Dice(pub u64);

impl Dice {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly in the logarithm.
    fn scale(&mut self, low: f64, high: f64) -> f64 {
        self.within(low.ln(), high.ln()).exp()
    }

    fn below(&mut self, count: usize) -> usize {
        (self.bits() % count as u64) as usize
    }

    fn chance(&mut self, part: f64) -> bool {
        self.within(0.0, 1.0) < part
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn vector(&mut self, half: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_: i32| self.within(-half, half)))
    }

    fn direction(&mut self) -> DVec3 {
        let [turn, height] = [self.within(0.0, TAU), self.within(-1.0, 1.0)];
        let across = (1.0 - height * height).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), height)
    }

    fn rotation(&mut self) -> DQuat {
        if self.chance(0.3) {
            return DQuat::IDENTITY;
        }
        DQuat::from_axis_angle(self.direction(), self.within(0.0, PI))
    }
}

/// Solids by number, the last of them the tank; the radius of the ball around each.
const SOLIDS: [f64; 4] = [0.128, 0.09, 0.172, 0.121];
const TANK: usize = SOLIDS.len();

/// By the view's name and the solid's number.
type Maps = HashMap<(String, usize), Arc<OnceLock<Shape>>>;

/// A solid's mesh with the map for a view; each is baked once.
fn shape(view: View, number: usize) -> Shape {
    static MAPS: LazyLock<Mutex<Maps>> = LazyLock::new(Mutex::default);
    let half = |x: f64, y: f64, z: f64| cuboid(-DVec3::new(x, y, z), DVec3::new(x, y, z));
    let slot = MAPS.lock().unwrap().entry((format!("{view:?}"), number)).or_default().clone();
    let bake = || {
        let mesh = match number {
            0 => half(0.1, 0.05, 0.06),
            1 => ball(SOLIDS[1], 3),
            2 => half(0.15, 0.02, 0.08),
            3 => half(0.07, 0.07, 0.07),
            _ => half(HALF, HALF, HALF),
        };
        methods::shape(mesh, &methods::world(view), number == TANK)
    };
    slot.get_or_init(bake).clone()
}

/// Distance from walls at which a fluid isn't pushed away at the start, rp.
fn clearance((boundary, closure): View) -> f64 {
    match (boundary, closure) {
        (BoundaryMethod::VolumeMap, ClosureKind::Paper) => 3.2,
        (BoundaryMethod::VolumeMap, ClosureKind::Offset) => 2.7,
        (BoundaryMethod::VolumeMap, _) => 1.1,
        (BoundaryMethod::DensityMap, _) => 2.3,
        (BoundaryMethod::TubeMap, _) => 2.3,
        (BoundaryMethod::Particles, _) => 2.5,
    }
}

impl Scene {
    /// The scene of a number.
    ///
    /// # Errors
    /// What a library says of a scene that can't be.
    pub fn new(seed: u64) -> Result<Scene, Error> {
        let mut dice = Dice(seed.wrapping_mul(0x2545_f491_4f6c_dd1d));
        let view = dice.pick(&methods::views());
        let mut world = methods::world(view);
        if view.0 != BoundaryMethod::DensityMap && dice.chance(0.2) {
            world.kernel = dice.pick(&[KernelKind::WendlandC2, KernelKind::Spiky, KernelKind::Poly6]);
        }
        world.gravity = match dice.below(3) {
            0 => DVec3::ZERO,
            1 => DVec3::new(0.0, -9.81, 0.0),
            _ => dice.scale(0.1, 30.0) * dice.direction(),
        };
        let fluid = fluid(&mut dice, &world);
        let solver = solver(&mut dice, &fluid, &world);
        let (descriptions, driving_speed) = bodies(&mut dice, view, fluid.rest_density);
        let has_ground = descriptions.iter().any(|body| !matches!(body.motion, Motion::Free(_)));
        let moves = |body: &BodyDescription| matches!(body.motion, Motion::Prescribed(_));
        let is_moved = descriptions.iter().any(moves);
        let kinds: Vec<String> = descriptions.iter().map(words_of).collect();
        let bodies = Bodies::new(descriptions, world.gravity)?;
        let particles = blocks(&mut dice, &bodies, clearance(view));
        let emitters = if dice.chance(0.15) { vec![emitter(&mut dice)] } else { Vec::new() };
        let emits = !emitters.is_empty();
        let has_default_pressure = solver.boundary_pressure == BoundaryPressure::Own;
        let words = format!(
            "{:?} {:?} {:?}, {:?}, g {:.1}, nu {:.1e} {:?}, xsph {:.2}, {} particles, [{}]{}, \
             relaxation {:.2}, warm {:.2}, dt {:.1e}",
            view.0,
            view.1,
            solver.boundary_pressure,
            world.kernel,
            world.gravity.length(),
            fluid.viscosity,
            fluid.viscosity_method,
            fluid.xsph,
            particles.len(),
            kinds.join(", "),
            if emits { ", an emitter" } else { "" },
            solver.relaxation,
            solver.warm_start,
            solver.time_step.max,
        );
        let domain = Some([DVec3::splat(-100.0), DVec3::splat(100.0)]);
        let steps = 60 + dice.below(120);
        let [_, implicit] = fluid.viscosities();
        let exchanged = solver.time_step.max * implicit * viscous_weights(&world);
        let stiffness = if exchanged > DOUBLE_PRECISION { 0.0 } else { exchanged };
        let setup = Setup { fluid, solver, emitters, domain, ..Setup::new(world, particles, bodies) };
        let gravity = setup.world.gravity;
        let simulation = Simulation::new(setup)?;
        let energy = scale(&simulation, gravity.length());
        let is_driven = is_moved || emits;
        Ok(Scene {
            simulation,
            gravity,
            has_default_pressure,
            energy,
            stiffness,
            is_driven,
            has_ground,
            emits,
            driving_speed,
            steps,
            words,
        })
    }
}

impl Scene {
    /// A speed, m/s, that nothing in the scene can reach: thrice what all of the energy gives the first of all
    /// particles that are pressed out of the way by a driven body, or a fall.
    pub fn most_speed(&self) -> f64 {
        let fluid = self.simulation.particle_mass() * self.simulation.particles().len().max(1) as f64;
        let given = (2.0 * self.energy / fluid).sqrt();
        let fall = (2.0 * self.gravity.length() * 4.0 * HALF).sqrt();
        3.0 * (4.0 + given + fall) + 12.0 * self.driving_speed
    }
}

/// Kinetic energy at the start, and what a fall through the scene gives, joule.
fn scale(simulation: &Simulation, gravity: f64) -> f64 {
    let bodies = simulation.bodies();
    let heavy = (0..bodies.posed().len()).filter_map(|body| bodies.mass(body)).map(|mass| mass.mass);
    let mass = simulation.particle_mass() * simulation.particles().len() as f64 + heavy.sum::<f64>();
    let kinetic = volmap_fluid::observe::kinetic_energy(simulation) + bodies.totals().kinetic_energy;
    kinetic + mass * (gravity * HALF + 0.5 * STILL * STILL)
}

fn words_of(body: &BodyDescription) -> String {
    let motion = match &body.motion {
        Motion::Static => "static".into(),
        Motion::Prescribed(Path::Spin(spin)) => format!("spin {:.1} rad/s", spin.speed),
        Motion::Prescribed(Path::Keys(_)) => "keys".into(),
        Motion::Free(FreeBody { weight: Weight::Density(density), .. }) => format!("free {density:.2e}"),
        Motion::Free(_) => "free".into(),
    };
    let drag = if body.fluid_contact == FluidContact::default() { "" } else { " drag" };
    format!("{} {motion}{drag}", body.name)
}

fn fluid(dice: &mut Dice, world: &World) -> FluidSettings {
    let viscosity_method =
        if dice.chance(0.5) { ViscosityMethod::Explicit } else { ViscosityMethod::Implicit };
    // An explicit one is stable with steps of 1e-4 s.
    let explicit = world.support_radius.powi(2) / 120.0 / 2e-4;
    let viscosity = match viscosity_method {
        ViscosityMethod::Explicit => dice.scale(1e-7, explicit),
        ViscosityMethod::Implicit => dice.scale(1e-6, 1e9),
    };
    FluidSettings {
        rest_density: dice.scale(1e-3, 1e6),
        viscosity: if dice.chance(0.2) { 0.0 } else { viscosity },
        viscosity_method,
        xsph: if dice.chance(0.1) { dice.within(0.0, 1.0) } else { 0.0 },
        volume_factor: 1.0,
    }
}

fn solver(dice: &mut Dice, fluid: &FluidSettings, world: &World) -> SolverSettings {
    let own = dice.chance(0.4);
    let boundary_pressure = if own { BoundaryPressure::Own } else { dice.pick(&PRESSURES) };
    let mut solver = SolverSettings { boundary_pressure, ..SolverSettings::default() };
    if dice.chance(0.4) {
        solver.density = SolveSettings {
            enabled: true,
            max_error: dice.scale(1e-5, 1e-2),
            min_iterations: 2,
            max_iterations: 2 + dice.below(150) as u32,
        };
        solver.divergence = SolveSettings { enabled: dice.chance(0.8), ..solver.density.clone() };
        solver.divergence.min_iterations = 1;
    }
    if dice.chance(0.3) {
        solver.relaxation = dice.within(0.1, MOST_RELAXATION);
        solver.warm_start = dice.within(0.0, 1.0);
    }
    if dice.chance(0.3) {
        solver.viscosity.max_error = dice.scale(1e-7, 0.5);
        solver.viscosity.max_iterations = 1 + dice.below(200) as u32;
    }
    if dice.chance(0.4) {
        let max = dice.scale(2e-4, 4e-3);
        let adaptive = dice.chance(0.8);
        let limit = volmap_fluid::forces::viscosity::viscous_limit(fluid, world);
        let initial = if adaptive { max.min(1e-3) } else { max.min(limit) };
        let cfl_factor = dice.within(0.3, 1.2);
        solver.time_step = TimeStepSettings { initial, adaptive, cfl_factor, min: 1e-4, max };
    }
    solver
}

/// Up to four bodies, none of which begins in another, and the largest speed of those that are moved.
fn bodies(dice: &mut Dice, view: View, rest_density: f64) -> (Vec<BodyDescription>, f64) {
    let (mut all, mut balls, mut fastest) = (Vec::new(), Vec::<(DVec3, f64)>::new(), 0.0_f64);
    let in_tank = dice.chance(0.4);
    if in_tank {
        all.push(shape(view, TANK).body("tank", DVec3::ZERO, Motion::Static));
    }
    let only_free = !in_tank && dice.chance(0.6);
    for n in 0..dice.below(5 - usize::from(in_tank)) {
        let number = dice.below(SOLIDS.len());
        let radius = SOLIDS[number];
        let place = dice.vector(HALF - radius - 0.01);
        if balls.iter().any(|(x, other)| x.distance(place) < radius + other + 0.005) {
            continue;
        }
        balls.push((place, radius));
        let (motion, speed) = motion(dice, only_free, place, rest_density);
        fastest = fastest.max(speed);
        let name = format!("{n} {}", ["box", "ball", "plate", "cube"][number]);
        let mut body = shape(view, number).body(&name, place, motion);
        body.pose = Pose { translation: place, rotation: dice.rotation() };
        body.material =
            ContactMaterial { friction: dice.within(0.0, 1.0), restitution: dice.within(0.0, 0.8) };
        if dice.chance(0.2) {
            let [viscosity, friction] = [0; 2].map(|_: i32| dice.scale(1e-4, 1e4));
            body.fluid_contact = FluidContact { viscosity, friction };
        }
        all.push(body);
    }
    if dice.chance(0.15) {
        all.truncate(3);
        all.extend(gap(dice, view, &all, &balls));
    }
    (all, fastest)
}

/// A static plate near another static body's place: a narrow gap.
fn gap(
    dice: &mut Dice,
    view: View,
    all: &[BodyDescription],
    balls: &[(DVec3, f64)],
) -> Option<BodyDescription> {
    let (n, plate) = all
        .iter()
        .enumerate()
        .find(|(_, body)| body.name.ends_with("plate") && matches!(body.motion, Motion::Static))?;
    let way = plate.pose.rotation * DVec3::Y * (0.04 + dice.within(0.8, 3.0) * RP);
    let place = plate.pose.translation + way;
    let own = |x: &DVec3| *x == plate.pose.translation;
    let is_free = balls.iter().filter(|(x, _)| !own(x)).all(|(x, r)| x.distance(place) > r + SOLIDS[2]);
    let mut other = shape(view, 2).body(&format!("{n} gap"), place, Motion::Static);
    other.pose.rotation = plate.pose.rotation;
    is_free.then_some(other)
}

fn motion(dice: &mut Dice, only_free: bool, place: DVec3, rest_density: f64) -> (Motion, f64) {
    let kind = if only_free { 3 } else { dice.below(6) };
    match kind {
        0 => (Motion::Static, 0.0),
        1 => {
            let spin = Spin { axis: dice.direction(), centre: place, speed: dice.within(-20.0, 20.0) };
            (Motion::Prescribed(Path::Spin(spin)), spin.speed.abs() * SOLIDS[2])
        }
        2 => {
            let (way, time) = (dice.vector(0.15), dice.within(0.1, 1.0));
            let key = |time: f64, translation: DVec3| Key { time, translation, rotation: DQuat::IDENTITY };
            let keys = vec![key(0.0, DVec3::ZERO), key(time, way), key(2.0 * time, DVec3::ZERO)];
            let interpolation = dice.pick(&[Interpolation::Linear, Interpolation::Smooth]);
            let keys = Keys { keys, interpolation, repeat: true };
            (Motion::Prescribed(Path::Keys(keys)), 2.0 * way.length() / time)
        }
        _ => {
            let free = FreeBody {
                weight: Weight::Density(rest_density * dice.scale(0.01, 100.0)),
                velocity: if dice.chance(0.5) { dice.vector(1.5) } else { DVec3::ZERO },
                angular_velocity: if dice.chance(0.5) { dice.vector(6.0) } else { DVec3::ZERO },
                ..FreeBody::default()
            };
            (Motion::Free(free), 0.0)
        }
    }
}

/// One or two blocks of fluid, where there is room.
fn blocks(dice: &mut Dice, bodies: &Bodies, clearance: f64) -> Particles {
    let mut particles = Particles::default();
    let clearance = RP * (clearance + dice.within(0.0, 1.0));
    for _ in 0..1 + dice.below(2) {
        let half = DVec3::from_array([0; 3].map(|_: i32| dice.within(0.05, 0.25)));
        let middle = dice.vector(HALF).clamp(half - HALF, DVec3::splat(HALF) - half);
        let velocity = if dice.chance(0.6) { dice.vector(2.0) } else { DVec3::ZERO };
        let is_free = |x: &DVec3| {
            let away = bodies.posed().iter().all(|body| body.values(*x).distance >= clearance);
            away && particles.positions.iter().all(|other| other.distance(*x) >= APART * RP)
        };
        let mut places: Vec<DVec3> =
            fill_box([middle - half, middle + half], 2.0 * RP).filter(is_free).collect();
        places.truncate(MOST_PARTICLES - particles.len());
        particles.add(&places, &vec![velocity.as_vec3().to_array(); places.len()]);
    }
    particles
}

fn emitter(dice: &mut Dice) -> Emitter {
    let direction = dice.direction();
    let right = direction.any_orthonormal_vector();
    let (up, middle) = (right.cross(direction), dice.vector(0.5 * HALF));
    let [width, height] = [0; 2].map(|_: i32| 1 + dice.below(4));
    let place = |n: usize| {
        let (x, y) = ((n % width) as f64, (n / width) as f64);
        middle + 2.0 * RP * (x * right + y * up)
    };
    let jet = Jet {
        direction,
        speed: dice.within(0.2, 3.0),
        layers: vec![(0..width * height).map(place).collect()],
        spacing: 2.0 * RP,
        start: dice.within(0.0, 0.05),
        stop: None,
        max_particles: 200,
    };
    Emitter::new(jet)
}
