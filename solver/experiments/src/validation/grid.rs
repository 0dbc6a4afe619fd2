//! Thin walls hold: water poured on a grid of bars (Fig. 13 of Bender et al. 2020) goes through its holes and not
//! through its bars, and a plate a quarter as thick as the support radius holds a column of water.

use super::flow::{lattice, water};
use super::{Experiment, Outcome, Row, Run};
use std::collections::HashMap;
use volmap_fluid::Error;
use volmap_fluid::bodies::Motion;
use volmap_fluid::shapes::{Shape, baked, cuboid};
use volmap_fluid::simulation::{Simulation, StepReport};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DVec3, PosedMap, Sample};

/// Its entry in [`EXPERIMENTS`](super::EXPERIMENTS).
pub const EXPERIMENT: Experiment = Experiment {
    name: "grid",
    title: "Thin walls",
    about: "Water falls on a grid of bars and rests on a thin plate: nothing goes through them",
    run,
};

/// Width of the grid's bars, their thickness, and its holes, metres: those of `grid.obj` in the sample data.
pub const BAR: f64 = 0.03;
const HOLE: f64 = 0.078;

fn run(run: &Run) -> Result<Outcome, Error> {
    let mut outcome = Outcome::default();
    // The long form has six, four and three particles across a hole.
    let radii: &[f64] = run.pick(&[0.013], &[0.0065, 0.01, 0.013]);
    for &radius in radii {
        (run.progress)(&format!("grid: rp = {radius} m"));
        pour(run, &mut outcome, radius)?;
    }
    (run.progress)("grid: plate");
    hold(run, &mut outcome)?;
    outcome.notes.push(NOTE.into());
    Ok(outcome)
}

const NOTE: &str = "\
    The grid is 3 cm thick, with bars 3 cm wide and holes of 7.8 cm between them: 6, 3.9 and 3 particles of rp = \
    6.5, 10 and 13 mm fit into a hole. A particle is through a bar if it crosses the middle plane where the map says \
    solid.";

/// A grid of `count` by `count` holes around the origin: its bars as one closed mesh.
pub fn bars(count: usize) -> TriangleMesh {
    let (pitch, half) = (BAR + HOLE, 0.5 * BAR);
    let width = count as f64 * pitch + BAR;
    let lines: Vec<f64> = (0..=count)
        .flat_map(|n| [n as f64 * pitch, n as f64 * pitch + BAR])
        .map(|x| x - 0.5 * width)
        .collect();
    let side = lines.len();
    let mut mesh = TriangleMesh::default();
    for &y in &[-half, half] {
        for &z in &lines {
            mesh.vertices.extend(lines.iter().map(|&x| [x, y, z]));
        }
    }
    let vertex = |x: usize, y: usize, z: usize| (y * side * side + z * side + x) as u32;
    let is_bar = |x: i64, z: i64| {
        let cells = 0..side as i64 - 1;
        cells.contains(&x) && cells.contains(&z) && (x % 2 == 0 || z % 2 == 0)
    };
    let mut quad = |[a, b, c, d]: [u32; 4]| mesh.triangles.extend([[a, b, c], [a, c, d]]);
    for z in 0..side - 1 {
        for x in (0..side - 1).filter(|&x| is_bar(x as i64, z as i64)) {
            quad([vertex(x, 1, z), vertex(x, 1, z + 1), vertex(x + 1, 1, z + 1), vertex(x + 1, 1, z)]);
            quad([vertex(x, 0, z), vertex(x + 1, 0, z), vertex(x + 1, 0, z + 1), vertex(x, 0, z + 1)]);
            // Corners of the cell around, and the cell beyond each edge.
            let around = [(x, z), (x + 1, z), (x + 1, z + 1), (x, z + 1)];
            for (n, (i, j)) in [(0, -1), (1, 0), (0, 1), (-1, 0)].into_iter().enumerate() {
                if !is_bar(x as i64 + i, z as i64 + j) {
                    let ((ax, az), (bx, bz)) = (around[n], around[(n + 1) % 4]);
                    quad([vertex(ax, 0, az), vertex(ax, 1, az), vertex(bx, 1, bz), vertex(bx, 0, bz)]);
                }
            }
        }
    }
    mesh
}

/// Particles that got into the solid or through it.
#[derive(Default)]
struct Leaks {
    /// Particles in the solid, summed over steps, and in the step with most of them.
    inside: u64,
    most_inside: usize,
    steps: u64,
    /// Greatest depth of a centre, metres.
    depth: f64,
    removed: usize,
    /// Crossings of the middle plane, through holes and through the solid.
    passed: usize,
    leaked: usize,
    /// Last position of each particle, by id.
    last: HashMap<u32, DVec3>,
}

impl Leaks {
    /// Counts after a step; `wall` lies around the plane y = 0.
    fn look(&mut self, simulation: &Simulation, wall: &PosedMap, report: &StepReport) {
        self.steps += 1;
        self.inside += report.inside as u64;
        self.most_inside = self.most_inside.max(report.inside);
        self.removed += report.removed;
        let particles = simulation.particles();
        for (&x, &id) in particles.positions.iter().zip(&particles.ids) {
            if let Sample::Near(near) = wall.sample(x) {
                self.depth = self.depth.max(-near.distance);
            }
            let Some(before) = self.last.insert(id, x) else { continue };
            if before.y > 0.0 && x.y <= 0.0 {
                let crossing = before.lerp(x, before.y / (before.y - x.y));
                match wall.map.inside(wall.pose.to_map(crossing)) {
                    true => self.leaked += 1,
                    false => self.passed += 1,
                }
            }
        }
    }

    fn rows(&self, outcome: &mut Outcome, case: &str, radius: f64) {
        let rows = &mut outcome.rows;
        rows.push(Row::new(case, "particles lost", "", self.removed as f64).at_most(0.0));
        rows.push(Row::new(case, "particles through the solid", "", self.leaked as f64).at_most(0.0));
        rows.push(Row::new(case, "deepest centre in the wall", "rp", self.depth / radius).at_most(1.0));
        rows.push(Row::new(case, "most centres in a body in a step", "", self.most_inside as f64));
        let mean = self.inside as f64 / self.steps.max(1) as f64;
        rows.push(Row::new(case, "mean of centres in a body", "", mean));
    }
}

/// A block of water falls on the grid.
fn pour(run: &Run, outcome: &mut Outcome, radius: f64) -> Result<(), Error> {
    let grid = baked(bars(5), 4.0 * radius, false)?;
    let tank =
        baked(cuboid(DVec3::new(-0.35, -0.4, -0.35), DVec3::new(0.35, 0.6, 0.35)), 4.0 * radius, true)?;
    let places = lattice(DVec3::new(-0.2, 0.05, -0.2), DVec3::new(0.2, run.pick(0.25, 0.45), 0.2), radius);
    let bodies =
        vec![grid.body("grid", DVec3::ZERO, Motion::Static), tank.body("tank", DVec3::ZERO, Motion::Static)];
    let mut simulation = water(radius, &places, 0.001, bodies)?;
    let wall = simulation.bodies().posed()[0].clone();
    let mut leaks = Leaks::default();
    run.until(&mut simulation, run.pick(0.5, 1.5), &mut |simulation, report| {
        leaks.look(simulation, &wall, report);
    })?;
    let case = format!("grid, rp = {} mm", 1e3 * radius);
    leaks.rows(outcome, &case, radius);
    let passed = leaks.passed as f64 / places.len() as f64;
    outcome.rows.push(Row::new(&case, "crossings through holes, over particles", "", passed).at_least(0.05));
    Ok(())
}

/// A column of water on a plate.
fn hold(run: &Run, outcome: &mut Outcome) -> Result<(), Error> {
    let radius = 0.02;
    let support = 4.0 * radius;
    let (half, low) = (0.25, 0.3);
    let thickness = 0.25 * support;
    let plate = cuboid(DVec3::new(-0.4, -0.5 * thickness, -0.4), DVec3::new(0.4, 0.5 * thickness, 0.4));
    let plate: Shape = baked(plate, support, false)?;
    let tank = baked(cuboid(DVec3::new(-half, -low, -half), DVec3::new(half, 0.8, half)), support, true)?;
    let places = lattice(DVec3::new(-half, 0.5 * thickness, -half), DVec3::new(half, 0.5, half), radius);
    let bodies = vec![
        plate.body("plate", DVec3::ZERO, Motion::Static),
        tank.body("tank", DVec3::ZERO, Motion::Static),
    ];
    let mut simulation = water(radius, &places, 0.01, bodies)?;
    let wall = simulation.bodies().posed()[0].clone();
    let mut leaks = Leaks::default();
    run.until(&mut simulation, run.pick(0.5, 5.0), &mut |simulation, report| {
        leaks.look(simulation, &wall, report);
    })?;
    let below = simulation.particles().positions.iter().filter(|x| x.y < 0.0).count();
    let case = "plate of r / 4 under 0.5 m";
    leaks.rows(outcome, case, radius);
    outcome.rows.push(Row::new(case, "particles below it at the end", "", below as f64).at_most(0.0));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bars_are_closed_and_fill_their_volume() {
        let mesh = bars(3);
        let at = |n: u32| DVec3::from(mesh.vertices[n as usize]);
        let volume: f64 = mesh.triangles.iter().map(|&[a, b, c]| at(a).dot(at(b).cross(at(c))) / 6.0).sum();
        let width = 3.0 * HOLE + 4.0 * BAR;
        assert!((volume - BAR * (width * width - 9.0 * HOLE * HOLE)).abs() < 1e-12, "{volume}");
        let edges: std::collections::HashSet<(u32, u32)> =
            mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]).collect();
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))), "not closed");
    }
}
