//! The surface of the union: of a mesh whose parts overlap, cross or touch, the pieces of its triangles that lie on the
//! solid's surface. Faces inside the solid are no boundary, so that neither distance nor volume may see them.
//!
//! As Zhou, Grinspun, Zorin and Jacobson 2016, "Mesh Arrangements for Solid Geometry": triangles are cut where others
//! cross or cover them (`contacts`, `cuts`, `pieces`), so that each piece has one winding number on each side; what has
//! the solid, winding number above one half, on both sides is left out, and all but one of pieces that lie on each
//! other. Only distances are asked of the pieces, never
//! how they hang together, so that rounded corners do no harm: they are off by rounding.

mod coarse;
mod contacts;
mod cuts;
mod patches;
mod pieces;
mod tree;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use volmap_formats::mesh::TriangleMesh;

use self::contacts::Contacts;
use self::cuts::inward_lines;
use self::patches::patches;
use self::pieces::pieces;
pub(super) use self::tree::tree_of_union;
use crate::mesh::topology::Topology;
use crate::sdf::bvh::Bvh;
use crate::sdf::winding::{BETA, WindingNumbers};

/// Lengths below this part of the mesh's size are rounding.
const ROUNDING: f64 = 1e-12;
/// Winding numbers are asked this far off a piece, as a part of the mesh's size.
const OFFSET: f64 = 1e-9;
/// Steps of the last digit of the farthest coordinate that the two lengths have at least.
const LAST_DIGITS: [f64; 2] = [4.0, 16.0];
/// Triangles of a patch that are asked before all of them are.
const SAMPLES: usize = 4;
/// How far from a corner to the middle of a piece the corner's winding number is asked.
const PULLED_IN: f64 = 0.02;
/// Winding number that shows the solid beyond doubt where holes make it no integer.
const SURELY_INSIDE: f64 = 0.75;

/// What overlaps in a mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Overlaps {
    /// Pairs of triangles that cross or cover each other.
    pub pairs: usize,
    /// Triangles that lie inside the solid, entirely or in part, and so don't count there.
    pub hidden: usize,
    /// Their area inside the solid, m^2.
    pub hidden_area: f64,
    /// A point of the largest hidden piece; without one, where two triangles meet.
    pub place: Option<[f64; 3]>,
    /// Winding numbers are integers, so that it is certain what lies inside.
    pub certain: bool,
}

/// The union's surface, where that isn't all of the mesh.
#[derive(Clone, Debug)]
pub struct UnionSurface {
    /// Triangles of the mesh that lie inside the solid, entirely or in part, in increasing order, and what is left of
    /// each. All others are the surface as they are.
    pub replaced: Vec<(u32, Vec<[DVec3; 3]>)>,
}

impl UnionSurface {
    /// The triangles that are kept and the pieces that are left, of a mesh with these corners, and the number in the
    /// mesh of each.
    pub fn triangles<'a>(
        &'a self,
        corners: &'a [[DVec3; 3]],
    ) -> impl Iterator<Item = ([DVec3; 3], u32)> + 'a {
        let pieces = self.replaced.iter().flat_map(|(id, left)| left.iter().map(|piece| (*piece, *id)));
        self.kept(corners.len()).map(|id| (corners[id as usize], id)).chain(pieces)
    }

    /// Numbers of the triangles, of so many, that are the surface as they are.
    fn kept(&self, count: usize) -> impl Iterator<Item = u32> + '_ {
        let mut replaced = self.replaced.iter().map(|(triangle, _)| *triangle).peekable();
        (0..count as u32).filter(move |id| replaced.next_if_eq(id).is_none())
    }

    /// The surface as a mesh: the vertices of `mesh`, and three for each piece.
    pub fn mesh(&self, mesh: &TriangleMesh) -> TriangleMesh {
        let kept = self.kept(mesh.triangles.len()).map(|id| mesh.triangles[id as usize]);
        let mut out = TriangleMesh { triangles: kept.collect(), vertices: mesh.vertices.clone() };
        for piece in self.replaced.iter().flat_map(|(_, left)| left) {
            let first = out.vertices.len() as u32;
            out.vertices.extend(piece.map(|corner| corner.to_array()));
            out.triangles.push([first, first + 1, first + 2]);
        }
        out
    }
}

/// A mesh with its edges, tree and winding numbers; `balanced`: they are integers.
pub(super) struct Arrangement<'a> {
    pub topology: &'a Topology,
    pub corners: &'a [[DVec3; 3]],
    pub bvh: &'a Bvh,
    pub winding: &'a WindingNumbers,
    pub balanced: bool,
}

/// A part of a triangle that is hidden or kept.
struct Piece {
    polygon: Vec<DVec3>,
    hidden: bool,
}

/// What is hidden of a triangle.
struct Hidden {
    triangle: u32,
    /// What isn't.
    left: Vec<[DVec3; 3]>,
    area: f64,
    /// A point of its largest hidden piece, and that one's area.
    place: DVec3,
    largest: f64,
}

impl Arrangement<'_> {
    /// What overlaps, and the union's surface where that isn't the mesh itself, from [`contacts`]. `nested` says that
    /// parts lie inside others, which may touch nothing.
    pub fn union(&self, contacts: &Contacts, nested: bool) -> (Overlaps, Option<UnionSurface>) {
        let place = contacts.place.map(|place| place.to_array());
        let overlaps =
            Overlaps { pairs: contacts.pairs, place, certain: self.balanced, ..Overlaps::default() };
        if contacts.pairs == 0 && !nested {
            return (overlaps, None);
        }
        let patches = patches(self.topology, contacts);
        let of_patches = patches.into_par_iter().map(|patch| self.hidden_of(&patch, contacts));
        let mut hidden: Vec<Hidden> = of_patches.flatten_iter().collect();
        hidden.sort_unstable_by_key(|hidden| hidden.triangle);
        let overlaps = with_hidden(overlaps, &hidden);
        // A mesh all of which is inside has no surface to be told: it is left as it is.
        let is_left =
            hidden.len() < self.corners.len() || hidden.iter().any(|hidden| !hidden.left.is_empty());
        let replaced = || hidden.into_iter().map(|hidden| (hidden.triangle, hidden.left)).collect();
        let is_changed = overlaps.hidden > 0 && is_left;
        (overlaps, is_changed.then(|| UnionSurface { replaced: replaced() }))
    }

    /// What is hidden of triangles that hang together: whole ones all or none, unless samples show otherwise.
    fn hidden_of(&self, patch: &[u32], contacts: &Contacts) -> Vec<Hidden> {
        // Only integers are the same all over a patch.
        if self.balanced && patch.len() > SAMPLES {
            let sample = |k: usize| patch[k * (patch.len() - 1) / (SAMPLES - 1)];
            let is_hidden = |k: usize| self.split(sample(k), contacts).iter().all(|piece| piece.hidden);
            let first = is_hidden(0);
            if (1..SAMPLES).all(|k| is_hidden(k) == first) {
                return if first {
                    patch.iter().map(|&triangle| self.hidden_whole(triangle)).collect()
                } else {
                    Vec::new()
                };
            }
        }
        patch.iter().filter_map(|&triangle| hidden(triangle, &self.split(triangle, contacts))).collect()
    }

    fn hidden_whole(&self, triangle: u32) -> Hidden {
        let corners = &self.corners[triangle as usize];
        let area = area(corners);
        Hidden { triangle, left: Vec::new(), area, place: middle(corners), largest: area }
    }

    /// The pieces of a triangle: itself where nothing cuts it.
    fn split(&self, triangle: u32, contacts: &Contacts) -> Vec<Piece> {
        let corners = &self.corners[triangle as usize];
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let polygons = match contacts.cuts_of(triangle) {
            [] => vec![corners.to_vec()],
            cuts => pieces(corners, normal, cuts, contacts.tolerance),
        };
        let offset = normal * length(self.bvh, OFFSET, LAST_DIGITS[1]);
        let covers: Vec<Vec<(DVec3, DVec3)>> = contacts
            .covers_of(triangle)
            .iter()
            .map(|(_, by)| inward_lines(&self.corners[*by as usize], normal, contacts.tolerance))
            .collect();
        let is_covered =
            |p: DVec3| covers.iter().any(|lines| lines.iter().all(|(q, inward)| inward.dot(p - *q) > 0.0));
        let piece = |polygon: Vec<DVec3>| {
            let place = middle(&polygon);
            Piece { hidden: is_covered(place) || self.is_hidden(&polygon, offset), polygon }
        };
        polygons.into_iter().map(piece).collect()
    }

    /// Whether the solid is on both sides of a piece: in its middle, and where winding numbers are no integers near all
    /// of its corners, too.
    fn is_hidden(&self, polygon: &[DVec3], offset: DVec3) -> bool {
        let inside = |p: DVec3| match self.balanced {
            true => self.winding.inside(self.bvh, p, true),
            false => self.winding.fast(self.bvh, p, BETA) > SURELY_INSIDE,
        };
        let is_within = |p: DVec3| inside(p + offset) && inside(p - offset);
        let place = middle(polygon);
        offset != DVec3::ZERO
            && is_within(place)
            && (self.balanced || polygon.iter().all(|corner| is_within(corner.lerp(place, PULLED_IN))))
    }
}

/// Pairs of triangles that cross or cover each other.
pub(super) fn contacts(bvh: &Bvh) -> Contacts {
    Contacts::find(bvh, length(bvh, ROUNDING, LAST_DIGITS[0]))
}

/// The part of the mesh's size, but so many steps of the coordinates' last digit at least.
fn length(bvh: &Bvh, part: f64, last_digits: f64) -> f64 {
    let farthest = bvh.frame.centre.abs().max_element() + 1.0 / bvh.frame.scale;
    (part / bvh.frame.scale).max(last_digits * f64::EPSILON * farthest)
}

/// What is hidden of a triangle, if anything; the rest as fans.
fn hidden(triangle: u32, pieces: &[Piece]) -> Option<Hidden> {
    let largest = pieces
        .iter()
        .filter(|piece| piece.hidden)
        .map(|piece| (area(&piece.polygon), middle(&piece.polygon)));
    let (largest, place) = largest.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut hidden = Hidden { triangle, left: Vec::new(), area: 0.0, place, largest };
    for Piece { polygon, hidden: is_hidden } in pieces {
        match is_hidden {
            true => hidden.area += area(polygon),
            false => {
                hidden.left.extend(polygon.windows(2).skip(1).map(|side| [polygon[0], side[0], side[1]]))
            }
        }
    }
    Some(hidden)
}

fn with_hidden(overlaps: Overlaps, hidden: &[Hidden]) -> Overlaps {
    let largest = hidden.iter().reduce(|a, b| if b.largest > a.largest { b } else { a });
    Overlaps {
        hidden: hidden.len(),
        hidden_area: hidden.iter().map(|hidden| hidden.area).sum(),
        place: largest.map(|hidden| hidden.place.to_array()).or(overlaps.place),
        ..overlaps
    }
}

/// A point inside a convex polygon.
fn middle(polygon: &[DVec3]) -> DVec3 {
    polygon.iter().sum::<DVec3>() / polygon.len() as f64
}

fn area(polygon: &[DVec3]) -> f64 {
    let corner = polygon[0];
    let sum: DVec3 = polygon.windows(2).map(|side| (side[0] - corner).cross(side[1] - corner)).sum();
    0.5 * sum.length()
}
