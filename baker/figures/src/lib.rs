//! Charts, coloured planes and pages: what a report draws. It knows no map. The same bytes on every machine.

mod escape;
pub mod page;
pub mod picture;
pub mod raster;
