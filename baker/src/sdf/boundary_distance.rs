//! The signed distance that is baked: that to the mesh, inverted for containers, moved by the thickness.

use super::mesh_distance::{KnownDistance, MeshDistance};
use glam::DVec3;

/// A signed distance that can be sampled.
pub trait SignedDistance: Sync {
    /// Phi at a point, metres, negative inside the solid.
    fn at(&self, point: DVec3) -> f64 {
        self.near(point, &mut None)
    }

    /// Phi at a point. What is `known` of another point may make it faster, and becomes what is known of this one.
    fn near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64;

    /// True if what is known shows that a box (centre, half size) has a point with |Phi| <= width.
    fn reaches(&self, _known: &KnownDistance, _center: DVec3, _half: DVec3, _width: f64) -> bool {
        false
    }
}

impl<F: Fn(DVec3) -> f64 + Sync> SignedDistance for F {
    fn near(&self, point: DVec3, _: &mut Option<KnownDistance>) -> f64 {
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

impl SignedDistance for BoundaryDistance {
    fn near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64 {
        let found = match known {
            Some(near) => self.mesh.known_near(point, near),
            None => self.mesh.known(point),
        };
        *known = Some(found);
        let to_mesh = found.signed_distance;
        (if self.invert { -to_mesh } else { to_mesh }) - self.thickness
    }

    /// The point of the box that is closest to a point of the surface is no further from the surface than from that.
    fn reaches(&self, known: &KnownDistance, center: DVec3, half: DVec3, width: f64) -> bool {
        let outside = ((known.surface - center).abs() - half).max(DVec3::ZERO);
        self.thickness == 0.0 && outside.length() <= width
    }
}
