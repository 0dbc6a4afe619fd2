//! The inner loop of the integral: gamma*(Phi) at the points of one cell, weighted and summed.
//!
//! Written for vectors of any width: every lane does the same operations in the same order, no fused ones, and the
//! lanes are summed in a fixed order. So the result has the same bits on every processor.

use super::extension::extension;
use volmap_runtime::serendipity::NODES;

/// Points that are worked on together.
pub const LANES: usize = 8;

/// Shape values and weights of up to [`LANES`] points in one cell; unused lanes have weight 0.
#[derive(Clone, Debug)]
pub struct Block {
    /// Per node, its shape value at each point.
    pub shape: [[f64; LANES]; NODES],
    /// Weight of each point.
    pub weights: [f64; LANES],
}

/// Weighted sum of gamma*(Phi) over the points of the blocks, Phi interpolated from the cell's 32 values.
#[inline(always)]
pub fn integral(blocks: &[Block], nodes: &[f64; NODES], inverse_radius: f64) -> f64 {
    let mut sums = [0.0; LANES];
    for block in blocks {
        let mut phi = [0.0; LANES];
        for (shape, node) in block.shape.iter().zip(nodes) {
            for lane in 0..LANES {
                phi[lane] += shape[lane] * node;
            }
        }
        for lane in 0..LANES {
            sums[lane] += block.weights[lane] * extension(phi[lane], inverse_radius);
        }
    }
    sums.iter().sum()
}
