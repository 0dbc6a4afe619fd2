//! Charts, coloured planes, pages and a rasteriser: what reports and simulations draw. It knows no map.
//!
//! - [`picture`]: figures of values on a plane, and charts, as PNG or SVG; colour bars; animated PNG.
//! - [`page`]: HTML pages in one file, without network.
//! - [`raster`]: triangles into a depth buffer.
//!
//! Guaranteed: the same bytes on every machine and on any number of threads.

mod escape;
pub mod page;
pub mod picture;
pub mod raster;
