//! The polynomial of a cell, cut at a plane and then at a line: what integrals along lines need of it.

use super::kernel::Content;
use volmap_runtime::layout::serendipity::NODES;
use volmap_runtime::layout::serendipity::monomials::{X2, X3, Y2, Y3, Z2, Z3};

/// What a cell holds.
#[derive(Clone, Copy, Debug)]
pub(super) struct BlockCell {
    pub content: Content,
    /// In the block's monomials, if the content is mixed.
    pub number: u32,
}

/// A cell at constant z: the coefficients of 1, y, y^2, y^3, the same times x, and of x^2, x^2 y, x^3,
/// x^3 y.
#[inline(always)]
pub(crate) fn surface_at(m: &[f64; NODES], z: f64) -> [f64; 12] {
    let base = |at: usize| m[at] + z * (m[at + 4] + z * (m[Z2 + at] + z * m[Z3 + at]));
    let low = |at: usize| m[at] + z * m[at + 2];
    let along_y = |x: usize| [base(x), base(x + 2), low(Y2 + x), low(Y3 + x)];
    let ([a, b, c, d], [e, f, g, h]) = (along_y(0), along_y(1));
    [a, b, c, d, e, f, g, h, low(X2), low(X2 + 1), low(X3), low(X3 + 1)]
}

/// The coefficients of 1, x, x^2, x^3 at constant y.
#[inline(always)]
pub(crate) fn cubic_on_line(c: &[f64; 12], y: f64) -> [f64; 4] {
    let constant = c[0] + y * (c[1] + y * (c[2] + y * c[3]));
    let linear = c[4] + y * (c[5] + y * (c[6] + y * c[7]));
    [constant, linear, c[8] + y * c[9], c[10] + y * c[11]]
}
