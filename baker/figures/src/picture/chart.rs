//! Charts of numbers: curves, bands between percentiles, bars; as SVG for pages, as PNG for print.

use super::canvas::Canvas;
use super::colours::Rgb;
use super::content::{Limits, Quantity};
use super::drawing::{Drawing, Paint, Pen, Rect};
use super::frame::{Side, bottom_room, draw_frame, left_room};
use super::legend::{Legend, LegendEntry, Sign};
use super::scale::Scale;
use super::svg::svg;

/// A chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Read out in place of the chart; not drawn, as a caption says it.
    pub title: String,
    /// To the right.
    pub x: ChartAxis,
    /// Up.
    pub y: ChartAxis,
    /// From the lowest up.
    pub series: Vec<Series>,
    /// Lines at single numbers.
    pub marks: Vec<Mark>,
}

/// An axis of a chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ChartAxis {
    /// What it shows.
    pub quantity: Quantity,
    /// Logarithmic; numbers that aren't positive are not shown.
    pub log: bool,
    /// Its ends; those of the series (with bars: from zero) if they aren't given.
    pub limits: Limits,
}

/// Numbers and how they are shown. A NaN interrupts curves and bands.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// For the legend; empty: not in it.
    pub name: String,
    /// Colour; bands and bars are lighter.
    pub colour: Rgb,
    /// The numbers.
    pub data: Data,
}

/// Numbers of a series.
#[derive(Clone, Debug, PartialEq)]
pub enum Data {
    /// Points (x, y) joined by lines.
    Curve(Vec<[f64; 2]>),
    /// Points (x, y) joined by dashes.
    Dashes(Vec<[f64; 2]>),
    /// The area between two curves: (x, lower y, upper y).
    Band(Vec<[f64; 3]>),
    /// Bars side by side: (left x, right x, height).
    Bars(Vec<[f64; 3]>),
}

/// A dashed line across the chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// For the legend; empty: not in it.
    pub name: String,
    /// Colour.
    pub colour: Rgb,
    /// Where.
    pub at: At,
}

/// Place of a mark.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum At {
    /// Upright, at a number of the horizontal axis.
    X(f64),
    /// Level, at a number of the vertical axis.
    Y(f64),
}

impl Chart {
    /// As an `svg` element that is as wide as its place and takes the page's colour of text.
    pub fn to_svg(&self) -> String {
        let (drawing, size) = self.draw(480.0, 13.0);
        svg(&drawing, size, &self.title)
    }

    /// As a PNG file, 1,600 pixels wide.
    pub fn to_png(&self) -> Vec<u8> {
        let (drawing, size) = self.draw(1600.0, 34.0);
        let mut canvas = Canvas::new(size);
        canvas.draw(&drawing);
        canvas.to_png()
    }

    fn draw(&self, width: f64, text: f64) -> (Drawing, [f64; 2]) {
        let height = 0.55 * width;
        let y = scale(&self.y, self.with_room(self.extent(1)), (height / (2.5 * text)) as usize);
        let left = left_room(&y, text);
        let right = 1.5 * text;
        let x = scale(&self.x, self.extent(0), ((width - left - right) / (4.5 * text)) as usize);
        let plot = Rect { x: left, y: 0.8 * text, width: width - left - right, height };
        let mut drawing = Drawing::default();
        let title = |axis: &ChartAxis, scale: &Scale| scale.title(&axis.quantity.name, &axis.quantity.unit);
        let sides =
            [Side { scale: &x, title: title(&self.x, &x) }, Side { scale: &y, title: title(&self.y, &y) }];
        let plotter = Plotter { plot, x: &x, y: &y, text };
        self.series.iter().filter(|s| s.is_area()).for_each(|s| plotter.series(&mut drawing, s));
        draw_frame(&mut drawing, plot, [&sides[0], &sides[1]], text, true);
        self.series.iter().filter(|s| !s.is_area()).for_each(|s| plotter.series(&mut drawing, s));
        self.marks.iter().for_each(|mark| plotter.mark(&mut drawing, mark));
        let legend = Legend::new(self.entries(text), width - left, text);
        let top = plot.bottom() + bottom_room(text) + 0.2 * text;
        legend.draw(&mut drawing, [left, top]);
        (drawing, [width, top + legend.height() + 0.4 * text])
    }

    /// Lowest and highest finite number of all series along an axis; on a logarithmic one of the positive ones.
    fn extent(&self, axis: usize) -> [f64; 2] {
        let log = [&self.x, &self.y][axis].log;
        let mut extent = [f64::INFINITY, f64::NEG_INFINITY];
        let mut hold = |value: f64| {
            if value.is_finite() && (!log || value > 0.0) {
                extent = [extent[0].min(value), extent[1].max(value)];
            }
        };
        for series in &self.series {
            match (&series.data, axis) {
                (Data::Curve(points) | Data::Dashes(points), _) => points.iter().for_each(|p| hold(p[axis])),
                (Data::Band(points), 0) => points.iter().for_each(|p| hold(p[0])),
                (Data::Band(points), _) => points.iter().flat_map(|p| [p[1], p[2]]).for_each(&mut hold),
                (Data::Bars(bars), 0) => bars.iter().flat_map(|p| [p[0], p[1]]).for_each(&mut hold),
                (Data::Bars(bars), _) => bars.iter().flat_map(|p| [0.0, p[2]]).for_each(&mut hold),
            }
        }
        for mark in &self.marks {
            match (mark.at, axis) {
                (At::X(value), 0) | (At::Y(value), 1) => hold(value),
                _ => (),
            }
        }
        extent
    }

    /// The vertical extent with zero, if that is near, and some room.
    fn with_room(&self, [low, high]: [f64; 2]) -> [f64; 2] {
        match self.y.log {
            true => [low / 1.3, high * 1.3],
            false if low >= 0.0 && low < 0.5 * high => [0.0, 1.05 * high],
            false => [low - 0.05 * (high - low), high + 0.05 * (high - low)],
        }
    }

    fn entries(&self, text: f64) -> Vec<LegendEntry> {
        // Bands of one colour lie over each other.
        let layers = |end: usize, colour: Rgb| {
            let same = |series: &&Series| matches!(series.data, Data::Band(_)) && series.colour == colour;
            self.series[..=end].iter().filter(same).count()
        };
        let series = self.series.iter().enumerate().map(|(number, series)| {
            let sign = match series.data {
                Data::Curve(_) => Sign::Line(pen(series.colour, text)),
                Data::Dashes(_) => Sign::Line(Pen { dashed: true, ..pen(series.colour, text) }),
                Data::Band(_) => Sign::Washes(series.colour, layers(number, series.colour)),
                Data::Bars(_) => Sign::Box(Paint::Wash(series.colour)),
            };
            LegendEntry { sign, name: series.name.clone() }
        });
        let marks = self.marks.iter().map(|mark| {
            let sign = Sign::Line(Pen { dashed: true, ..pen(mark.colour, text) });
            LegendEntry { sign, name: mark.name.clone() }
        });
        series.chain(marks).filter(|entry| !entry.name.is_empty()).collect()
    }
}

impl Series {
    fn is_area(&self) -> bool {
        matches!(self.data, Data::Band(_) | Data::Bars(_))
    }
}

fn scale(axis: &ChartAxis, extent: [f64; 2], most: usize) -> Scale {
    let limits = match axis.limits {
        Limits::Given(limits) => limits,
        Limits::Auto => extent,
    };
    match axis.log {
        true => Scale::log(limits, most),
        false => Scale::linear(limits, most),
    }
}

fn pen(colour: Rgb, text: f64) -> Pen {
    Pen::new(Paint::Colour(colour), 0.13 * text)
}

struct Plotter<'a> {
    plot: Rect,
    x: &'a Scale,
    y: &'a Scale,
    text: f64,
}

impl Plotter<'_> {
    fn at(&self, x: f64, y: f64) -> [f64; 2] {
        self.plot.at(self.x.place(x), self.y.place(y))
    }

    fn series(&self, drawing: &mut Drawing, series: &Series) {
        let pen = pen(series.colour, self.text);
        match &series.data {
            Data::Curve(points) => self.curve(drawing, points, pen),
            Data::Dashes(points) => self.curve(drawing, points, Pen { dashed: true, ..pen }),
            Data::Band(points) => self.band(drawing, points, series.colour),
            Data::Bars(bars) => bars.iter().for_each(|bar| self.bar(drawing, *bar, series.colour)),
        }
    }

    fn curve(&self, drawing: &mut Drawing, points: &[[f64; 2]], pen: Pen) {
        let places: Vec<[f64; 2]> = points.iter().map(|p| self.at(p[0], p[1])).collect();
        drawing.stroke_within(&places, self.plot, pen);
    }

    /// Unbroken pieces of the band; what lies beyond the chart is pushed to its border.
    fn band(&self, drawing: &mut Drawing, points: &[[f64; 3]], colour: Rgb) {
        for piece in points.split(|p| p.iter().any(|x| x.is_nan())).filter(|piece| piece.len() > 1) {
            let lower = piece.iter().map(|p| self.held(p[0], p[1]));
            let upper = piece.iter().rev().map(|p| self.held(p[0], p[2]));
            drawing.area(lower.chain(upper).collect(), Paint::Wash(colour));
        }
    }

    fn bar(&self, drawing: &mut Drawing, [left, right, height]: [f64; 3], colour: Rgb) {
        if [left, right, height].iter().any(|x| x.is_nan()) {
            return;
        }
        let base = if self.y.log { self.y.limits[0] } else { 0.0 };
        let corners = vec![
            self.held(left, base),
            self.held(right, base),
            self.held(right, height),
            self.held(left, height),
        ];
        drawing.area(corners.clone(), Paint::Wash(colour));
        drawing.stroke(
            [&corners[..], &corners[..1]].concat(),
            Pen::new(Paint::Colour(colour), 0.06 * self.text),
        );
    }

    fn held(&self, x: f64, y: f64) -> [f64; 2] {
        self.plot.at(self.x.place(x).clamp(0.0, 1.0), self.y.place(y).clamp(0.0, 1.0))
    }

    fn mark(&self, drawing: &mut Drawing, mark: &Mark) {
        let ends = match mark.at {
            At::X(x) => [0.0, 1.0].map(|up| self.plot.at(self.x.place(x), up)),
            At::Y(y) => [0.0, 1.0].map(|across| self.plot.at(across, self.y.place(y))),
        };
        drawing.stroke_within(&ends, self.plot, Pen { dashed: true, ..pen(mark.colour, self.text) });
    }
}
