//! The fluid at the start: lattices of particles in boxes and solids, without those that can't be there.

use super::Scene;
use super::count::make_count;
use super::fluid::{Fill, Packing};
use super::numbers::Region;
use super::overlap::{BODY_MARGIN, Placed, bounds, drop_in_bodies, drop_outside};
use super::solid::{Solid, depth_in};
use super::space::Space;
use crate::error::Error;
use glam::{BVec3, DVec3};
use serde::Serialize;
use std::ops::Range;
use volmap_fluid::lattice::{self, MAX_PARTICLES};
use volmap_formats::text::{number, thousands};
use volmap_runtime::{PosedMap, Values};

/// Error of a map's distance that is allowed for where there is no mesh, in rp.
const MAP_SLACK: f64 = 0.1;
/// Particles nearer than this many rp are duplicates.
const DUPLICATE: f64 = 1.0;
/// Points per query of a map.
const BLOCK: usize = 4096;

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
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
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
    /// Nearer to bodies than fluid rests from them by the scene's boundary method, if that is farther than rp.
    pub too_near: u64,
    /// Volume of its box or solid without bodies, m^3.
    pub space: f64,
    /// Whether its particles are spread, as many as its space holds.
    pub is_relaxed: bool,
}

/// Particles of all blocks and fills. `solids` are those of the fills, `bodies` the placed maps of the bodies.
///
/// # Errors
/// More particles than can be.
pub fn fill(scene: &Scene, solids: &[Solid], bodies: &[PosedMap]) -> Result<PlacedParticles, Error> {
    let rp = scene.particle_radius;
    let mut sources = lattices(scene, solids, bodies)?;
    let mut counts: Vec<SourceCount> = Vec::new();
    for source in &mut sources {
        let points = &mut source.points;
        let outside = drop_outside(points, scene.domain.as_ref());
        let mut in_bodies = drop_in_bodies(points, bodies, BODY_MARGIN * rp);
        let space = Space { gap: 0.0, ..source.space }.volume();
        let is_relaxed = source.packing == Packing::Relaxed;
        if is_relaxed {
            // Its space ends at bodies, and is full.
            in_bodies = 0;
            let holds = if source.space.gap > 0.0 { source.space.volume() } else { space };
            make_count(points, source.space, (holds / scene.particle_volume()).round() as usize);
        }
        let too_near = if is_relaxed { 0 } else { too_near(points, source.space) };
        let key = source.key.clone();
        let count =
            SourceCount { key, outside, in_bodies, space, is_relaxed, too_near, ..Default::default() };
        counts.push(count);
    }
    check_total(&sources)?;
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

impl PlacedParticles {
    /// The particles of each source.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        let mut end = 0;
        self.counts.iter().map(move |count| {
            let start = end;
            end += count.particles as usize;
            start..end
        })
    }
}

/// Blocks and fills on their lattices, bodies not yet left out.
fn lattices<'a>(
    scene: &Scene,
    solids: &'a [Solid],
    bodies: &'a [PosedMap],
) -> Result<Vec<Source<'a>>, Error> {
    let mut sources: Vec<Source> = Vec::new();
    for (i, block) in scene.blocks.iter().enumerate() {
        let points = lattice::fill_box(block.region().corners(), scene.spacing()).collect();
        sources.push(Source {
            key: format!("blocks[{i}]"),
            velocity: block.velocity.into(),
            points,
            packing: block.packing,
            space: scene.space(Some(block.region()), None, bodies),
        });
        check_total(&sources)?;
    }
    for (i, (fill, solid)) in scene.fills.iter().zip(solids).enumerate() {
        let key = format!("fills[{i}]");
        let space = scene.space(fill.within, Some(solid), bodies);
        let points =
            fill_solid(fill, solid, space).map_err(|reason| Error::Scene { place: key.clone(), reason })?;
        sources.push(Source { key, velocity: fill.velocity.into(), points, packing: fill.packing, space });
        check_total(&sources)?;
    }
    Ok(sources)
}

impl Scene {
    /// The space of a source.
    pub(super) fn space<'a>(
        &self,
        region: Option<Region>,
        solid: Option<&'a Solid>,
        bodies: &'a [PosedMap],
    ) -> Space<'a> {
        let rests = self.world().resting_distance(self.solver.boundary_pressure);
        let rp = self.particle_radius;
        Space { region, solid, bodies, gap: (rests - rp).max(0.0), rp }
    }

    /// Volume of a particle, m^3.
    pub(super) fn particle_volume(&self) -> f64 {
        self.world().particle_volume(&self.fluid)
    }
}

/// A block or a fill.
struct Source<'a> {
    key: String,
    velocity: DVec3,
    points: Vec<DVec3>,
    packing: Packing,
    space: Space<'a>,
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
fn fill_solid(fill: &Fill, solid: &Solid, space: Space) -> Result<Vec<DVec3>, String> {
    let (middle, half) = solid.middle_and_half();
    let spacing = 2.0 * space.rp;
    let cells = (half / spacing).ceil();
    let total = 8.0 * cells.element_product();
    if total > MAX_PARTICLES as f64 {
        return Err(format!(
            "its box holds {} particles, more than {}; check its scale",
            number(total),
            thousands(MAX_PARTICLES)
        ));
    }
    let mut best = Vec::new();
    for shift in 0..8_u8 {
        let on_point = BVec3::new(shift & 1 > 0, shift & 2 > 0, shift & 4 > 0);
        let offset = DVec3::select(on_point, DVec3::ZERO, DVec3::splat(0.5 * spacing));
        let first = middle - cells * spacing + offset;
        let counts = (2.0 * cells).to_array().map(|n| n as u64);
        let points = with_room(lattice::points(first, spacing, counts), fill, solid, space);
        if points.len() > best.len() {
            best = points;
        }
    }
    Ok(best)
}

/// The points whose particle fits into the solid, or into the hollow of a container, and that are as far from bodies as
/// the fluid rests from them, if that is farther than rp.
fn with_room(points: impl Iterator<Item = DVec3>, fill: &Fill, solid: &Solid, space: Space) -> Vec<DVec3> {
    let rp = space.rp;
    let mut points = points.filter(|&point| fill.within.is_none_or(|within| within.contains(point)));
    let (mut out, mut block, mut values) = (Vec::new(), Vec::new(), Vec::<Values>::new());
    loop {
        block.clear();
        block.extend(points.by_ref().take(BLOCK));
        if block.is_empty() {
            break;
        }
        solid.map.sample_batch(&block, &mut values);
        let room = block.iter().zip(&values).filter(|(point, at)| has_room(solid, **point, at.distance, rp));
        out.extend(room.map(|(point, _)| *point));
    }
    if space.gap > 0.0 {
        drop_in_bodies(&mut out, space.bodies, rp * (1.0 - MAP_SLACK) + space.gap);
    }
    out
}

/// How many points are nearer to bodies than the fluid rests from them, if that is farther than rp.
fn too_near(points: &[DVec3], space: Space) -> u64 {
    match space.gap > 0.0 {
        true => {
            let margin = space.rp * (1.0 - MAP_SLACK) + space.gap;
            drop_in_bodies(&mut points.to_vec(), space.bodies, margin)
        }
        false => 0,
    }
}

/// Whether a particle fits into the space that is filled; `distance` is the map's.
fn has_room(solid: &Solid, point: DVec3, distance: f64, rp: f64) -> bool {
    let depth = depth_in(solid, point, distance, rp);
    depth >= rp * (1.0 - if solid.mesh.is_some() { 1e-6 } else { MAP_SLACK })
}
