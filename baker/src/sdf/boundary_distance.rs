//! The signed distance that is baked: that to the mesh, inverted for containers, moved by the thickness.

use super::mesh_distance::{KnownDistance, MeshDistance};
use glam::DVec3;

/// A signed distance that can be sampled: at any point, or faster along a row of points.
pub trait SignedDistance: Sync {
    /// Phi at a point, metres, negative inside the solid.
    fn at(&self, point: DVec3) -> f64;

    /// Phi at points that follow each other closely.
    fn along(&self, points: impl Iterator<Item = DVec3>, out: &mut [f64]) {
        out.iter_mut().zip(points).for_each(|(value, point)| *value = self.at(point));
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> SignedDistance for F {
    fn at(&self, point: DVec3) -> f64 {
        self(point)
    }
}

/// Distance to the boundary that the fluid sees.
#[derive(Clone, Debug)]
pub struct BoundaryDistance {
    /// Distance to the mesh.
    pub mesh: MeshDistance,
    /// Solid and fluid change places.
    pub invert: bool,
    /// The surface moves outwards from the solid by this, metres.
    pub thickness: f64,
}

impl BoundaryDistance {
    fn boundary(&self, to_mesh: f64) -> f64 {
        (if self.invert { -to_mesh } else { to_mesh }) - self.thickness
    }
}

impl SignedDistance for BoundaryDistance {
    fn at(&self, point: DVec3) -> f64 {
        self.boundary(self.mesh.signed_distance(point))
    }

    fn along(&self, points: impl Iterator<Item = DVec3>, out: &mut [f64]) {
        let mut known: Option<KnownDistance> = None;
        for (value, point) in out.iter_mut().zip(points) {
            let signed_distance = match &known {
                Some(known) => self.mesh.signed_distance_near(point, known),
                None => self.mesh.signed_distance(point),
            };
            known = Some(KnownDistance { point, signed_distance });
            *value = self.boundary(signed_distance);
        }
    }
}
