//! Maps made without a baker, and the plain way to evaluate them: the oracle of the tests, the yardstick of the bench.
//! Not all who include it need all of it.
#![allow(dead_code)]

use volmap_formats::asset::{
    Array, Asset, Attributes, CellRun, DensityField, Dimension, Exterior, GridSpec, QuadratureSpec, Rounded,
};
use volmap_runtime::layout::serendipity::shape_and_gradient;
use volmap_runtime::layout::{Cell, CellIndex, FlatWall, LevelCells, Levels, Nodes, serendipity};
use volmap_runtime::{DVec3, Grid, MapDensity, Sample, Surface, UVec3};

/// Random numbers (xorshift), the same in every run.
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn point(&mut self, low: DVec3, high: DVec3) -> DVec3 {
        low + (high - low) * DVec3::new(self.unit(), self.unit(), self.unit())
    }
}

/// An asset whose fields are functions of the place of the node.
pub fn asset(
    grid: GridSpec,
    cells: [Vec<CellRun>; 2],
    phi: impl Fn(DVec3) -> f64,
    v: impl Fn(DVec3) -> f64,
) -> Asset {
    let [band_cells, solid_cells] = cells;
    let lattice = Grid::from(grid);
    let nodes = Nodes::new(lattice.resolution, &band_cells).unwrap();
    let places: Vec<DVec3> = nodes.positions(&lattice).collect();
    Asset {
        dimension: Dimension::Three,
        grid,
        support_radius: 0.1,
        exterior: Exterior::Fluid,
        quadrature: QuadratureSpec { name: "gl4".into(), degree: 4, points: 19, ball_volume: 0.004 },
        band_cells,
        solid_cells,
        finer: Vec::new(),
        signed_distance: Array::F64(places.iter().map(|&x| phi(x)).collect()),
        volume: Array::F64(places.iter().map(|&x| v(x)).collect()),
        density: None,
        plane_weight: None,
        bake: Attributes::default(),
        source: Attributes::default(),
        diagnosis: Attributes::default(),
    }
}

/// A ball of 0.5 m in cells of so many levels, finer towards a place of its surface; r is 0.1 m. Volume is against a flat
/// wall where x > 0.
pub fn adaptive_ball(levels: u32) -> Asset {
    let grid = GridSpec { origin: [-0.8, -0.9, -1.0], cell_size: [0.4, 0.3, 0.5], resolution: [4, 6, 4] };
    let phi = |x: DVec3| x.length() - 0.5;
    let wall = FlatWall::new(0.1, 0.004);
    let volume = |x: DVec3| wall.volume(phi(x)) * (1.0 + 0.3 * (0.1 - phi(x)).max(0.0));
    let fine = |x: DVec3| x.distance(DVec3::new(0.3, 0.4, 0.0));
    adaptive_asset(grid, levels, [&phi, &volume, &fine], |x| u32::from(x.x > 0.0))
}

/// An adaptive asset of distance and volume, divided towards where the third function, a distance too, is 0; `weight` is
/// asked at corners.
pub fn adaptive_asset(
    grid: GridSpec,
    levels: u32,
    [phi, v, fine]: [&dyn Fn(DVec3) -> f64; 3],
    weight: impl Fn(DVec3) -> u32,
) -> Asset {
    let lattice = Grid::from(grid);
    let cells = divided(&lattice, levels, phi, fine);
    let layout = Levels::new(lattice, &cells).expect("distances grade the levels");
    let places = layout.positions();
    let weights: Vec<u32> = layout.free_corners().map(|node| weight(places[node as usize])).collect();
    let corners = layout.complete_weights(&weights);
    let wall = FlatWall::new(0.1, 0.004);
    // The weights of all nodes, by the cells that have them.
    let mut weight_at = vec![0.0; layout.count()];
    for cell in layout.cells() {
        let corners = &corners.palette[corners.of_cell[cell.number] as usize];
        for (a, &node) in cell.nodes.iter().enumerate() {
            weight_at[node as usize] = trilinear(corners, serendipity::node(a));
        }
    }
    let free: Vec<usize> = layout.free().map(|node| node as usize).collect();
    let stored = |&node: &usize| v(places[node]) - weight_at[node] * wall.volume(phi(places[node]));
    let mut levels = cells.into_iter();
    let first = levels.next().expect("one level at least");
    Asset {
        signed_distance: Array::F64(free.iter().map(|&node| phi(places[node])).collect()),
        volume: Array::F64(free.iter().map(stored).collect()),
        finer: levels.collect(),
        plane_weight: Some(weights),
        ..asset(grid, [first.band, first.solid], |_| 0.0, |_| 0.0)
    }
}

/// Of values at the corners of the reference cell.
pub fn trilinear(corners: &[f64; 8], xi: DVec3) -> f64 {
    let side = |a: usize| DVec3::from([0, 1, 2].map(|axis| (a >> axis & 1) as f64 * 2.0 - 1.0));
    (0..8).map(|a| corners[a] * (0.5 * (DVec3::ONE + side(a) * xi)).element_product()).sum()
}

/// Cells are divided within one and a half of their diagonals from where `fine` is 0, which leaves them balanced.
fn divided(
    grid: &Grid,
    levels: u32,
    phi: &dyn Fn(DVec3) -> f64,
    fine: &dyn Fn(DVec3) -> f64,
) -> Vec<LevelCells> {
    let n = grid.resolution;
    let mut of_level: Vec<UVec3> =
        (0..n.element_product()).map(|at| UVec3::new(at % n.x, at / n.x % n.y, at / (n.x * n.y))).collect();
    let mut out = Vec::new();
    for level in 0..levels {
        let size = grid.cell_size / f64::from(1 << level);
        let (mut cells, mut next) = ([Vec::new(), Vec::new()], Vec::new());
        of_level.sort_by_key(|cell| (cell.z, cell.y, cell.x));
        for cell in of_level {
            let middle = grid.origin + size * (cell.as_dvec3() + 0.5);
            let distance = phi(middle);
            if level + 1 < levels && fine(middle).abs() < 1.5 * size.length() {
                next.extend((0..8).map(|n| 2 * cell + UVec3::new(n & 1, n >> 1 & 1, n >> 2 & 1)));
            } else if distance < 0.2 + 0.5 * size.length() {
                let solid = usize::from(distance < -0.2 - 0.5 * size.length());
                cells[solid].push(CellRun { i: cell.x, j: cell.y, k: cell.z, len: 1 });
            }
        }
        let [band, solid] = cells;
        out.push(LevelCells { band, solid });
        of_level = next;
    }
    out
}

/// The same asset with fields of single precision.
pub fn single(asset: &Asset) -> Asset {
    let round = |array: &Array| match array {
        Array::F64(values) => Array::F32(values.iter().map(|&x| x as f32).collect()),
        other => other.clone(),
    };
    each_field(asset, round)
}

/// The same asset with its volume, times a factor, for a density.
pub fn with_density(asset: Asset, factor: f64) -> Asset {
    let Array::F64(volume) = &asset.volume else { panic!("fields are of double precision") };
    let density = DensityField {
        kernel: "cubic_spline".into(),
        extension_length: 0.1,
        quadrature: "gl4".into(),
        degree: 4,
        points: 19,
        kernel_integral: 1.0,
        values: Array::F64(volume.iter().map(|v| factor * v).collect()),
    };
    Asset { density: Some(density), ..asset }
}

/// The same asset with fields of 16 bits, in steps of 1/10,000 of each one's largest number.
pub fn in_steps(asset: &Asset) -> Asset {
    let round = |array: &Array| match array {
        Array::F64(values) => {
            let largest = values.iter().fold(1e-300f64, |largest, x| largest.max(x.abs()));
            Array::Rounded(Rounded::new(values, largest, 5e-5).unwrap())
        }
        other => other.clone(),
    };
    each_field(asset, round)
}

/// The same asset with fields of double precision.
pub fn double_of(asset: &Asset) -> Asset {
    let double = |array: &Array| match array {
        Array::Rounded(rounded) => Array::F64(rounded.values().collect()),
        other => other.clone(),
    };
    each_field(asset, double)
}

fn each_field(asset: &Asset, change: impl Fn(&Array) -> Array) -> Asset {
    let density = asset.density.as_ref();
    let density = density.map(|d| DensityField { values: change(&d.values), ..d.clone() });
    let (signed_distance, volume) = (change(&asset.signed_distance), change(&asset.volume));
    Asset { signed_distance, volume, density, ..asset.clone() }
}

/// SPEC.md, sections 5 to 7, word by word: the sum of 32 products.
pub struct Oracle {
    grid: Grid,
    exterior: Exterior,
    cells: CellIndex,
    nodes: Vec<[f64; 2]>,
    density: Vec<f64>,
}

impl Oracle {
    pub fn new(asset: &Asset) -> Oracle {
        let grid = Grid::from(asset.grid);
        let nodes = Nodes::new(grid.resolution, &asset.band_cells).unwrap();
        let numbers = |array: &Array| match array {
            Array::F32(values) => values.iter().map(|&x| f64::from(x)).collect(),
            Array::F64(values) => values.clone(),
            _ => panic!("fields are floating-point numbers"),
        };
        let (phi, v): (Vec<f64>, Vec<f64>) = (numbers(&asset.signed_distance), numbers(&asset.volume));
        Oracle {
            grid,
            exterior: asset.exterior,
            cells: CellIndex::new(grid.resolution, &asset.band_cells, &asset.solid_cells, &nodes),
            nodes: phi.into_iter().zip(v).map(|(phi, v)| [phi, v]).collect(),
            density: asset.density.as_ref().map(|density| numbers(&density.values)).unwrap_or_default(),
        }
    }

    /// Density and gradient in a map that has them.
    pub fn density(&self, point: DVec3) -> Option<MapDensity> {
        let (sample, _) = self.sample(point);
        match sample {
            Sample::Outside => return Some(MapDensity::default()),
            Sample::DeepInside => return None,
            Sample::Near(_) => {}
        }
        let at = self.grid.locate(point)?;
        let Cell::Band(numbers) = self.cells.find(at.cell) else { return None };
        let (weights, gradients) = shape_and_gradient(at.xi);
        let mut out = MapDensity::default();
        for (a, number) in numbers.all().into_iter().enumerate() {
            out.value += weights[a] * self.density[number as usize];
            out.gradient += gradients[a] * self.density[number as usize];
        }
        out.gradient = out.gradient * 2.0 / self.grid.cell_size;
        Some(out)
    }

    /// The sample, and the length of the gradient that its normal comes from.
    pub fn sample(&self, point: DVec3) -> (Sample, f64) {
        let Some(at) = self.grid.locate(point) else {
            let solid = self.exterior == Exterior::Solid && point.is_finite();
            return (if solid { Sample::DeepInside } else { Sample::Outside }, 0.0);
        };
        let numbers = match self.cells.find(at.cell) {
            Cell::Band(numbers) => numbers.all(),
            Cell::Solid => return (Sample::DeepInside, 0.0),
            Cell::Fluid => return (Sample::Outside, 0.0),
        };
        let (weights, gradients) = shape_and_gradient(at.xi);
        let [mut distance, mut volume] = [0.0; 2];
        let mut slope = DVec3::ZERO;
        for (a, number) in numbers.into_iter().enumerate() {
            let [phi, v] = self.nodes[number as usize];
            distance += weights[a] * phi;
            volume += weights[a] * v;
            slope += gradients[a] * phi;
        }
        let slope = slope * 2.0 / self.grid.cell_size;
        let normal = slope.normalize_or_zero();
        let surface = Surface { distance, normal, closest_point: point - distance * normal, volume };
        (Sample::Near(surface), slope.length())
    }
}
