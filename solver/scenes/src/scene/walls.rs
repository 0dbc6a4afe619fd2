//! Walls around a source whose particles are spread: they hold it together where no body does, and are gone at time 0.

use super::body::Source;
use super::fluid::{Block, Fill};
use super::map::Library;
use super::numbers::Region;
use super::solid::Solid;
use super::space::Space;
use super::spread::{face, spread};
use crate::error::Error;
use std::ops::Range;
use std::sync::Arc;
use volmap_bake::parameters::Parameters;
use volmap_bake::primitive::Primitive;
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{DQuat, DVec3, Pose, VolumeMap};

/// A source whose particles are spread before time 0.
#[derive(Clone, Debug)]
pub struct Relaxed {
    /// Its key, as `blocks[0]`.
    pub key: String,
    /// Its particles.
    pub particles: Range<usize>,
    /// What holds it together.
    pub walls: Vec<Wall>,
}

/// A container around a source.
#[derive(Clone, Debug)]
pub struct Wall {
    /// Its map.
    pub map: Arc<VolumeMap>,
    /// Its mesh in the map's frame.
    pub mesh: Option<Arc<TriangleMesh>>,
    /// Where it is.
    pub pose: Pose,
}

/// Nearer to a body than this many rp a wall lies on it: the fluid must not feel both.
const ON_BODY: f64 = 0.5;
/// Points along a face of a box at most.
const MOST_POINTS: f64 = 64.0;

/// Walls of a block. `space` is the block's.
///
/// # Errors
/// As [`Library::obtain_for_body`].
pub(super) fn of_block(
    library: &mut Library,
    block: &Block,
    space: Space,
    key: &str,
) -> Result<Vec<Wall>, Error> {
    let space = Space { region: None, ..space };
    Ok(of_region(library, block.region(), space, key)?.into_iter().collect())
}

/// Walls of a fill: around its solid, and around the part of it that is filled. `space` is the fill's.
///
/// # Errors
/// As [`Library::obtain_for_body`].
pub(super) fn of_fill(
    library: &mut Library,
    fill: &Fill,
    solid: &Solid,
    space: Space,
    key: &str,
) -> Result<Vec<Wall>, Error> {
    let mut walls = Vec::new();
    let around = Space { solid: None, gap: 0.0, ..space };
    let shape = library.bounded(fill.shape, fill.pose());
    if let Some(mesh) = &solid.surface {
        let surface: Vec<DVec3> =
            spread(mesh, space.rp).into_iter().map(|point| solid.map.pose.to_world(point)).collect();
        if !is_covered(&surface, around) {
            let bake = &inside_out(&fill.bake, space.gap);
            if let Some(source) = Source::of(None, fill.mesh.as_deref(), shape, bake) {
                let shape = library.obtain_for_body(source, key)?;
                walls.push(Wall { map: shape.map, mesh: shape.mesh, pose: fill.pose() });
            }
        }
    }
    if let Some(region) = fill.within {
        walls.extend(of_region(library, region, Space { region: None, ..space }, key)?);
    }
    Ok(walls)
}

/// The container whose hollow is the solid, wider by a gap (metres), with the support radius of bodies.
fn inside_out(bake: &Parameters, gap: f64) -> Parameters {
    let side = if bake.invert == Some(true) { 1.0 } else { -1.0 };
    let thickness = side * bake.thickness.unwrap_or(0.0) - gap;
    Parameters {
        invert: Some(true),
        thickness: (thickness != 0.0).then_some(thickness),
        support_radius: None,
        particle_radius: None,
        ..bake.clone()
    }
}

/// A box around a region, but for the faces that lie on bodies; none where all do.
fn of_region(library: &mut Library, region: Region, space: Space, key: &str) -> Result<Option<Wall>, Error> {
    let [low, high] = region.corners();
    let around = Space { gap: 0.0, ..space };
    let mut corners = [low - space.gap, high + space.gap];
    let parts =
        ((high - low) / (2.0 * space.rp)).ceil().clamp(DVec3::ONE, DVec3::splat(MOST_POINTS)).as_uvec3();
    let mut open = 0;
    for side in 0..6 {
        let (axis, end) = (side / 2, side % 2);
        let at = [low, high][end][axis];
        if is_covered(&face([low, high], axis, at, parts.to_array()), around) {
            // Out of the fluid's reach.
            corners[end][axis] += [-1.0, 1.0][end] * FAR * space.rp;
        } else {
            open += 1;
        }
    }
    if open == 0 {
        return Ok(None);
    }
    let size = (corners[1] - corners[0]).to_array();
    let bake = Parameters { invert: Some(true), ..Parameters::default() };
    let shape = library.obtain_for_body(Source::Shape(Primitive::Box { size }, &bake), key)?;
    let pose = Pose { rotation: DQuat::IDENTITY, translation: 0.5 * (corners[0] + corners[1]) };
    Ok(Some(Wall { map: shape.map, mesh: shape.mesh, pose }))
}

/// Out of reach of a wall, in rp: support radii are 10 at most.
const FAR: f64 = 20.0;

/// Whether most of a surface that isn't buried lies on other walls.
fn is_covered(surface: &[DVec3], around: Space) -> bool {
    let least = ON_BODY * around.rp;
    let depths = around.depths(surface);
    let seen = depths.iter().filter(|depth| **depth >= -least).count();
    let on = depths.iter().filter(|depth| depth.abs() < least).count();
    2 * on >= seen
}
