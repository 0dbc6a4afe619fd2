//! Shapes to pixels, by tiny-skia.

use super::colours::{INK, Rgb, WHITE};
use super::drawing::{Anchor, Drawing, Paint, Pen, Shape, Text};
use super::font;
use super::png::{self, Effort};
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Path, PathBuilder, Pixmap, Stroke, StrokeDash, Transform,
};

/// Longest side of a picture, pixels.
const LONGEST: f64 = 16_384.0;

/// White pixels to draw on.
pub struct Canvas {
    pixmap: Pixmap,
}

impl Canvas {
    /// A white canvas, rounded up to whole pixels.
    pub fn new(size: [f64; 2]) -> Canvas {
        let [width, height] = size.map(|length| length.ceil().clamp(1.0, LONGEST) as u32);
        let mut pixmap = Pixmap::new(width, height).expect("not empty and not too large");
        pixmap.fill(Color::WHITE);
        Canvas { pixmap }
    }

    /// Sets the pixels of a rectangle; `colour` is asked for (across, down) from its upper left corner.
    pub fn image(&mut self, at: [f64; 2], size: [usize; 2], colour: impl Fn(usize, usize) -> Rgb) {
        let [left, top] = at.map(|x| x.round().max(0.0) as usize);
        let (width, height) = (self.pixmap.width() as usize, self.pixmap.height() as usize);
        let pixels = self.pixmap.pixels_mut();
        for y in 0..size[1].min(height.saturating_sub(top)) {
            for x in 0..size[0].min(width.saturating_sub(left)) {
                let [r, g, b] = colour(x, y);
                pixels[(top + y) * width + left + x] =
                    tiny_skia::ColorU8::from_rgba(r, g, b, 255).premultiply();
            }
        }
    }

    /// Draws shapes over what is there.
    pub fn draw(&mut self, drawing: &Drawing) {
        for shape in &drawing.shapes {
            match shape {
                Shape::Area { points, paint } => {
                    if let Some(path) = polygon(points, true) {
                        self.fill(&path, *paint);
                    }
                }
                Shape::Stroke { points, pen } => self.stroke(points, *pen),
                Shape::Text(text) => self.text(text),
            }
        }
    }

    /// The picture as a PNG file.
    pub fn to_png(&self) -> Vec<u8> {
        png::encode([self.pixmap.width(), self.pixmap.height()], &self.rgb(), Effort::Small)
    }

    /// The same in a third of the time, for pictures of which there are many; the file is somewhat larger.
    pub fn to_preview(&self) -> Vec<u8> {
        png::encode([self.pixmap.width(), self.pixmap.height()], &self.rgb(), Effort::Fast)
    }

    fn rgb(&self) -> Vec<u8> {
        let mut rgb = Vec::with_capacity(3 * self.pixmap.pixels().len());
        for pixel in self.pixmap.pixels() {
            rgb.extend_from_slice(&[pixel.red(), pixel.green(), pixel.blue()]);
        }
        rgb
    }

    fn fill(&mut self, path: &Path, paint: Paint) {
        self.pixmap.fill_path(path, &ink(paint), FillRule::Winding, Transform::identity(), None);
    }

    fn stroke(&mut self, points: &[[f64; 2]], pen: Pen) {
        let closed = points.len() > 2 && points.first() == points.last();
        let Some(path) = polygon(points, closed) else { return };
        let dash =
            pen.dashed.then(|| StrokeDash::new(vec![4.0 * pen.width as f32, 2.5 * pen.width as f32], 0.0));
        let mut stroke = Stroke {
            width: pen.width as f32,
            line_cap: LineCap::Butt,
            line_join: LineJoin::Round,
            dash: dash.flatten(),
            ..Stroke::default()
        };
        if pen.cased {
            let wide = Stroke { width: 2.2 * stroke.width, ..stroke.clone() };
            let white = ink(Paint::Colour(WHITE));
            self.pixmap.stroke_path(&path, &white, &wide, Transform::identity(), None);
            stroke.line_cap = LineCap::Round;
        }
        self.pixmap.stroke_path(&path, &ink(pen.paint), &stroke, Transform::identity(), None);
    }

    fn text(&mut self, text: &Text) {
        let width = font::width(&text.text, text.size);
        let back = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => 0.5 * width,
            Anchor::End => width,
        };
        let at = if text.turned { [text.at[0], text.at[1] + back] } else { [text.at[0] - back, text.at[1]] };
        if let Some(path) = font::outline(&text.text, text.size, at, text.turned) {
            self.fill(&path, text.paint);
        }
    }
}

fn polygon(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let (first, rest) = points.split_first()?;
    builder.move_to(first[0] as f32, first[1] as f32);
    rest.iter().for_each(|p| builder.line_to(p[0] as f32, p[1] as f32));
    if closed {
        builder.close();
    }
    builder.finish()
}

fn ink(paint: Paint) -> tiny_skia::Paint<'static> {
    let ([r, g, b], opacity) = match paint {
        Paint::Ink => (INK, 255),
        Paint::Faint => ([216, 216, 216], 255),
        Paint::Colour(rgb) => (rgb, 255),
        Paint::Wash(rgb) => (rgb, 64),
    };
    let mut paint = tiny_skia::Paint { anti_alias: true, ..tiny_skia::Paint::default() };
    paint.set_color_rgba8(r, g, b, opacity);
    paint
}
