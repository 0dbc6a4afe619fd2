//! Volume maps: Bender et al. 2020, sections 4.3 and 5.
//!
//! - [`extension`]: the cubic extension function, Eq. 13;
//! - [`quadrature`]: rules for the ball, Gauss-Legendre and product rules;
//! - [`bounds`]: cells whose interpolated Phi is known to be inside or beyond r;
//! - [`lattice`]: Eq. 12 at all nodes of the grid, in rows;
//! - `kernel`, `dispatch`: the inner loop, and the widest vectors that the processor has for it;
//! - [`oracle`]: Eq. 12 at any point, plain and slow, kept to test the other.

pub mod bounds;
mod dispatch;
pub mod extension;
mod kernel;
pub mod lattice;
pub mod oracle;
pub mod quadrature;
