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
    /// Place in the palette, of each stored cell.
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
        let of_cell = weights.of_cell.iter().map(|&at| places[at as usize]).collect();
        Walls { wall, palette, of_cell }
    }

    fn memory_bytes(&self) -> usize {
        size_of_val(self.palette.as_slice()) + size_of_val(self.of_cell.as_slice())
    }

    #[inline(always)]
    fn weights<V: Lanes>(&self, tree: &Tree, places: &[Place; LANES], f: &[V; 3]) -> Option<Weighted<V>> {
        let entry = |place: Place| self.of_cell[tree.cell(place)] as usize;
        let c: [V; 8] = if *places == [places[0]; LANES] {
            let entry = entry(places[0]);
            if entry == 0 {
                return None;
            }
            self.palette[entry].map(V::splat)
        } else {
            let entries = places.map(entry);
            if entries == [0; LANES] {
                return None;
            }
            let each = entries.map(|entry| self.palette[entry]);
            std::array::from_fn(|n| V::new(each.map(|coefficients| coefficients[n])))
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
        let scale = V::new(places.map(|place| self.tree.scale(place)));
        let axis = |per_cell: f64| V::splat(per_cell) * scale;
        OfLevels {
            per_cell: [axis(per_cell.x), axis(per_cell.y), axis(per_cell.z)],
            weighted: self.walls.as_ref().and_then(|walls| walls.weights(&self.tree, places, f)),
        }
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
        self.weighted.as_ref().map_or([V::splat(0.0); 2], |weighted| weighted.wall.at(distance))
    }

    #[inline(always)]
    fn volume(&self, [wall, _]: [V; 2], stored: V) -> V {
        self.weighted.as_ref().map_or(stored, |weighted| stored + weighted.weight * wall)
    }

    #[inline(always)]
    fn volume_slope(&self, [wall, along]: [V; 2], stored: [V; 3], distance: [V; 3]) -> [V; 3] {
        let Some(weighted) = &self.weighted else { return stored };
        let along = weighted.weight * along;
        let axis = |n: usize| stored[n] + (along * distance[n] + wall * weighted.slope[n]);
        [axis(0), axis(1), axis(2)]
    }
}
