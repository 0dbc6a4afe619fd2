//! What signs and colours mean, in rows below a plot, so that they hide no value.

use super::colours::{Rgb, SOLID, WHITE};
use super::drawing::{Anchor, Drawing, Paint, Pen, Rect};
use super::font;

/// A sign and its meaning.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendEntry {
    pub sign: Sign,
    pub name: String,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    Line(Pen),
    Ring(Rgb),
    Box(Paint),
    /// So many washes of a colour over each other.
    Washes(Rgb, usize),
    /// A box with stripes.
    Striped(Rgb),
}

/// Entries in rows that are at most as wide as the legend, where they can be.
pub struct Legend {
    rows: Vec<Vec<(f64, LegendEntry)>>,
    text: f64,
}

const ROW: f64 = 1.5;

impl Legend {
    pub fn new(entries: Vec<LegendEntry>, width: f64, text: f64) -> Legend {
        let mut rows: Vec<Vec<(f64, LegendEntry)>> = Vec::new();
        let mut x = 0.0;
        for entry in entries {
            let own = 2.2 * text + font::width(&entry.name, text) + 1.4 * text;
            if rows.is_empty() || x + own - 1.4 * text > width {
                rows.push(Vec::new());
                x = 0.0;
            }
            rows.last_mut().expect("just made").push((x, entry));
            x += own;
        }
        Legend { rows, text }
    }

    pub fn height(&self) -> f64 {
        ROW * self.text * self.rows.len() as f64
    }

    pub fn width(&self) -> f64 {
        let end = |(x, entry): &(f64, LegendEntry)| x + 2.2 * self.text + font::width(&entry.name, self.text);
        self.rows.iter().filter_map(|row| row.last()).map(end).fold(0.0, f64::max)
    }

    pub fn draw(&self, drawing: &mut Drawing, at: [f64; 2]) {
        let text = self.text;
        for (number, row) in self.rows.iter().enumerate() {
            let y = at[1] + ROW * text * (number as f64 + 0.5);
            for (x, entry) in row {
                let x = at[0] + x;
                let sign = Rect { x, y: y - 0.4 * text, width: 1.6 * text, height: 0.8 * text };
                draw_sign(drawing, entry.sign, sign, text);
                drawing.label([x + 2.2 * text, y + 0.36 * text], text, Anchor::Start, &entry.name);
            }
        }
    }
}

fn draw_sign(drawing: &mut Drawing, sign: Sign, rect: Rect, text: f64) {
    let thin = Pen::new(Paint::Ink, 0.05 * text);
    match sign {
        Sign::Line(pen) if pen.paint == Paint::Colour(WHITE) => {
            drawing.area(rect.corners(), Paint::Colour(SOLID));
            drawing.stroke(vec![rect.at(0.0, 0.5), rect.at(1.0, 0.5)], pen);
        }
        Sign::Line(pen) => drawing.stroke(vec![rect.at(0.0, 0.5), rect.at(1.0, 0.5)], pen),
        Sign::Ring(colour) => ring(drawing, rect.at(0.5, 0.5), 0.4 * text, colour),
        Sign::Box(paint) => {
            drawing.area(rect.corners(), paint);
            drawing.frame(rect, thin);
        }
        Sign::Washes(colour, layers) => {
            (0..layers).for_each(|_| drawing.area(rect.corners(), Paint::Wash(colour)));
            drawing.frame(rect, thin);
        }
        Sign::Striped(colour) => {
            drawing.area(rect.corners(), Paint::Colour(colour));
            let white = Pen::new(Paint::Colour(WHITE), 0.08 * text);
            for n in 0..5 {
                let x = rect.x + (f64::from(n) - 0.6) * rect.height * 0.5;
                drawing.stroke_within(&[[x, rect.bottom()], [x + rect.height, rect.y]], rect, white);
            }
            drawing.frame(rect, thin);
        }
    }
}

/// A ring with a cross through it, open in the middle so that the pixel there can be seen.
pub fn ring(drawing: &mut Drawing, [x, y]: [f64; 2], radius: f64, colour: Rgb) {
    // A polygon of 48 corners, turned step by step: no sine of the system's library.
    let (cosine, sine) = (0.991_444_861_373_810_4, 0.130_526_192_220_051_6);
    let mut corners = vec![[radius, 0.0]];
    for n in 0..48 {
        let [u, v] = corners[n];
        corners.push([u * cosine - v * sine, u * sine + v * cosine]);
    }
    corners[48] = corners[0];
    let pen = Pen { paint: Paint::Colour(colour), width: 0.28 * radius, dashed: false, cased: true };
    drawing.stroke(corners.into_iter().map(|[u, v]| [x + u, y + v]).collect(), pen);
    for [u, v] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
        let place = |part: f64| [x + part * radius * u, y + part * radius * v];
        drawing.stroke(vec![place(1.15), place(1.9)], pen);
    }
}
