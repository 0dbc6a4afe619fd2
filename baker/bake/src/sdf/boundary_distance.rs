//! The signed distance that is baked: that to the mesh, inverted for containers, moved by the thickness.

use super::mesh_distance::{KnownDistance, MeshDistance, Neighbours};
use crate::primitive::PlacedPrimitive;
use glam::DVec3;

/// A signed distance that can be sampled.
pub trait SignedDistance: Sync {
    /// Phi at a point, metres, negative inside the solid.
    fn at(&self, point: DVec3) -> f64 {
        self.near(point, &mut None)
    }

    /// Phi at a point. What is `known` of another point may make it faster, and becomes what is known of this one.
    fn near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64;

    /// Whether signs can be followed from point to point, so that the nodes of a band need few of them.
    fn has_separate_signs(&self) -> bool {
        false
    }

    /// |Phi| at a point, alike, without its sign where that saves work.
    fn size_near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64 {
        self.near(point, known).abs()
    }

    /// The boundary of a mesh, if this is one.
    fn of_mesh(&self) -> Option<&BoundaryDistance> {
        None
    }

    /// Makes known of up to [`Neighbours::MAX`] points, close to each other, what can be found out faster together than
    /// when each is asked; the signs too if they will be.
    fn prepare(&self, _points: &[DVec3], _known: &mut Neighbours, _signed: bool) {}

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

/// Any signed distance, inverted and moved as a mesh's is.
#[derive(Clone, Copy, Debug)]
pub struct ChangedDistance<'a, D> {
    /// The distance.
    pub phi: &'a D,
    /// Solid and fluid change places.
    pub invert: bool,
    /// The surface moves outwards from the solid by this, metres.
    pub thickness: f64,
}

impl<D: SignedDistance> SignedDistance for ChangedDistance<'_, D> {
    fn near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64 {
        let phi = self.phi.near(point, known);
        (if self.invert { -phi } else { phi }) - self.thickness
    }

    fn prepare(&self, points: &[DVec3], known: &mut Neighbours, _signed: bool) {
        self.phi.prepare(points, known, true);
    }
}

/// Distance to the boundary that the fluid sees.
#[derive(Clone, Debug)]
pub struct BoundaryDistance {
    /// Distance to the mesh.
    pub mesh: MeshDistance,
    /// The shape that the mesh stands for, whose distance counts then.
    pub shape: Option<PlacedPrimitive>,
    /// Solid and fluid change places.
    pub invert: bool,
    /// The surface moves outwards from the solid by this, metres.
    pub thickness: f64,
}

impl SignedDistance for BoundaryDistance {
    fn near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64 {
        let distance = match &self.shape {
            Some(shape) => shape.distance(point),
            None => {
                let mut found = self.mesh.distance_near(point, known.as_ref());
                let to_mesh = self.mesh.side(&mut found) * found.distance;
                *known = Some(found);
                to_mesh
            }
        };
        (if self.invert { -distance } else { distance }) - self.thickness
    }

    fn of_mesh(&self) -> Option<&BoundaryDistance> {
        Some(self)
    }

    fn has_separate_signs(&self) -> bool {
        self.thickness == 0.0 && self.shape.is_none() && self.mesh.has_integer_winding()
    }

    fn size_near(&self, point: DVec3, known: &mut Option<KnownDistance>) -> f64 {
        if self.thickness != 0.0 || self.shape.is_some() {
            return self.near(point, known).abs();
        }
        let found = self.mesh.distance_near(point, known.as_ref());
        *known = Some(found);
        found.distance
    }

    fn prepare(&self, points: &[DVec3], known: &mut Neighbours, signed: bool) {
        if self.shape.is_some() {
            return;
        }
        self.mesh.distances_near(points, known);
        if signed {
            self.mesh.sides_near(points.len(), known);
        }
    }

    /// The point of the box that is closest to a point of the surface is no further from the surface than from that.
    fn reaches(&self, known: &KnownDistance, center: DVec3, half: DVec3, width: f64) -> bool {
        let outside = ((known.surface - center).abs() - half).max(DVec3::ZERO);
        self.thickness == 0.0 && outside.length() <= width
    }
}
