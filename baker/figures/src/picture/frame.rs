//! The frame of a plot, with ticks, numbers and names of its axes.

use super::drawing::{Anchor, Drawing, Paint, Pen, Rect, Text};
use super::font;
use super::scale::Scale;

/// An axis of a plot.
pub struct Side<'a> {
    pub scale: &'a Scale,
    pub title: String,
}

/// Room that the vertical axis needs to the left of the plot.
pub fn left_room(scale: &Scale, text: f64) -> f64 {
    widest(scale, text) + 2.2 * text
}

/// Room below the plot.
pub fn bottom_room(text: f64) -> f64 {
    3.2 * text
}

/// Width of the longest label.
pub fn widest(scale: &Scale, text: f64) -> f64 {
    scale.ticks.iter().map(|(_, label)| font::width(label, text)).fold(0.0, f64::max)
}

/// Frame, ticks, numbers and names; with lines of a grid if asked for.
pub fn draw_frame(drawing: &mut Drawing, rect: Rect, [x, y]: [&Side; 2], text: f64, grid: bool) {
    let pen = Pen::new(Paint::Ink, 0.06 * text);
    let faint = Pen::new(Paint::Faint, 0.05 * text);
    for (value, label) in &x.scale.ticks {
        let [across, bottom] = rect.at(x.scale.place(*value), 0.0);
        if grid {
            drawing.stroke(vec![[across, bottom], [across, rect.y]], faint);
        }
        drawing.stroke(vec![[across, bottom], [across, bottom + 0.3 * text]], pen);
        drawing.label([across, bottom + 1.25 * text], text, Anchor::Middle, label);
    }
    for (value, label) in &y.scale.ticks {
        let [left, up] = rect.at(0.0, y.scale.place(*value));
        if grid {
            drawing.stroke(vec![[left, up], [rect.right(), up]], faint);
        }
        drawing.stroke(vec![[left, up], [left - 0.3 * text, up]], pen);
        drawing.label([left - 0.5 * text, up + 0.36 * text], text, Anchor::End, label);
    }
    drawing.frame(rect, pen);
    let below = [rect.at(0.5, 0.0)[0], rect.bottom() + 2.6 * text];
    drawing.label(below, text, Anchor::Middle, &x.title);
    let beside = [rect.x - widest(y.scale, text) - 1.1 * text, rect.at(0.0, 0.5)[1]];
    drawing.text(Text {
        at: beside,
        size: text,
        anchor: Anchor::Middle,
        paint: Paint::Ink,
        turned: true,
        text: y.title.clone(),
    });
}
