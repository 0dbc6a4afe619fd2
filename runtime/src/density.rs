//! Boundary density at a point: Koschier and Bender 2017; Bender et al. 2020, section 4.2.
//!
//! The map holds rho_B / rho0 of Eq. 9 at its nodes, for one SPH kernel. As in the papers, the gradient is that of the
//! interpolated density, by the derivatives of the element's shape functions: it jumps between cells.

use crate::batch::answer_all;
use crate::fields::Numbers;
use crate::pose::PosedMap;
use crate::query::VolumeMap;
use glam::DVec3;

/// Boundary density as a particle sees it; the caller multiplies by its rest density rho0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Density {
    /// rho_B / rho0 (Eq. 9), without unit. About 1 at the surface of a flat wall, and more in the solid.
    pub value: f64,
    /// Its gradient, 1/m, towards the solid.
    pub gradient: DVec3,
}

/// The density of a map.
#[derive(Clone, Debug)]
pub(crate) struct DensityNodes {
    pub kernel: String,
    pub numbers: Numbers,
}

impl VolumeMap {
    /// Name of the SPH kernel whose density the map holds; `None` if it holds none.
    pub fn density_kernel(&self) -> Option<&str> {
        self.density.as_ref().map(|density| density.kernel.as_str())
    }

    /// Boundary density and its gradient at a point (metres, in the map's frame); both 0 outside the band. `None` if the
    /// map holds no density, and deep inside the solid, where it isn't known.
    pub fn density(&self, point: DVec3) -> Option<Density> {
        let mut out = None;
        answer_all(self, &[point], std::slice::from_mut(&mut out));
        out
    }

    /// [`VolumeMap::density`] of every point, into `densities`, whose old content is dropped.
    pub fn density_batch(&self, points: &[DVec3], densities: &mut Vec<Option<Density>>) {
        densities.resize(points.len(), None);
        answer_all(self, points, densities);
    }
}

impl PosedMap {
    /// [`VolumeMap::density`] of a point of the world, its gradient in the world.
    pub fn density(&self, point: DVec3) -> Option<Density> {
        self.density_in_world(self.map.density(self.pose.to_map(point)))
    }

    /// [`VolumeMap::density_batch`] of points of the world.
    pub fn density_batch(&self, points: &[DVec3], densities: &mut Vec<Option<Density>>) {
        densities.resize(points.len(), None);
        self.in_blocks(points, densities);
        for density in densities {
            *density = self.density_in_world(*density);
        }
    }

    fn density_in_world(&self, density: Option<Density>) -> Option<Density> {
        density.map(|d| Density { gradient: self.pose.rotation * d.gradient, ..d })
    }
}
