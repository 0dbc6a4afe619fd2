//! Winding numbers of a few points around a balanced surface, by counting crossings.
//!
//! A ray from the point to +x meets the surface; the sum of the crossings' directions is the winding
//! number. Whether it meets a triangle is decided side by side, each side seen the same way by all
//! triangles that share it (the half-open rule of Haines 1994, "Point in polygon strategies"), so that
//! a ray through an edge or a corner counts once. Linear in the triangles: a grid finds the points.

use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering::Relaxed};

use glam::{DVec3, Vec3Swizzles};
use rayon::prelude::*;
use volmap_formats::mesh::TriangleMesh;

use crate::mesh::parts::corners;

/// Tests for each point and triangle, on average, before it's given up. Fewer than ten are usual.
const MAX_TESTS: u64 = 1000;
/// Cells of the grid along an axis, at most.
const MAX_CELLS: usize = 1024;
/// Rounding error of the determinant of corners relative to a point, in units of its permanent: Shewchuk
/// 1997, "Adaptive precision floating-point arithmetic and fast robust geometric predicates".
const DETERMINANT_ERROR: f64 = 8e-16;

/// Winding numbers around points. A point on the surface, to rounding, gets `None` if it is a corner, and
/// else `None` or the number of either side. `triangles` of the mesh form a surface whose edges are run
/// through as often one way as the other. `None` for all if it would take too long.
pub fn winding_numbers(mesh: &TriangleMesh, triangles: &[u32], points: &[DVec3]) -> Option<Vec<Option<i64>>> {
    let grid = Grid::new(points);
    let turns: Vec<AtomicI64> = points.iter().map(|_| AtomicI64::new(0)).collect();
    let on_surface: Vec<AtomicBool> = points.iter().map(|_| AtomicBool::new(false)).collect();
    let allowed = MAX_TESTS.saturating_mul((triangles.len() + points.len()) as u64);
    let tests = AtomicU64::new(0);
    triangles.par_chunks(1 << 12).for_each(|chunk| {
        let mut tested = 0;
        for &triangle in chunk {
            let corners = corners(mesh, triangle as usize);
            tested += grid.visit(&corners, |k| match crossing(points[k as usize], &corners) {
                Crossing::None => {}
                Crossing::Turn(turn) => {
                    turns[k as usize].fetch_add(turn, Relaxed);
                }
                Crossing::OnSurface => on_surface[k as usize].store(true, Relaxed),
            });
            if tested > allowed {
                break;
            }
        }
        tests.fetch_add(tested, Relaxed);
    });
    let number = |(turns, on): (AtomicI64, AtomicBool)| (!on.into_inner()).then_some(turns.into_inner());
    (tests.into_inner() <= allowed).then(|| turns.into_iter().zip(on_surface).map(number).collect())
}

/// Points by their y and z.
struct Grid {
    lower: [f64; 2],
    upper: [f64; 2],
    /// Cells along an axis, and per length.
    cells: usize,
    density: [f64; 2],
    /// Points of each cell, one after the other, and where each cell ends.
    order: Vec<u32>,
    ends: Vec<u32>,
}

impl Grid {
    fn new(points: &[DVec3]) -> Grid {
        let axes = |p: &DVec3| [p.y, p.z];
        let fold = |start: f64, pick: fn(f64, f64) -> f64| {
            points.iter().map(axes).fold([start; 2], |m, p| [pick(m[0], p[0]), pick(m[1], p[1])])
        };
        let (lower, upper) = (fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max));
        let cells = (points.len() as f64).sqrt().ceil().clamp(1.0, MAX_CELLS as f64) as usize;
        let density = [0, 1].map(|i| cells as f64 / (upper[i] - lower[i]));
        let mut grid = Grid { lower, upper, cells, density, order: Vec::new(), ends: Vec::new() };
        let cell: Vec<usize> =
            points.iter().map(|p| grid.column(0, p.y) * cells + grid.column(1, p.z)).collect();
        grid.ends = vec![0; cells * cells];
        cell.iter().for_each(|&cell| grid.ends[cell] += 1);
        let mut next: Vec<u32> = Vec::with_capacity(cells * cells);
        let mut end = 0;
        for count in &mut grid.ends {
            next.push(end);
            end += *count;
            *count = end;
        }
        grid.order = vec![0; points.len()];
        for (k, &cell) in cell.iter().enumerate() {
            grid.order[next[cell] as usize] = k as u32;
            next[cell] += 1;
        }
        grid
    }

    /// Where a coordinate lies along an axis; grows with it. (A width of 0 makes 0 times infinity.)
    fn column(&self, axis: usize, coordinate: f64) -> usize {
        let place = (coordinate - self.lower[axis]) * self.density[axis];
        (place.max(0.0) as usize).min(self.cells - 1)
    }

    /// Calls for all points that the triangle could hide seen along x, and maybe more; how many.
    #[inline]
    fn visit(&self, corners: &[DVec3; 3], mut call: impl FnMut(u32)) -> u64 {
        let [a, b, c] = corners;
        // Without a thought for NaN, unlike `f64::min` and `f64::max`.
        let min = |a: f64, b: f64| if a < b { a } else { b };
        let max = |a: f64, b: f64| if a > b { a } else { b };
        let range = |[a, b, c]: [f64; 3]| (min(min(a, b), c), max(max(a, b), c));
        let (low, high) = range([a.y, b.y, c.y]);
        if low > self.upper[0] || high < self.lower[0] {
            return 0;
        }
        let rows = self.column(0, low)..=self.column(0, high);
        let (low, high) = range([a.z, b.z, c.z]);
        if low > self.upper[1] || high < self.lower[1] {
            return 0;
        }
        let (first, last) = (self.column(1, low), self.column(1, high));
        let mut count = 0;
        for row in rows {
            let cell = row * self.cells + first;
            let start = if cell == 0 { 0 } else { self.ends[cell - 1] };
            let points = start as usize..self.ends[row * self.cells + last] as usize;
            count += 1 + points.len() as u64;
            self.order[points].iter().for_each(|&k| call(k));
        }
        count
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Crossing {
    None,
    /// 1 where the ray leaves through the triangle's front, -1 where it enters.
    Turn(i64),
    OnSurface,
}

/// How the ray from `p` to +x meets a triangle.
fn crossing(p: DVec3, [a, b, c]: &[DVec3; 3]) -> Crossing {
    if p == *a || p == *b || p == *c {
        return Crossing::OnSurface;
    }
    let turn = passes(p, a, b) + passes(p, b, c) + passes(p, c, a);
    if turn == 0 || a.x.max(b.x).max(c.x) < p.x {
        return Crossing::None;
    }
    if a.x.min(b.x).min(c.x) > p.x {
        return Crossing::Turn(turn);
    }
    let [a, b, c] = [*a - p, *b - p, *c - p];
    let (forwards, backwards) = (b.yzx() * c.zxy(), b.zxy() * c.yzx());
    let ahead = a.dot(forwards - backwards) * turn as f64;
    let error = DETERMINANT_ERROR * a.abs().dot(forwards.abs() + backwards.abs());
    if ahead > error {
        Crossing::Turn(turn)
    } else if ahead < -error {
        Crossing::None
    } else {
        Crossing::OnSurface
    }
}

/// Seen from +x: 1 where the side passes p's y towards higher ones with p on its left, -1 the other way.
fn passes(p: DVec3, from: &DVec3, to: &DVec3) -> i64 {
    match (from.y <= p.y, to.y <= p.y) {
        (true, false) => i64::from(is_left(p, from, to)),
        (false, true) => -i64::from(is_left(p, to, from)),
        _ => 0,
    }
}

/// Asked of a side from its end of lower y to the other: the same answer for all its triangles.
fn is_left(p: DVec3, low: &DVec3, high: &DVec3) -> bool {
    (high.y - low.y) * (p.z - low.z) - (high.z - low.z) * (p.y - low.y) > 0.0
}
