//! The fluid at the start: lattices of particles in boxes and solids, without those that can't be there.

use super::Scene;
use super::fluid::Fill;
use super::overlap::{BODY_MARGIN, Placed, bounds, drop_in_bodies, drop_outside};
use crate::error::Error;
use glam::{BVec3, DVec3};
use serde::Serialize;
use volmap_bake::sdf::{BoundaryDistance, SignedDistance};
use volmap_fluid::lattice::{self, MAX_PARTICLES};
use volmap_formats::asset::Exterior;
use volmap_formats::text::{number, thousands};
use volmap_runtime::{PosedMap, Values};

/// Error of a map's distance that is allowed for where there is no mesh, in rp.
const MAP_SLACK: f64 = 0.1;
/// Particles nearer than this many rp are duplicates.
const DUPLICATE: f64 = 1.0;
/// Points per query of a map.
const BLOCK: usize = 4096;

/// A solid that is filled.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its map, placed.
    pub map: PosedMap,
    /// Its mesh in the map's frame, if there is one. It is more exact than the map in the corners of a box, where
    /// particles must fit.
    pub mesh: Option<BoundaryDistance>,
    /// Offset of the map's surface from the mesh, out of the solid, metres.
    pub thickness: f64,
}

/// The fluid at the start.
#[derive(Clone, Debug, Default)]
pub struct PlacedParticles {
    /// Centres, metres.
    pub positions: Vec<DVec3>,
    /// Velocities, m/s.
    pub velocities: Vec<DVec3>,
    /// Particles of each source, in the scene's order.
    pub counts: Vec<SourceCount>,
}

/// How many particles a source gave.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SourceCount {
    /// Its key, as `blocks[0]`.
    pub key: String,
    /// Particles that the fluid begins with.
    pub particles: u64,
    /// Left out: in a body, or closer to one than rp/5.
    pub in_bodies: u64,
    /// Left out: closer than rp to a particle of an earlier source.
    pub duplicates: u64,
    /// Left out: out of the domain.
    pub outside: u64,
}

/// Particles of all blocks and fills. `solids` are those of the fills, `bodies` the placed maps of the bodies.
///
/// # Errors
/// More particles than can be.
pub fn fill(scene: &Scene, solids: &[Solid], bodies: &[PosedMap]) -> Result<PlacedParticles, Error> {
    let (rp, spacing) = (scene.particle_radius, scene.spacing());
    let mut sources: Vec<Source> = Vec::new();
    for (i, block) in scene.blocks.iter().enumerate() {
        let points = lattice::fill_box(block.region().corners(), spacing).collect();
        sources.push(Source { key: format!("blocks[{i}]"), velocity: block.velocity.into(), points });
        check_total(&sources)?;
    }
    for (i, (fill, solid)) in scene.fills.iter().zip(solids).enumerate() {
        let key = format!("fills[{i}]");
        let points =
            fill_solid(fill, solid, rp).map_err(|reason| Error::Scene { place: key.clone(), reason })?;
        sources.push(Source { key, velocity: fill.velocity.into(), points });
        check_total(&sources)?;
    }
    let mut counts: Vec<SourceCount> = Vec::new();
    for Source { key, points, .. } in &mut sources {
        let outside = drop_outside(points, scene.domain.as_ref());
        let in_bodies = drop_in_bodies(points, bodies, BODY_MARGIN * rp);
        counts.push(SourceCount { key: key.clone(), outside, in_bodies, ..SourceCount::default() });
    }
    let boxes: Vec<_> = sources.iter().map(|source| bounds(&source.points)).collect();
    let mut placed = Placed::new(DUPLICATE * rp);
    let mut out = PlacedParticles::default();
    for (i, Source { velocity, mut points, .. }) in sources.into_iter().enumerate() {
        counts[i].duplicates = placed.drop_duplicates(&mut points);
        counts[i].particles = points.len() as u64;
        let later: Vec<_> = boxes[i + 1..].iter().flatten().copied().collect();
        placed.add(&points, &later);
        out.velocities.extend(std::iter::repeat_n(velocity, points.len()));
        out.positions.append(&mut points);
    }
    out.counts = counts;
    Ok(out)
}

/// A block or a fill.
struct Source {
    key: String,
    velocity: DVec3,
    points: Vec<DVec3>,
}

fn check_total(sources: &[Source]) -> Result<(), Error> {
    let total: usize = sources.iter().map(|source| source.points.len()).sum();
    match sources.last() {
        Some(Source { key, .. }) if total as u64 > MAX_PARTICLES => Err(Error::Scene {
            place: key.clone(),
            reason: format!(
                "with this source there are {} particles, more than {}",
                thousands(total as u64),
                thousands(MAX_PARTICLES)
            ),
        }),
        _ => Ok(()),
    }
}

/// Points of a lattice around the map's middle that have room in the solid. Along each axis the middle can lie on a
/// point or between two. Of these eight lattices the one with most points is taken, so that a box of whole spacings
/// is filled to its walls.
fn fill_solid(fill: &Fill, solid: &Solid, rp: f64) -> Result<Vec<DVec3>, String> {
    let body = &solid.map;
    let grid = body.map.grid();
    let [low, high] = [grid.origin, grid.max_corner()];
    let turned = |axis: DVec3| (body.pose.rotation * (axis * (high - low))).abs();
    let half = 0.5 * (turned(DVec3::X) + turned(DVec3::Y) + turned(DVec3::Z));
    let spacing = 2.0 * rp;
    let cells = (half / spacing).ceil();
    let total = 8.0 * cells.element_product();
    if total > MAX_PARTICLES as f64 {
        return Err(format!(
            "its box holds {} particles, more than {}; check its scale",
            number(total),
            thousands(MAX_PARTICLES)
        ));
    }
    let middle = body.pose.to_world(0.5 * (low + high));
    let mut best = Vec::new();
    for shift in 0..8_u8 {
        let on_point = BVec3::new(shift & 1 > 0, shift & 2 > 0, shift & 4 > 0);
        let offset = DVec3::select(on_point, DVec3::ZERO, DVec3::splat(0.5 * spacing));
        let first = middle - cells * spacing + offset;
        let counts = (2.0 * cells).to_array().map(|n| n as u64);
        let points = with_room(lattice::points(first, spacing, counts), fill, solid, rp);
        if points.len() > best.len() {
            best = points;
        }
    }
    Ok(best)
}

/// The points whose particle fits into the solid, or into the hollow of a container.
fn with_room(points: impl Iterator<Item = DVec3>, fill: &Fill, solid: &Solid, rp: f64) -> Vec<DVec3> {
    let mut points = points.filter(|&point| fill.within.is_none_or(|within| within.contains(point)));
    let (mut out, mut block, mut values) = (Vec::new(), Vec::new(), Vec::<Values>::new());
    loop {
        block.clear();
        block.extend(points.by_ref().take(BLOCK));
        if block.is_empty() {
            return out;
        }
        solid.map.sample_batch(&block, &mut values);
        let room = block.iter().zip(&values).filter(|(point, at)| has_room(solid, **point, at.distance, rp));
        out.extend(room.map(|(point, _)| *point));
    }
}

/// Whether a particle fits into the space that is filled; `distance` is the map's.
fn has_room(solid: &Solid, point: DVec3, distance: f64, rp: f64) -> bool {
    let side = if solid.map.map.exterior() == Exterior::Solid { 1.0 } else { -1.0 };
    let depth = side * distance;
    match &solid.mesh {
        Some(mesh) if depth.abs() < 2.0 * rp => {
            // Inside the mesh is the solid, or the hollow of a container: both are filled.
            let inside = -mesh.at(solid.map.pose.to_map(point));
            inside - side * solid.thickness >= rp * (1.0 - 1e-6)
        }
        Some(_) => depth > 0.0,
        None => depth >= rp * (1.0 - MAP_SLACK),
    }
}
