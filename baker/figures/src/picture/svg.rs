//! Shapes to SVG that stands in a page and takes its colour of text.

use super::drawing::{Anchor, Drawing, Paint, Pen, Shape, Text};
use crate::escape::escape;
use std::fmt::Write;

/// An `svg` element of this size in its own unit, as wide as its place; `name` is read out.
pub fn svg(drawing: &Drawing, size: [f64; 2], name: &str) -> String {
    let mut out = format!(
        "<svg viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\" font-family=\"system-ui, sans-serif\">\n",
        size[0],
        size[1],
        escape(name)
    );
    for shape in &drawing.shapes {
        match shape {
            Shape::Area { points, paint } => {
                _ = writeln!(out, "<polygon points=\"{}\" {}/>", places(points), colour("fill", *paint));
            }
            Shape::Stroke { points, pen } => stroke(&mut out, points, pen),
            Shape::Text(line) => text(&mut out, line),
        }
    }
    out + "</svg>"
}

fn stroke(out: &mut String, points: &[[f64; 2]], pen: &Pen) {
    let dash = if pen.dashed {
        format!(" stroke-dasharray=\"{} {}\"", 4.0 * pen.width, 2.5 * pen.width)
    } else {
        String::new()
    };
    _ = writeln!(
        out,
        "<polyline points=\"{}\" fill=\"none\" {} stroke-width=\"{}\" stroke-linejoin=\"round\"{dash}/>",
        places(points),
        colour("stroke", pen.paint),
        pen.width
    );
}

fn text(out: &mut String, line: &Text) {
    let anchor = match line.anchor {
        Anchor::Start => "start",
        Anchor::Middle => "middle",
        Anchor::End => "end",
    };
    let [x, y] = line.at.map(round);
    let turn = if line.turned { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
    _ = writeln!(
        out,
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" {}{turn}>{}</text>",
        line.size,
        colour("fill", line.paint),
        escape(&line.text)
    );
}

fn places(points: &[[f64; 2]]) -> String {
    let words: Vec<String> = points.iter().map(|p| format!("{},{}", round(p[0]), round(p[1]))).collect();
    words.join(" ")
}

/// A hundredth is far below what shows.
fn round(x: f64) -> f64 {
    (100.0 * x).round() / 100.0
}

fn colour(what: &str, paint: Paint) -> String {
    match paint {
        Paint::Ink => format!("{what}=\"currentColor\""),
        Paint::Faint => format!("{what}=\"currentColor\" {what}-opacity=\"0.18\""),
        Paint::Colour([r, g, b]) => format!("{what}=\"#{r:02x}{g:02x}{b:02x}\""),
        Paint::Wash([r, g, b]) => format!("{what}=\"#{r:02x}{g:02x}{b:02x}\" {what}-opacity=\"0.3\""),
    }
}
