//! Relaxed sources: their particles are spread and settle before time 0, by the scene's own method among its bodies.

use crate::error::Error;
use crate::scene::walls::Relaxed;
use crate::scene::{PreparedBody, Scene};
use std::ops::Range;
use std::sync::Arc;
use volmap_bake::watch::Watch;
use volmap_fluid::bodies::{BodyDescription, ContactMaterial, FluidContact, Motion};
use volmap_fluid::compression::COMPRESSED;
use volmap_fluid::packing::{Packed, Packing, settle, spread};
use volmap_fluid::simulation::Simulation;
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::{number, percent, thousands};
use volmap_runtime::{DVec3, Pose, VolumeMap};

/// Spreads the particles of the relaxed sources of a simulation at time 0, each between its walls and the bodies, and
/// lets them settle together. What the user should know of it.
///
/// # Errors
/// As [`spread`].
pub fn pack(
    simulation: &mut Simulation,
    scene: &Scene,
    bodies: &[PreparedBody],
    relaxed: &[Relaxed],
    watch: &Watch,
) -> Result<Vec<String>, Error> {
    let world = scene.world();
    let packing = Packing { world: &world, fluid: &scene.fluid, solver: &scene.solver, watch };
    let held = |body: &PreparedBody| still(&body.name, &body.map, &body.surface.mesh, body.pose);
    let held: Vec<BodyDescription> = bodies.iter().map(held).collect();
    let mut notes = Vec::new();
    let mut parts = Vec::new();
    for source in relaxed {
        let mut all = held.clone();
        all.extend(source.walls.iter().map(|wall| still("wall", &wall.map, &wall.mesh, wall.pose)));
        let found = spread(packing, all, &positions(simulation, &source.particles))?;
        notes.extend(too_dense(source, &found));
        parts.push(found);
    }
    if world.gravity != DVec3::ZERO && !relaxed.is_empty() {
        let all: Vec<DVec3> = parts.iter().flat_map(|part| part.positions.iter().copied()).collect();
        share(settle(packing, held, &all)?, &mut parts);
    }
    for (source, part) in relaxed.iter().zip(&parts) {
        let Range { start, end } = source.particles;
        simulation.take(start as u32..end as u32, part);
    }
    Ok(notes)
}

/// Gives each source its part of what has settled. Those that were lost there stay where they were.
fn share(settled: Packed, parts: &mut [Packed]) {
    let places = parts.iter_mut().flat_map(|part| part.positions.iter_mut().zip(&mut part.pressures));
    let mut places: Vec<(&mut DVec3, &mut f32)> = places.collect();
    for ((n, position), pressure) in settled.kept.iter().zip(settled.positions).zip(settled.pressures) {
        let (place, value) = &mut places[*n as usize];
        (**place, **value) = (position, pressure);
    }
}

fn positions(simulation: &Simulation, range: &Range<usize>) -> Vec<DVec3> {
    simulation.particles().positions[range.clone()].to_vec()
}

fn too_dense(source: &Relaxed, packed: &Packed) -> Option<String> {
    let found = &packed.compression;
    (found.largest > COMPRESSED).then(|| {
        format!(
            "{}: its particles are not at rest after {} steps: up to {} denser than at rest, at ({}) m; look for \
             bodies that overlap there, or for gaps narrower than a particle",
            source.key,
            thousands(packed.steps.into()),
            percent(found.largest),
            found.place.to_array().map(number).join(", ")
        )
    })
}

/// What stands still, of a surface that is known by a mesh, a map or both.
fn still(name: &str, map: &Arc<VolumeMap>, mesh: &Option<Arc<TriangleMesh>>, pose: Pose) -> BodyDescription {
    BodyDescription {
        name: name.into(),
        map: map.clone(),
        mesh: mesh.clone(),
        pose,
        motion: Motion::Static,
        material: ContactMaterial::default(),
        fluid_contact: FluidContact::default(),
    }
}
