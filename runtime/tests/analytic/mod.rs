//! Maps made without a baker, and the plain way to evaluate them: the oracle of the tests, the yardstick of the bench.
//! Not all who include it need all of it.
#![allow(dead_code)]

use volmap_formats::asset::{
    Array, Asset, Attributes, CellRun, DensityField, Dimension, Exterior, GridSpec, QuadratureSpec, Rounded,
};
use volmap_runtime::layout::serendipity::shape_and_gradient;
use volmap_runtime::layout::{Cell, CellIndex, Nodes};
use volmap_runtime::{DVec3, Grid, MapDensity, Sample, Surface};

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
