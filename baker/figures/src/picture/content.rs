//! What a panel of a figure shows: values on pixels, with curves and markers.

use super::colours::{ColourMap, Rgb};
use super::contour::Polyline;
use super::lattice::PixelLattice;

/// Values on a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Above the panel; may be empty.
    pub title: String,
    /// Values.
    pub raster: Raster,
    /// What they are.
    pub quantity: Quantity,
    /// Their colours.
    pub colouring: Colouring,
    /// Curves, drawn in this order over the values.
    pub lines: Vec<Line>,
    /// Points, over the curves.
    pub markers: Vec<Marker>,
}

/// What is known of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pixel {
    /// A value in the quantity's unit; of categories, the number of one. NaN is [`Pixel::Unknown`].
    Value(f64),
    /// Outside the band, in the fluid.
    Fluid,
    /// Beyond the band, in the solid.
    Solid,
    /// Not computed.
    Unknown,
}

/// Pixels on a lattice, i fastest, from the lowest row up.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Where they are.
    pub lattice: PixelLattice,
    /// As many as the lattice has; those that are missing are unknown.
    pub pixels: Vec<Pixel>,
}

/// Name and unit of a number, as `volume` in `m³`; the unit may be empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Quantity {
    /// Name.
    pub name: String,
    /// Unit.
    pub unit: String,
}

impl Quantity {
    /// A quantity.
    pub fn new(name: impl Into<String>, unit: impl Into<String>) -> Quantity {
        Quantity { name: name.into(), unit: unit.into() }
    }
}

/// How values become colours.
#[derive(Clone, Debug, PartialEq)]
pub enum Colouring {
    /// In proportion.
    Linear(ColourMap, Limits),
    /// By the logarithm; values of at most the lower limit, zero among them, have the first colour.
    Log(ColourMap, Limits),
    /// The value n stands for category n.
    Categories(Vec<Category>),
}

/// Values at the ends of the colour map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Limits {
    /// Those of the panel's values; of a diverging map balanced about zero; of logarithms at most 4 decades.
    #[default]
    Auto,
    /// Given ones; values beyond have the end's colour, and the bar an arrow there.
    Given([f64; 2]),
}

/// A kind of pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Category {
    /// For the legend; empty: not in it.
    pub name: String,
    /// Colour.
    pub colour: Rgb,
}

/// Curves of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// For the legend; empty: not in it.
    pub name: String,
    /// Curves, metres along the lattice's axes.
    pub curves: Vec<Polyline>,
    /// Colour.
    pub colour: Rgb,
    /// Width as a part of the usual one.
    pub width: f64,
    /// Dashed.
    pub dashed: bool,
}

impl Line {
    /// A whole line of usual width.
    pub fn new(name: impl Into<String>, curves: Vec<Polyline>, colour: Rgb) -> Line {
        Line { name: name.into(), curves, colour, width: 1.0, dashed: false }
    }
}

/// A marked point: a cross in a ring.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// For the legend; empty: not in it.
    pub name: String,
    /// Metres along the lattice's axes.
    pub at: [f64; 2],
    /// Colour.
    pub colour: Rgb,
}
