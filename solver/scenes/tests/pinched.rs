//! Fluid between walls that leave it less room than a particle has, and what walls throw back: nothing gains energy of
//! it, whatever the boundary's method.

use std::path::Path;
use volmap_fluid::simulation::Simulation;
use volmap_runtime::DVec3;
use volmap_scenes::assemble::assemble;
use volmap_scenes::scene::{Scene, Syntax, parse, prepare};

const RP: f64 = 0.025;

/// Keys of all boundary methods and closures.
const METHODS: [&str; 9] = [
    r#""closure": "mirror""#,
    r#""closure": "lattice""#,
    r#""closure": "wedge""#,
    r#""closure": "calibrated""#,
    r#""closure": "offset""#,
    r#""closure": "paper""#,
    r#""boundary": "density_map""#,
    r#""boundary": "tube_map""#,
    r#""boundary": "particles""#,
];

/// Gaps, in particle radii, below which `mirror` leaves a particle no room.
const NO_ROOM: f64 = 1.38;

fn scene(keys: &str) -> Scene {
    scene_of(keys, RP)
}

fn scene_of(keys: &str, rp: f64) -> Scene {
    let text = format!(r#"{{"version": 1, "particle_radius": {rp}, "stop": {{"time": 1}}, {keys}}}"#);
    let mut scene =
        parse(&text, Syntax::Json, "pinched.json").unwrap_or_else(|error| panic!("{error}\n{text}"));
    scene.cache = Some(Path::new(env!("CARGO_TARGET_TMPDIR")).join("maps"));
    scene
}

fn simulation(keys: &str) -> Simulation {
    simulation_of(keys, RP)
}

fn simulation_of(keys: &str, rp: f64) -> Simulation {
    let scene = scene_of(keys, rp);
    let prepared = prepare(&scene, &Default::default(), &mut |_| ()).unwrap();
    Simulation::new(assemble(&scene, prepared).unwrap()).unwrap()
}

/// A box of this size, x, y and z; more keys begin with a comma.
fn cuboid([x, y, z]: [f64; 3], at: [f64; 3], more: &str) -> String {
    format!(r#"{{"shape": {{"box": {{"size": [{x}, {y}, {z}]}}}}, "translation": {at:?}{more}}}"#)
}

fn block(min: [f64; 3], max: [f64; 3], velocity: [f64; 3]) -> String {
    format!(r#""blocks": [{{"min": {min:?}, "max": {max:?}, "velocity": {velocity:?}}}]"#)
}

/// Motion from one place to another in so many seconds, for [`cuboid`].
fn moving(from: [f64; 3], to: [f64; 3], seconds: f64) -> String {
    let key = |time: f64, at: [f64; 3]| format!(r#"{{"time": {time}, "translation": {at:?}}}"#);
    format!(r#", "motion": {{"keyframes": [{}, {}]}}"#, key(0.0, from), key(seconds, to))
}

/// Kinetic energy of the fluid for each of its mass, and with it that of gravity, J/kg.
fn energy(simulation: &Simulation, gravity: f64) -> f64 {
    let particles = simulation.particles();
    let kinetic = |v: &[f32; 3]| 0.5 * v.iter().map(|&x| f64::from(x).powi(2)).sum::<f64>();
    let all = particles.velocities.iter().zip(&particles.positions);
    all.map(|(v, x)| kinetic(v) + gravity * x.y).sum::<f64>() / particles.len() as f64
}

#[test]
fn in_a_static_slit_nothing_gains_energy() {
    for method in METHODS {
        for gap in [1.0, 1.3] {
            let slit = cuboid([0.4, 0.4, gap * RP], [0.0; 3], r#", "bake": {"invert": true}"#);
            // One particle a little off the middle, and a film of 25.
            for half in [RP, 0.125] {
                let off = 0.08 * RP;
                let fluid = block([-half, -half, off - RP], [half, half, off + RP], [0.05, 0.03, 0.04]);
                let keys = format!(r#""gravity": [0, 0, 0], {fluid}, "bodies": [{slit}], {method}"#);
                let mut simulation = simulation(&keys);
                let start = energy(&simulation, 0.0);
                let mut pinched = 0;
                for step in 0..60 {
                    let report = simulation.step().unwrap();
                    pinched += report.pinched.count;
                    let now = energy(&simulation, 0.0);
                    // Where the method leaves room, a film that begins too dense is let out.
                    let bound = if report.pinched.count > 0 { start } else { start + 0.5 };
                    assert!(now <= 1.0001 * bound, "{method}, {gap} rp, step {step}: {now} of {start}");
                }
                assert!(pinched > 0 || !method.contains("mirror"), "{method}: it is counted");
            }
        }
    }
}

#[test]
fn a_plate_shoots_no_particle_out() {
    for method in METHODS {
        for speed in [0.1, 1.0] {
            let [high, low] = [[0.0, 0.15, 0.0], [0.0, 0.1, 0.0]];
            let plate = cuboid([0.2; 3], [0.0; 3], &moving(high, low, 0.05 / speed));
            let floor = cuboid([1.0, 0.2, 1.0], [0.0, -0.1, 0.0], "");
            let fluid = block([-0.015, 0.0, -RP], [0.035, 0.05, RP], [0.0; 3]);
            let keys = format!(r#""gravity": [0, 0, 0], {fluid}, "bodies": [{floor}, {plate}], {method}"#);
            let mut simulation = simulation(&keys);
            let (mut fastest, mut pinched) = (0.0_f64, 0);
            while simulation.time() < 0.05 / speed + 0.05 {
                pinched += simulation.step().unwrap().pinched.count;
                let [x, y, z] = simulation.particles().velocities[0].map(f64::from);
                fastest = fastest.max(DVec3::new(x, y, z).length());
            }
            assert!(fastest < 4.0 * speed, "{method}, {speed} m/s: {fastest} m/s");
            assert!(pinched > 0 && simulation.particles().len() == 1, "{method}: {pinched}");
        }
    }
}

#[test]
fn a_film_is_squeezed_out_no_faster_than_it_flows() {
    let (width, height) = (0.3, 4.0 * RP);
    let mut moved = 0.0;
    for speed in [0.1, 0.5, 1.0] {
        let (from, to) = ([0.0, height + 0.05, 0.0], [0.0, 0.05 - 0.2 * RP, 0.0]);
        let seconds = (height + 0.2 * RP) / speed;
        let plate = cuboid([width, 0.1, width], [0.0; 3], &moving(from, to, seconds));
        let floor = cuboid([2.0, 0.2, 2.0], [0.0, -0.1, 0.0], "");
        let fluid = block([-0.125, 0.0, -0.125], [0.125, height, 0.125], [0.0; 3]);
        let domain = r#""domain": {"min": [-3, -1, -3], "max": [3, 1, 3]}"#;
        let keys = format!(
            r#""gravity": [0, 0, 0], "fluid": {{"viscosity": 0}}, {domain}, {fluid}, "bodies": [{floor}, {plate}]"#
        );
        let mut simulation = simulation(&keys);
        let (mut fastest, mut pinched) = (0.0_f64, 0);
        while simulation.time() < seconds {
            let report = simulation.step().unwrap();
            pinched += report.pinched.count;
            fastest = fastest.max(report.max_speed);
        }
        // Continuity: v h = V x, at the edge of the plate in the thinnest film that there is; and as fast as water that
        // begins on a lattice settles.
        let flow = speed * 0.5 * width / (NO_ROOM * RP) + 0.5;
        assert!(fastest > speed && fastest < flow, "{speed} m/s: {fastest} of {flow} m/s");
        assert!(pinched > 0, "the last of it is held");
        moved += fastest;
    }
    assert!(moved > 1.0, "it is squeezed out at all: {moved}");
}

#[test]
fn bodies_that_land_on_a_floor_through_water_throw_none_of_it() {
    for density in [100.0, 7_800.0, 1e6] {
        let tank = cuboid([0.4, 0.8, 0.4], [0.0, 0.4, 0.0], r#", "bake": {"invert": true}"#);
        let free = format!(r#", "motion": {{"free": {{"density": {density}}}}}"#);
        let body = cuboid([0.2; 3], [0.0, 0.35, 0.0], &free);
        let fluid = block([-0.2, 0.0, -0.2], [0.2, 0.1, 0.2], [0.0; 3]);
        let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{tank}, {body}]"#));
        let mut fastest = 0.0_f64;
        while simulation.time() < 0.5 {
            let report = simulation.step().unwrap();
            assert_eq!(report.removed, 0);
            fastest = fastest.max(report.max_speed);
        }
        // It falls 0.15 m to the water and 0.1 m in it; the film below flows out at V x / h.
        let fall = (2.0_f64 * 9.81 * 0.25).sqrt();
        let flow = fall * 0.1 / (NO_ROOM * RP);
        assert!(fastest < flow, "{density} kg/m^3: {fastest} of {flow} m/s");
    }
}

#[test]
fn bodies_that_close_on_water_keep_the_momentum_of_both() {
    let free =
        |speed: f64| format!(r#", "motion": {{"free": {{"density": 700, "velocity": [{speed}, 0, 0]}}}}"#);
    let bodies = [
        cuboid([0.1, 0.2, 0.2], [-0.11, 0.0, 0.0], &free(1.0)),
        cuboid([0.1, 0.2, 0.2], [0.11, 0.0, 0.0], &free(-0.7)),
    ];
    let fluid = block([-0.05, -0.1, -0.1], [0.05, 0.1, 0.1], [0.0; 3]);
    let domain = r#""domain": {"min": [-9, -9, -9], "max": [9, 9, 9]}"#;
    let bodies = bodies.join(", ");
    let mut simulation =
        simulation(&format!(r#""gravity": [0, 0, 0], {domain}, {fluid}, "bodies": [{bodies}]"#));
    let totals = |simulation: &Simulation| {
        let velocities = simulation.particles().velocities.iter();
        let fluid: DVec3 = velocities.map(|v| DVec3::from_array(v.map(f64::from))).sum();
        let bodies = simulation.bodies().totals();
        let kinetic = simulation.particles().len() as f64 * energy(simulation, 0.0);
        let mass = simulation.particle_mass();
        (mass * fluid + bodies.momentum, mass * kinetic + bodies.kinetic_energy)
    };
    let (momentum, mut last) = totals(&simulation);
    let start = last;
    // Of one body alone.
    let scale = 0.004 * 700.0;
    while simulation.time() < 0.4 {
        simulation.step().unwrap();
        let (now, energy) = totals(&simulation);
        assert!((now - momentum).length() < 1e-6 * scale, "{} of {momentum}", now - momentum);
        assert!(energy < last + 1e-3 * start, "{energy} after {last}, {start} at the start");
        last = energy;
    }
    assert!(last < 0.5 * start, "what closed is stopped: {last} of {start}");
}

#[test]
fn a_droplet_keeps_no_more_energy_than_its_restitution() {
    // `sph` presses by the weight of fluid that isn't there.
    let pressures = ["own", "mirror", "mls"];
    let all = METHODS.iter().flat_map(|method| pressures.map(|pressure| (*method, pressure)));
    for (method, pressure) in
        all.filter(|&(method, pressure)| pressure == "own" || method.contains("closure"))
    {
        for (height, speed) in [(8.0, 1.0), (20.0, 0.0)] {
            let floor = cuboid([0.4, 0.2, 0.4], [0.0, -0.1, 0.0], "");
            let [low, high] = [-1.0, 1.0].map(|side| (height + side) * RP);
            let fluid = block([-RP, low, -RP], [RP, high, RP], [0.0, -speed, 0.0]);
            let solver = format!(r#""solver": {{"boundary_pressure": "{pressure}"}}"#);
            let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{floor}], {solver}, {method}"#));
            let start = energy(&simulation, 9.81);
            let (mut least, mut most) = (start, 0.0_f64);
            while simulation.time() < 0.5 {
                simulation.step().unwrap();
                let now = energy(&simulation, 9.81);
                least = least.min(now);
                most = most.max(now - least);
            }
            // The rest is the way out of the wall, some 0.1 rp at most for the default.
            assert!(most < 0.005 * start, "{method}, {pressure}, {height} rp: {most} of {start} J/kg");
            assert!(energy(&simulation, 0.0) < 0.1, "{method}, {pressure}: it rests");
        }
    }
}

#[test]
fn a_sheet_of_water_stops_at_a_floor() {
    for warm_start in [0.5, 1.0] {
        let floor = cuboid([2.0, 0.2, 2.0], [0.0, -0.1, 0.0], "");
        let fluid = block([-0.125, 4.0 * RP, -0.125], [0.125, 6.0 * RP, 0.125], [0.0, -3.0, 0.0]);
        let solver = format!(r#""solver": {{"warm_start": {warm_start}}}, "fluid": {{"viscosity": 0}}"#);
        let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{floor}], {solver}"#));
        let start = energy(&simulation, 9.81);
        let (mut least, mut most) = (start, 0.0_f64);
        while simulation.time() < 0.2 {
            simulation.step().unwrap();
            least = least.min(energy(&simulation, 9.81));
            most = most.max(energy(&simulation, 9.81) - least);
        }
        assert!(most < 0.005 * start, "{warm_start}: {most} of {start} J/kg");
    }
}

#[test]
fn pressures_of_the_walls_are_stable_where_walls_make_most_of_a_density() {
    // `paper` rests at 2.8 rp; the fluid begins at 2.
    for pressure in ["own", "mirror", "sph", "mls"] {
        let tank = cuboid([0.45, 0.5, 0.45], [0.0, 0.25, 0.0], r#", "bake": {"invert": true}"#);
        let fluid = block([-0.2, RP, -0.2], [0.2, 0.225, 0.2], [0.0; 3]);
        let solver = format!(r#""solver": {{"boundary_pressure": "{pressure}"}}, "closure": "paper""#);
        let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{tank}], {solver}"#));
        while simulation.time() < 0.3 {
            let report = simulation.step().unwrap();
            assert!(report.max_speed < 4.0 && report.removed == 0, "{pressure}: {} m/s", report.max_speed);
        }
    }
}

#[test]
fn pressures_of_the_walls_throw_no_film_out() {
    let rp = 0.0125;
    for (pressure, speed) in [("mirror", 0.1), ("mirror", 0.5), ("mls", 0.5)] {
        let (width, height, low) = (0.3, 4.0 * rp, 2.0 * rp);
        let seconds = (height - low) / speed;
        let motion = moving([0.0, height + 0.05, 0.0], [0.0, low + 0.05, 0.0], seconds);
        let plate = cuboid([width, 0.1, width], [0.0; 3], &motion);
        let floor = cuboid([2.0, 0.2, 2.0], [0.0, -0.1, 0.0], "");
        let fluid = block([-0.1375, 0.0, -0.1375], [0.1375, height, 0.1375], [0.0; 3]);
        let keys = format!(
            r#""gravity": [0, 0, 0], "fluid": {{"viscosity": 0}}, {fluid}, "bodies": [{floor}, {plate}],
            "domain": {{"min": [-3, -1, -3], "max": [3, 1, 3]}}, "solver": {{"boundary_pressure": "{pressure}"}}"#
        );
        let mut simulation = simulation_of(&keys, rp);
        let mut fastest = 0.0_f64;
        while simulation.time() < seconds {
            fastest = fastest.max(simulation.step().unwrap().max_speed);
        }
        // Continuity: v h = V x; and as fast as what begins too dense beside a wall comes apart.
        let flow = speed * 0.5 * width / low + 1.0;
        assert!(fastest > speed && fastest < flow, "{pressure}, {speed} m/s: {fastest} of {flow} m/s");
    }
}

#[test]
fn heavy_bodies_that_fall_into_water_throw_none_of_it_by_pressures_of_the_walls() {
    // `paper` rests at 2.8 rp; the fluid begins at 1.
    for pressure in ["mirror", "sph", "mls"] {
        let tank = cuboid([0.4, 0.8, 0.4], [0.0, 0.4, 0.0], r#", "bake": {"invert": true}"#);
        let body = cuboid([0.2; 3], [0.0, 0.35, 0.0], r#", "motion": {"free": {"density": 20000}}"#);
        let fluid = block([-0.2, 0.0, -0.2], [0.2, 0.1, 0.2], [0.0; 3]);
        let solver = format!(r#""solver": {{"boundary_pressure": "{pressure}"}}, "closure": "paper""#);
        let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{tank}, {body}], {solver}"#));
        let mut fastest = 0.0_f64;
        while simulation.time() < 0.5 {
            let report = simulation.step().unwrap();
            assert_eq!(report.removed, 0);
            fastest = fastest.max(report.max_speed);
        }
        let flow = (2.0_f64 * 9.81 * 0.25).sqrt() * 0.1 / RP;
        assert!(fastest < flow, "{pressure}: {fastest} of {flow} m/s");
    }
}

#[test]
fn water_in_a_narrow_gap_between_two_bodies_stays_up() {
    // A column of 0.2 m in a gap of 2 rp between two boxes, on the floor of a tank.
    let tank = cuboid([0.2, 0.6, 0.6], [0.0, 0.3, 0.0], r#", "bake": {"invert": true}"#);
    let wall = |side: f64| cuboid([1.0, 0.8, 0.3], [0.0, 0.3, side * (0.15 + RP)], "");
    let fluid = block([-0.1, 0.0, -RP], [0.1, 0.2, RP], [0.0; 3]);
    let bodies = [tank, wall(1.0), wall(-1.0)].join(", ");
    let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{bodies}]"#));
    let start = energy(&simulation, 9.81);
    while simulation.time() < 1.0 {
        let report = simulation.step().unwrap();
        assert!(report.max_speed < 1.0 && report.pinched.count == 0, "{} m/s", report.max_speed);
    }
    let now = energy(&simulation, 9.81);
    assert!((now / start - 1.0).abs() < 0.1, "{now} of {start}");
}

#[test]
fn too_much_relaxation_is_refused() {
    let with = |relaxation: f64| {
        let text = format!(
            r#"{{"version": 1, "particle_radius": {RP}, {}, "stop": {{"time": 1}},
            "solver": {{"relaxation": {relaxation}}}}}"#,
            block([0.0; 3], [0.2; 3], [0.0; 3])
        );
        parse(&text, Syntax::Json, "r.json").map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(with(0.7), Ok(()));
    for relaxation in [0.71, 0.9, 1.0] {
        let error = with(relaxation).unwrap_err();
        assert!(error.contains("relaxation") && error.contains("more than 0.7"), "{error}");
    }
    // What is allowed gives no energy: a tank at rest.
    let tank = cuboid([0.3, 0.4, 0.3], [0.0, 0.2, 0.0], r#", "bake": {"invert": true}"#);
    let fluid = block([-0.15, 0.0, -0.15], [0.15, 0.25, 0.15], [0.0; 3]);
    let solver = r#""solver": {"relaxation": 0.7, "warm_start": 1.0}"#;
    let mut simulation = simulation(&format!(r#"{fluid}, "bodies": [{tank}], {solver}"#));
    let start = energy(&simulation, 9.81);
    while simulation.time() < 0.6 {
        simulation.step().unwrap();
        assert!(energy(&simulation, 9.81) < 1.001 * start, "{}", energy(&simulation, 9.81));
    }
}

#[test]
fn too_light_bodies_are_refused_by_name_and_the_lightest_floats() {
    let tank = cuboid([0.4, 0.6, 0.4], [0.0, 0.3, 0.0], r#", "bake": {"invert": true}"#);
    let fluid = block([-0.2, 0.0, -0.2], [0.2, 0.2, 0.2], [0.0; 3]);
    let keys = |density: f64| {
        let free = format!(r#", "name": "bubble", "motion": {{"free": {{"density": {density}}}}}"#);
        format!(r#"{fluid}, "bodies": [{tank}, {}]"#, cuboid([0.15; 3], [0.0, 0.3, 0.0], &free))
    };
    let scene = scene(&keys(0.05));
    let prepared = prepare(&scene, &Default::default(), &mut |_| ()).unwrap();
    let error = Simulation::new(assemble(&scene, prepared).unwrap()).err().unwrap().to_string();
    assert!(error.contains("`bubble`") && error.contains("0.05 kg/m^3"), "{error}");
    assert!(error.contains("give it 0.1 kg/m^3"), "{error}");
    let mut simulation = simulation(&keys(0.1));
    let start = energy(&simulation, 9.81);
    while simulation.time() < 0.8 {
        let report = simulation.step().unwrap();
        assert!(report.removed == 0 && energy(&simulation, 9.81) < 1.01 * start);
    }
    let body = simulation.bodies().state(1);
    assert!((0.2..0.35).contains(&body.centre.y), "it floats: {}", body.centre);
}
