//! What a run's folder and pictures hold, taken from the scene.

use crate::output::animation::AnimationSettings;
use crate::output::bodies::{BodyMesh, surface_of_map};
use crate::output::particles::ParticleFormat;
use crate::output::picture::{Bounds, Model, PictureSettings, Prop, World};
use crate::output::{BodyFrame, FolderSettings};
use crate::scene::{Picture, PreparedBody, Scene};
use std::sync::Arc;
use volmap_fluid::simulation::Simulation;
use volmap_formats::asset::Exterior;
use volmap_runtime::DVec3;

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
        statistics: settings.statistics,
        solver: scene.solver.clone(),
    }
}

/// The surface of each body as a mesh; none where a map has no surface.
pub fn body_meshes(bodies: &[PreparedBody]) -> Vec<Option<BodyMesh>> {
    let surface = |body: &PreparedBody| surface_of_map(&body.map).ok().map(Arc::new);
    let mesh = |body: &PreparedBody| {
        let mesh = body.surface.mesh.clone().or_else(|| surface(body))?;
        Some(BodyMesh { name: body.name.clone(), mesh })
    };
    bodies.iter().map(mesh).collect()
}

/// What a run begins with.
pub struct Beginning<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// At time 0.
    pub simulation: &'a Simulation,
    /// In the scene's order.
    pub bodies: &'a [PreparedBody],
}

/// Places may be wrong by this part of a particle's radius.
const FINE: f64 = 1e-3;

/// A point near all that is there at the start, which single precision has, if places in single precision would be
/// wrong by more than a thousandth of a particle's radius.
pub fn far_origin(beginning: &Beginning) -> Option<DVec3> {
    let &Beginning { scene, simulation, bodies } = beginning;
    let around = |[low, high]: [DVec3; 2], place: DVec3| [low.min(place), high.max(place)];
    let corners = |body: &PreparedBody| {
        let [low, high] = [body.map.grid().origin, body.map.grid().max_corner()];
        let pose = body.pose;
        (0..8).map(move |n| {
            let pick = |axis: usize| if n >> axis & 1 == 0 { low[axis] } else { high[axis] };
            pose.to_world(DVec3::new(pick(0), pick(1), pick(2)))
        })
    };
    let fluid = simulation.particles().positions.iter().copied();
    let jets = simulation.emitters().iter().flat_map(|emitter| emitter.places());
    let all = fluid.chain(jets).chain(bodies.iter().flat_map(corners));
    let [low, high] = all.fold([DVec3::INFINITY, DVec3::NEG_INFINITY], around);
    let error = 0.5 * f64::from(f32::EPSILON) * low.abs().max(high.abs()).max_element();
    (error > FINE * scene.particle_radius && error.is_finite())
        .then(|| (0.5 * (low + high)).as_vec3().as_dvec3())
}

/// What a run says of an origin.
pub fn origin_note(scene: &Scene, origin: DVec3) -> String {
    let formats = &scene.output.formats;
    let DVec3 { x, y, z } = origin;
    let mut parts = vec!["the scene lies far from the origin".to_owned()];
    if formats.contains(&ParticleFormat::Vtu) {
        parts.push(".vtu files have double precision".into());
    }
    let relative: Vec<String> = [ParticleFormat::Ply, ParticleFormat::Bgeo]
        .into_iter()
        .filter(|format| formats.contains(format))
        .map(|format| format!(".{}", format.extension()))
        .collect();
    if !relative.is_empty() {
        let relative = relative.join(" and ");
        parts.push(format!("places in {relative} files are relative to ({x}, {y}, {z}), their `origin`"));
    }
    parts.join("; ")
}

/// All that pictures show, at the start, relative to an origin.
pub fn picture_world(beginning: &Beginning, meshes: &[Option<BodyMesh>], origin: DVec3) -> World {
    let &Beginning { scene, simulation, bodies } = beginning;
    let mut bounds = Bounds::EMPTY;
    for &position in &simulation.particles().positions {
        bounds.add((position - origin).as_vec3());
    }
    for place in simulation.emitters().iter().flat_map(|emitter| emitter.places()) {
        bounds.add((place - origin).as_vec3());
    }
    let mut props = Vec::new();
    for (body, mesh) in bodies.iter().zip(meshes) {
        let Some(BodyMesh { mesh, .. }) = mesh else { continue };
        for &vertex in &mesh.vertices {
            bounds.add((body.pose.to_world(vertex.into()) - origin).as_vec3());
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
        origin,
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
