// A map that the examples need: a ball, computed here by plain sums. A bake is faster and takes any mesh.

use volmap_formats::asset::{Array, Asset, Attributes, Dimension, Exterior, QuadratureSpec};
use volmap_runtime::layout::{CellRun, GridSpec, Nodes};
use volmap_runtime::{DVec3, Grid};

/// Radius of the ball, metres; its centre is the origin.
pub const RADIUS: f64 = 0.2;

/// Its map for a support radius r (metres), in cells of r / 2.
pub fn asset(support_radius: f64) -> Asset {
    let n = (2.0 * (RADIUS + 2.5 * support_radius) / (0.5 * support_radius)).ceil() as u32;
    let grid = GridSpec {
        origin: [-0.25 * support_radius * f64::from(n); 3],
        cell_size: [0.5 * support_radius; 3],
        resolution: [n; 3],
    };
    let [band_cells, solid_cells] = cells(&Grid::from(grid), 2.0 * support_radius);
    let nodes = Nodes::new([n; 3].into(), &band_cells).expect("fewer than 2^32 nodes");
    let places: Vec<DVec3> = nodes.positions(&Grid::from(grid)).collect();
    Asset {
        dimension: Dimension::Three,
        grid,
        support_radius,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec {
            name: "lattice".into(),
            degree: 1,
            points: u64::from(STEPS).pow(3),
            ball_volume: 4.0 / 3.0 * std::f64::consts::PI * support_radius.powi(3),
        },
        band_cells,
        solid_cells,
        finer: Vec::new(),
        signed_distance: Array::F32(places.iter().map(|x| distance(*x) as f32).collect()),
        volume: Array::F32(places.iter().map(|x| volume(*x, support_radius) as f32).collect()),
        density: None,
        plane_weight: None,
        bake: Attributes::new(),
        source: Attributes::new(),
        diagnosis: Attributes::new(),
    }
}

/// Signed distance to the surface, metres.
pub fn distance(point: DVec3) -> f64 {
    point.length() - RADIUS
}

/// Runs of the cells that reach into the band of this half width, and of those deeper in the ball.
fn cells(grid: &Grid, width: f64) -> [Vec<CellRun>; 2] {
    let mut runs = [Vec::<CellRun>::new(), Vec::new()];
    let [nx, ny, nz] = grid.resolution.to_array();
    let reach = width + 0.5 * grid.cell_size.length();
    for (k, j, i) in (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| (k, j, i)))) {
        let phi = distance(grid.cell_corner([i, j, k].into()) + 0.5 * grid.cell_size);
        let runs = match phi {
            _ if phi.abs() <= reach => &mut runs[0],
            _ if phi < 0.0 => &mut runs[1],
            _ => continue,
        };
        match runs.last_mut().filter(|run| (run.k, run.j, run.i + run.len) == (k, j, i)) {
            Some(run) => run.len += 1,
            None => runs.push(CellRun { i, j, k, len: 1 }),
        }
    }
    runs
}

/// Points of the sum along each axis.
const STEPS: u32 = 10;

/// Eq. 12 and 13 of Bender et al. 2020: the solid's volume in the ball of radius r around a point, m^3.
fn volume(point: DVec3, r: f64) -> f64 {
    let at = |n: u32| r * ((2.0 * f64::from(n) + 1.0) / f64::from(STEPS) - 1.0);
    let (mut inside, mut solid) = (0.0, 0.0);
    for n in 0..STEPS.pow(3) {
        let offset = DVec3::new(at(n % STEPS), at(n / STEPS % STEPS), at(n / STEPS.pow(2)));
        if offset.length_squared() < r * r {
            inside += 1.0;
            solid += match distance(point + offset) / r {
                q if q <= 0.0 => 1.0,
                q if q <= 0.5 => 6.0 * (q.powi(3) - q * q) + 1.0,
                q => 2.0 * (1.0 - q).max(0.0).powi(3),
            };
        }
    }
    4.0 / 3.0 * std::f64::consts::PI * r.powi(3) * solid / inside
}
