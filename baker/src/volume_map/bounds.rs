//! Cells in which the extension function is 0 or 1 everywhere.
//!
//! A polynomial stays within its Bernstein coefficients (Farouki and Rajan 1987). The 32 values of a cell determine a
//! polynomial of degree 3 in each variable, so a constant 64 x 32 matrix gives its coefficients; if all of them are
//! at least r, gamma*(Phi) is 0 in the whole cell, if none is above 0, it is 1.

use crate::sdf::field::DistanceField;
use glam::DVec3;
use rayon::prelude::*;
use volmap_runtime::NodeNumbers;
use volmap_runtime::serendipity::{NODES, shape};

/// What gamma*(Phi) is in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// 0: the whole cell is at least r away from the solid.
    Zero,
    /// 1: the whole cell is solid.
    One,
    /// Not known.
    Mixed,
}

/// The matrix from the values at a cell's nodes to Bernstein coefficients.
pub struct Bounds {
    rows: Vec<[f64; NODES]>,
}

/// From values at -1, -1/3, 1/3, 1 to the coefficients of the cubic Bernstein polynomials.
const TO_BERNSTEIN: [[f64; 4]; 4] = [
    [1.0, 0.0, 0.0, 0.0],
    [-5.0 / 6.0, 3.0, -1.5, 1.0 / 3.0],
    [1.0 / 3.0, -1.5, 3.0, -5.0 / 6.0],
    [0.0, 0.0, 0.0, 1.0],
];

impl Default for Bounds {
    fn default() -> Self {
        Bounds::new()
    }
}

impl Bounds {
    /// Computes the matrix.
    pub fn new() -> Bounds {
        let place = |i: usize| i as f64 / 1.5 - 1.0;
        let mut rows = vec![[0.0; NODES]; 64];
        for (b, row) in rows.iter_mut().enumerate() {
            for s in 0..64 {
                let axes = [0, 2, 4].map(|shift| (b >> shift & 3, s >> shift & 3));
                let factor: f64 = axes.iter().map(|&(b, s)| TO_BERNSTEIN[b][s]).product();
                let [x, y, z] = axes.map(|(_, s)| place(s));
                let shapes = shape(DVec3::new(x, y, z));
                row.iter_mut().zip(shapes).for_each(|(entry, n)| *entry += factor * n);
            }
        }
        Bounds { rows }
    }

    /// Lowest and highest Bernstein coefficient of the polynomial with these values.
    pub fn range(&self, values: &[f64; NODES]) -> (f64, f64) {
        let coefficient = |row: &[f64; NODES]| row.iter().zip(values).map(|(m, v)| m * v).sum::<f64>();
        let widen = |(low, high): (f64, f64), b: f64| (low.min(b), high.max(b));
        self.rows.iter().map(coefficient).fold((f64::INFINITY, f64::NEG_INFINITY), widen)
    }

    /// What gamma* is in every stored cell of the field, by the cell's number.
    pub fn contents(&self, field: &DistanceField, radius: f64) -> Vec<Content> {
        let cells: Vec<NodeNumbers> = field.cells.stored().collect();
        let content = |numbers: &NodeNumbers| {
            let values = numbers.all().map(|number| field.values[number as usize]);
            match self.range(&values) {
                (low, _) if low >= radius => Content::Zero,
                (_, high) if high <= 0.0 => Content::One,
                _ => Content::Mixed,
            }
        };
        cells.par_iter().map(content).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use volmap_runtime::serendipity::node;

    #[test]
    fn linear_functions_have_exact_bounds() {
        let values = std::array::from_fn(|a| node(a).dot(DVec3::new(1.0, 2.0, -0.5)) + 0.25);
        let (low, high) = Bounds::new().range(&values);
        assert!((low + 3.25).abs() < 1e-12 && (high - 3.75).abs() < 1e-12, "{low} {high}");
    }

    #[test]
    fn bounds_hold() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / (1u64 << 31) as f64
        };
        let bounds = Bounds::new();
        for _ in 0..200 {
            let values: [f64; NODES] = std::array::from_fn(|_| random());
            let (low, high) = bounds.range(&values);
            for _ in 0..50 {
                let xi = DVec3::new(random(), random(), random()) * 2.0 - DVec3::ONE;
                let value: f64 = shape(xi).iter().zip(values).map(|(n, v)| n * v).sum();
                assert!(low <= value && value <= high);
            }
        }
    }
}
