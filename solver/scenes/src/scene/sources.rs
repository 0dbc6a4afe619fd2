//! The particles of the start: lattices in boxes and solids, without what can't be there.

use super::Scene;
use super::fluid::Fill;
use super::overlap::{BODY_MARGIN, Placed, bounds, drop_in_bodies, drop_outside};
use crate::error::Error;
use glam::{BVec3, DVec3};
use serde::Serialize;
use volmap_bake::sdf::MeshDistance;
use volmap_fluid::lattice::{self, MAX_PARTICLES};
use volmap_formats::asset::Exterior;
use volmap_runtime::{PosedMap, Values};

/// Where no mesh tells the exact distance: part of rp that the map's may be wrong by.
const MAP_SLACK: f64 = 0.1;
/// Particles nearer than this part of rp are one.
const DUPLICATE: f64 = 1.0;
/// Points that are asked for at a time.
const BLOCK: usize = 4096;

/// A solid that is filled.
#[derive(Clone, Debug)]
pub struct Solid {
    /// Its map, placed.
    pub map: PosedMap,
    /// Its mesh in the map's frame, if there is one. A map is less exact in the corners of a box, where a
    /// particle should lie.
    pub mesh: Option<MeshDistance>,
    /// Offset of the map's surface from the mesh, out of the solid, metres.
    pub thickness: f64,
}

/// The fluid at the start.
#[derive(Clone, Debug, Default)]
pub struct Particles {
    /// Centres, metres.
    pub positions: Vec<DVec3>,
    /// Velocities, m/s.
    pub velocities: Vec<DVec3>,
    /// What came of each source, in the scene's order.
    pub counts: Vec<SourceCount>,
}

/// What came of a source.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct SourceCount {
    /// Its key, as `blocks[0]`.
    pub key: String,
    /// Particles that are in the fluid.
    pub particles: u64,
    /// Left out: in a body, or closer to one than rp/5.
    pub in_bodies: u64,
    /// Left out: closer than rp to a particle of an earlier source.
    pub duplicates: u64,
    /// Left out: out of the domain.
    pub outside: u64,
}

/// Particles of all blocks and fills. `solids` holds the solid of each fill, `bodies` the placed map of each
/// body.
///
/// # Errors
/// More particles than can be.
pub fn fill(scene: &Scene, solids: &[Solid], bodies: &[PosedMap]) -> Result<Particles, Error> {
    let (rp, spacing) = (scene.particle_radius, scene.spacing());
    let mut sources: Vec<(String, DVec3, Vec<DVec3>)> = Vec::new();
    for (i, block) in scene.blocks.iter().enumerate() {
        let points = lattice::fill_box(block.region().corners(), spacing).collect();
        sources.push((format!("blocks[{i}]"), block.velocity.into(), points));
        check_total(&sources)?;
    }
    for (i, (fill, solid)) in scene.fills.iter().zip(solids).enumerate() {
        let key = format!("fills[{i}]");
        let points =
            fill_solid(fill, solid, rp).map_err(|reason| Error::Scene { place: key.clone(), reason })?;
        sources.push((key, fill.velocity.into(), points));
        check_total(&sources)?;
    }
    let mut counts: Vec<SourceCount> = Vec::new();
    for (key, _, points) in &mut sources {
        let outside = drop_outside(points, scene.domain.as_ref());
        let in_bodies = drop_in_bodies(points, bodies, BODY_MARGIN * rp);
        counts.push(SourceCount { key: key.clone(), outside, in_bodies, ..SourceCount::default() });
    }
    let boxes: Vec<_> = sources.iter().map(|(.., points)| bounds(points)).collect();
    let mut placed = Placed::new(DUPLICATE * rp);
    let mut out = Particles::default();
    for (i, (_, velocity, mut points)) in sources.into_iter().enumerate() {
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

fn check_total(sources: &[(String, DVec3, Vec<DVec3>)]) -> Result<(), Error> {
    let total: usize = sources.iter().map(|(.., points)| points.len()).sum();
    match sources.last() {
        Some((key, ..)) if total as u64 > MAX_PARTICLES => Err(Error::Scene {
            place: key.clone(),
            reason: format!("with this source there are {total} particles, more than {MAX_PARTICLES}"),
        }),
        _ => Ok(()),
    }
}

/// Points of a lattice about the map's middle that have room in the solid. Of the eight ways to put the
/// middle on a point or between two, along each axis, the one that holds most is taken: a box of whole
/// spacings is filled to its walls.
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
            "its box holds {total:.1e} particles, more than {MAX_PARTICLES}; check its scale"
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

/// Those with their ball in the solid, or in what a container holds.
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

/// Whether a ball lies within the space that is filled; `distance` is the map's.
fn has_room(solid: &Solid, point: DVec3, distance: f64, rp: f64) -> bool {
    let side = if solid.map.map.exterior() == Exterior::Solid { 1.0 } else { -1.0 };
    let depth = side * distance;
    match &solid.mesh {
        Some(mesh) if depth.abs() < 2.0 * rp => {
            // In the mesh is where either is filled: the solid, or what the container holds.
            let inside = -mesh.signed_distance(solid.map.pose.to_map(point));
            inside - side * solid.thickness >= rp * (1.0 - 1e-6)
        }
        Some(_) => depth > 0.0,
        None => depth >= rp * (1.0 - MAP_SLACK),
    }
}
