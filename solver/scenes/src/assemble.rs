//! From a prepared scene to the setup of a simulation.

use crate::error::Error;
use crate::scene::{FreeMotion, Keyframe, Motion, Prepared, PreparedBody, Scene, Spin};
use std::f64::consts::PI;
use volmap_fluid::bodies::{self, Bodies, BodyDescription, FreeBody, Interpolation, Key, Keys, Path, Weight};
use volmap_fluid::particles::Particles;
use volmap_fluid::simulation::Setup;
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
    Ok(Setup {
        world: scene.world(),
        fluid: scene.fluid.clone(),
        solver: scene.solver.clone(),
        particles,
        emitters: prepared.emitters,
        bodies: Bodies::new(descriptions, scene.gravity.into())?,
        domain: scene.domain.map(|domain| [domain.min.into(), domain.max.into()]),
    })
}

fn description(body: &PreparedBody) -> BodyDescription {
    let material = &body.settings.material;
    // Keyframes are poses in the world.
    let keyed = matches!(body.settings.motion, Motion::Keyframes(_));
    BodyDescription {
        name: body.name.clone(),
        map: body.map.clone(),
        mesh: body.mesh.clone(),
        pose: if keyed { Pose::default() } else { body.pose },
        motion: motion(&body.settings.motion, body.pose),
        material: bodies::ContactMaterial { friction: material.friction, restitution: material.restitution },
        fluid_contact: bodies::FluidContact {
            viscosity: material.fluid_viscosity,
            friction: material.fluid_friction,
        },
    }
}

fn motion(motion: &Motion, pose: Pose) -> bodies::Motion {
    match motion {
        Motion::Static => bodies::Motion::Static,
        Motion::Keyframes(frames) => bodies::Motion::Prescribed(Path::Keys(Keys {
            keys: frames.iter().map(key).collect(),
            interpolation: Interpolation::Linear,
            repeat: false,
        })),
        Motion::Spin(spin) => bodies::Motion::Prescribed(Path::Spin(rotation(spin, pose))),
        Motion::Free(free) => bodies::Motion::Free(free_body(free)),
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

fn free_body(free: &FreeMotion) -> FreeBody {
    FreeBody {
        weight: match (free.mass, free.density) {
            (Some(mass), _) => Weight::Mass(mass),
            (None, density) => Weight::Density(density.unwrap_or(1000.0)),
        },
        velocity: free.velocity.into(),
        angular_velocity: free.angular_velocity.into(),
        locked_translation: free.fixed_translation,
        locked_rotation: free.fixed_rotation,
    }
}
