//! From a scene to what a simulation starts with: maps, particles, emitters.

use super::Scene;
use super::body::{self, Body, Source};
use super::fluid::{EmitterSettings, Fill};
use super::map::{Library, Origin, Shape};
use super::memory::{Limit, of_maps};
use super::nozzle;
use super::overlap::{BODY_MARGIN, Placed, bounds, drop_in_bodies};
use super::solid::Solid;
use super::sources::{self, PlacedParticles, SourceCount};
use super::surface::Surface;
use super::walls::{self, Relaxed};
use crate::error::Error;
use glam::DVec3;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use volmap_bake::cache::default_folder;
use volmap_bake::mesh::diagnose;
use volmap_bake::sdf::{BoundaryDistance, MeshDistance, SignMethod};
use volmap_bake::watch::Watch;
use volmap_fluid::boundary::particles;
use volmap_fluid::emitter::Emitter;
use volmap_fluid::settings::BoundaryMethod;
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::{percent, significant, thousands};
use volmap_runtime::{Pose, PosedMap, VolumeMap};

/// What a simulation starts with.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Bodies in the scene's order.
    pub bodies: Vec<PreparedBody>,
    /// The fluid at the start; that of relaxed sources is not spread yet.
    pub particles: PlacedParticles,
    /// Sources whose particles are spread before time 0.
    pub relaxed: Vec<Relaxed>,
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
    /// The surface of its solid.
    pub surface: Surface,
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
    let cache = scene.cache.clone().unwrap_or_else(default_folder);
    prepare_from(scene, Library::new(&scene.world(), cache, watch, on_bake))
}

/// The same of a scene whose run and bakes may need so much memory.
///
/// # Errors
/// As [`prepare`], and a run or a bake that would need more.
pub fn prepare_within(
    scene: &Scene,
    limit: Limit,
    watch: &Watch,
    on_bake: &mut dyn FnMut(&Path),
) -> Result<Prepared, Error> {
    scene.validate()?;
    limit.check_scene(scene)?;
    let cache = scene.cache.clone().unwrap_or_else(default_folder);
    let library = Library::new(&scene.world(), cache, watch, on_bake).with_memory(limit.bytes);
    let prepared = prepare_from(scene, library)?;
    let maps = of_maps(prepared.bodies.iter().map(|body| &body.map));
    limit.check(scene, prepared.particles.positions.len() as u64, maps)?;
    Ok(prepared)
}

fn prepare_from(scene: &Scene, library: Library) -> Result<Prepared, Error> {
    let mut library = library.within(scene.domain);
    let mut files = Vec::new();
    let bodies = prepare_bodies(scene, &mut library, &mut files)?;
    let solids = prepare_solids(scene, &mut library, &mut files)?;
    let posed: Vec<PosedMap> = bodies.iter().map(PreparedBody::posed).collect();
    let particles = sources::fill(scene, &solids, &posed)?;
    let relaxed = prepare_walls(scene, &mut library, &solids, &posed, &particles)?;
    let mut notes = scene.notes.clone();
    notes.extend(library.notes);
    let emitter = |settings| nozzle::emitter(settings, scene.rest_spacing());
    let emitters: Vec<Emitter> = scene.emitters.iter().map(emitter).collect();
    check_not_empty(scene, &particles, &emitters, &bodies)?;
    notes.extend(particles.counts.iter().filter_map(left_out));
    notes.extend(particles.counts.iter().filter_map(|count| left_empty(count, scene)));
    notes.extend(particles.counts.iter().filter_map(|count| too_near(count, scene)));
    notes.extend(emitters.iter().enumerate().filter_map(|(i, emitter)| blocked(i, emitter, &posed, scene)));
    notes.extend(overlapping(scene, &emitters));
    Ok(Prepared { bodies, particles, relaxed, emitters, files, notes })
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
        let Shape { map, surface, origin, content, .. } = library.obtain_for_body(source, &key)?;
        files.push(SourceFile { path: source.path().to_owned(), content });
        bodies.push(PreparedBody {
            boundary_particles: count_particles(scene, surface.mesh.as_deref(), &key)?,
            name,
            map,
            surface,
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
        let fill = &Fill { shape: library.bounded(fill.shape, fill.pose()), ..fill.clone() };
        let source = given(fill.source(), &key)?;
        let Shape { map, mesh: surface, primitive, content, .. } = library.obtain(source, &key)?;
        files.push(SourceFile { path: source.path().to_owned(), content });
        let mesh = surface.clone().map(|mesh| BoundaryDistance {
            mesh: MeshDistance::new(&mesh, SignMethod::Auto, &diagnose(&mesh)),
            shape: primitive,
            invert: false,
            thickness: 0.0,
        });
        let map = PosedMap { map, pose: fill.pose() };
        solids.push(Solid { map, mesh, surface, thickness: fill.bake.thickness.unwrap_or(0.0) });
    }
    Ok(solids)
}

/// The relaxed sources, and what holds each together while its particles are spread.
fn prepare_walls(
    scene: &Scene,
    library: &mut Library,
    solids: &[Solid],
    posed: &[PosedMap],
    particles: &PlacedParticles,
) -> Result<Vec<Relaxed>, Error> {
    let mut relaxed = Vec::new();
    for (n, (count, range)) in particles.counts.iter().zip(particles.ranges()).enumerate() {
        if !count.is_relaxed || range.is_empty() {
            continue;
        }
        let key = &count.key;
        let walls = match n.checked_sub(scene.blocks.len()) {
            None => {
                let block = &scene.blocks[n];
                walls::of_block(library, block, scene.space(Some(block.region()), None, posed), key)?
            }
            Some(n) => {
                let (fill, solid) = (&scene.fills[n], &solids[n]);
                let space = scene.space(fill.within, Some(solid), posed);
                walls::of_fill(library, fill, solid, space, key)?
            }
        };
        relaxed.push(Relaxed { key: key.clone(), particles: range, walls });
    }
    Ok(relaxed)
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
    let reason = "give `map`, `mesh` or `shape`";
    source.ok_or_else(|| Error::Scene { place: key.to_owned(), reason: reason.into() })
}

/// Refuses a scene that can't have fluid at any time, and says why.
fn check_not_empty(
    scene: &Scene,
    particles: &PlacedParticles,
    emitters: &[Emitter],
    bodies: &[PreparedBody],
) -> Result<(), Error> {
    if !particles.positions.is_empty() {
        return Ok(());
    }
    let mut reasons: Vec<(String, String)> = Vec::new();
    for (i, (emitter, settings)) in emitters.iter().zip(&scene.emitters).enumerate() {
        match dry(emitter, settings, bodies, scene) {
            Some(reason) => reasons.push((format!("emitters[{i}]"), reason)),
            None => return Ok(()),
        }
    }
    reasons.extend(nothing_placed(scene, particles));
    let mut texts = reasons.into_iter();
    let (place, first) = texts.next().unwrap_or_else(|| {
        ("blocks".to_owned(), "there is no fluid: add [[blocks]], [[fills]] or [[emitters]]".to_owned())
    });
    let others = texts.map(|(place, reason)| format!("; {place}: {reason}"));
    Err(Error::Scene { place, reason: first + &others.collect::<String>() })
}

/// Why blocks and fills give no particle, if there are any.
fn nothing_placed(scene: &Scene, particles: &PlacedParticles) -> Option<(String, String)> {
    let place = if scene.blocks.is_empty() { "fills" } else { "blocks" };
    let sum = |of: fn(&SourceCount) -> u64| -> u64 { particles.counts.iter().map(of).sum() };
    let (in_bodies, outside) = (sum(|count| count.in_bodies), sum(|count| count.outside));
    let (all, so) = (thousands(in_bodies + outside), "so there is no fluid");
    let invert = "set bake.invert = true for a body that is a container";
    let reason = match (in_bodies, outside) {
        _ if particles.counts.is_empty() => return None,
        (0, 0) => format!("no particle fits into any of them, {so}; check scale and particle_radius"),
        (_, 0) => format!("all {all} particles lie in a body, {so}; {invert}, or move them"),
        (0, _) => format!("all {all} particles lie outside the domain, {so}; move them, or widen `domain`"),
        _ => format!("all {all} particles lie in a body or outside the domain, {so}; move them, or {invert}"),
    };
    Some((place.to_owned(), reason))
}

/// Why an emitter never gives fluid, if it doesn't.
fn dry(
    emitter: &Emitter,
    settings: &EmitterSettings,
    bodies: &[PreparedBody],
    scene: &Scene,
) -> Option<String> {
    let count = emitter.places().count() as u64;
    if emitter.is_done() {
        let (layer, most) =
            (significant(emitter.particles_per_layer(), 3), thousands(settings.max_particles));
        return Some(format!("a layer has {layer} particles, more than max_particles, {most}"));
    }
    let margin = BODY_MARGIN * scene.particle_radius;
    let in_body = |body: &&PreparedBody| {
        drop_in_bodies(&mut emitter.places().collect(), &[body.posed()], margin) == count
    };
    let body = bodies.iter().find(in_body)?;
    Some(format!(
        "its nozzle lies in body `{}`, so no fluid comes out; set bake.invert = true if that is a container, or move \
         the nozzle",
        body.name
    ))
}

fn left_out(count: &SourceCount) -> Option<String> {
    let reasons = [
        (count.in_bodies, "in a body, or closer to it than a fifth of a particle radius"),
        (count.duplicates, "on top of particles of an earlier source"),
        (count.outside, "outside the domain"),
    ];
    let parts: Vec<String> = reasons
        .iter()
        .filter(|(n, _)| *n > 0)
        .map(|(n, reason)| format!("{} {reason}", thousands(*n)))
        .collect();
    let none = match count.particles {
        0 if count.in_bodies > 0 => "; none is left: if the body is a container, set its bake.invert = true",
        0 => "; none is left",
        _ => "",
    };
    (!parts.is_empty()).then(|| format!("{}: particles left out: {}{none}", count.key, parts.join(", ")))
}

/// A note for each nozzle that lies in an earlier one that works at the same time: each takes the other's room.
fn overlapping(scene: &Scene, emitters: &[Emitter]) -> Vec<String> {
    let until = |settings: &EmitterSettings| settings.stop.unwrap_or(f64::INFINITY);
    let meet = |[first, second]: [usize; 2]| {
        let [one, other] = [first, second].map(|n| &scene.emitters[n]);
        let mut places: Vec<DVec3> = emitters[second].places().collect();
        let mut placed = Placed::new(scene.particle_radius);
        let taken: Vec<DVec3> = emitters[first].places().collect();
        placed.add(&taken, &bounds(&places).into_iter().collect::<Vec<_>>());
        one.start.max(other.start) < until(one).min(until(other)) && placed.drop_duplicates(&mut places) > 0
    };
    let note = |second: usize| {
        let first = (0..second).find(|&first| meet([first, second]))?;
        Some(format!(
            "emitters[{second}]: its nozzle lies in that of emitters[{first}], nearer than a particle radius, and both \
             work at the same time: they give less than they should; move one, or start it when the other has stopped"
        ))
    };
    (0..emitters.len()).filter_map(note).collect()
}

/// A lattice leaves this part of a solid empty without a note, or of the room that bodies take in a block.
const EMPTY_OF_FILL: f64 = 0.03;
const EMPTY_OF_BODIES: f64 = 0.05;

/// How much of its space a lattice leaves empty, if that is worth a note.
fn left_empty(count: &SourceCount, scene: &Scene) -> Option<String> {
    let volume = scene.particle_volume();
    let filled = count.particles as f64 * volume;
    let empty = count.space - filled;
    if count.is_relaxed || count.particles == 0 || count.duplicates + count.outside > 0 {
        return None;
    }
    let cure = "packing = \"relaxed\" fills it";
    if count.key.starts_with("fills") {
        let (part, space) = (percent(filled / count.space), significant(count.space, 3));
        let is_much = empty > EMPTY_OF_FILL * count.space;
        return is_much
            .then(|| format!("{}: its lattice fills {part} of its solid of {space} m^3; {cure}", count.key));
    }
    let in_bodies = count.in_bodies as f64 * volume;
    (in_bodies > 0.0 && empty > EMPTY_OF_BODIES * in_bodies).then(|| {
        let (shell, particles) = (significant(empty, 2), (empty / volume).round() as u64);
        format!(
            "{}: its lattice leaves {shell} m^3 empty around bodies and at its faces, room for {} particles, into \
             which water and bodies fall at first; {cure}",
            count.key,
            thousands(particles)
        )
    })
}

/// Particles that begin where the boundary method doesn't let them rest.
fn too_near(count: &SourceCount, scene: &Scene) -> Option<String> {
    let rests = scene.world().resting_distance(scene.solver.boundary_pressure) / scene.particle_radius;
    (count.too_near > 0).then(|| {
        format!(
            "{}: {} particles begin nearer to bodies than fluid rests from them with this boundary method, {} particle \
             radii, and are pushed away; leave so much room (fills do), or set packing = \"relaxed\"",
            count.key,
            thousands(count.too_near),
            significant(rests, 3)
        )
    })
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
