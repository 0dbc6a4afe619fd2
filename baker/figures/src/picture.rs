//! Pictures for print and for pages: values on a lattice of pixels, with contours, colour bars and axes in metres,
//! and charts. The model is Fig. 6 of Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*.
//!
//! ```text
//! PixelLattice -> Raster, Contour (marching squares, mesh section) -> Panel -> Figure -> PNG
//!                                                            series -> Chart  -> SVG or PNG
//! ```
//! [`animation`] strings pictures together (APNG). Guaranteed: the bytes of a picture depend on its content alone, not
//! on processor, threads or time.

pub mod animation;
pub mod bar;
pub mod canvas;
pub mod chart;
pub mod colours;
pub mod content;
pub mod contour;
pub mod drawing;
pub mod figure;
pub mod font;
mod frame;
pub mod lattice;
mod legend;
mod panel;
pub mod png;
pub mod scale;
mod svg;

pub use chart::{At, Chart, ChartAxis, Data, Mark, Series};
pub use colours::{ColourMap, Rgb};
pub use content::{Category, Colouring, Limits, Line, Marker, Panel, Pixel, Quantity, Raster};
pub use contour::{Polyline, contours, section};
pub use figure::Figure;
pub use lattice::{Axis, PixelLattice, Plane};
