//! Distance, normal, closest point and volume at a point: Bender et al. 2020, section 4.3.

use crate::batch::answer_all;
use crate::cells::CellIndex;
use crate::density::DensityNodes;
use crate::fields::Fields;
use crate::grid::Grid;
use glam::DVec3;
use volmap_formats::asset::{Dimension, Exterior, QuadratureSpec};

/// A volume map, ready to be sampled. Made by [`VolumeMap::open`].
#[derive(Clone, Debug)]
pub struct VolumeMap {
    pub(crate) dimension: Dimension,
    pub(crate) grid: Grid,
    /// 1 / cell_size, for gradients only.
    pub(crate) per_cell: DVec3,
    pub(crate) support_radius: f64,
    pub(crate) exterior: Exterior,
    pub(crate) quadrature: QuadratureSpec,
    pub(crate) cells: CellIndex,
    pub(crate) fields: Fields,
    pub(crate) density: Option<DensityNodes>,
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
    /// Volume of the solid in the ball of the support radius, m^3 (Eq. 12); in two dimensions area in the disc, m^2.
    pub volume: f64,
}

/// Distance and volume alone, for whom the direction doesn't matter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Values {
    /// Signed distance Phi, metres; infinite where it is unknown: positive outside the band, negative deep inside.
    pub distance: f64,
    /// Volume of the solid in the ball of the support radius, m^3; 0 outside, that of the full ball deep inside.
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
        let mut out = Sample::Outside;
        answer_all(self, &[point], std::slice::from_mut(&mut out));
        out
    }

    /// [`VolumeMap::sample`] of every point, into `samples`, whose old content is dropped.
    pub fn sample_batch(&self, points: &[DVec3], samples: &mut Vec<Sample>) {
        samples.resize(points.len(), Sample::Outside);
        answer_all(self, points, samples);
    }

    /// [`VolumeMap::sample`], and the gradient of the volume, m^2 (0 where the boundary isn't near): that of the
    /// interpolated volume, which jumps a little between cells.
    pub fn sample_with_gradient(&self, point: DVec3) -> (Sample, DVec3) {
        let mut out = (Sample::Outside, DVec3::ZERO);
        answer_all(self, &[point], std::slice::from_mut(&mut out));
        out
    }

    /// [`VolumeMap::sample_with_gradient`] of every point, into `samples`, whose old content is dropped.
    pub fn sample_with_gradient_batch(&self, points: &[DVec3], samples: &mut Vec<(Sample, DVec3)>) {
        samples.resize(points.len(), (Sample::Outside, DVec3::ZERO));
        answer_all(self, points, samples);
    }

    /// Distance and volume at a point.
    pub fn values(&self, point: DVec3) -> Values {
        let mut out = Values::default();
        answer_all(self, &[point], std::slice::from_mut(&mut out));
        out
    }

    /// [`VolumeMap::values`] of every point, into `values`, whose old content is dropped.
    pub fn values_batch(&self, points: &[DVec3], values: &mut Vec<Values>) {
        values.resize(points.len(), Values::default());
        answer_all(self, points, values);
    }

    /// Whether a point lies in the solid: for filling a body with particles.
    pub fn inside(&self, point: DVec3) -> bool {
        self.values(point).distance < 0.0
    }

    /// In how many dimensions the map is. In two, z plays no part: volumes are areas (m^2), their gradients are in m, and
    /// directions lie in the plane.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// The lattice of cells; its box is the domain of the map. In two dimensions the cells are endless along z.
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
        let density = self.density.as_ref().map_or(0, |density| density.numbers.memory_bytes());
        self.fields.memory_bytes() + density + self.cells.memory_bytes()
    }
}
