//! The cells of an adaptive map as the queries see them: several sizes, and volume as its difference from a flat wall's.

use crate::finder::{Finder, Frame};
use crate::flat_wall::FlatWall;
use crate::lanes::{LANES, Lanes};
use crate::layout::{CornerWeights, Found, Place, Starts, Tree, TreeHint};
use glam::{DVec3, UVec3};

/// Cells of several levels.
#[derive(Clone, Debug)]
pub(crate) struct AdaptiveCells {
    pub tree: Tree,
    pub walls: Option<Walls>,
}

/// Where the volume is stored as its difference from a flat wall's.
#[derive(Clone, Debug)]
pub(crate) struct Walls {
    wall: FlatWall,
    /// The different weights, as the coefficients of 1, x, y, z, xy, xz, yz, xyz. The first has none.
    palette: Vec<[f64; 8]>,
    /// Place in the palette, of each stored cell; empty if all have the last one.
    of_cell: Vec<u32>,
}

impl Walls {
    pub fn new(wall: FlatWall, weights: &CornerWeights) -> Walls {
        let without = weights.palette.iter().position(|corners| *corners == [0.0; 8]);
        let mut palette = vec![[0.0; 8]];
        let place = |(n, corners): (usize, &[f64; 8])| {
            if Some(n) == without {
                return 0;
            }
            palette.push(coefficients(corners));
            palette.len() as u32 - 1
        };
        let places: Vec<u32> = weights.palette.iter().enumerate().map(place).collect();
        let of_cell = match places[..] {
            [1] => Vec::new(),
            _ => weights.of_cell.iter().map(|&at| places[at as usize]).collect(),
        };
        Walls { wall, palette, of_cell }
    }

    fn memory_bytes(&self) -> usize {
        size_of_val(self.palette.as_slice()) + size_of_val(self.of_cell.as_slice())
    }

    #[inline(always)]
    fn entry(&self, tree: &Tree, place: Place) -> usize {
        match self.of_cell.is_empty() {
            true => 1,
            false => self.of_cell[tree.cell(place)] as usize,
        }
    }

    #[inline(always)]
    fn weights<V: Lanes>(&self, tree: &Tree, places: &[Place; LANES], f: &[V; 3]) -> Option<Weighted<V>> {
        let [p, q, r, s] = *places;
        let c: [V; 8] = if *places == [p; LANES] {
            let entry = self.entry(tree, p);
            if entry == 0 {
                return None;
            }
            splat(&self.palette[entry])
        } else {
            let entries =
                [self.entry(tree, p), self.entry(tree, q), self.entry(tree, r), self.entry(tree, s)];
            if entries == [0; LANES] {
                return None;
            }
            gather(&self.palette, entries)
        };
        let [x, y, z] = *f;
        let (along_x, along_y) = (c[5] + c[7] * y, c[6] + c[7] * x);
        let rise = (c[3] + c[5] * x) + y * along_y;
        let slope = [(c[1] + c[4] * y) + z * along_x, (c[2] + c[4] * x) + z * along_y, rise];
        Some(Weighted {
            wall: self.wall,
            weight: ((c[0] + c[1] * x) + y * (c[2] + c[4] * x)) + z * rise,
            slope,
        })
    }
}

// No closures in what follows: they would not be compiled for the processor that has the lanes.
#[inline(always)]
fn splat<V: Lanes>(c: &[f64; 8]) -> [V; 8] {
    let mut out = [V::splat(0.0); 8];
    for (out, &c) in out.iter_mut().zip(c) {
        *out = V::splat(c);
    }
    out
}

#[inline(always)]
fn gather<V: Lanes>(palette: &[[f64; 8]], [p, q, r, s]: [usize; LANES]) -> [V; 8] {
    let [p, q, r, s] = [&palette[p], &palette[q], &palette[r], &palette[s]];
    let mut out = [V::splat(0.0); 8];
    for (n, out) in out.iter_mut().enumerate() {
        *out = V::new([p[n], q[n], r[n], s[n]]);
    }
    out
}

/// Of the trilinear polynomial with these values at the corners of the unit cube.
fn coefficients(corners: &[f64; 8]) -> [f64; 8] {
    let [a, b, c, d, e, f, g, h] = *corners;
    [
        a,
        b - a,
        c - a,
        e - a,
        (d - c) - (b - a),
        (f - e) - (b - a),
        (g - e) - (c - a),
        (h - g) - (f - e) - ((d - c) - (b - a)),
    ]
}

impl AdaptiveCells {
    pub fn memory_bytes(&self) -> usize {
        self.tree.memory_bytes() + self.walls.as_ref().map_or(0, Walls::memory_bytes)
    }
}

impl Finder for AdaptiveCells {
    type Hint = TreeHint;
    type Frame<V: Lanes> = OfLevels<V>;

    #[inline(always)]
    fn hint(&self) -> TreeHint {
        TreeHint::NONE
    }

    #[inline(always)]
    fn place(&self, cell: UVec3, f: &mut DVec3, hint: &mut TreeHint) -> Found {
        self.tree.place(cell, f, hint)
    }

    #[inline(always)]
    fn starts(&self, place: Place) -> Starts {
        self.tree.starts(place)
    }

    #[inline(always)]
    fn frame<V: Lanes>(&self, per_cell: DVec3, places: &[Place; LANES], f: &[V; 3]) -> OfLevels<V> {
        let [p, q, r, s] = *places;
        let tree = &self.tree;
        let scale = V::new([tree.scale(p), tree.scale(q), tree.scale(r), tree.scale(s)]);
        let weighted = match &self.walls {
            Some(walls) => walls.weights(tree, places, f),
            None => None,
        };
        let per_cell =
            [V::splat(per_cell.x) * scale, V::splat(per_cell.y) * scale, V::splat(per_cell.z) * scale];
        OfLevels { per_cell, weighted }
    }
}

/// Cells of several sizes.
pub(crate) struct OfLevels<V> {
    per_cell: [V; 3],
    /// `None` where the volume is stored as it is.
    weighted: Option<Weighted<V>>,
}

/// How much of the volume is a flat wall's, and how that changes with the place in the cell.
struct Weighted<V> {
    wall: FlatWall,
    weight: V,
    slope: [V; 3],
}

impl<V: Lanes> Frame<V> for OfLevels<V> {
    /// The flat wall's volume and its derivative with respect to the distance.
    type Wall = [V; 2];

    #[inline(always)]
    fn per_cell(&self) -> [V; 3] {
        self.per_cell
    }

    #[inline(always)]
    fn wall(&self, distance: V) -> [V; 2] {
        match &self.weighted {
            Some(weighted) => weighted.wall.at(distance),
            None => [V::splat(0.0); 2],
        }
    }

    #[inline(always)]
    fn volume(&self, [wall, _]: [V; 2], stored: V) -> V {
        match &self.weighted {
            Some(weighted) => stored + weighted.weight * wall,
            None => stored,
        }
    }

    #[inline(always)]
    fn volume_slope(&self, [wall, along]: [V; 2], [x, y, z]: [V; 3], distance: [V; 3]) -> [V; 3] {
        let Some(weighted) = &self.weighted else { return [x, y, z] };
        let along = weighted.weight * along;
        [
            x + (along * distance[0] + wall * weighted.slope[0]),
            y + (along * distance[1] + wall * weighted.slope[1]),
            z + (along * distance[2] + wall * weighted.slope[2]),
        ]
    }
}
