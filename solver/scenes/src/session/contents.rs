//! What a run's folder and pictures hold, taken from the scene.

use crate::output::animation::AnimationSettings;
use crate::output::bodies::{BodyMesh, surface_of_map};
use crate::output::picture::{Bounds, Model, PictureSettings, Prop, World};
use crate::output::{BodyFrame, FolderSettings};
use crate::scene::{Picture, Prepared, PreparedBody, Scene};
use std::sync::Arc;
use volmap_fluid::simulation::Simulation;
use volmap_formats::asset::Exterior;

/// What is written, as the scene's `[output]` says.
pub fn folder_settings(scene: &Scene) -> FolderSettings {
    let settings = &scene.output;
    let frames_per_second = settings.frames_per_second.round().clamp(1.0, 1000.0) as u16;
    FolderSettings {
        particles: settings.formats.clone(),
        pictures: !settings.preview.is_empty(),
        picture: PictureSettings { camera: settings.camera.clone(), ..Default::default() },
        animate: settings.preview.contains(&Picture::Apng),
        animation: AnimationSettings { frames_per_second, ..Default::default() },
        solver: scene.solver.clone(),
    }
}

/// The mesh of each body, as it was given or the surface of its map; none where the map has no surface.
pub fn body_meshes(bodies: &[PreparedBody]) -> Vec<Option<BodyMesh>> {
    let surface = |body: &PreparedBody| surface_of_map(&body.map).ok().map(Arc::new);
    let mesh = |body: &PreparedBody| {
        let mesh = body.mesh.clone().or_else(|| surface(body))?;
        Some(BodyMesh { name: body.name.clone(), mesh })
    };
    bodies.iter().map(mesh).collect()
}

/// All that pictures show, at the start.
pub fn picture_world(scene: &Scene, prepared: &Prepared, meshes: &[Option<BodyMesh>]) -> World {
    let mut bounds = Bounds::EMPTY;
    for &position in &prepared.particles.positions {
        bounds.add(position.as_vec3());
    }
    for place in prepared.emitters.iter().flat_map(|emitter| emitter.places()) {
        bounds.add(place.as_vec3());
    }
    let mut props = Vec::new();
    for (body, mesh) in prepared.bodies.iter().zip(meshes) {
        let Some(BodyMesh { mesh, .. }) = mesh else { continue };
        for &vertex in &mesh.vertices {
            bounds.add(body.pose.to_world(vertex.into()).as_vec3());
        }
        props.push(Prop {
            name: body.name.clone(),
            model: Model::new(mesh),
            pose: body.pose,
            container: body.map.exterior() == Exterior::Solid,
            colour: body.settings.colour.map(|colour| colour.map(|channel| (channel * 255.0).round() as u8)),
        });
    }
    World {
        bounds: bounds.or_unit(),
        gravity: scene.world().gravity.as_vec3(),
        rest_density: scene.fluid.rest_density,
        props,
    }
}

/// Poses and velocities of the bodies, in the scene's order.
pub fn body_frames(simulation: &Simulation) -> Vec<BodyFrame<'_>> {
    let bodies = simulation.bodies();
    let frame = |body: usize| {
        let state = bodies.state(body);
        BodyFrame {
            name: bodies.name(body),
            pose: state.pose,
            velocity: state.velocity,
            angular_velocity: state.angular_velocity,
        }
    };
    (0..bodies.posed().len()).map(frame).collect()
}
