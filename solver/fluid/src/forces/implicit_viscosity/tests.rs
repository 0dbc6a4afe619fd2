//! The viscous solve against the whole system as a dense matrix: all pairs, the four points of every particle near a
//! body, and the bodies' velocities as unknowns.

use super::*;
use crate::bodies::{Bodies, BodyDescription, FluidContact, FreeBody, Motion, Weight};
use crate::discretization::Discretization;
use crate::fields::Fields;
use crate::neighbours::tests::{Arranged, arrange_with, random, random_points};
use crate::settings::ViscosityMethod;
use crate::shapes::{Shape, baked, cuboid};
use nalgebra::{DMatrix, DVector};
use volmap_runtime::{ClosureKind, DQuat, Dimension, Kernel, KernelKind, Pose, Sample};

const RADIUS: f64 = 0.1;
const VOLUME: f64 = 1.25e-4;
const MASS: f64 = 0.125;
const DT: f64 = 2e-3;
const VISCOSITY: f64 = 0.8;
const KIND: KernelKind = KernelKind::CubicSpline;
const EXACTLY: ViscositySolveSettings =
    ViscositySolveSettings { max_error: 3e-6, max_iterations: 1000, max_passes: 1 };

/// A fluid around a free body, and a moving plate.
struct Scene {
    positions: Vec<DVec3>,
    fields: Fields,
    neighbours: Neighbours,
    boundary: Boundary,
    bodies: Bodies,
}

/// A slab, of which both bodies are made.
fn shape() -> Shape {
    let mesh = cuboid(DVec3::new(-0.15, -0.06, -0.1), DVec3::new(0.15, 0.06, 0.1));
    baked(mesh, RADIUS, false).unwrap()
}

fn bodies(shape: &Shape, locked: bool) -> Bodies {
    bodies_touched(shape, locked, |contact| contact)
}

fn bodies_touched(shape: &Shape, locked: bool, touched: impl Fn(FluidContact) -> FluidContact) -> Bodies {
    let free = FreeBody {
        weight: Weight::Density(150.0),
        velocity: DVec3::new(0.3, if locked { 0.0 } else { -0.5 }, 0.2),
        angular_velocity: DVec3::new(if locked { 0.0 } else { 2.0 }, 1.0, -3.0),
        locked_translation: [false, locked, false],
        locked_rotation: [locked, false, false],
    };
    let rotation = DQuat::from_axis_angle(DVec3::new(0.48, 0.6, 0.64), 0.7);
    let first = BodyDescription {
        pose: Pose { rotation, ..Pose::default() },
        fluid_contact: touched(FluidContact { viscosity: 3.0, friction: 1.0 }),
        ..shape.body("slab", DVec3::ZERO, Motion::Free(free))
    };
    let plate = BodyDescription {
        fluid_contact: touched(FluidContact { viscosity: 0.0, friction: 0.5 }),
        ..shape.body("plate", DVec3::new(0.1, -0.3, 0.0), Motion::Static)
    };
    let mut bodies = Bodies::new(vec![first, plate], DVec3::new(0.0, -9.81, 0.0)).unwrap();
    bodies.apply(0, DVec3::new(1.0, 2.0, 0.5), DVec3::new(-0.1, 0.05, 0.02));
    bodies
}

fn scene(shape: &Shape, locked: bool, count: usize) -> Scene {
    let bodies = bodies(shape, locked);
    let outside = |x: &DVec3| bodies.posed().iter().all(|map| map.values(*x).distance > 0.02);
    let cloud: Vec<DVec3> =
        random_points(60 * count, 0.55, 5).into_iter().map(|x| x - 0.3).filter(outside).take(count).collect();
    let Arranged { positions, mut fields, neighbours } = arrange_with(&cloud, with());
    let mut boundary = Boundary::new(&world(), &FluidSettings::default(), &bodies).unwrap();
    boundary.sample(&bodies, &positions, &neighbours);
    fields.compute_density(&boundary);
    let last = positions.len();
    fields.velocities = field(last, 7);
    Scene { positions, fields, neighbours, boundary, bodies }
}

fn world() -> World {
    World { particle_radius: 0.25 * RADIUS, support_radius: RADIUS, kernel: KIND, ..World::default() }
}

fn with() -> Discretization {
    Discretization {
        kernel: KIND,
        support_radius: RADIUS,
        volume: VOLUME,
        rest_sum: 1.0,
        gradient_scale: 1.0,
        dimension: Dimension::Three,
    }
}

/// One vector for each particle.
fn field(count: usize, seed: u64) -> Vec<Quad> {
    let mut next = random(seed);
    let mut quad = || [(); 3].map(|()| (2.0 * next() - 1.0) as f32);
    let quads = (0..count).map(|_| quad()).map(|[x, y, z]| [x, y, z, 0.0]);
    quads.collect()
}

impl Scene {
    /// Velocities, and the body by the forces that it gets, are those of the dense solution, to these errors (m/s, and
    /// parts); the body's velocity there.
    fn assert_is(&self, exact: &[f64], velocities: &[DVec3], forces: &[[DVec3; 2]], most: [f64; 2]) -> DVec3 {
        let at = |n: usize| DVec3::new(exact[3 * n], exact[3 * n + 1], exact[3 * n + 2]);
        for (n, got) in velocities.iter().enumerate() {
            assert!((*got - at(n)).length() < most[0], "{n}: {got} {}", at(n));
        }
        let moved = self.bodies.response(0, forces[0][0], forces[0][1]);
        for (part, known) in self.known().into_iter().enumerate() {
            let (got, wanted) = (known + DT * moved[part], at(velocities.len() + part));
            assert!((got - wanted).length() < most[1] * wanted.length(), "{part}: {got} {wanted}");
        }
        at(velocities.len())
    }

    /// The same with surfaces of so large coefficients.
    fn touched(mut self, shape: &Shape, coefficient: f64) -> Scene {
        let contact = FluidContact { viscosity: coefficient, friction: coefficient };
        self.bodies = bodies_touched(shape, false, |_| contact);
        self.boundary.sample(&self.bodies, &self.positions, &self.neighbours);
        self
    }

    fn system(&self) -> System<'_> {
        System {
            neighbours: &self.neighbours,
            boundary: &self.boundary,
            carried: Carried::new(&self.bodies, &self.boundary, MASS, DT),
            viscosity: VISCOSITY,
            dt: DT,
        }
    }

    /// Velocities, changes and forces.
    fn solve(&self, settings: &ViscositySolveSettings) -> (SolveReport, Vec<DVec3>, Motions) {
        let (mut velocities, mut solver) = (self.fields.velocities.clone(), Solver::default());
        let mut changes = vec![[0.0; 3]; self.positions.len()];
        let solved = solver.solve(&self.system(), settings, &mut velocities, &mut changes);
        let velocities: Vec<DVec3> = velocities.iter().map(|&v| carried::velocity(v)).collect();
        for ((after, before), change) in velocities.iter().zip(&self.fields.velocities).zip(changes) {
            let change = DVec3::from_array(change.map(f64::from));
            assert!((*after - carried::velocity(*before) - change).length() < 1e-6);
        }
        (solved.report, velocities[..self.positions.len()].to_vec(), solved.on_bodies)
    }

    /// What the force makes of a viscosity; the stiff solver in any case, if `stiff`.
    fn act(
        &self,
        viscosity: f64,
        settings: &ViscositySolveSettings,
        stiff: bool,
    ) -> (SolveReport, Vec<DVec3>, Motions) {
        let (world, mut velocities) = (world(), self.fields.velocities.clone());
        let fluid =
            FluidSettings { viscosity, viscosity_method: ViscosityMethod::Implicit, ..Default::default() };
        let step = ForceStep {
            dt: DT,
            world: &world,
            with: with(),
            particle_mass: MASS,
            neighbours: &self.neighbours,
            boundary: &self.boundary,
            bodies: &self.bodies,
            positions: &self.positions,
            places: &self.fields.places,
            densities: &self.fields.densities,
        };
        let mut channels = Channels::default();
        channels.declare(CHANGES, velocities.len()).unwrap();
        let mut force = ImplicitViscosity::new(&fluid, &world, settings);
        let solved = match stiff {
            true => {
                let changes = channels.vectors_mut(CHANGES.name);
                force.stiff.solve(&self.system(), &step, settings, &mut velocities, changes)
            }
            false => force.solve(&step, &mut velocities, &mut channels).unwrap(),
        };
        (solved.report, velocities.iter().map(|&v| carried::velocity(v)).collect(), solved.on_bodies)
    }

    /// Momentum and angular momentum about the origin, where the slab's centre is, that a solve loses, the sum of the
    /// sizes of all that is exchanged, and the energy that particles and free body gain.
    fn balance(&self, velocities: &[DVec3], forces: &Motions) -> ([DVec3; 2], f64, f64) {
        let (mut lost, mut size, mut energy) = ([DVec3::ZERO; 2], 0.0, 0.0);
        for ((after, before), x) in velocities.iter().zip(&self.fields.velocities).zip(&self.positions) {
            let before = carried::velocity(*before);
            let change = MASS * (*after - before);
            lost = [lost[0] + change, lost[1] + x.cross(change)];
            size += change.length();
            energy += 0.5 * change.dot(*after + before);
        }
        for (body, [push, turn]) in forces.iter().enumerate() {
            let arm = self.bodies.center_of_mass(body);
            lost = [lost[0] + DT * *push, lost[1] + DT * (*turn + arm.cross(*push))];
        }
        let ([push, turn], known) = (forces[0], self.known());
        let moved = self.bodies.response(0, push, turn);
        energy += DT * push.dot(known[0] + 0.5 * DT * moved[0]);
        energy += DT * turn.dot(known[1] + 0.5 * DT * moved[1]);
        (lost, size, energy)
    }

    /// Velocity of the free body at its centre and about it, by gravity and what was applied.
    fn known(&self) -> [DVec3; 2] {
        let (state, [linear, angular]) = (self.bodies.state(0), self.bodies.acceleration(0));
        [state.velocity + DT * linear, state.angular_velocity + DT * angular]
    }

    /// Accelerations of all particles by viscosity and bodies, Eq. 16 to 19, and what the free body gets for each mass.
    fn exchange(&self, velocities: &[DVec3], body: [DVec3; 2]) -> (Vec<DVec3>, [DVec3; 2]) {
        let kernel = Kernel::new(KIND, RADIUS);
        let term = |x: DVec3, apart: DVec3, volume: f64| {
            let slope = x.normalize_or_zero() * kernel.derivative(x.length());
            10.0 * volume * apart.dot(x) / (x.length_squared() + 0.01 * RADIUS * RADIUS) * slope
        };
        let map = &self.bodies.posed()[0].map;
        let closure = map.closure(ClosureKind::Mirror, kernel, 0.25 * RADIUS).unwrap();
        let (mut out, mut pushes) = (Vec::new(), [DVec3::ZERO; 2]);
        for (i, x) in self.positions.iter().enumerate() {
            let mut sum = DVec3::ZERO;
            for (other, velocity) in self.positions.iter().zip(velocities) {
                sum += VISCOSITY * term(*x - *other, velocities[i] - *velocity, VOLUME);
            }
            for (at, map) in self.bodies.posed().iter().enumerate() {
                let Sample::Near(near) = map.sample(*x) else { continue };
                let [sticks, rubs] =
                    [self.bodies.fluid_contact(at).viscosity, self.bodies.fluid_contact(at).friction];
                let volume = closure.volume(&near);
                let t = near.normal.any_orthonormal_vector();
                let [linear, angular] = if at == 0 { body } else { [DVec3::ZERO; 2] };
                let arm = |x: DVec3| x - self.bodies.center_of_mass(at);
                for tangent in [t, -t, near.normal.cross(t), -near.normal.cross(t)] {
                    let point = near.closest_point + 0.5 * RADIUS * tangent;
                    let apart = velocities[i] - linear - angular.cross(arm(point));
                    // Friction sees the body's velocity continued to the particle.
                    let slip = (velocities[i] - linear - angular.cross(arm(*x))).reject_from(near.normal);
                    let force = sticks * term(*x - point, apart, 0.25 * volume)
                        + rubs * term(*x - point, slip, 0.25 * volume);
                    sum += force;
                    if at == 0 {
                        pushes = [pushes[0] - force, pushes[1] - arm(point).cross(force)];
                    }
                }
            }
            out.push(sum);
        }
        (out, pushes)
    }

    /// The left side of the whole system at a vector of all unknowns: particles, then the body.
    fn dense_product(&self, unknowns: &DVector<f64>) -> DVector<f64> {
        let at = |n: usize| DVec3::new(unknowns[3 * n], unknowns[3 * n + 1], unknowns[3 * n + 2]);
        let count = self.positions.len();
        let velocities: Vec<DVec3> = (0..count).map(at).collect();
        let body = [at(count), at(count + 1)];
        let (accelerations, push) = self.exchange(&velocities, body);
        let moved = self.bodies.response(0, MASS * push[0], MASS * push[1]);
        let particles = velocities.iter().zip(accelerations).map(|(v, a)| *v - DT * a);
        let all = particles.chain((0..2).map(|n| body[n] - DT * moved[n]));
        DVector::from_iterator(unknowns.len(), all.flat_map(|v| v.to_array()))
    }

    /// All unknowns by a dense solve.
    fn dense_solution(&self) -> DVector<f64> {
        let size = 3 * self.positions.len() + 6;
        let columns: Vec<DVector<f64>> = (0..size)
            .map(|n| self.dense_product(&DVector::from_fn(size, |row, _| f64::from(u8::from(row == n)))))
            .collect();
        let before = self.fields.velocities[..self.positions.len()].iter().map(|&v| carried::velocity(v));
        let right = before.chain(self.known()).flat_map(|v| v.to_array());
        DMatrix::from_columns(&columns).lu().solve(&DVector::from_iterator(size, right)).unwrap()
    }
}

#[test]
fn the_solve_is_that_of_the_dense_matrix() {
    let shape = shape();
    for locked in [false, true] {
        let scene = scene(&shape, locked, 200);
        let touching = |body: u32| scene.boundary.drags().filter(|drag| drag.body == body).count();
        assert!(touching(0) > 6 && touching(1) > 3, "{} {}", touching(0), touching(1));
        let exact = scene.dense_solution();
        let (report, velocities, forces) = scene.solve(&EXACTLY);
        assert!(report.error <= EXACTLY.max_error && report.iterations > 3, "{report:?}");
        let moved = scene.assert_is(exact.as_slice(), &velocities, &forces, [6e-5, 1e-4]);
        let change = (moved - scene.known()[0]).length();
        assert!(change > 0.05, "the fluid moves the body: {change}");
    }
}

/// So conjugate gradients are allowed, and nothing is excited.
#[test]
fn the_matrix_is_symmetric_and_at_least_one() {
    let scene = scene(&shape(), false, 400);
    let (system, count) = (scene.system(), scene.positions.len());
    let product = |field: &[Quad]| {
        let mut out = vec![[0.0; 4]; field.len()];
        let bodies = system.carried.response(&of(field));
        system.apply(&Unknowns { fluid: field, bodies: &bodies }, &mut out);
        out
    };
    let dot_all = |a: &[Quad], b: &[Quad]| a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum::<f64>();
    for seed in 0..5 {
        let (a, b) = (field(count, 10 + seed), field(count, 20 + seed));
        let (left, right) = (dot_all(&a, &product(&b)), dot_all(&product(&a), &b));
        let (size, square) = (dot_all(&product(&a), &a), dot_all(&a, &a));
        assert!((left - right).abs() < 1e-6 * size, "{left} {right} {size}");
        assert!(size > 2.0 * square, "{size} {square}");
        // All alike: of the fluid's part nothing remains, of the bodies' what they take away.
        let alike: Vec<Quad> = a[..count].iter().map(|_| a[0]).collect();
        assert!(dot_all(&product(&alike), &alike) >= dot_all(&alike, &alike) * (1.0 - 1e-6));
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = scene(&shape(), false, 1500);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| scene.solve(&ViscositySolveSettings::default()))
    };
    let (one, three) = (on(1), on(3));
    assert!(one.0.iterations > 2 && one.0 == three.0, "{:?} {:?}", one.0, three.0);
    assert!(one.1 == three.1 && one.2 == three.2);
}

/// Whatever the tolerance is.
#[test]
fn a_coarse_solve_keeps_momentum_and_angular_momentum() {
    let scene = scene(&shape(), false, 500);
    let coarse = ViscositySolveSettings { max_error: 0.05, max_iterations: 100, max_passes: 1 };
    let (report, velocities, forces) = scene.solve(&coarse);
    assert!(report.error > 1e-3, "{report:?}");
    let (lost, size, _) = scene.balance(&velocities, &forces);
    for (body, [push, _]) in forces.iter().enumerate() {
        assert!(push.length() * DT > 0.002 * size, "{body} {push} {size}");
    }
    assert!(lost[0].length() < 2e-6 * size, "{} of {size}", lost[0]);
    assert!(lost[1].length() < 1e-6 * size, "{} of {size}", lost[1]);
}

/// However stiff fluid and surfaces are, and wherever the solve ends.
#[test]
fn a_solve_at_its_limit_keeps_momenta_and_adds_no_energy() {
    let shape = shape();
    for (coefficient, viscosities) in [(1.0, [0.8, 1e3, 1e6, 1e9]), (1e9, [0.0, 0.8, 1e5, 1e9])] {
        let scene = scene(&shape, false, 300).touched(&shape, coefficient);
        let before: f64 = scene.fields.velocities.iter().map(|&v| 0.5 * MASS * dot(v, v)).sum();
        for viscosity in viscosities {
            for (max_error, max_iterations) in
                [(1e-3, 0), (1e-3, 1), (1e-3, 3), (1e-3, 20), (0.5, 200), (1e-3, 200)]
            {
                let settings = ViscositySolveSettings { max_error, max_iterations, max_passes: 1 };
                let (report, velocities, forces) = scene.act(viscosity, &settings, false);
                let (lost, size, energy) = scene.balance(&velocities, &forces);
                let case = format!("{coefficient} {viscosity} {settings:?} {report:?}");
                assert!(report.iterations <= max_iterations, "{case}");
                // Velocities are rounded to 6e-8.
                let size = size + MASS * 0.3 * velocities.len() as f64;
                assert!(lost[0].length() < 1e-6 * size, "{case}: {} of {size}", lost[0]);
                assert!(lost[1].length() < 1e-6 * size, "{case}: {} of {size}", lost[1]);
                assert!(energy < 1e-6 * before, "{case}: {energy} of {before}");
                // A loose cloud that is stirred is harder than any fluid.
                if viscosity <= 1.0 && max_iterations == 200 {
                    assert!(report.error <= max_error && energy < -0.1 * before, "{case}: {energy}");
                }
            }
        }
    }
}

#[test]
fn the_stiff_solver_solves_the_same_system() {
    let scene = scene(&shape(), false, 200);
    let exact = scene.dense_solution();
    let exactly = ViscositySolveSettings { max_error: 1e-9, ..EXACTLY };
    let (report, velocities, forces) = scene.act(VISCOSITY, &exactly, true);
    assert!(report.error <= exactly.max_error && report.iterations > 3, "{report:?}");
    scene.assert_is(exact.as_slice(), &velocities, &forces, [1e-6, 1e-6]);
}

#[test]
fn nothing_that_moves_is_solved_at_once() {
    let mut scene = scene(&shape(), false, 50);
    scene.fields.velocities.fill([0.0; 4]);
    scene.bodies = Bodies::new(Vec::new(), DVec3::ZERO).unwrap();
    scene.boundary.sample(&scene.bodies, &scene.positions, &scene.neighbours);
    let (report, velocities, _) = scene.solve(&ViscositySolveSettings::default());
    assert_eq!((report.iterations, report.error), (0, 0.0));
    assert!(velocities.iter().all(|v| *v == DVec3::ZERO));
}
