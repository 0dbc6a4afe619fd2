//! A canyon: a winding river bed between terraced walls, closed by side walls and a floor to a solid.
//!
//! Its proportions are those of the map of Bender et al. 2020, Fig. 1 (128 x 64 x 768 cells): 6.4 m wide (x),
//! 3.2 m high (y), 38.4 m long (z). The bed falls towards +z; both of its ends are walled, so that water stays.

use glam::{DVec2, DVec3};

use crate::mesh::Mesh;
use crate::noise::{fractal, noise};

/// Width, height and length, m.
pub const SIZE: DVec3 = DVec3::new(6.4, 3.2, 38.4);
/// Squares of the height field along x and z.
const SQUARES: [u32; 2] = [64, 384];
/// Rows of quadrilaterals in the side walls.
const WALL_ROWS: u32 = 8;
/// The floor's squares are this many times as large as those of the height field.
const FLOOR_SQUARE: u32 = 8;

/// The closed canyon, from (-3.2, 0, 0) to (3.2, 3.2, 38.4).
pub fn canyon() -> Mesh {
    let mut mesh = Mesh::default();
    add_terrain(&mut mesh);
    let rim = rim();
    let foot = add_walls(&mut mesh, &rim);
    add_floor(&mut mesh, &rim, &foot);
    let half = 0.5 * SIZE.x;
    mesh.fit(DVec3::new(-half, 0.0, 0.0), DVec3::new(half, SIZE.y, SIZE.z));
    mesh
}

/// Point of the plane at column i and row k of the height field, m.
fn place(i: u32, k: u32) -> DVec2 {
    let [columns, rows] = SQUARES.map(f64::from);
    DVec2::new((f64::from(i) / columns - 0.5) * SIZE.x, f64::from(k) / rows * SIZE.z)
}

fn terrain_index(i: u32, k: u32) -> u32 {
    k * (SQUARES[0] + 1) + i
}

fn add_terrain(mesh: &mut Mesh) {
    for k in 0..=SQUARES[1] {
        for i in 0..=SQUARES[0] {
            let p = place(i, k);
            mesh.push(DVec3::new(p.x, height(p), p.y));
        }
    }
    for k in 0..SQUARES[1] {
        for i in 0..SQUARES[0] {
            mesh.push_quad(
                [(i, k), (i, k + 1), (i + 1, k + 1), (i + 1, k)].map(|(i, k)| terrain_index(i, k)),
            );
        }
    }
}

/// Column and row of the points around the height field, in the order in which a wall's outside is seen from
/// left to right.
fn rim() -> Vec<(u32, u32)> {
    let [columns, rows] = SQUARES;
    let front = (0..columns).map(|i| (columns - i, 0));
    let left = (0..rows).map(|k| (0, k));
    let back = (0..columns).map(|i| (i, rows));
    let right = (0..rows).map(|k| (columns, rows - k));
    front.chain(left).chain(back).chain(right).collect()
}

/// The side walls, from the rim down to y = 0; returns the vertices at their foot.
fn add_walls(mesh: &mut Mesh, rim: &[(u32, u32)]) -> Vec<u32> {
    let mut above: Vec<u32> = rim.iter().map(|&(i, k)| terrain_index(i, k)).collect();
    let tops = above.clone();
    for row in 1..=WALL_ROWS {
        let share = 1.0 - f64::from(row) / f64::from(WALL_ROWS);
        let below: Vec<u32> = tops
            .iter()
            .map(|&top| {
                let p = mesh.vertices[top as usize];
                mesh.push(DVec3::new(p.x, p.y * share, p.z))
            })
            .collect();
        for left in 0..rim.len() {
            let right = (left + 1) % rim.len();
            mesh.push_quad([below[left], below[right], above[right], above[left]]);
        }
        above = below;
    }
    above
}

/// The floor: large squares, each a fan around its middle, with the walls' foot points on the outer edges.
fn add_floor(mesh: &mut Mesh, rim: &[(u32, u32)], foot: &[u32]) {
    let mut floor = vec![u32::MAX; (terrain_index(SQUARES[0], SQUARES[1]) + 1) as usize];
    for (&(i, k), &vertex) in rim.iter().zip(foot) {
        floor[terrain_index(i, k) as usize] = vertex;
    }
    let flat = |i: u32, k: u32| DVec3::new(place(i, k).x, 0.0, place(i, k).y);
    let size = FLOOR_SQUARE;
    for k in (0..SQUARES[1]).step_by(size as usize) {
        for i in (0..SQUARES[0]).step_by(size as usize) {
            let mut ring = Vec::new();
            for side in 0..4 {
                for step in 0..size {
                    // Clockwise from above, which is counter-clockwise from below.
                    let (di, dk) = [(step, 0), (size, step), (size - step, size), (0, size - step)][side];
                    let slot = terrain_index(i + di, k + dk) as usize;
                    if floor[slot] == u32::MAX && step == 0 {
                        floor[slot] = mesh.push(flat(i + di, k + dk));
                    }
                    if floor[slot] != u32::MAX {
                        ring.push(floor[slot]);
                    }
                }
            }
            let middle = mesh.push(flat(i + size / 2, k + size / 2));
            for (j, &from) in ring.iter().enumerate() {
                mesh.triangles.push([middle, from, ring[(j + 1) % ring.len()]]);
            }
        }
    }
}

/// Height of the terrain above the floor at p = (x, z), before it is scaled to the box.
fn height(p: DVec2) -> f64 {
    let warped = p + DVec2::new(fractal(p / 1.7, 10, 3), fractal(p / 1.7, 20, 3)) * 0.3;
    let from_river = (warped.x - river(warped.y)).abs();
    let bed_half_width = 0.62 + 0.22 * noise(DVec2::new(0.5, p.y / 3.1), 30);
    let from_ends = (p.y - 1.2).min(SIZE.z - 1.2 - p.y) + 0.25 * fractal(p / 1.3, 40, 3);

    // 0 in the bed, 1 on the plateau.
    let side = ((from_river - bed_half_width) / 1.75).clamp(0.0, 1.0);
    let end = (-from_ends / 0.9).clamp(0.0, 1.0);
    let rise = side.max(end);
    let gullies = fractal(p / DVec2::new(1.6, 1.2), 50, 4);
    let wall = terraces((rise + 0.16 * gullies * smooth_step(rise * 2.0)).max(0.0));

    let bed = 0.62 - 0.30 * p.y / SIZE.z + 0.05 * fractal(p / 0.9, 60, 3) + 0.10 * side;
    let plateau = 0.22 * fractal(p / 1.9, 70, 4) * smooth_step(rise);
    bed + 2.1 * wall + plateau
}

/// The river's middle line: x at a given z, m. Two waves of incommensurate lengths.
fn river(z: f64) -> f64 {
    0.95 * wave(z / 11.3 + 0.1) + 0.38 * wave(z / 4.9 + 0.6)
}

/// A smooth wave of period 1 and height 1, like a sine but of parabolas.
fn wave(turns: f64) -> f64 {
    let t = (turns - turns.floor()) * 4.0 - 2.0;
    t * (2.0 - t.abs())
}

fn smooth_step(s: f64) -> f64 {
    let s = s.clamp(0.0, 1.0);
    s * s * (3.0 - 2.0 * s)
}

/// Turns a ramp from 0 to 1 into steps: steep faces, gently sloping ledges.
fn terraces(ramp: f64) -> f64 {
    const STEPS: f64 = 4.0;
    let scaled = ramp * STEPS;
    let step = scaled.floor();
    let inside = scaled - step;
    (step + 0.3 * inside + 0.7 * smooth_step(inside * 1.8 - 0.4)) / STEPS
}
