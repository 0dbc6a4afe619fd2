//! From a prepared scene to the setup of a simulation.

use crate::error::Error;
use crate::scene::{FreeMotion, Keyframe, Motion, Prepared, PreparedBody, Scene, Spin};
use std::f64::consts::PI;
use volmap_bake::primitive::PlacedPrimitive;
use volmap_fluid::bodies::{
    self, Bodies, BodyDescription, FreeBody, Interpolation, Key, Keys, Mass, Path, Weight,
};
use volmap_fluid::particles::Particles;
use volmap_fluid::setup::Setup;
use volmap_runtime::{DVec3, Pose};

/// The setup of a scene's simulation.
///
/// # Errors
/// As [`Bodies::new`].
pub fn assemble(scene: &Scene, prepared: Prepared) -> Result<Setup, Error> {
    let descriptions = prepared.bodies.iter().map(description).collect();
    let velocity = |v: &DVec3| v.as_vec3().to_array();
    let velocities: Vec<[f32; 3]> = prepared.particles.velocities.iter().map(velocity).collect();
    let mut particles = Particles::default();
    particles.add(&prepared.particles.positions, &velocities);
    let bodies = Bodies::new(descriptions, scene.gravity.into())?;
    Ok(Setup {
        fluid: scene.fluid.clone(),
        solver: scene.solver.clone(),
        forces: scene.forces.clone(),
        emitters: prepared.emitters,
        domain: scene.domain.map(|domain| domain.corners()),
        ..Setup::new(scene.world(), particles, bodies)
    })
}

fn description(body: &PreparedBody) -> BodyDescription {
    let material = &body.settings.material;
    // Keyframes are poses in the world.
    let keyed = matches!(body.settings.motion, Motion::Keyframes(_));
    BodyDescription {
        name: body.name.clone(),
        map: body.map.clone(),
        mesh: body.surface.mesh.clone(),
        pose: if keyed { Pose::default() } else { body.pose },
        motion: motion(body),
        material: bodies::ContactMaterial { friction: material.friction, restitution: material.restitution },
        fluid_contact: bodies::FluidContact {
            viscosity: material.fluid_viscosity,
            friction: material.fluid_friction,
        },
    }
}

fn motion(body: &PreparedBody) -> bodies::Motion {
    match &body.settings.motion {
        Motion::Static => bodies::Motion::Static,
        Motion::Keyframes(frames) => bodies::Motion::Prescribed(Path::Keys(Keys {
            keys: frames.iter().map(key).collect(),
            interpolation: Interpolation::Linear,
            repeat: false,
        })),
        Motion::Spin(spin) => bodies::Motion::Prescribed(Path::Spin(rotation(spin, body.pose))),
        Motion::Free(free) => bodies::Motion::Free(free_body(free, body.surface.primitive.as_ref())),
    }
}

fn key(frame: &Keyframe) -> Key {
    Key { time: frame.time, translation: frame.translation.into(), rotation: frame.rotation.to_quat() }
}

fn rotation(spin: &Spin, pose: Pose) -> bodies::Spin {
    bodies::Spin {
        axis: DVec3::from(spin.axis).normalize_or(DVec3::Y),
        centre: spin.centre.map_or(pose.translation, DVec3::from),
        speed: spin.rpm * 2.0 * PI / 60.0,
    }
}

/// Of a shape, mass and inertia are closed forms.
fn free_body(free: &FreeMotion, shape: Option<&PlacedPrimitive>) -> FreeBody {
    let density = free.density.unwrap_or(1000.0);
    let exact = shape.and_then(|shape| Mass::of_shape(shape, density));
    FreeBody {
        weight: match (exact, free.mass) {
            (Some(exact), Some(mass)) => Weight::Known(exact.with_mass(mass)),
            (Some(exact), None) => Weight::Known(exact),
            (None, Some(mass)) => Weight::Mass(mass),
            (None, None) => Weight::Density(density),
        },
        velocity: free.velocity.into(),
        angular_velocity: free.angular_velocity.into(),
        locked_translation: free.fixed_translation,
        locked_rotation: free.fixed_rotation,
    }
}
