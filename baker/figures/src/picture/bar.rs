//! Colour bars: to the right of a panel, below it where the panel is flat, or anywhere on a canvas.

use super::canvas::Canvas;
use super::colours::{ColourMap, INK};
use super::content::{Colouring, Limits, Pixel, Quantity};
use super::drawing::{Anchor, Drawing, Paint, Pen, Rect, Text};
use super::frame::widest;
use super::scale::Scale;

/// How far the limits of a logarithm are apart at most, if they are those of the values.
const SPAN: f64 = 1e4;

/// Colours and their scale.
#[derive(Clone, Debug)]
pub struct ColourBar {
    /// Colours.
    pub map: ColourMap,
    /// Numbers.
    pub scale: Scale,
    /// Name and unit, as of [`Scale::title`].
    pub title: String,
    /// Whether values lie below and above the scale: an arrow there tells of them.
    pub beyond: [bool; 2],
    /// From below upwards, instead of from left to right.
    pub upright: bool,
    /// The title of a bar that isn't upright stands above it, instead of below.
    pub title_above: bool,
    /// Height of letters, pixels.
    pub text: f64,
}

impl ColourBar {
    /// That of a panel; `None` for categories.
    pub(super) fn of_panel(
        colouring: &Colouring,
        pixels: &[Pixel],
        quantity: &Quantity,
        room: Room,
    ) -> Option<ColourBar> {
        let most = (room.length / (if room.upright { 2.5 } else { 4.5 } * room.text)) as usize;
        let (map, scale) = match colouring {
            Colouring::Linear(map, limits) => {
                (*map, Scale::linear(linear_limits(*map, *limits, pixels), most.min(9)))
            }
            Colouring::Log(map, limits) => (*map, Scale::log(log_limits(*limits, pixels), most.min(9))),
            Colouring::Categories(_) => return None,
        };
        let [low, high] = scale.limits;
        let slack = 1e-9 * (high - low);
        let below = !scale.log && values(pixels).any(|x| x < low - slack);
        let beyond = [below, values(pixels).any(|x| x > high + slack)];
        let title = scale.title(&quantity.name, &quantity.unit);
        let (upright, text) = (room.upright, room.text);
        Some(ColourBar { map, scale, title, beyond, upright, title_above: false, text })
    }

    /// How far it reaches from the plot.
    pub fn depth(&self) -> f64 {
        match self.upright {
            true => 3.9 * self.text + widest(&self.scale, self.text),
            false => 4.0 * self.text,
        }
    }

    /// Draws it beside (right of, or below) the side from `start` of this length.
    pub fn draw(&self, canvas: &mut Canvas, start: [f64; 2], length: f64) {
        let text = self.text;
        let (arrow, thick) = (1.0 * text, 0.9 * text);
        let ends = self.beyond.map(|there| if there { arrow } else { 0.0 });
        let inner = length - ends[0] - ends[1];
        let [x, y] = start.map(f64::round);
        let rect = match self.upright {
            true => Rect { x: x + 0.8 * text, y: y + ends[1], width: thick, height: inner },
            false => Rect { x: x + ends[0], y, width: inner, height: thick },
        };
        let count = inner.round().max(1.0) as usize;
        let size =
            if self.upright { [thick.round() as usize, count] } else { [count, thick.round() as usize] };
        canvas.image([rect.x, rect.y], size, |across, down| {
            let step = if self.upright { count - 1 - down.min(count - 1) } else { across };
            self.map.at((step as f64 + 0.5) / count as f64)
        });
        let rect =
            Rect { x: rect.x.round(), y: rect.y.round(), width: size[0] as f64, height: size[1] as f64 };
        let mut drawing = Drawing::default();
        self.draw_ends(&mut drawing, rect, arrow);
        self.draw_ticks(&mut drawing, rect);
        canvas.draw(&drawing);
    }

    fn draw_ends(&self, drawing: &mut Drawing, rect: Rect, arrow: f64) {
        let pen = Pen::new(Paint::Ink, 0.06 * self.text);
        drawing.frame(rect, pen);
        for (end, _) in self.beyond.iter().enumerate().filter(|(_, there)| **there) {
            let at = end as f64;
            let sign = if end == 0 { -1.0 } else { 1.0 };
            let mut points = match self.upright {
                true => vec![rect.at(0.0, at), rect.at(1.0, at), rect.at(0.5, at)],
                false => vec![rect.at(at, 0.0), rect.at(at, 1.0), rect.at(at, 0.5)],
            };
            if self.upright {
                points[2][1] -= sign * arrow
            } else {
                points[2][0] += sign * arrow
            }
            drawing.area(points.clone(), Paint::Colour(self.map.at(at)));
            points.push(points[0]);
            drawing.stroke(points, pen);
        }
    }

    fn draw_ticks(&self, drawing: &mut Drawing, rect: Rect) {
        let text = self.text;
        let pen = Pen::new(Paint::Colour(INK), 0.06 * text);
        for (value, label) in &self.scale.ticks {
            let place = self.scale.place(*value);
            if self.upright {
                let [x, y] = rect.at(1.0, place);
                drawing.stroke(vec![[x, y], [x + 0.3 * text, y]], pen);
                drawing.label([x + 0.5 * text, y + 0.36 * text], text, Anchor::Start, label);
            } else {
                let [x, y] = rect.at(place, 0.0);
                drawing.stroke(vec![[x, y], [x, y + 0.3 * text]], pen);
                drawing.label([x, y + 1.25 * text], text, Anchor::Middle, label);
            }
        }
        let (at, turned) = match self.upright {
            true => ([rect.right() + widest(&self.scale, text) + 1.7 * text, rect.at(0.0, 0.5)[1]], true),
            false if self.title_above => ([rect.at(0.5, 1.0)[0], rect.y - 0.6 * text], false),
            false => ([rect.at(0.5, 0.0)[0], rect.bottom() + 2.6 * text], false),
        };
        let title = self.title.clone();
        drawing.text(Text { at, size: text, anchor: Anchor::Middle, paint: Paint::Ink, turned, text: title });
    }
}

/// Where the bar of a panel goes.
#[derive(Clone, Copy)]
pub(super) struct Room {
    pub length: f64,
    pub upright: bool,
    pub text: f64,
}

fn values(pixels: &[Pixel]) -> impl Iterator<Item = f64> + '_ {
    let value = |pixel: &Pixel| match pixel {
        Pixel::Value(x) if x.is_finite() => Some(*x),
        _ => None,
    };
    pixels.iter().filter_map(value)
}

fn linear_limits(map: ColourMap, limits: Limits, pixels: &[Pixel]) -> [f64; 2] {
    if let Limits::Given(limits) = limits {
        return limits;
    }
    let low = values(pixels).fold(f64::INFINITY, f64::min);
    let high = values(pixels).fold(f64::NEG_INFINITY, f64::max);
    let largest = low.abs().max(high.abs());
    match map.is_diverging() && largest > 0.0 && largest.is_finite() {
        true => [-largest, largest],
        false => [low, high],
    }
}

fn log_limits(limits: Limits, pixels: &[Pixel]) -> [f64; 2] {
    if let Limits::Given(limits) = limits {
        return limits;
    }
    let positive = || values(pixels).filter(|x| *x > 0.0);
    let high = positive().fold(0.0, f64::max);
    [positive().fold(f64::INFINITY, f64::min).max(high / SPAN), high]
}
