//! Shapes of a picture, before they become pixels or SVG. Pixels count from the upper left corner, y down.

use super::colours::Rgb;

/// Shapes, from the lowest up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Drawing {
    /// From the lowest up.
    pub shapes: Vec<Shape>,
}

/// A shape.
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// A filled polygon.
    Area {
        /// Its corners.
        points: Vec<[f64; 2]>,
        /// What fills it.
        paint: Paint,
    },
    /// A curve.
    Stroke {
        /// Along it.
        points: Vec<[f64; 2]>,
        /// What draws it.
        pen: Pen,
    },
    /// A line of text.
    Text(Text),
}

/// What draws a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pen {
    /// Its colour.
    pub paint: Paint,
    /// Pixels.
    pub width: f64,
    /// In dashes.
    pub dashed: bool,
    /// A white edge, so that it shows on every colour.
    pub cased: bool,
}

/// A colour, or what a page chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Paint {
    /// Letters and axes: dark on a white page, light on a dark one.
    Ink,
    /// Lines of the grid.
    Faint,
    /// This one.
    Colour(Rgb),
    /// A quarter of the colour over what is below.
    Wash(Rgb),
}

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct Text {
    /// On the base line: its start, middle or end.
    pub at: [f64; 2],
    /// Height of the font, pixels.
    pub size: f64,
    /// Which part of it is there.
    pub anchor: Anchor,
    /// Its colour.
    pub paint: Paint,
    /// Upwards.
    pub turned: bool,
    /// What it says.
    pub text: String,
}

/// Part of a line of text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its first letter.
    Start,
    /// Its middle.
    Middle,
    /// Its last letter.
    End,
}

/// A rectangle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rect {
    /// Left.
    pub x: f64,
    /// Top.
    pub y: f64,
    /// To the right.
    pub width: f64,
    /// Down.
    pub height: f64,
}

impl Rect {
    /// Right side.
    pub fn right(&self) -> f64 {
        self.x + self.width
    }

    /// Lower side.
    pub fn bottom(&self) -> f64 {
        self.y + self.height
    }

    /// Whether a place is in it.
    pub fn holds(&self, [x, y]: [f64; 2]) -> bool {
        (self.x..=self.right()).contains(&x) && (self.y..=self.bottom()).contains(&y)
    }

    /// A place from the lower left (0, 0) to the upper right (1, 1).
    pub fn at(&self, across: f64, up: f64) -> [f64; 2] {
        [self.x + across * self.width, self.bottom() - up * self.height]
    }

    /// From the lower left, against the clock.
    pub fn corners(&self) -> Vec<[f64; 2]> {
        vec![self.at(0.0, 0.0), self.at(1.0, 0.0), self.at(1.0, 1.0), self.at(0.0, 1.0)]
    }
}

impl Pen {
    /// A plain pen.
    pub fn new(paint: Paint, width: f64) -> Pen {
        Pen { paint, width, dashed: false, cased: false }
    }
}

impl Drawing {
    /// A filled polygon.
    pub fn area(&mut self, points: Vec<[f64; 2]>, paint: Paint) {
        self.shapes.push(Shape::Area { points, paint });
    }

    /// A curve.
    pub fn stroke(&mut self, points: Vec<[f64; 2]>, pen: Pen) {
        self.shapes.push(Shape::Stroke { points, pen });
    }

    /// The border of a rectangle.
    pub fn frame(&mut self, rect: Rect, pen: Pen) {
        let mut points = rect.corners();
        points.push(points[0]);
        // The last corner needs a join too.
        points.push(points[1]);
        self.stroke(points, pen);
    }

    /// A line of text.
    pub fn text(&mut self, text: Text) {
        self.shapes.push(Shape::Text(text));
    }

    /// A horizontal line of text in ink.
    pub fn label(&mut self, at: [f64; 2], size: f64, anchor: Anchor, text: &str) {
        self.text(Text { at, size, anchor, paint: Paint::Ink, turned: false, text: text.to_owned() });
    }

    /// A curve, without what is outside of the rectangle.
    pub fn stroke_within(&mut self, points: &[[f64; 2]], rect: Rect, pen: Pen) {
        let mut part: Vec<[f64; 2]> = Vec::new();
        for pair in points.windows(2) {
            let clipped = clip(pair[0], pair[1], rect);
            if let Some([from, to]) = clipped {
                if part.last() != Some(&from) {
                    self.finish(&mut part, pen);
                    part.push(from);
                }
                part.push(to);
            }
        }
        self.finish(&mut part, pen);
    }

    fn finish(&mut self, part: &mut Vec<[f64; 2]>, pen: Pen) {
        let points = std::mem::take(part);
        if points.len() > 1 {
            self.stroke(points, pen);
        }
    }
}

/// The part of a line within a rectangle (Liang and Barsky 1984).
fn clip(from: [f64; 2], to: [f64; 2], rect: Rect) -> Option<[[f64; 2]; 2]> {
    let (low, high) = ([rect.x, rect.y], [rect.right(), rect.bottom()]);
    let (mut enter, mut leave) = (0.0f64, 1.0f64);
    for a in 0..2 {
        let along = to[a] - from[a];
        if along == 0.0 && !(low[a]..=high[a]).contains(&from[a]) {
            return None;
        }
        if along != 0.0 {
            let (s, t) = ((low[a] - from[a]) / along, (high[a] - from[a]) / along);
            enter = enter.max(s.min(t));
            leave = leave.min(s.max(t));
        }
    }
    let at = |t: f64| match t {
        0.0 => from,
        1.0 => to,
        _ => [0, 1].map(|a| (from[a] + t * (to[a] - from[a])).clamp(low[a], high[a])),
    };
    (enter <= leave && from.iter().chain(&to).all(|x| x.is_finite())).then(|| [at(enter), at(leave)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_end_at_the_border() {
        let rect = Rect { x: 0.0, y: 0.0, width: 10.0, height: 10.0 };
        let mut drawing = Drawing::default();
        let curve = [[-5.0, 5.0], [5.0, 5.0], [5.0, 1e300], [5.0, 5.0], [8.0, 5.0]];
        drawing.stroke_within(&curve, rect, Pen::new(Paint::Ink, 1.0));
        let parts: Vec<Vec<[f64; 2]>> = drawing
            .shapes
            .iter()
            .map(|shape| match shape {
                Shape::Stroke { points, .. } => points.clone(),
                other => panic!("{other:?}"),
            })
            .collect();
        assert_eq!(parts[0][..2], [[0.0, 5.0], [5.0, 5.0]]);
        assert!(parts.iter().flatten().all(|p| (0.0..=10.0).contains(&p[0]) && (0.0..=10.0).contains(&p[1])));
        assert_eq!(parts.last().unwrap().last(), Some(&[8.0, 5.0]));
        assert!(clip([f64::NAN, 0.0], [1.0, 1.0], rect).is_none());
        assert!(clip([20.0, 0.0], [20.0, 9.0], rect).is_none());
    }
}
