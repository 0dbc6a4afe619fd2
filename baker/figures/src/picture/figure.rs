//! What a figure shows: panels of values on pixels, with curves, markers, colour bar and axes.

use super::canvas::Canvas;
use super::colours::{ColourMap, Rgb};
use super::contour::Polyline;
use super::drawing::{Anchor, Drawing};
use super::lattice::PixelLattice;
use super::legend::{Entry, Legend};
use super::panel::{Layout, Style, entries};

/// One or several panels, as one picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Figure {
    /// Above all panels; may be empty.
    pub title: String,
    /// Panels, row by row.
    pub panels: Vec<Panel>,
    /// Panels a row, at least 1.
    pub columns: usize,
}

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

impl Figure {
    /// A figure of one panel, without a title of its own.
    pub fn of(panel: Panel) -> Figure {
        Figure { title: String::new(), panels: vec![panel], columns: 1 }
    }

    /// The picture as a PNG file: about 1,600 pixels wide, 300 an inch, white behind.
    pub fn to_png(&self) -> Vec<u8> {
        let columns = self.columns.clamp(1, self.panels.len().max(1));
        let style = Style::new(columns, &self.panels);
        let (shared, own) = self.legends(&style);
        let layouts: Vec<Layout> =
            self.panels.iter().zip(own).map(|(panel, own)| Layout::new(panel, style, own)).collect();
        let rows: Vec<&[Layout]> = layouts.chunks(columns).collect();
        let column = |c: usize| rows.iter().filter_map(move |row| row.get(c));
        let widths: Vec<f64> = (0..columns).map(|c| largest(column(c), Layout::width)).collect();
        let heights: Vec<f64> = rows.iter().map(|row| largest(row.iter(), Layout::height)).collect();
        let head = style.gap + if self.title.is_empty() { 0.0 } else { 1.8 * style.text };
        let all = |lengths: &[f64]| lengths.iter().map(|length| length + style.gap).sum::<f64>();
        let width = style.gap + all(&widths);
        let legend = Legend::new(shared, width - 4.0 * style.gap, style.text);
        let foot = if legend.height() > 0.0 { legend.height() + style.gap } else { 0.0 };
        let mut canvas = Canvas::new([width, head + all(&heights) + foot]);
        let mut y = head;
        for (row, height) in rows.iter().zip(&heights) {
            let mut x = style.gap;
            for (layout, width) in row.iter().zip(&widths) {
                layout.draw(&mut canvas, [x, y]);
                x += width + style.gap;
            }
            y += height + style.gap;
        }
        let mut around = Drawing::default();
        around.label([0.5 * width, style.gap + style.text], 1.2 * style.text, Anchor::Middle, &self.title);
        legend.draw(&mut around, [2.0 * style.gap, y]);
        canvas.draw(&around);
        canvas.to_png()
    }

    /// What several panels have in common is explained once, below them; the rest by each panel.
    fn legends(&self, style: &Style) -> (Vec<Entry>, Vec<Vec<Entry>>) {
        let all: Vec<Vec<Entry>> = self.panels.iter().map(|panel| entries(panel, style.text)).collect();
        let common = |entry: &Entry| all.iter().filter(|own| own.contains(entry)).count() > 1;
        let mut shared: Vec<Entry> = Vec::new();
        for entry in all.iter().flatten().filter(|entry| common(entry)) {
            if !shared.contains(entry) {
                shared.push(entry.clone());
            }
        }
        let own =
            all.iter().map(|own| own.iter().filter(|entry| !common(entry)).cloned().collect()).collect();
        (shared, own)
    }
}

fn largest<'a>(layouts: impl Iterator<Item = &'a Layout<'a>>, length: impl Fn(&Layout<'a>) -> f64) -> f64 {
    layouts.map(length).fold(0.0, f64::max)
}
