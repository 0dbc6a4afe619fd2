//! Eq. 12 of Bender et al. 2020 at any point, on a tree of cells: what the oracle does, along the lines of a rule.

use super::distance_tree::{DistanceTree, Leaf};
use crate::volume_map::anywhere::{LineRule, floor, sum_on_line};
use crate::volume_map::cell_cut::{cubic_on_line, surface_at};
use crate::volume_map::kernel::Content;
use glam::{DVec3, IVec3};
use volmap_formats::asset::Exterior;

/// A tree and a rule, ready for integrals over balls of the tree's radius.
pub struct TreeIntegrator<'a> {
    tree: &'a DistanceTree,
    rule: &'a LineRule,
    /// Support radius, metres.
    radius: f64,
    /// The same in finest cells, by axis.
    reach: DVec3,
    /// Finest cells along x, y and z.
    resolution: IVec3,
    /// Content beyond the grid.
    beyond: Content,
}

impl<'a> TreeIntegrator<'a> {
    /// For the support radius in metres that the tree was made for.
    pub fn new(tree: &'a DistanceTree, rule: &'a LineRule, radius: f64) -> TreeIntegrator<'a> {
        let finest = tree.lattice.finest();
        let beyond = if tree.exterior == Exterior::Solid { Content::One } else { Content::Zero };
        TreeIntegrator {
            tree,
            rule,
            radius,
            reach: radius / tree.lattice.cell_size(finest),
            resolution: (tree.resolution() << finest).as_ivec3(),
            beyond,
        }
    }

    /// Boundary volume at a point, m^3.
    pub fn volume(&self, x: DVec3) -> f64 {
        let lattice = &self.tree.lattice;
        let place = (x - lattice.grid().origin) / lattice.cell_size(lattice.finest());
        let mut sum = 0.0;
        for line in &self.rule.lines {
            let (y, z) = (place.y + self.reach.y * line.y, place.z + self.reach.z * line.z);
            sum += self.along(line.first..line.end, place.x, [y, z]);
        }
        self.radius.powi(3) * sum
    }

    /// Over the points of one line, which lies at y and z in finest cells around the place x.
    #[inline(always)]
    fn along(&self, points: std::ops::Range<usize>, place: f64, [y, z]: [f64; 2]) -> f64 {
        let (rule, reach) = (self.rule, self.reach.x);
        let (j, k) = (floor(y) as i32, floor(z) as i32);
        let (mut sum, mut at) = (0.0, points.start);
        let in_grid = (0..self.resolution.y).contains(&j) && (0..self.resolution.z).contains(&k);
        while at < points.end {
            let first = place + reach * rule.x[at];
            let i = floor(first) as i32;
            let (leaf, low, size) = match in_grid && (0..self.resolution.x).contains(&i) {
                true => self.leaf_at(IVec3::new(i, j, k)),
                false => (Leaf { level: 0, content: self.beyond, number: 0 }, IVec3::new(i, 0, 0), 1),
            };
            let end = f64::from(low.x + size);
            let own = &rule.x[at..points.end];
            // Rounding may take a point to the cell before; there it is as good.
            let count = own.iter().take_while(|x| place + reach * **x < end).count().max(1);
            match leaf.content {
                Content::Zero => {}
                Content::One => sum += rule.summed[at + count] - rule.summed[at],
                Content::Mixed => {
                    let scale = 2.0 / f64::from(size);
                    let local = |x: f64, low: i32| scale * (x - f64::from(low)) - 1.0;
                    let polynomial = &self.tree.polynomials[leaf.number as usize];
                    let surface = surface_at(polynomial, local(z, low.z));
                    let cubic = cubic_on_line(&surface, local(y, low.y));
                    let offset = local(place, low.x);
                    sum += sum_on_line(&cubic, offset, scale * reach, &own[..count], &rule.weight[at..]);
                }
            }
            at += count;
        }
        sum
    }

    /// The leaf that holds a finest cell, with its lowest corner and its size in finest cells.
    #[inline(always)]
    fn leaf_at(&self, at: IVec3) -> (Leaf, IVec3, i32) {
        let leaf = self.tree.leaf(at.as_uvec3());
        let shift = self.tree.lattice.finest() - leaf.level;
        (leaf, (at >> shift) << shift, 1 << shift)
    }
}
