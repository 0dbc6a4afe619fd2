//! From a scene to what a simulation starts with: maps, particles, emitters.

use super::Scene;
use super::body::{self, Body, Source};
use super::map::{Library, Origin, Shape, default_cache};
use super::nozzle;
use super::overlap::{BODY_MARGIN, drop_in_bodies};
use super::sources::{self, PlacedParticles, Solid, SourceCount};
use crate::error::Error;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use volmap_bake::mesh::diagnose;
use volmap_bake::sdf::{MeshDistance, SignMethod};
use volmap_bake::watch::Watch;
use volmap_fluid::boundary::particles;
use volmap_fluid::emitter::Emitter;
use volmap_fluid::settings::BoundaryMethod;
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::percent;
use volmap_runtime::{Pose, PosedMap, VolumeMap};

/// What a simulation starts with.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Bodies in the scene's order.
    pub bodies: Vec<PreparedBody>,
    /// The fluid at the start.
    pub particles: PlacedParticles,
    /// Emitters in the scene's order.
    pub emitters: Vec<Emitter>,
    /// Files of the bodies, then of the fills, in the scene's order.
    pub files: Vec<SourceFile>,
    /// What the user should look at.
    pub notes: Vec<String>,
}

/// A file that the scene names, as it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SourceFile {
    /// Where it is.
    pub path: PathBuf,
    /// BLAKE3 of its content: see [`Shape::content`].
    pub content: [u8; 32],
}

/// A body with its map.
#[derive(Clone, Debug)]
pub struct PreparedBody {
    /// Name, unique.
    pub name: String,
    /// Its map, shared with bodies of the same shape.
    pub map: Arc<VolumeMap>,
    /// Its mesh in the map's frame, if it was baked from one.
    pub mesh: Option<Arc<TriangleMesh>>,
    /// Particles on its surface, with particle boundaries.
    pub boundary_particles: Option<u64>,
    /// Where the map comes from.
    pub origin: Origin,
    /// Where it is at the start.
    pub pose: Pose,
    /// The body in the scene: motion, material, colour.
    pub settings: Body,
}

impl PreparedBody {
    /// Its map where it is at the start.
    pub fn posed(&self) -> PosedMap {
        PosedMap { map: self.map.clone(), pose: self.pose }
    }
}

/// Checks a scene, opens or bakes its maps, places its particles. `on_bake` is called with each mesh before it is
/// baked.
///
/// # Errors
/// A value that can't be used, a file that is missing or damaged, a map of another support radius, no fluid;
/// [`Error::Cancelled`] if a bake was stopped.
pub fn prepare(scene: &Scene, watch: &Watch, on_bake: &mut dyn FnMut(&Path)) -> Result<Prepared, Error> {
    scene.validate()?;
    let cache = scene.cache.clone().unwrap_or_else(default_cache);
    let mut library = Library::new(&scene.world(), cache, watch, on_bake);
    let mut files = Vec::new();
    let bodies = prepare_bodies(scene, &mut library, &mut files)?;
    let solids = prepare_solids(scene, &mut library, &mut files)?;
    let mut notes = scene.all_notes();
    notes.extend(library.notes);
    let posed: Vec<PosedMap> = bodies.iter().map(PreparedBody::posed).collect();
    let particles = sources::fill(scene, &solids, &posed)?;
    let emitter = |settings| nozzle::emitter(settings, scene.rest_spacing());
    let emitters: Vec<Emitter> = scene.emitters.iter().map(emitter).collect();
    check_not_empty(scene, &particles)?;
    notes.extend(particles.counts.iter().filter_map(left_out));
    notes.extend(emitters.iter().enumerate().filter_map(|(i, emitter)| blocked(i, emitter, &posed, scene)));
    Ok(Prepared { bodies, particles, emitters, files, notes })
}

fn prepare_bodies(
    scene: &Scene,
    library: &mut Library,
    files: &mut Vec<SourceFile>,
) -> Result<Vec<PreparedBody>, Error> {
    let mut bodies = Vec::new();
    for (i, (settings, name)) in scene.bodies.iter().zip(body::names(&scene.bodies)).enumerate() {
        let key = format!("bodies[{i}]");
        let baked = library.with_cells(settings);
        let source = given(baked.source(), &key)?;
        let Shape { map, mesh, origin, content } = library.obtain_for_body(source, &key)?;
        files.push(SourceFile { path: source.path().to_owned(), content });
        bodies.push(PreparedBody {
            boundary_particles: count_particles(scene, mesh.as_deref(), &key)?,
            name,
            map,
            mesh,
            origin,
            pose: settings.pose(),
            settings: settings.clone(),
        });
    }
    Ok(bodies)
}

/// The solids of the fills.
fn prepare_solids(
    scene: &Scene,
    library: &mut Library,
    files: &mut Vec<SourceFile>,
) -> Result<Vec<Solid>, Error> {
    let mut solids = Vec::new();
    for (i, fill) in scene.fills.iter().enumerate() {
        let key = format!("fills[{i}]");
        let source = given(fill.source(), &key)?;
        let Shape { map, mesh, content, .. } = library.obtain(source, &key)?;
        files.push(SourceFile { path: source.path().to_owned(), content });
        let mesh = mesh.map(|mesh| MeshDistance::new(&mesh, SignMethod::Auto, &diagnose(&mesh)));
        let map = PosedMap { map, pose: fill.pose() };
        solids.push(Solid { map, mesh, thickness: fill.bake.thickness.unwrap_or(0.0) });
    }
    Ok(solids)
}

/// How many boundary particles a body gets; none with maps.
fn count_particles(scene: &Scene, mesh: Option<&TriangleMesh>, key: &str) -> Result<Option<u64>, Error> {
    let (BoundaryMethod::Particles, Some(mesh)) = (scene.boundary, mesh) else { return Ok(None) };
    match particles::defect(mesh, scene.particle_radius) {
        Some(reason) => Err(Error::Scene { place: format!("{key}.mesh"), reason }),
        None => Ok(Some(particles::count(mesh, scene.particle_radius))),
    }
}

fn given<'a>(source: Option<Source<'a>>, key: &str) -> Result<Source<'a>, Error> {
    let reason = "give `map` or `mesh`";
    source.ok_or_else(|| Error::Scene { place: key.to_owned(), reason: reason.into() })
}

fn check_not_empty(scene: &Scene, particles: &PlacedParticles) -> Result<(), Error> {
    if !particles.positions.is_empty() || !scene.emitters.is_empty() {
        return Ok(());
    }
    let left_out: u64 = particles.counts.iter().map(|count| count.in_bodies + count.outside).sum();
    let (place, reason) = match left_out {
        0 if particles.counts.is_empty() => {
            ("blocks", "there is no fluid: add [[blocks]], [[fills]] or [[emitters]]".to_owned())
        }
        0 => (
            "fills",
            "no particle fits into any of them, so there is no fluid; check scale and particle_radius"
                .to_owned(),
        ),
        lost => (
            "blocks",
            format!(
                "all {lost} particles lie in a body or outside the domain, so there is no fluid; move them, or set \
                 bake.invert = true for a body that is a container"
            ),
        ),
    };
    Err(Error::Scene { place: place.into(), reason })
}

fn left_out(count: &SourceCount) -> Option<String> {
    let reasons = [
        (count.in_bodies, "in a body, or closer to it than a fifth of a particle radius"),
        (count.duplicates, "on top of particles of an earlier source"),
        (count.outside, "outside the domain"),
    ];
    let parts: Vec<String> =
        reasons.iter().filter(|(n, _)| *n > 0).map(|(n, reason)| format!("{n} {reason}")).collect();
    (!parts.is_empty()).then(|| format!("{}: particles left out: {}", count.key, parts.join(", ")))
}

fn blocked(index: usize, emitter: &Emitter, bodies: &[PosedMap], scene: &Scene) -> Option<String> {
    let mut places: Vec<DVec3> = emitter.places().collect();
    let all = places.len();
    let blocked = drop_in_bodies(&mut places, bodies, BODY_MARGIN * scene.particle_radius);
    (blocked > 0).then(|| {
        let part = percent(blocked as f64 / all as f64);
        format!("emitters[{index}]: {part} of the nozzle lies in a body, and gives nothing there")
    })
}
