//! Eq. 12 of Bender et al. 2020 at all nodes of a grid.
//!
//! On a regular lattice, the cell and the local coordinates of (node + quadrature point) depend only on the class
//! of the node: corner, or one of the two thirds of an edge along x, y or z; 7 classes. So the 32 shape values of a
//! (class, point) are computed once. The points of a class are grouped by the cell, relative to the node's, that
//! they fall into; sampling Phi for a row of nodes is then, for each group, a product of
//! [points of the group x 32] shape values with [32 x cells of the row] node values. Cells in which gamma* is known
//! to be 0 or 1 everywhere need no product.

use super::bounds::{Bounds, Content};
use super::dispatch::{self, Integral};
use super::kernel::{Block, LANES};
use super::quadrature::Point;
use crate::rows::{NodeRow, fill_rows};
use crate::sdf::field::DistanceField;
use glam::{DVec3, IVec3, UVec3};
use volmap_runtime::serendipity::{NODES, shape};
use volmap_runtime::{Cell, Family, Nodes};

/// The quadrature points of one class that fall into one cell.
struct Group {
    /// The cell, from the node's lattice point.
    cell: IVec3,
    /// Shape values and weights of its points.
    blocks: Vec<Block>,
    /// Sum of the weights.
    total: f64,
}

/// A rule laid out on a lattice of cells.
pub struct LatticeRule {
    /// Per family, per node of a lattice point.
    classes: [Vec<Vec<Group>>; 4],
    radius: f64,
    integral: Integral,
}

impl LatticeRule {
    /// Lays the rule's points (of the unit ball) out on cells of the given size; metres.
    pub fn new(points: &[Point], radius: f64, cell_size: DVec3) -> LatticeRule {
        let class = |family: Family, t: u32| groups(points, radius / cell_size, family.offset(t));
        let classes = Family::ALL
            .map(|family| (0..family.nodes_per_point()).map(|t| class(family, t)).collect::<Vec<_>>());
        LatticeRule { classes, radius, integral: dispatch::integral() }
    }

    /// Boundary volume at every node, m^3. The nodes' lattice lies `shift` cells inside the field's grid.
    pub fn volumes(&self, field: &DistanceField, nodes: &Nodes, shift: UVec3) -> Vec<f64> {
        let contents = Bounds::new().contents(field, self.radius);
        fill_rows(nodes, |row, out| {
            let per_point = row.family.nodes_per_point() as usize;
            for (t, class) in self.classes[row.family as usize].iter().enumerate() {
                let sums = out.iter_mut().skip(t).step_by(per_point);
                self.row((field, &contents), class, row, shift, sums);
            }
        })
    }

    fn row<'a>(
        &self,
        (field, contents): (&DistanceField, &[Content]),
        class: &[Group],
        row: NodeRow,
        shift: UVec3,
        out: impl Iterator<Item = &'a mut f64>,
    ) {
        let at = |node: u32, shift: u32, step: i32| i64::from(node) + i64::from(shift) + i64::from(step);
        let mut sums = vec![0.0; (row.end - row.first) as usize];
        for group in class {
            let (j, k) = (at(row.j, shift.y, group.cell.y), at(row.k, shift.z, group.cell.z));
            for (sum, i) in sums.iter_mut().zip(row.first..) {
                *sum += match field.cell(at(i, shift.x, group.cell.x), j, k) {
                    Cell::Fluid => 0.0,
                    Cell::Solid => group.total,
                    Cell::Band(numbers) if contents[numbers.cell()] == Content::Zero => 0.0,
                    Cell::Band(numbers) if contents[numbers.cell()] == Content::One => group.total,
                    Cell::Band(numbers) => {
                        let nodes = numbers.all().map(|number| field.values[number as usize]);
                        (self.integral)(&group.blocks, &nodes, 1.0 / self.radius)
                    }
                };
            }
        }
        let cube = self.radius.powi(3);
        out.zip(sums).for_each(|(value, sum)| *value = cube * sum);
    }
}

/// Groups the points around a node at `offset` (in cells) from its lattice point by the cell they fall into.
fn groups(points: &[Point], scale: DVec3, offset: DVec3) -> Vec<Group> {
    let place = |point: &Point| {
        let u = offset + scale * point.position;
        (u.floor().as_ivec3(), (u - u.floor()) * 2.0 - DVec3::ONE, point.weight)
    };
    let mut placed: Vec<(IVec3, DVec3, f64)> = points.iter().map(place).collect();
    // Stable: the order of the sum is that of the rule, on every machine.
    placed.sort_by_key(|(cell, ..)| (cell.z, cell.y, cell.x));
    let group = |members: &[(IVec3, DVec3, f64)]| Group {
        cell: members[0].0,
        blocks: members.chunks(LANES).map(block).collect(),
        total: members.iter().map(|(.., weight)| weight).sum(),
    };
    placed.chunk_by(|a, b| a.0 == b.0).map(group).collect()
}

fn block(members: &[(IVec3, DVec3, f64)]) -> Block {
    let mut block = Block { shape: [[0.0; LANES]; NODES], weights: [0.0; LANES] };
    for (lane, (_, xi, weight)) in members.iter().enumerate() {
        let shapes = shape(*xi);
        (0..NODES).for_each(|a| block.shape[a][lane] = shapes[a]);
        block.weights[lane] = *weight;
    }
    block
}
