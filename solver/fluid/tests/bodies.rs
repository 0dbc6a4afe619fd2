//! Bodies among themselves: masses, contacts, conservation, the same bytes.

use glam::Vec3Swizzles;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::sync::{Arc, LazyLock};
use volmap_bake::bake::{BakeSettings, bake};
use volmap_bake::input::{self, Input, InputSettings, MeshSource};
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_fluid::Error;
use volmap_fluid::bodies::{
    Bodies, BodyDescription, ContactMaterial, FluidContact, FreeBody, Interpolation, Key, Keys, Mass, Motion,
    Path, Spin, Weight,
};
use volmap_formats::mesh::{CleanReport, Placement, TriangleMesh};
use volmap_runtime::{DQuat, DVec3, Pose, VolumeMap};

const GRAVITY: DVec3 = DVec3::new(0.0, -9.81, 0.0);

/// A mesh and its map.
#[derive(Clone)]
struct Thing {
    mesh: Arc<TriangleMesh>,
    map: Arc<VolumeMap>,
}

static DUCK: LazyLock<Thing> = LazyLock::new(|| thing(&data("duck.obj"), false, [26, 26, 30]));
static TANK: LazyLock<Thing> = LazyLock::new(|| thing(&data("tank.obj"), true, [24; 3]));
static CUBE: LazyLock<Thing> = LazyLock::new(|| thing(&block(DVec3::splat(0.2)), false, [12; 3]));
static PLATE: LazyLock<Thing> =
    LazyLock::new(|| thing(&block(DVec3::new(4.0, 0.2, 4.0)), false, [40, 4, 40]));

fn data(name: &str) -> TriangleMesh {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name);
    input::load(&path, &InputSettings::default()).unwrap().mesh
}

fn thing(mesh: &TriangleMesh, invert: bool, resolution: [u32; 3]) -> Thing {
    let source = MeshSource { file: String::new(), format: String::new(), blake3: String::new() };
    let input = Input {
        mesh: mesh.clone(),
        source,
        cleaning: CleanReport::default(),
        placement: Placement::default(),
        weld_tolerance: 0.0,
        coordinate_step: None,
        shape: None,
        placed_shape: None,
    };
    let map = MapSettings {
        support_radius: Some(0.1),
        grid: GridChoice::Resolution(resolution),
        invert,
        ..MapSettings::default()
    };
    let settings = BakeSettings { map, ..BakeSettings::default() };
    let asset = bake(input, &settings, &Default::default()).unwrap().asset;
    Thing { mesh: Arc::new(mesh.clone()), map: Arc::new(VolumeMap::from_asset(&asset).unwrap()) }
}

/// A box around the origin.
fn block(size: DVec3) -> TriangleMesh {
    let corner = |n: u32| {
        let side = DVec3::new((n & 1).into(), (n >> 1 & 1).into(), (n >> 2 & 1).into());
        (size * (side - 0.5)).to_array()
    };
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
}

/// A cylinder around z, of radius 1 and length 1, with 64 sides.
fn cylinder() -> TriangleMesh {
    const SIDES: u32 = 64;
    let rim = |n: u32, z: f64| {
        let angle = TAU * f64::from(n) / f64::from(SIDES);
        [angle.cos(), angle.sin(), z]
    };
    let mut vertices = vec![[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]];
    vertices.extend((0..SIDES).flat_map(|n| [rim(n, -0.5), rim(n, 0.5)]));
    let side = |n: u32| {
        let (a, b) = (2 + 2 * n, 2 + 2 * ((n + 1) % SIDES));
        [[0, b, a], [1, a + 1, b + 1], [a, b, b + 1], [a, b + 1, a + 1]]
    };
    TriangleMesh { vertices, triangles: (0..SIDES).flat_map(side).collect() }
}

fn body(name: &str, thing: &Thing, at: DVec3, motion: Motion) -> BodyDescription {
    BodyDescription {
        name: name.into(),
        map: thing.map.clone(),
        mesh: Some(thing.mesh.clone()),
        pose: Pose { translation: at, ..Pose::default() },
        motion,
        material: ContactMaterial::default(),
        fluid_contact: FluidContact::default(),
    }
}

fn free(name: &str, thing: &Thing, at: DVec3) -> BodyDescription {
    body(name, thing, at, Motion::Free(FreeBody::default()))
}

fn run(bodies: &mut Bodies, seconds: f64, dt: f64) {
    for _ in 0..(seconds / dt).round() as usize {
        bodies.step(dt).unwrap();
    }
}

/// Lowest point of a body's mesh in the world.
fn lowest(bodies: &Bodies, at: usize, thing: &Thing) -> f64 {
    let pose = bodies.state(at).pose;
    thing.mesh.vertices.iter().map(|&v| pose.to_world(v.into()).y).fold(f64::INFINITY, f64::min)
}

#[test]
fn masses_of_a_box_are_closed_forms() {
    let size = DVec3::new(0.4, 1.0, 0.7);
    let mut mesh = block(size);
    mesh.vertices.iter_mut().for_each(|v| *v = (DVec3::from(*v) + DVec3::new(100.0, -20.0, 3.0)).to_array());
    let mass = Mass::of_mesh(&mesh, 500.0).unwrap();
    assert!((mass.mass - 140.0).abs() < 1e-10);
    assert!((mass.centre - DVec3::new(100.0, -20.0, 3.0)).length() < 1e-12);
    let squares = size * size;
    let expected = (squares.yzx() + squares.zxy()) * (140.0 / 12.0);
    let [x, y, z] = [mass.inertia.x_axis, mass.inertia.y_axis, mass.inertia.z_axis];
    assert!((DVec3::new(x.x, y.y, z.z) - expected).length() < 1e-10);
    assert!(DVec3::new(x.y, y.z, z.x).length() < 1e-10);
    mesh.triangles.pop();
    assert_eq!(Mass::of_mesh(&mesh, 500.0), None, "open");
}

#[test]
fn masses_of_mesh_and_map_agree() {
    let fine = thing(&block(DVec3::splat(0.2)), false, [24; 3]);
    for (thing, tolerance) in [(&*DUCK, 1e-3), (&fine, 0.02)] {
        let exact = Mass::of_mesh(&thing.mesh, 300.0).unwrap();
        let near = Mass::of_map(&thing.map, 300.0);
        let apart = (near.mass / exact.mass - 1.0).abs();
        assert!(apart < tolerance, "mass {apart}");
        assert!((near.centre - exact.centre).length() < tolerance * exact.volume.cbrt());
        let columns = |mass: &Mass| [mass.inertia.x_axis, mass.inertia.y_axis, mass.inertia.z_axis];
        let largest = exact.inertia.x_axis.x.max(exact.inertia.y_axis.y).max(exact.inertia.z_axis.z);
        for (a, b) in columns(&near).into_iter().zip(columns(&exact)) {
            assert!((a - b).length() < 2.0 * tolerance * largest, "inertia {a} {b}");
        }
        let given = exact.with_mass(7.0);
        assert!((given.inertia.x_axis.x / exact.inertia.x_axis.x - 7.0 / exact.mass).abs() < 1e-12);
    }
}

#[test]
fn momenta_are_conserved_without_forces() {
    let start = FreeBody {
        velocity: DVec3::new(0.3, -0.2, 0.1),
        angular_velocity: DVec3::new(2.0, 3.0, -1.0),
        ..FreeBody::default()
    };
    let duck = body("duck", &DUCK, DVec3::ZERO, Motion::Free(start));
    let mut bodies = Bodies::new(vec![duck], DVec3::ZERO).unwrap();
    let before = bodies.totals();
    run(&mut bodies, 5.0, 0.005);
    let after = bodies.totals();
    let lost = (after.momentum - before.momentum).length() / before.momentum.length();
    assert!(lost < 1e-14, "momentum {lost}");
    let lost = (after.angular_momentum - before.angular_momentum).length() / before.angular_momentum.length();
    assert!(lost < 1e-12, "angular momentum {lost}");
    let gained = after.kinetic_energy / before.kinetic_energy - 1.0;
    assert!(gained.abs() < 1e-4, "energy {gained}");
}

#[test]
fn forces_and_torques_act_for_one_step() {
    let mut bodies = Bodies::new(vec![free("cube", &CUBE, DVec3::ZERO)], DVec3::ZERO).unwrap();
    let mass = *bodies.mass(0).unwrap();
    let (force, torque) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(0.02, 0.0, 0.01));
    for _ in 0..10 {
        bodies.apply(0, 0.5 * force, 0.25 * torque);
        bodies.apply(0, 0.5 * force, 0.75 * torque);
        bodies.step(0.01).unwrap();
    }
    run(&mut bodies, 0.1, 0.01);
    let totals = bodies.totals();
    assert!((totals.momentum - 0.1 * force).length() < 1e-12);
    let spin = totals.angular_momentum - bodies.center_of_mass(0).cross(totals.momentum);
    assert!((spin - 0.1 * torque).length() < 1e-12, "{spin}");
    // Half of a t^2 while it acts, then coasting.
    let expected = force / mass.mass * (0.005 + 0.01);
    assert!((bodies.center_of_mass(0) / expected - 1.0).abs().max_element() < 0.02);
}

#[test]
fn a_duck_comes_to_rest_on_the_floor_of_a_tank() {
    for has_mesh in [true, false] {
        let mut tank = body("tank", &TANK, DVec3::ZERO, Motion::Static);
        let mut duck = free("duck", &DUCK, DVec3::new(0.2, 0.9, 0.1));
        if !has_mesh {
            (tank.mesh, duck.mesh) = (None, None);
        }
        let mut bodies = Bodies::new(vec![tank, duck], GRAVITY).unwrap();
        run(&mut bodies, 10.0, 0.005);
        let state = bodies.state(1);
        let height = lowest(&bodies, 1, &DUCK);
        assert!(height.abs() < 0.01, "it stands {height} m above the floor; mesh: {has_mesh}");
        assert!(state.velocity.length() < 0.03 && state.angular_velocity.length() < 0.06, "{state:?}");
        assert!(state.centre.x.abs().max(state.centre.z.abs()) < 1.0);
    }
}

#[test]
fn walls_of_a_container_hold_from_inside() {
    let fast = FreeBody { velocity: DVec3::new(9.0, 0.0, 7.0), ..FreeBody::default() };
    let tank = body("tank", &TANK, DVec3::ZERO, Motion::Static);
    let cube = body("cube", &CUBE, DVec3::new(0.0, 1.5, 0.0), Motion::Free(fast));
    let mut bodies = Bodies::new(vec![tank, cube], GRAVITY).unwrap();
    for _ in 0..600 {
        bodies.step(0.005).unwrap();
        let at = bodies.center_of_mass(1);
        assert!(at.x.abs() < 1.55 && at.z.abs() < 1.55 && at.y > 0.0, "it left at {at}");
    }
}

/// How far a cube slides in a second on a plate with this slope, in metres.
fn slide(friction: f64, slope: f64) -> f64 {
    let rotation = DQuat::from_rotation_z(slope);
    let mut plate = body("plate", &PLATE, DVec3::ZERO, Motion::Static);
    let mut cube = free("cube", &CUBE, rotation * DVec3::new(0.5, 0.2, 0.0));
    for body in [&mut plate, &mut cube] {
        body.material = ContactMaterial { friction, restitution: 0.0 };
        body.pose.rotation = rotation;
    }
    let start = cube.pose.translation;
    let mut bodies = Bodies::new(vec![plate, cube], GRAVITY).unwrap();
    run(&mut bodies, 1.0, 0.0025);
    (bodies.center_of_mass(1) - start).dot(rotation * -DVec3::X)
}

#[test]
fn a_box_slides_beyond_the_friction_angle_only() {
    let friction = 0.5;
    let angle = f64::atan(friction);
    let held = slide(friction, angle - 0.03);
    assert!(held.abs() < 2e-3, "it crept {held} m");
    for slope in [angle + 0.03, angle + 0.1] {
        let slid = slide(friction, slope);
        let expected = 0.5 * 9.81 * (slope.sin() - friction * slope.cos());
        assert!((slid / expected - 1.0).abs() < 0.05, "{slid} m of {expected}");
    }
}

#[test]
fn bodies_that_share_a_map_pile_up() {
    let plate = body("plate", &PLATE, DVec3::new(0.0, -0.1, 0.0), Motion::Static);
    let cube = |n: u32| free(&format!("cube {n}"), &CUBE, DVec3::new(0.0, 0.15 + 0.25 * f64::from(n), 0.0));
    let mut bodies = Bodies::new(vec![plate, cube(0), cube(1), cube(2)], GRAVITY).unwrap();
    run(&mut bodies, 2.0, 0.005);
    for n in 0..3 {
        let height = bodies.center_of_mass(n + 1).y;
        let expected = 0.1 + 0.2 * n as f64;
        assert!((height - expected).abs() < 2e-3, "cube {n} at {height}");
    }
}

/// How far two cubes in a stack on a plate have sunk after 5 s, metres: the lower one, the upper one; and sideways. The
/// upper one is so many times as heavy.
fn sunk(ratio: f64, dt: f64) -> [f64; 3] {
    let weighing =
        |density: f64| Motion::Free(FreeBody { weight: Weight::Density(density), ..FreeBody::default() });
    let plate = body("plate", &PLATE, DVec3::new(0.0, -0.1, 0.0), Motion::Static);
    let lower = body("lower", &CUBE, DVec3::new(0.0, 0.1, 0.0), weighing(500.0));
    let upper = body("upper", &CUBE, DVec3::new(0.0, 0.3, 0.0), weighing(500.0 * ratio));
    let mut bodies = Bodies::new(vec![plate, lower, upper], GRAVITY).unwrap();
    run(&mut bodies, 5.0, dt);
    let [low, high] = [1, 2].map(|n| bodies.center_of_mass(n));
    [0.1 - low.y, 0.3 - high.y, low.with_y(0.0).length().max(high.with_y(0.0).length())]
}

#[test]
fn stacks_of_unlike_masses_stand() {
    // A tenth of a particle's radius of 25 mm. They were 3, 31, 200 and 200 mm once from 10 on.
    for ratio in [1.0, 10.0, 100.0, 300.0, 1000.0] {
        for dt in [0.002, 0.008] {
            let [lower, upper, aside] = sunk(ratio, dt);
            let told = format!("1:{ratio}, steps of {dt} s: {lower} m, {upper} m, {aside} m");
            assert!(lower.abs() < 0.0025 && upper.abs() < 0.0025, "{told}");
            // They creep a little, at like masses too.
            assert!(aside < 0.006, "{told}");
        }
    }
    // What is beyond is told with its size.
    let [_, upper, _] = sunk(3000.0, 0.002);
    assert!((upper - 0.0036).abs() < 5e-4, "{upper}");
}

/// How far from the bottom a slowly spinning drum carries a box, radians.
fn carried(friction: f64, drum: &Thing) -> f64 {
    let spin = Path::Spin(Spin { axis: DVec3::Z, centre: DVec3::ZERO, speed: 0.2 });
    let mut drum = body("drum", drum, DVec3::ZERO, Motion::Prescribed(spin));
    let mut cube = free("cube", &CUBE, DVec3::new(0.0, -0.88, 0.0));
    for body in [&mut drum, &mut cube] {
        body.material.friction = friction;
    }
    let mut bodies = Bodies::new(vec![drum, cube], GRAVITY).unwrap();
    let mut farthest = 0.0f64;
    for _ in 0..800 {
        bodies.step(0.005).unwrap();
        let at = bodies.center_of_mass(1);
        farthest = farthest.max(at.x.atan2(-at.y));
        assert!(at.truncate().length() < 0.95, "it left the drum at {at}");
    }
    farthest
}

#[test]
fn a_spinning_drum_drags_a_box_up() {
    let drum = thing(&cylinder(), true, [20, 20, 10]);
    let smooth = carried(0.0, &drum);
    assert!(smooth < 0.1, "without friction it was carried {smooth}");
    // To the friction angle, a facet (0.1) and a swing further, at which it begins to slide.
    let rough = carried(0.4, &drum);
    let angle = f64::atan(0.4);
    assert!(rough > angle && rough < angle + 0.2, "{rough} of {angle}");
}

#[test]
fn prescribed_bodies_are_where_their_path_is() {
    let key = |time: f64, y: f64, angle: f64| Key {
        time,
        translation: DVec3::new(0.0, y, 0.0),
        rotation: DQuat::from_rotation_y(angle),
    };
    let keys = vec![key(0.0, 0.0, 0.0), key(0.5, 1.0, 1.0), key(1.0, 0.2, -PI / 3.0)];
    let path = Path::Keys(Keys { keys, interpolation: Interpolation::Smooth, repeat: false });
    let lift = body("lift", &CUBE, DVec3::X, Motion::Prescribed(path.clone()));
    let start = lift.pose;
    let mut bodies = Bodies::new(vec![lift], GRAVITY).unwrap();
    for _ in 0..130 {
        bodies.step(0.01).unwrap();
        let moving = path.at(bodies.time(), start);
        assert_eq!(bodies.state(0).pose, moving.pose);
        let point = moving.pose.to_world(DVec3::new(0.1, 0.0, 0.1));
        let expected = moving.velocity + moving.angular_velocity.cross(point - moving.pose.translation);
        assert!((bodies.velocity_at(0, point) - expected).length() < 1e-12);
    }
    assert_eq!(bodies.velocity_at(0, DVec3::ZERO), DVec3::ZERO, "the path has ended");
}

#[test]
fn locked_axes_are_kept() {
    let free = FreeBody {
        locked_translation: [true, false, true],
        locked_rotation: [true, false, true],
        ..FreeBody::default()
    };
    let mut bodies =
        Bodies::new(vec![body("piston", &DUCK, DVec3::ZERO, Motion::Free(free))], GRAVITY).unwrap();
    let start = bodies.center_of_mass(0);
    for _ in 0..100 {
        bodies.apply(0, DVec3::new(50.0, 9000.0, 10.0), DVec3::new(10.0, 20.0, 30.0));
        bodies.step(0.005).unwrap();
    }
    let state = bodies.state(0);
    let moved = state.centre - start;
    assert!(moved.x.abs() + moved.z.abs() < 1e-12 && moved.y.abs() > 0.1, "{moved}");
    assert!(state.angular_velocity.x == 0.0 && state.angular_velocity.z == 0.0);
    assert!(state.angular_velocity.y > 0.01);
}

/// Two ducks, two cubes and a stirrer in a tank.
fn busy() -> Bodies {
    let spin = Path::Spin(Spin { axis: DVec3::Y, centre: DVec3::ZERO, speed: 3.0 });
    let descriptions = vec![
        body("tank", &TANK, DVec3::ZERO, Motion::Static),
        free("duck", &DUCK, DVec3::new(0.5, 0.9, 0.1)),
        free("second duck", &DUCK, DVec3::new(-0.4, 2.2, 0.1)),
        free("cube", &CUBE, DVec3::new(0.3, 2.4, 0.4)),
        free("second cube", &CUBE, DVec3::new(-0.9, 0.15, -0.5)),
        body("stirrer", &CUBE, DVec3::new(1.0, 0.2, 1.0), Motion::Prescribed(spin)),
    ];
    Bodies::new(descriptions, GRAVITY).unwrap()
}

fn bits(bodies: &Bodies) -> Vec<u64> {
    let numbers = |at: usize| {
        let s = bodies.state(at);
        let (r, t) = (s.pose.rotation.to_array(), s.pose.translation.to_array());
        let (v, w) = (s.velocity.to_array(), s.angular_velocity.to_array());
        r.into_iter().chain(t).chain(v).chain(w).map(f64::to_bits).collect::<Vec<_>>()
    };
    (0..bodies.posed().len()).flat_map(numbers).collect()
}

#[test]
fn snapshots_go_on_with_the_same_bits() {
    let (mut whole, mut second) = (busy(), busy());
    let push = |bodies: &mut Bodies, step: u32| {
        bodies.apply(1, DVec3::new(0.0, 2000.0, f64::from(step)), DVec3::X);
        bodies.step(0.004 + 1e-5 * f64::from(step % 7)).unwrap();
    };
    for step in 0..150 {
        push(&mut whole, step);
        push(&mut second, step);
    }
    let snapshot = whole.snapshot().unwrap();
    assert_eq!(snapshot, second.snapshot().unwrap(), "two runs");
    let mut restored = busy();
    restored.restore(&snapshot).unwrap();
    assert_eq!(restored.snapshot().unwrap(), snapshot);
    for step in 150..400 {
        push(&mut whole, step);
        push(&mut restored, step);
        assert_eq!(bits(&whole), bits(&restored), "step {step}");
    }
    assert_eq!(whole.time().to_bits(), restored.time().to_bits());
    assert_eq!(whole.snapshot().unwrap(), restored.snapshot().unwrap());
}

#[test]
fn damaged_and_foreign_snapshots_are_refused() {
    let mut bodies = busy();
    run(&mut bodies, 0.1, 0.01);
    let good = bodies.snapshot().unwrap();
    let before = bits(&bodies);
    for at in (0..good.len()).step_by(good.len() / 50) {
        let mut bad = good.clone();
        bad[at] ^= 4;
        assert!(bodies.restore(&bad).unwrap_err().contains("damaged"));
        assert!(bodies.restore(&good[..at]).unwrap_err().contains("damaged"));
    }
    let mut others = Bodies::new(vec![free("cube", &CUBE, DVec3::ZERO)], GRAVITY).unwrap();
    assert!(others.restore(&good).unwrap_err().contains("other bodies"));
    assert_eq!(bits(&bodies), before);
}

#[test]
fn impossible_bodies_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut BodyDescription)| {
        let mut cube = free("odd", &CUBE, DVec3::ZERO);
        change(&mut cube);
        let error = Bodies::new(vec![cube], GRAVITY).err().expect("it was taken").to_string();
        assert!(error.contains("body `odd`"), "{error}");
        error
    };
    let weighing = |weight: Weight| Motion::Free(FreeBody { weight, ..FreeBody::default() });
    for weight in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refused(&|body| body.motion = weighing(Weight::Density(weight)));
        refused(&|body| body.motion = weighing(Weight::Mass(weight)));
    }
    refused(&|body| body.motion = weighing(Weight::Mass(1e-310)));
    refused(&|body| body.pose.translation.x = f64::NAN);
    refused(&|body| body.pose.rotation = DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    refused(&|body| body.material.friction = -0.1);
    refused(&|body| body.material.restitution = 1.5);
    refused(&|body| {
        body.motion = Motion::Free(FreeBody { velocity: DVec3::NAN, ..FreeBody::default() });
    });
    let along =
        FreeBody { velocity: DVec3::Y, locked_translation: [true, true, false], ..FreeBody::default() };
    let about = FreeBody { angular_velocity: DVec3::Z, locked_rotation: [true; 3], ..FreeBody::default() };
    for (moving, expected) in [(along, "a velocity along y"), (about, "an angular velocity about z")] {
        let error = refused(&|body| body.motion = Motion::Free(moving.clone()));
        assert!(error.contains(expected) && error.contains("locked there"), "{error}");
    }
    assert!(refused(&|body| body.map = TANK.map.clone()).contains("inverted"));
    let nowhere = Keys { keys: vec![], interpolation: Interpolation::Linear, repeat: false };
    refused(&|body| body.motion = Motion::Prescribed(Path::Keys(nowhere.clone())));
    let flat = TriangleMesh { vertices: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 2]] };
    refused(&|body| body.mesh = Some(Arc::new(flat.clone())));
    assert!(Bodies::new(vec![], DVec3::NAN).is_err());
}

#[test]
fn a_rotation_of_another_length_is_normalised() {
    let mut cube = free("cube", &CUBE, DVec3::ZERO);
    cube.pose.rotation = DQuat::from_xyzw(0.0, 3.0, 0.0, 4.0);
    let bodies = Bodies::new(vec![cube], GRAVITY).unwrap();
    assert!(bodies.state(0).pose.rotation.is_normalized());
}

#[test]
fn forces_that_are_not_finite_stop_the_simulation() {
    for (force, torque) in
        [(DVec3::NAN, DVec3::ZERO), (DVec3::ZERO, DVec3::INFINITY), (DVec3::MAX, DVec3::ZERO)]
    {
        let mut bodies = busy();
        bodies.step(0.005).unwrap();
        bodies.apply(1, force, torque);
        let error = (0..10).find_map(|_| bodies.step(0.005).err()).expect("it went on");
        assert!(matches!(error, Error::Simulation { .. }), "{error}");
        assert!(error.to_string().contains("duck"), "{error}");
    }
    let mut bodies = busy();
    for dt in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        assert!(matches!(bodies.step(dt), Err(Error::Simulation { .. })));
    }
}

/// A cube twice, a micrometre apart, one in another, and two that overlap: mass, centre and inertia count what is there
/// once.
#[test]
fn overlapping_parts_weigh_once() {
    use volmap_bake::mesh::diagnose;
    use volmap_bake::sdf::{MeshDistance, SignMethod};
    let moved = |by: DVec3| {
        let mut mesh = block(DVec3::splat(0.2));
        mesh.vertices.iter_mut().for_each(|v| *v = (DVec3::from(*v) + by).to_array());
        mesh
    };
    let joined = |parts: &[TriangleMesh]| {
        let mut all = TriangleMesh::default();
        for part in parts {
            let first = all.vertices.len() as u32;
            all.vertices.extend(&part.vertices);
            all.triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + first)));
        }
        MeshDistance::new(&all, SignMethod::Auto, &diagnose(&all)).union_mesh().unwrap()
    };
    let cube = Mass::of_mesh(&moved(DVec3::ZERO), 500.0).unwrap();
    let mut small = moved(DVec3::ZERO);
    small.vertices.iter_mut().flatten().for_each(|x| *x *= 0.5);
    for other in [moved(DVec3::splat(1e-6)), small] {
        let found = Mass::of_mesh(&joined(&[moved(DVec3::ZERO), other]), 500.0).unwrap();
        assert!((found.mass / cube.mass - 1.0).abs() < 2e-5, "{}", found.mass);
        assert!(found.centre.distance(cube.centre) < 1e-6);
        assert!((found.inertia.x_axis.x / cube.inertia.x_axis.x - 1.0).abs() < 5e-5);
    }
    // Two cubes that overlap by half are a box of 0.3 m.
    let found =
        Mass::of_mesh(&joined(&[moved(DVec3::ZERO), moved(DVec3::new(0.1, 0.0, 0.0))]), 500.0).unwrap();
    let mass = 500.0 * 0.3 * 0.2 * 0.2;
    assert!((found.mass - mass).abs() < 1e-9 * mass);
    let about_x = mass * (0.2f64.powi(2) + 0.2f64.powi(2)) / 12.0;
    let about_y = mass * (0.3f64.powi(2) + 0.2f64.powi(2)) / 12.0;
    assert!((found.inertia.x_axis.x - about_x).abs() < 1e-9 * about_x);
    assert!((found.inertia.y_axis.y - about_y).abs() < 1e-9 * about_y);
}
