//! Volume maps: Bender et al. 2020, sections 4.3 and 5.
//!
//! - [`extension`]: the cubic extension function, Eq. 13;
//! - [`quadrature`]: rules for the ball, Gauss-Legendre and product rules;
//! - [`lattice`]: Eq. 12 at all nodes of the grid, in rows;
//! - `window`: rows of cells laid side by side, those known to be inside or beyond r among them;
//! - [`kernel`], [`dispatch`]: the inner loops, and their form for the processor at hand;
//! - [`anywhere`]: Eq. 12 at any point, for error maps;
//! - [`pixel_rows`], [`pixel_line`]: the same at the pixels of a slice, and its inner loop;
//! - `cell_cut`: a cell's polynomial at a plane and on a line;
//! - [`oracle`]: Eq. 12 at any point, plain and slow, kept to test the other.

pub mod anywhere;
pub(crate) mod cell_cut;
pub mod dispatch;
pub mod extension;
pub mod kernel;
pub mod lattice;
pub mod oracle;
pub mod pixel_line;
pub mod pixel_rows;
pub mod quadrature;
pub(crate) mod window;
