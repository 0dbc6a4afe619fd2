//! What a body is: its map, its mesh, where it starts and how it moves.

use super::mass::Mass;
use super::path::Path;
use std::sync::Arc;
use volmap_formats::asset::Exterior;
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::number;
use volmap_runtime::{DVec3, Pose, VolumeMap};

/// One body. Many may share a map and a mesh.
#[derive(Clone, Debug)]
pub struct BodyDescription {
    /// Its name in messages and in the output.
    pub name: String,
    /// What the fluid sees.
    pub map: Arc<VolumeMap>,
    /// A mesh of the map's surface, if there is one, in the map's frame, counter-clockwise from outside; of an
    /// inverted map that of the solid before the inversion. It encloses the mass, and other bodies touch it.
    /// Without one, as where a map's surface was moved by a thickness, the map's own surface does both.
    pub mesh: Option<Arc<TriangleMesh>>,
    /// Where it starts.
    pub pose: Pose,
    /// How it moves.
    pub motion: Motion,
    /// How it feels to other bodies.
    pub material: ContactMaterial,
    /// How it feels to the fluid.
    pub fluid_contact: FluidContact,
}

/// How a body moves.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// Not at all.
    Static,
    /// As prescribed, whatever it meets.
    Prescribed(Path),
    /// By forces.
    Free(FreeBody),
}

/// What a body moved by forces starts with.
#[derive(Clone, Debug, PartialEq)]
pub struct FreeBody {
    /// How heavy it is; the solid fills it evenly.
    pub weight: Weight,
    /// Velocity of the centre of mass, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s, in the world.
    pub angular_velocity: DVec3,
    /// Axes of the world along which the centre of mass can't move: `velocity` must be 0 there.
    pub locked_translation: [bool; 3],
    /// Axes of the world around which it can't turn: `angular_velocity` must be 0 there.
    pub locked_rotation: [bool; 3],
}

/// How heavy a body is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weight {
    /// kg/m^3.
    Density(f64),
    /// kg.
    Mass(f64),
    /// Mass, centre and inertia, which don't follow from the mesh then.
    Known(Mass),
}

/// Contact with other bodies; of two, the mean counts. The fluid has its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMaterial {
    /// Coulomb's coefficient of friction.
    pub friction: f64,
    /// Part of the normal velocity that a bounce gives back, 0 to 1.
    pub restitution: f64,
}

/// Drag of a body's surface on the fluid: Bender et al. 2020, section 4.4. Both are kinematic, mu_B / rho_0, in
/// m^2/s, as the fluid's viscosity; they add up, and by default are 0: the fluid slips.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FluidContact {
    /// Sticking: viscosity between body and fluid (Eq. 16 and 17).
    pub viscosity: f64,
    /// Tangential friction (Eq. 18 and 19).
    pub friction: f64,
}

impl Default for FreeBody {
    fn default() -> Self {
        FreeBody {
            weight: Weight::Density(1000.0),
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            locked_translation: [false; 3],
            locked_rotation: [false; 3],
        }
    }
}

impl Default for ContactMaterial {
    fn default() -> Self {
        ContactMaterial { friction: 0.5, restitution: 0.0 }
    }
}

impl BodyDescription {
    /// The pose with a rotation of length 1, if all numbers can be used.
    pub(super) fn checked_start(&self) -> Result<Pose, String> {
        let Pose { rotation, translation } = self.pose;
        let length = rotation.length();
        if !(translation.is_finite() && length.is_finite() && length > 1e-6) {
            return Err("its pose is not finite".into());
        }
        let ContactMaterial { friction, restitution } = self.material;
        if !(friction >= 0.0 && friction.is_finite()) {
            return Err(format!("a friction of {friction}: take 0 or more"));
        }
        if !(0.0..=1.0).contains(&restitution) {
            return Err(format!("a restitution of {restitution}: take 0 to 1"));
        }
        let FluidContact { viscosity, friction } = self.fluid_contact;
        if ![viscosity, friction].iter().all(|x| *x >= 0.0 && x.is_finite()) {
            return Err(format!(
                "a viscosity of {viscosity} and a friction of {friction} between it and the fluid: take 0 or more"
            ));
        }
        let defect = match &self.motion {
            Motion::Static => None,
            Motion::Prescribed(path) => path.defect(),
            Motion::Free(free) => free.defect(self.map.exterior()),
        };
        defect.map_or(Ok(Pose { rotation: rotation / length, translation }), Err)
    }

    /// Mass and inertia of a free body: of what its surface encloses.
    pub(super) fn mass(&self) -> Result<Option<Mass>, String> {
        let Motion::Free(free) = &self.motion else { return Ok(None) };
        let of_solid = |density: f64| {
            let of_mesh = self.mesh.as_ref().and_then(|mesh| Mass::of_mesh(mesh, density));
            of_mesh.unwrap_or_else(|| Mass::of_map(&self.map, density))
        };
        let mass = match free.weight {
            Weight::Density(density) => of_solid(density),
            Weight::Mass(mass) => of_solid(1.0).with_mass(mass),
            Weight::Known(mass) => mass,
        };
        match mass.is_usable() {
            true => Ok(Some(mass)),
            false => Err(format!(
                "its mass of {} kg, from a volume of {} m^3, can't be moved",
                number(mass.mass),
                number(mass.volume)
            )),
        }
    }
}

impl FreeBody {
    fn defect(&self, exterior: Exterior) -> Option<String> {
        let (Weight::Density(weight) | Weight::Mass(weight) | Weight::Known(Mass { mass: weight, .. })) =
            self.weight;
        if exterior == Exterior::Solid {
            return Some("its map is inverted, a container without an outside; it can't move freely".into());
        }
        if !(weight > 0.0 && weight.is_finite()) {
            return Some(format!("a mass or density of {weight}: take more than 0"));
        }
        if !(self.velocity.is_finite() && self.angular_velocity.is_finite()) {
            return Some("its velocity is not finite".into());
        }
        let moves = |velocity: DVec3, locked: [bool; 3]| {
            (0..3).find(|&axis| locked[axis] && velocity[axis] != 0.0).map(|axis| ["x", "y", "z"][axis])
        };
        let along = moves(self.velocity, self.locked_translation)
            .map(|axis| format!("it has a velocity along {axis}, but its translation is locked there"));
        let about = moves(self.angular_velocity, self.locked_rotation)
            .map(|axis| format!("it has an angular velocity about {axis}, but its rotation is locked there"));
        along.or(about).map(|defect| defect + "; take 0, or unlock the axis")
    }
}
