//! Letters as outlines: DejaVu Sans, a subset of it (licence beside the file).

use std::sync::LazyLock;
use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, OutlineBuilder};

static FACE: LazyLock<Face<'static>> = LazyLock::new(|| {
    Face::parse(include_bytes!("DejaVuSans-subset.ttf"), 0).expect("the font of the program is whole")
});

/// Width of a line of text in the unit of `size`, the font's height.
pub fn width(text: &str, size: f64) -> f64 {
    let units: u32 = text.chars().map(|c| advance(glyph(c))).sum();
    f64::from(units) * size / f64::from(FACE.units_per_em())
}

/// The outline of a line of text that starts at `at` on its base line, to the right or (`turned`) upwards.
pub fn outline(text: &str, size: f64, at: [f64; 2], turned: bool) -> Option<Path> {
    let scale = size / f64::from(FACE.units_per_em());
    let mut pen = GlyphPen { builder: PathBuilder::new(), at, along: 0, scale, turned };
    for c in text.chars() {
        let glyph = glyph(c);
        FACE.outline_glyph(glyph, &mut pen);
        pen.along += advance(glyph);
    }
    pen.builder.finish()
}

/// Glyph 0, a box, stands for what the font doesn't have.
fn glyph(c: char) -> ttf_parser::GlyphId {
    FACE.glyph_index(if c.is_control() { ' ' } else { c }).unwrap_or_default()
}

fn advance(glyph: ttf_parser::GlyphId) -> u32 {
    FACE.glyph_hor_advance(glyph).unwrap_or(0).into()
}

struct GlyphPen {
    builder: PathBuilder,
    at: [f64; 2],
    along: u32,
    scale: f64,
    turned: bool,
}

impl GlyphPen {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        let (x, y) = ((f64::from(x) + f64::from(self.along)) * self.scale, f64::from(y) * self.scale);
        let [dx, dy] = if self.turned { [-y, -x] } else { [x, -y] };
        ((self.at[0] + dx) as f32, (self.at[1] + dy) as f32)
    }
}

impl OutlineBuilder for GlyphPen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.builder.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.builder.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.builder.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.builder.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_of_the_pictures_are_there() {
        for c in "AZaz09 −·⁰¹²³⁴⁵⁶⁷⁸⁹⁻³Φ°×ß≤%é–…".chars() {
            assert!(FACE.glyph_index(c).is_some(), "{c}");
        }
        assert!(width("mmm", 30.0) > width("iii", 30.0));
        assert!(
            outline("x", 30.0, [0.0; 2], false).is_some() && outline(" ", 30.0, [0.0; 2], false).is_none()
        );
        assert!(outline("漢\u{7}", 30.0, [0.0; 2], true).is_some(), "a box");
    }
}
