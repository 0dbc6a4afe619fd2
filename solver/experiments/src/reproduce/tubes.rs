//! Comparison with tube maps: density against the exact integral where a surface is smooth, sharp, thin or near another
//! one; bake times; and a scene of thin and sharp walls.

use super::methods::{Method, Scenery, survives};
use super::prism::{circle, prism};
use crate::validation::flow::{GRAVITY, lattice};
use crate::validation::{Experiment, Outcome, Row, Run, chart, curve};
use std::ops::Range;
use volmap_figures::picture::colours::{DISTINCT, INK};
use volmap_figures::picture::{Data, Series};
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::boundary::density_map::EXTENSION;
use volmap_fluid::observe::rms_speed;
use volmap_fluid::settings::{BoundaryMethod, BoundaryPressure, SolverSettings};
use volmap_fluid::shapes::{bake_made, ball, cuboid};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{ClosureKind, DVec3, Kernel, KernelKind};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "tubes",
    title: "Tube maps",
    about: "Tube, density and volume maps: densities against exact integrals, bake times, thin and sharp walls",
    run,
};

/// Particle radius and support radius of the densities, metres.
const RADIUS: f64 = 0.025;
const SUPPORT: f64 = 4.0 * RADIUS;

/// A solid, and a ray away from it.
struct Solid {
    name: &'static str,
    mesh: TriangleMesh,
    container: bool,
    /// Its signed distance, metres.
    distance: Box<dyn Fn(DVec3) -> f64 + Sync>,
    /// The ray's origin on the surface, and its direction per unit of distance.
    ray: [DVec3; 2],
}

/// Distances at which densities are compared, rp.
const DISTANCES: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0];

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    let mut errors = Vec::new();
    for solid in solids() {
        (run.progress)(&format!("tubes: {}", solid.name));
        errors.push(compare(&solid, &mut outcome)?);
    }
    for Group { name: group, solids } in GROUPS {
        for (n, (method, _)) in integrals().iter().enumerate() {
            let mean = errors[solids.clone()].iter().map(|errors| errors[n] * errors[n]).sum::<f64>()
                / solids.len() as f64;
            outcome.rows.push(Row::new(
                group,
                format!("{}: density, rms error", method.view()),
                "%",
                100.0 * mean.sqrt(),
            ));
        }
    }
    build(run, &mut outcome)?;
    for &thickness in run.pick(&[0.5][..], &[1.0, 0.25]) {
        for method in scene_methods() {
            (run.progress)(&format!("tubes: plate of {thickness} rp, {}", method.name()));
            outcome.rows.extend(pour(run, method, thickness)?);
        }
    }
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    r = 0.1 m, rp = r / 4, cells of r / 4, distances 0.5 to 3 rp. Density and tube maps have the integral of gamma W \
    over the solid and 0.2 r around it (Eq. 9 and 11), `calibrated` and `wedge` that of W over the solid: each is \
    compared with its own. `mirror` and particles have no integral. The authors' own tube maps: \
    solver/benches/compare_tube_maps.py.";

fn cube_distance(x: DVec3, low: DVec3, high: DVec3) -> f64 {
    let out = (low - x).max(x - high);
    out.max(DVec3::ZERO).length() + out.max_element().min(0.0)
}

/// A box or its hollow.
fn cube(name: &'static str, [low, high]: [DVec3; 2], container: bool, ray: [DVec3; 2]) -> Solid {
    let sign = if container { -1.0 } else { 1.0 };
    let distance = Box::new(move |x| sign * cube_distance(x, low, high));
    Solid { name, mesh: cuboid(low, high), container, distance, ray }
}

fn round(name: &'static str, radius: f64, container: bool) -> Solid {
    let sign = if container { -1.0 } else { 1.0 };
    // Off the symmetry axes of the mesh.
    let way = DVec3::new(0.48, 0.6, 0.64);
    let distance = Box::new(move |x: DVec3| sign * (x.length() - radius));
    Solid { name, mesh: ball(radius, 6), container, distance, ray: [radius * way, sign * way] }
}

fn cylinder(radius: f64) -> Solid {
    let way = DVec3::new(0.6, 0.8, 0.0);
    let distance = Box::new(move |x: DVec3| x.truncate().length() - radius);
    let mesh = prism(&circle(radius, 240), 0.5);
    Solid { name: "cylinder of r", mesh, container: false, distance, ray: [radius * way, way] }
}

fn solids() -> Vec<Solid> {
    let half = DVec3::splat(0.3);
    let [face, edge, corner] = [DVec3::Y, DVec3::new(1.0, 1.0, 0.0), DVec3::ONE];
    let flat = |thickness: f64| [DVec3::new(-0.3, -thickness, -0.3), DVec3::new(0.3, 0.0, 0.3)];
    let way = |corner: DVec3| corner / corner.length();
    let aside = DVec3::new(0.013, 0.0, 0.021);
    let out = |n: DVec3| [0.3 * n + if n == face { aside } else { DVec3::ZERO }, way(n)];
    let into = |n: DVec3| [0.3 * n, -n];
    vec![
        cube("plane", [-half, half], false, out(face)),
        round("ball of 4 r", 4.0 * SUPPORT, false),
        round("ball of r", SUPPORT, false),
        round("ball of r / 2", 0.5 * SUPPORT, false),
        round("hollow of 4 r", 4.0 * SUPPORT, true),
        cylinder(SUPPORT),
        cube("convex edge", [-half, half], false, out(edge)),
        cube("convex corner", [-half, half], false, out(corner)),
        cube("concave edge", [-half, half], true, into(edge)),
        cube("concave corner", [-half, half], true, into(corner)),
        cube("plate of r / 4", flat(0.25 * SUPPORT), false, [aside, face]),
        cube("gap of r", flat(SUPPORT), true, [aside, -face]),
    ]
}

/// Solids whose errors are averaged.
struct Group {
    name: &'static str,
    /// Which of [`solids`].
    solids: Range<usize>,
}

const GROUPS: [Group; 3] = [
    Group { name: "all smooth ones", solids: 0..6 },
    Group { name: "all edges and corners", solids: 6..10 },
    Group { name: "plate and gap", solids: 10..12 },
];

/// Maps of an integral, and whether it has gamma.
fn integrals() -> [(Method, bool); 4] {
    let own = BoundaryPressure::Own;
    [
        (Method::maps(ClosureKind::Calibrated, own), false),
        (Method::maps(ClosureKind::Wedge, own), false),
        (Method::of(BoundaryMethod::DensityMap, own), true),
        (Method::of(BoundaryMethod::TubeMap, own), true),
    ]
}

/// Root mean square of each method's error.
fn compare(solid: &Solid, outcome: &mut Outcome) -> Result<[f64; 4], Error> {
    // Beyond the middle of a gap of r the other wall is nearer.
    let farthest = if solid.name == "gap of r" { 2.0 } else { 3.0 };
    let distances: Vec<f64> = DISTANCES.into_iter().filter(|d| *d <= farthest).collect();
    let places: Vec<DVec3> = distances.iter().map(|d| solid.ray[0] + d * RADIUS * solid.ray[1]).collect();
    let exact: Vec<[f64; 2]> = places.iter().map(|&place| integral(solid, place)).collect();
    let (mut curves, mut errors) = (Vec::new(), [0.0; 4]);
    // A density map has what all four methods need.
    let with_all = Method::of(BoundaryMethod::DensityMap, BoundaryPressure::Own);
    let shape = with_all.shape(solid.mesh.clone(), RADIUS, solid.container)?;
    for (n, (method, has_gamma)) in integrals().into_iter().enumerate() {
        let walls = method.walls(RADIUS, vec![shape.body("solid", DVec3::ZERO, Motion::Static)], &places)?;
        let (mut square, mut largest) = (0.0, 0.0_f64);
        let mut points = Vec::new();
        for ((wall, exact), d) in walls.iter().zip(&exact).zip(&distances) {
            let exact = exact[usize::from(has_gamma)];
            let error = (f64::from(wall.density) - exact) / exact;
            square += error * error / walls.len() as f64;
            largest = if error.abs() > largest.abs() { error } else { largest };
            points.push([*d, f64::from(wall.density) / exact]);
        }
        let row = |quantity: &str, value| {
            Row::new(solid.name, format!("{}: {quantity}", method.view()), "%", 100.0 * value)
        };
        errors[n] = square.sqrt();
        outcome.rows.push(row("density, rms error", errors[n]));
        outcome.rows.push(row("density, largest error", largest));
        curves.push(curve(method.view(), DISTINCT[n], points));
    }
    let one = Data::Dashes(vec![[0.5, 1.0], [farthest, 1.0]]);
    curves.push(Series { name: String::new(), colour: INK, data: one });
    let file = format!("tubes-{}.png", solid.name.replace(" / ", "_over_").replace(' ', "_"));
    let axes = [["Distance from the surface", "rp"], ["Density over the exact one", ""]];
    outcome.chart(file, chart(solid.name, axes[0], axes[1], curves));
    Ok(errors)
}

/// Integrals of W over the solid, and of gamma W: sums over small cubes, each filled as by a plane at its distance.
fn integral(solid: &Solid, place: DVec3) -> [f64; 2] {
    const ACROSS: i32 = 64;
    let kernel = Kernel::new(KernelKind::CubicSpline, SUPPORT);
    let edge = 2.0 * SUPPORT / f64::from(ACROSS);
    let middle = |n: i32| (f64::from(n) + 0.5) * edge - SUPPORT;
    let mut sum = [0.0; 2];
    for n in 0..ACROSS.pow(3) {
        let way = DVec3::new(middle(n % ACROSS), middle(n / ACROSS % ACROSS), middle(n / ACROSS / ACROSS));
        let weight = kernel.value(way.length()) * edge.powi(3);
        if weight > 0.0 {
            let distance = (solid.distance)(place + way);
            sum[0] += weight * (0.5 - distance / edge).clamp(0.0, 1.0);
            sum[1] += weight * (1.0 - distance / (EXTENSION * SUPPORT)).max(0.0);
        }
    }
    sum
}

/// Seconds that the maps of a ball of 8,192 triangles take.
fn build(run: &Run, outcome: &mut Outcome) -> Result<(), Error> {
    let support = run.pick(2.0 * SUPPORT, SUPPORT);
    let own = BoundaryPressure::Own;
    for method in [
        Method::maps(ClosureKind::Calibrated, own),
        Method::maps(ClosureKind::Mirror, own),
        Method::of(BoundaryMethod::DensityMap, own),
    ] {
        (run.progress)(&format!("tubes: building, {}", method.view()));
        let baked = bake_made(ball(0.5, 5), method.baking(support, false))?;
        let case = format!("building, {}", method.view());
        let total: f64 = baked.summary.seconds.iter().map(|(_, seconds)| seconds).sum();
        for (stage, seconds) in &baked.summary.seconds {
            outcome.rows.push(Row::new(&case, format!("stage {stage}"), "s", *seconds));
        }
        outcome.rows.push(Row::new(&case, "all", "s", total));
        outcome.rows.push(Row::new(&case, "nodes", "", baked.summary.nodes as f64));
    }
    Ok(())
}

fn scene_methods() -> [Method; 8] {
    use BoundaryPressure::{Mirror, Mls, Own};
    [
        Method::maps(ClosureKind::Mirror, Own),
        Method::maps(ClosureKind::Calibrated, Own),
        Method::of(BoundaryMethod::TubeMap, Own),
        Method::of(BoundaryMethod::TubeMap, Mirror),
        Method::of(BoundaryMethod::DensityMap, Own),
        Method::of(BoundaryMethod::DensityMap, Mirror),
        Method::of(BoundaryMethod::Particles, Mirror),
        Method::of(BoundaryMethod::Particles, Mls),
    ]
}

/// Half of the tank's sides, its height, and bottom and top of the water at the start, metres.
const HALF: [f64; 2] = [0.3, 0.15];
const HEIGHT: f64 = 0.7;
const LEVELS: [f64; 2] = [0.2, 0.6];

/// A tank with a plate in its middle, `thickness` in rp, and a ridge of 30 degrees under the water on the left.
fn plate_and_ridge(method: &Method, radius: f64, thickness: f64) -> Result<Scenery, Error> {
    let plate_half = 0.5 * thickness * radius;
    let tank = cuboid(DVec3::new(-HALF[0], 0.0, -HALF[1]), DVec3::new(HALF[0], HEIGHT, HALF[1]));
    let plate =
        cuboid(DVec3::new(-plate_half, -0.1, -HALF[1] - 0.1), DVec3::new(plate_half, HEIGHT, HALF[1] + 0.1));
    // Around its centre, which is at a third of its height.
    let ridge = prism(&[[0.0, 0.1], [-0.04, -0.05], [0.04, -0.05]], HALF[1] + 0.1);
    let (tank, plate) = (method.shape(tank, radius, true)?, method.shape(plate, radius, false)?);
    let ridge = method.shape(ridge, radius, false)?;
    let bodies = vec![
        tank.body("tank", DVec3::ZERO, Motion::Static),
        plate.body("plate", DVec3::ZERO, Motion::Static),
        ridge.body("ridge", DVec3::new(-0.5 * HALF[0], 0.05, 0.0), Motion::Static),
    ];
    let low = DVec3::new(-HALF[0] + radius, LEVELS[0], -HALF[1] + radius);
    let high = DVec3::new(-plate_half - radius, LEVELS[1], HALF[1] - radius);
    let mut solver = SolverSettings::default();
    solver.time_step.min = 1e-5;
    Ok(Scenery { radius, places: lattice(low, high, radius), bodies, solver, ..Scenery::default() })
}

/// Water falls on the ridge; measures what gets through the plate, `thickness` in rp, and out of the tank.
fn pour(run: &Run, method: Method, thickness: f64) -> Result<Vec<Row>, Error> {
    let radius = run.pick(0.025, 0.015);
    let mut simulation = method.simulation(&plate_and_ridge(&method, radius, thickness)?)?;
    let count = simulation.particles().len();
    let (mut inside, mut steps, mut fastest) = (0, 0_u32, 0.0_f64);
    let stopped = survives(run, &mut simulation, run.pick(0.6, 2.0), &mut |_, report| {
        inside += report.inside;
        steps += 1;
        fastest = fastest.max(report.max_speed);
    })?;
    let positions = &simulation.particles().positions;
    let through = positions.iter().filter(|x| x.x > 0.0).count();
    let out = |x: &&DVec3| x.y < -radius || x.x.abs() > HALF[0] + radius || x.z.abs() > HALF[1] + radius;
    let case = format!("plate of {thickness} rp and a ridge: {}", method.name());
    let told = |quantity: &str, unit, value| Row::new(&case, quantity, unit, value);
    let fall = (2.0 * GRAVITY * LEVELS[1]).sqrt();
    let mut rows = vec![
        told("through the plate", "%", 100.0 * through as f64 / count as f64),
        told("out of the tank", "", (count - positions.len() + positions.iter().filter(out).count()) as f64),
        told("centres in a body", "%", 100.0 * inside as f64 / (count as f64 * f64::from(steps.max(1)))),
        told("largest speed over that of a free fall", "", fastest / fall),
        told("rms speed at the end", "m/s", rms_speed(&simulation)),
        told("steps", "", f64::from(steps)),
    ];
    if let Some(time) = stopped {
        rows.push(told("stopped at", "s", time));
    }
    Ok(rows)
}
