//! Distance, normal, closest point and volume at a point: Bender et al. 2020, section 4.3.

use crate::cells::{Cell, CellIndex};
use crate::grid::Grid;
use crate::serendipity::{NODES, shape, shape_and_gradient};
use glam::DVec3;
use volmap_formats::asset::{Exterior, QuadratureSpec};

/// A volume map, ready to be sampled. Made by [`VolumeMap::open`].
#[derive(Clone, Debug)]
pub struct VolumeMap {
    pub(crate) grid: Grid,
    pub(crate) support_radius: f64,
    pub(crate) exterior: Exterior,
    pub(crate) quadrature: QuadratureSpec,
    pub(crate) cells: CellIndex,
    pub(crate) fields: Fields,
}

/// Signed distance and volume of each node, side by side.
#[derive(Clone, Debug)]
pub(crate) enum Fields {
    F32(Vec<[f32; 2]>),
    F64(Vec<[f64; 2]>),
    /// Multiples of the two steps.
    Rounded(Vec<[i16; 2]>, [f64; 2]),
}

/// What the map says of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// In the band: the boundary is near.
    Near(Boundary),
    /// Farther from the solid than the band: no boundary volume.
    Outside,
    /// Deeper in the solid than the band: the whole ball is solid, the way out is unknown.
    DeepInside,
}

/// The boundary as a particle near it sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Signed distance Phi, metres, negative inside the solid (Eq. 10).
    pub distance: f64,
    /// Direction of the gradient of Phi, away from the solid, of length 1; zero where the gradient vanishes.
    pub normal: DVec3,
    /// Point of the surface closest to the sample, x - Phi n, metres.
    pub closest_point: DVec3,
    /// Volume of the solid in the ball of the support radius, m^3 (Eq. 12).
    pub volume: f64,
}

impl Sample {
    /// The boundary, if it is near.
    pub fn near(self) -> Option<Boundary> {
        match self {
            Sample::Near(boundary) => Some(boundary),
            Sample::Outside | Sample::DeepInside => None,
        }
    }
}

impl VolumeMap {
    /// Distance, normal, closest point and volume at a point (metres, in the map's frame).
    pub fn sample(&self, point: DVec3) -> Sample {
        let Some(at) = self.grid.locate(point) else {
            return match self.exterior {
                Exterior::Solid if point.is_finite() => Sample::DeepInside,
                _ => Sample::Outside,
            };
        };
        let numbers = match self.cells.find(at.cell) {
            Cell::Band(numbers) => numbers.all(),
            Cell::Solid => return Sample::DeepInside,
            Cell::Fluid => return Sample::Outside,
        };
        let (weights, gradients) = shape_and_gradient(at.xi);
        let [mut distance, mut volume] = [0.0; 2];
        let mut slope = DVec3::ZERO;
        for (a, [phi, v]) in self.fields.gather(&numbers).into_iter().enumerate() {
            distance += weights[a] * phi;
            volume += weights[a] * v;
            slope += gradients[a] * phi;
        }
        let normal = (slope * 2.0 / self.grid.cell_size).normalize_or_zero();
        Sample::Near(Boundary { distance, normal, closest_point: point - distance * normal, volume })
    }

    /// [`VolumeMap::sample`] of every point, into `samples`, whose old content is dropped.
    pub fn sample_batch(&self, points: &[DVec3], samples: &mut Vec<Sample>) {
        samples.clear();
        samples.extend(points.iter().map(|&point| self.sample(point)));
    }

    /// Whether a point lies in the solid: for filling a body with particles.
    pub fn inside(&self, point: DVec3) -> bool {
        let Some(at) = self.grid.locate(point) else {
            return self.exterior == Exterior::Solid && point.is_finite();
        };
        match self.cells.find(at.cell) {
            Cell::Solid => true,
            Cell::Fluid => false,
            Cell::Band(numbers) => {
                let nodes = self.fields.gather(&numbers.all());
                let weighted = shape(at.xi).into_iter().zip(nodes).map(|(n, [phi, _])| n * phi);
                weighted.sum::<f64>() < 0.0
            }
        }
    }

    /// The lattice of cells; its box is the domain of the map.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Support radius r of the kernels that the map serves, metres.
    pub fn support_radius(&self) -> f64 {
        self.support_radius
    }

    /// What lies outside the domain.
    pub fn exterior(&self) -> Exterior {
        self.exterior
    }

    /// The rule that integrated the volume.
    pub fn quadrature(&self) -> &QuadratureSpec {
        &self.quadrature
    }

    /// Bytes that the map holds in memory.
    pub fn memory_bytes(&self) -> usize {
        let fields = match &self.fields {
            Fields::F32(nodes) => size_of_val(nodes.as_slice()),
            Fields::F64(nodes) => size_of_val(nodes.as_slice()),
            Fields::Rounded(nodes, _) => size_of_val(nodes.as_slice()),
        };
        fields + self.cells.memory_bytes()
    }
}

impl Fields {
    fn gather(&self, numbers: &[u32; NODES]) -> [[f64; 2]; NODES] {
        match self {
            Fields::F32(nodes) => numbers.map(|n| nodes[n as usize].map(f64::from)),
            Fields::F64(nodes) => numbers.map(|n| nodes[n as usize]),
            Fields::Rounded(nodes, steps) => {
                let scaled = |[d, v]: [i16; 2]| [f64::from(d) * steps[0], f64::from(v) * steps[1]];
                numbers.map(|n| scaled(nodes[n as usize]))
            }
        }
    }
}
