//! The surface Phi = constant as triangles: marching tetrahedra over thirds of the cells, each corner of the surface
//! found on the map itself, so that it is as exact as the map, whatever the lattice.

pub mod lattice;
mod tetrahedra;

use crate::error::Error;
use crate::watch::Watch;
use lattice::{Lattice, LatticeChoice};
use rayon::prelude::*;
use std::collections::HashMap;
use std::fmt;
use tetrahedra::{Edge, triangles};
use volmap_formats::text::thousands;
use volmap_runtime::{DVec3, Values, VolumeMap};

/// Steps in a cell: the element has its nodes at thirds.
const STEPS: u32 = 3;
const MAX_POINTS: u64 = 1 << 33;
/// Crossings this close to a point of the lattice, as a part of an edge, are that point: no slivers where a surface
/// lies in the lattice.
const SNAP: f64 = 1e-6;

/// Triangles whose normals point away from the solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct IsoSurface {
    /// Places, metres.
    pub vertices: Vec<[f64; 3]>,
    /// Corners of the triangles.
    pub triangles: Vec<[u32; 3]>,
    /// Whether it ends at the border of the map's domain.
    pub is_cut: bool,
}

impl fmt::Display for IsoSurface {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let state = if self.is_cut { "open at the border of the map's domain" } else { "closed" };
        let [triangles, vertices] = [self.triangles.len(), self.vertices.len()].map(|n| thousands(n as u64));
        write!(f, "{triangles} triangles, {vertices} vertices, {state}")
    }
}

/// The surface Phi = `iso` (metres) of a map; by default the points at which the map is asked are at thirds of its
/// cells.
///
/// # Errors
/// A distance beyond the band, or too many points; cancelled.
pub fn iso_surface(
    map: &VolumeMap,
    iso: f64,
    choice: Option<LatticeChoice>,
    watch: &Watch,
) -> Result<IsoSurface, Error> {
    let limit = 2.0 * map.support_radius();
    // Also false for NaN.
    if !(-limit < iso && iso < limit) {
        let reason = format!("{iso} m is not within the map's band of -{limit} to {limit} m");
        return Err(Error::setting("iso", reason));
    }
    let lattice = Lattice::over(map, choice, STEPS, MAX_POINTS)?;
    let mut crossings = Crossings { lattice: &lattice, edges: Vec::new(), numbers: HashMap::new() };
    let found = march(map, iso, &mut crossings, watch)?;
    watch.check()?;
    Ok(finish(map, iso, &crossings, &found))
}

/// The edges of the lattice that the surface crosses.
struct Crossings<'a> {
    lattice: &'a Lattice,
    /// Lower end, and the mask of the axes along which the edge goes up.
    edges: Vec<([usize; 3], u8)>,
    numbers: HashMap<u64, u32>,
}

impl Crossings<'_> {
    fn number(&mut self, cube: [usize; 3], [from, to]: Edge) -> u32 {
        let at = shifted(cube, from);
        let next = self.edges.len() as u32;
        let key = 8 * point_key(self.lattice, at) + u64::from(to ^ from);
        *self.numbers.entry(key).or_insert_with(|| {
            self.edges.push((at, to ^ from));
            next
        })
    }
}

fn shifted([i, j, k]: [usize; 3], mask: u8) -> [usize; 3] {
    [i + usize::from(mask & 1), j + usize::from(mask >> 1 & 1), k + usize::from(mask >> 2 & 1)]
}

fn point_key(lattice: &Lattice, [i, j, k]: [usize; 3]) -> u64 {
    let [nx, ny, _] = lattice.points();
    (i + nx * (j + ny * k)) as u64
}

/// The triangles, by the numbers of their crossings.
fn march(
    map: &VolumeMap,
    iso: f64,
    crossings: &mut Crossings,
    watch: &Watch,
) -> Result<Vec<[u32; 3]>, Error> {
    let [nx, ny, nz] = crossings.lattice.points();
    let work = watch.begin("marching through the cells", nz as u64)?;
    let mut found = Vec::new();
    let mut lower = inside_plane(map, iso, crossings.lattice, 0);
    for k in 0..nz - 1 {
        work.check()?;
        work.add(1);
        let upper = inside_plane(map, iso, crossings.lattice, k + 1);
        for j in 0..ny - 1 {
            for i in 0..nx - 1 {
                let bit = |corner: usize| {
                    let plane = if corner < 4 { &lower } else { &upper };
                    u8::from(plane[i + (corner & 1) + nx * (j + (corner >> 1 & 1))]) << corner
                };
                let inside = (0..8).map(bit).sum();
                if inside != 0 && inside != 255 {
                    triangles(inside, &mut |edges| {
                        found.push(edges.map(|edge| crossings.number([i, j, k], edge)));
                    });
                }
            }
        }
        if crossings.edges.len() > i32::MAX as usize {
            return Err(Error::setting(
                "resolution",
                "the surface has more than 2^31 corners; take fewer steps, or a larger `cell_size`",
            ));
        }
        lower = upper;
    }
    Ok(found)
}

/// Which points of a plane of the lattice are closer to the solid than the surface.
fn inside_plane(map: &VolumeMap, iso: f64, lattice: &Lattice, k: usize) -> Vec<bool> {
    let [nx, ny, _] = lattice.points();
    let mut plane = vec![false; nx * ny];
    plane.par_chunks_mut(nx).enumerate().for_each(|(j, row)| {
        let points: Vec<DVec3> = (0..nx).map(|i| lattice.point([i, j, k])).collect();
        let mut values = Vec::<Values>::new();
        map.sample_batch(&points, &mut values);
        row.iter_mut().zip(&values).for_each(|(inside, values)| *inside = values.distance < iso);
    });
    plane
}

/// Places of the crossings; triangles that a point of the lattice has swallowed are left out.
fn finish(map: &VolumeMap, iso: f64, crossings: &Crossings, found: &[[u32; 3]]) -> IsoSurface {
    let lattice = crossings.lattice;
    let ends = |&(at, mask): &([usize; 3], u8)| [at, shifted(at, mask)];
    let place = |edge: &([usize; 3], u8)| {
        let [a, b] = ends(edge).map(|at| lattice.point(at));
        crossing(|t| map.values(a.lerp(b, t)).distance - iso)
    };
    let places: Vec<f64> = crossings.edges.par_iter().map(place).collect();
    let mut surface = IsoSurface::default();
    let mut snapped = HashMap::new();
    let mut number = |crossing: u32, surface: &mut IsoSurface| -> u32 {
        let (edge, t) = (&crossings.edges[crossing as usize], places[crossing as usize]);
        let [a, b] = ends(edge);
        // The first key is a point of the lattice, the second an edge.
        let (key, at) = match t {
            t if t <= SNAP => ((point_key(lattice, a), 0), lattice.point(a)),
            t if t >= 1.0 - SNAP => ((point_key(lattice, b), 0), lattice.point(b)),
            t => ((u64::from(crossing), 1), lattice.point(a).lerp(lattice.point(b), t)),
        };
        *snapped.entry(key).or_insert_with(|| {
            surface.vertices.push(at.to_array());
            surface.vertices.len() as u32 - 1
        })
    };
    for corners in found {
        let [a, b, c] = corners.map(|corner| number(corner, &mut surface));
        if a != b && b != c && c != a {
            surface.triangles.push([a, b, c]);
        }
    }
    surface.is_cut = crossings.edges.iter().any(|edge| lies_in_border(lattice, edge));
    without_unused(surface)
}

fn lies_in_border(lattice: &Lattice, &(at, mask): &([usize; 3], u8)) -> bool {
    let points = lattice.points();
    (0..3).any(|axis| mask >> axis & 1 == 0 && (at[axis] == 0 || at[axis] == points[axis] - 1))
}

/// Drops vertices whose triangles are all gone.
fn without_unused(surface: IsoSurface) -> IsoSurface {
    let mut numbers = vec![u32::MAX; surface.vertices.len()];
    let mut out = IsoSurface { is_cut: surface.is_cut, ..IsoSurface::default() };
    for corners in &surface.triangles {
        out.triangles.push(corners.map(|corner| {
            let number = &mut numbers[corner as usize];
            if *number == u32::MAX {
                *number = out.vertices.len() as u32;
                out.vertices.push(surface.vertices[corner as usize]);
            }
            *number
        }));
    }
    out
}

/// Where `f` is zero in [0, 1], at whose ends it has different signs: the regula falsi in the form called Illinois, and
/// bisection where `f` is infinite. Dowell and Jarratt 1971.
fn crossing(f: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (0.0, 1.0);
    let (mut fa, mut fb) = (f(a), f(b));
    if fa == 0.0 || fb == 0.0 {
        return if fa == 0.0 { a } else { b };
    }
    let mut last_was_low = None;
    for _ in 0..100 {
        let straight = (a * fb - b * fa) / (fb - fa);
        let t = if straight > a && straight < b { straight } else { 0.5 * (a + b) };
        let ft = f(t);
        if ft == 0.0 || (t - a).min(b - t) < 1e-15 {
            return t;
        }
        let is_low = (ft < 0.0) == (fa < 0.0);
        let repeated = last_was_low == Some(is_low);
        if is_low {
            (a, fa) = (t, ft);
            fb *= if repeated { 0.5 } else { 1.0 };
        } else {
            (b, fb) = (t, ft);
            fa *= if repeated { 0.5 } else { 1.0 };
        }
        last_was_low = Some(is_low);
    }
    if fa.abs() < fb.abs() { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crossings_are_found() {
        for root in [0.0, 1e-9, 0.3, 0.5, 1.0] {
            for cubic in [0.0, 5.0] {
                let f = |t: f64| (t - root) * (1.0 + cubic * t * t);
                for sign in [1.0, -1.0] {
                    let found = crossing(|t| sign * f(t));
                    assert!((found - root).abs() < 1e-13, "{root} {cubic}: {found}");
                }
            }
        }
        let far = |t: f64| if t < 0.7 { f64::NEG_INFINITY } else { t - 0.8 };
        assert!((crossing(far) - 0.8).abs() < 1e-13);
    }
}
