//! Volume, centre and inertia of primitives that are evenly filled, in closed form.

use super::{PlacedPrimitive, Primitive};
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// What the mass of an evenly filled solid follows from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// m^3.
    pub volume: f64,
    /// Centre of mass, metres.
    pub centre: DVec3,
    /// Inertia tensor about the centre for a density of 1, m^5.
    pub inertia: DMat3,
}

impl PlacedPrimitive {
    /// Its moments; none of a plane, whose mass has no end.
    pub fn moments(&self) -> Option<Moments> {
        let inertia = DMat3::from_diagonal(inertia(&self.shape)?);
        let turn = self.turn;
        Some(Moments {
            volume: self.shape.volume(),
            centre: self.centre,
            inertia: turn * inertia * turn.transpose(),
        })
    }
}

/// About x, y and z, for a density of 1.
fn inertia(shape: &Primitive) -> Option<DVec3> {
    let volume = shape.volume();
    Some(match *shape {
        Primitive::Box { size } => {
            let squares = DVec3::from(size) * DVec3::from(size);
            volume / 12.0 * (DVec3::splat(squares.element_sum()) - squares)
        }
        Primitive::Sphere { radius } => DVec3::splat(0.4 * volume * radius * radius),
        Primitive::Cylinder { radius, height } => of_cylinder(radius, height),
        Primitive::Capsule { radius, length } => {
            let ends = 4.0 / 3.0 * PI * radius.powi(3);
            let along = 0.4 * radius * radius;
            // The two halves of a sphere, each moved by half the length (Steiner; its centre of mass is 3/8 r from the
            // flat side).
            let across = along + 0.25 * length * length + 0.375 * length * radius;
            of_cylinder(radius, length) + ends * DVec3::new(across, along, across)
        }
        Primitive::Plane { .. } => return None,
    })
}

fn of_cylinder(radius: f64, height: f64) -> DVec3 {
    let volume = PI * radius * radius * height;
    let across = (3.0 * radius * radius + height * height) / 12.0;
    volume * DVec3::new(across, 0.5 * radius * radius, across)
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_formats::mesh::{Placement, Rotation};

    /// Against the midpoints of small cubes.
    #[test]
    fn moments_are_those_of_many_small_cubes() {
        let turned = Placement {
            rotation: Rotation { axis: [1.0, 2.0, -1.0], degrees: 40.0 },
            translation: [0.3, -0.2, 5.0],
            scale: [0.5; 3],
            ..Placement::default()
        };
        for text in ["box:1,2,0.6", "sphere:0.9", "cylinder:0.5,1.6", "capsule:0.4,1.1"] {
            let placed = PlacedPrimitive::new(text.parse().unwrap(), &turned).unwrap();
            let found = placed.moments().unwrap();
            let ([low, high], cells) = (placed.bounds(), 100);
            let edge = (high - low) / f64::from(cells);
            let (mut volume, mut first, mut second) = (0.0, DVec3::ZERO, DMat3::ZERO);
            for n in 0..cells * cells * cells {
                let at = [n % cells, n / cells % cells, n / cells / cells].map(|n| f64::from(n) + 0.5);
                let x = low + edge * DVec3::from(at);
                if placed.distance(x) < 0.0 {
                    let from = x - found.centre;
                    volume += 1.0;
                    first += from;
                    let outer = DMat3::from_cols(from * from.x, from * from.y, from * from.z);
                    second += DMat3::from_diagonal(DVec3::splat(from.length_squared())) - outer;
                }
            }
            let cube = edge.element_product();
            assert!((volume * cube / found.volume - 1.0).abs() < 5e-3, "{text}: {volume}");
            assert!((first / volume).length() < 2e-3, "{text}");
            let error = (second * cube - found.inertia).to_cols_array();
            let size = found.inertia.to_cols_array().iter().fold(0.0f64, |a, b| a.max(b.abs()));
            assert!(error.iter().all(|e| e.abs() < 1e-2 * size), "{text}: {error:?} of {size}");
        }
    }
}
