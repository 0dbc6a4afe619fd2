//! Where everything of a panel goes, and its drawing.

use super::bar::{ColourBar, Room};
use super::canvas::Canvas;
use super::colours::{FLUID, Rgb, SOLID, WHITE};
use super::content::{Colouring, Line, Panel, Pixel};
use super::drawing::{Anchor, Drawing, Paint, Pen, Rect};
use super::frame::{Side, bottom_room, draw_frame, left_room};
use super::legend::{Legend, LegendEntry, Sign, ring};
use super::scale::Scale;

/// Lengths in pixels that all panels of a figure share.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Height of letters.
    pub text: f64,
    /// Between panels.
    pub gap: f64,
    /// Wanted length of a plot's longer side.
    plot: f64,
}

impl Style {
    /// For so many panels a row: print of 14 to 18 cm at 300 dots an inch, letters of about 7 points. Where the
    /// values have more pixels than that, everything grows with them.
    pub fn new(columns: usize, panels: &[Panel]) -> Style {
        let (text, plot) = match columns {
            1 => (30.0, 1180.0),
            2 => (28.0, 640.0),
            _ => (26.0, 460.0),
        };
        let longest = panels.iter().flat_map(|panel| panel.raster.lattice.size).max().unwrap_or(0);
        let growth = (longest as f64 / plot).max(1.0);
        Style { text: growth * text, gap: growth * 0.6 * text, plot: growth * plot }
    }
}

/// A panel and its places, counted from its upper left corner.
pub struct Layout<'a> {
    panel: &'a Panel,
    style: Style,
    /// Pixels of the picture for one of the values, along each side.
    scale: usize,
    plot: Rect,
    axes: [Scale; 2],
    bar: Option<ColourBar>,
    /// The bar is to the right.
    upright: bool,
    legend: Legend,
}

impl<'a> Layout<'a> {
    pub fn new(panel: &'a Panel, style: Style, entries: Vec<LegendEntry>) -> Layout<'a> {
        let lattice = &panel.raster.lattice;
        let longest = lattice.size[0].max(lattice.size[1]).max(1);
        let scale = ((style.plot / longest as f64).round() as usize).max(1);
        let [width, height] = lattice.size.map(|n| (scale * n) as f64);
        let (text, high) = (style.text, lattice.high());
        let limits = [0, 1].map(|a| [lattice.low[a], high[a]]);
        let axes = [
            Scale::linear(limits[0], ((width / (3.6 * text)) as usize).min(10)),
            Scale::linear(limits[1], ((height / (2.5 * text)) as usize).min(10)),
        ];
        let upright = height > 9.0 * text;
        let length = if upright { height } else { width };
        let bar = ColourBar::of_panel(
            &panel.colouring,
            &panel.raster.pixels,
            &panel.quantity,
            Room { length, upright, text },
        );
        let top = if panel.title.is_empty() { 0.5 * text } else { 1.7 * text };
        let plot = Rect { x: left_room(&axes[1], text).ceil(), y: top.ceil(), width, height };
        let right = if upright { bar.as_ref().map_or(0.0, ColourBar::depth) } else { 0.0 };
        let legend = Legend::new(entries, width + right, text);
        Layout { panel, style, scale, plot, axes, bar, upright, legend }
    }

    /// Width of all.
    pub fn width(&self) -> f64 {
        let beside =
            self.bar.as_ref().filter(|_| self.upright).map_or(0.5 * self.style.text, ColourBar::depth);
        (self.plot.right() + beside).max(self.plot.x + self.legend.width())
    }

    /// Height of all.
    pub fn height(&self) -> f64 {
        self.legend_top() + self.legend.height()
    }

    fn legend_top(&self) -> f64 {
        let below = self.bar.as_ref().filter(|_| !self.upright).map_or(0.0, ColourBar::depth);
        self.plot.bottom() + bottom_room(self.style.text) + below + 0.3 * self.style.text
    }

    /// Draws the panel with its upper left corner there.
    pub fn draw(&self, canvas: &mut Canvas, corner: [f64; 2]) {
        let [left, top] = corner.map(f64::round);
        let text = self.style.text;
        let plot = Rect { x: left + self.plot.x, y: top + self.plot.y, ..self.plot };
        let [width, height] = self.panel.raster.lattice.size;
        let colours: Vec<Rgb> = (0..width * height).map(|at| self.colour(at)).collect();
        let period = (0.62 * text).round().max(4.0) as usize;
        canvas.image([plot.x, plot.y], [self.scale * width, self.scale * height], |x, y| {
            let colour = colours[(height - 1 - y / self.scale) * width + x / self.scale];
            // Stripes, as grey alone could be taken for a value.
            if colour == SOLID && (x + y) % period < period / 5 { WHITE } else { colour }
        });
        let mut drawing = Drawing::default();
        self.draw_lines(&mut drawing, plot);
        let names = self.panel.raster.lattice.axes.map(|axis| axis.name());
        let side = |a: usize| Side { scale: &self.axes[a], title: self.axes[a].title(names[a], "m") };
        draw_frame(&mut drawing, plot, [&side(0), &side(1)], text, false);
        let above = [plot.at(0.5, 1.0)[0], plot.y - 0.6 * text];
        drawing.label(above, text, Anchor::Middle, &self.panel.title);
        self.legend.draw(&mut drawing, [plot.x, top + self.legend_top()]);
        canvas.draw(&drawing);
        match (&self.bar, self.upright) {
            (Some(bar), true) => bar.draw(canvas, [plot.right(), plot.y], plot.height),
            (Some(bar), false) => bar.draw(canvas, [plot.x, plot.bottom() + bottom_room(text)], plot.width),
            (None, _) => (),
        }
    }

    /// Colour of one of the values.
    fn colour(&self, at: usize) -> Rgb {
        let pixel = self.panel.raster.pixels.get(at).copied().unwrap_or(Pixel::Unknown);
        match (pixel, &self.panel.colouring, &self.bar) {
            (Pixel::Value(x), _, Some(bar)) if !x.is_nan() => bar.map.at(bar.scale.place(x)),
            (Pixel::Value(x), Colouring::Categories(all), _) if x >= 0.0 => {
                all.get(x as usize).map_or(WHITE, |category| category.colour)
            }
            (Pixel::Fluid, ..) => FLUID,
            (Pixel::Solid, ..) => SOLID,
            _ => WHITE,
        }
    }

    fn draw_lines(&self, drawing: &mut Drawing, plot: Rect) {
        let lattice = &self.panel.raster.lattice;
        let per_metre = self.scale as f64 / lattice.pixel;
        let place = |p: &[f64; 2]| {
            [
                plot.x + (p[0] - lattice.low[0]) * per_metre,
                plot.bottom() - (p[1] - lattice.low[1]) * per_metre,
            ]
        };
        for line in &self.panel.lines {
            let pen = pen(line, self.style.text);
            for curve in &line.curves {
                let points: Vec<[f64; 2]> = curve.iter().map(place).collect();
                drawing.stroke_within(&points, plot, pen);
            }
        }
        for marker in &self.panel.markers {
            let at = place(&marker.at);
            if plot.holds(at) {
                ring(drawing, at, 0.5 * self.style.text, marker.colour);
            }
        }
    }
}

fn pen(line: &Line, text: f64) -> Pen {
    let paint = Paint::Colour(line.colour);
    Pen { paint, width: 0.11 * text * line.width, dashed: line.dashed, cased: false }
}

/// What the legend explains: categories and regions that there are, curves and markers with a name.
pub fn entries(panel: &Panel, text: f64) -> Vec<LegendEntry> {
    let mut entries = Vec::new();
    let mut add = |sign: Sign, name: &str| entries.push(LegendEntry { sign, name: name.to_owned() });
    let pixels = &panel.raster.pixels;
    if let Colouring::Categories(all) = &panel.colouring {
        let named = all.iter().filter(|category| !category.name.is_empty());
        named.for_each(|category| add(Sign::Box(Paint::Colour(category.colour)), &category.name));
    }
    for line in panel.lines.iter().filter(|line| !line.name.is_empty()) {
        add(Sign::Line(pen(line, text)), &line.name);
    }
    for marker in panel.markers.iter().filter(|marker| !marker.name.is_empty()) {
        add(Sign::Ring(marker.colour), &marker.name);
    }
    if pixels.contains(&Pixel::Fluid) {
        add(Sign::Box(Paint::Colour(FLUID)), "fluid beyond the band");
    }
    if pixels.contains(&Pixel::Solid) {
        add(Sign::Striped(SOLID), "solid beyond the band");
    }
    let unknown =
        |pixel: &Pixel| matches!(pixel, Pixel::Unknown) || matches!(pixel, Pixel::Value(x) if x.is_nan());
    if pixels.len() < panel.raster.lattice.len() || pixels.iter().any(unknown) {
        add(Sign::Box(Paint::Colour(WHITE)), "unknown");
    }
    entries
}
