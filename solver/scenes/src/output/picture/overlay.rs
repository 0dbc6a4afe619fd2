//! What is written on a picture: time, particles, the colour bar, the edges of containers.

use super::camera::Bounds;
use super::model::Model;
use glam::Vec3;
use volmap_figures::picture::ColourMap;
use volmap_figures::picture::bar::ColourBar;
use volmap_figures::picture::canvas::Canvas;
use volmap_figures::picture::colours::{INK, WHITE};
use volmap_figures::picture::drawing::{Anchor, Drawing, Paint, Pen, Rect};
use volmap_figures::picture::font;
use volmap_figures::picture::scale::Scale;
use volmap_figures::raster::View;
use volmap_runtime::Pose;

/// What the colour bar says.
pub struct Legend<'a> {
    /// Colours.
    pub map: ColourMap,
    /// Numbers at the ends of the bar.
    pub range: [f64; 2],
    /// Name and unit.
    pub quantity: (&'a str, &'a str),
    /// Whether something may be below it, which is made lighter.
    pub backed: bool,
    /// Upper left corner.
    pub title: String,
    /// Below it.
    pub subtitle: String,
}

/// Writes title, subtitle and colour bar.
pub fn draw(canvas: &mut Canvas, size: [f64; 2], legend: &Legend) {
    let text = (0.028 * size[1]).max(9.0);
    let mut drawing = Drawing::default();
    let widest = font::width(&legend.title, 1.35 * text).max(font::width(&legend.subtitle, 0.85 * text));
    let lighten = |drawing: &mut Drawing, rect: Rect| {
        if legend.backed {
            lighten(drawing, rect)
        }
    };
    lighten(&mut drawing, Rect { x: 0.0, y: 0.0, width: widest + 2.4 * text, height: 4.6 * text });
    drawing.label([1.2 * text, 2.2 * text], 1.35 * text, Anchor::Start, &legend.title);
    drawing.label([1.2 * text, 3.75 * text], 0.85 * text, Anchor::Start, &legend.subtitle);
    let length = (0.26 * size[0]).round();
    let start = [size[0] - length - 1.6 * text, size[1] - 2.6 * text].map(f64::round);
    let [x, y] = start;
    lighten(&mut drawing, Rect { x: x - 1.6 * text, y: y - 2.0 * text, width: size[0], height: size[1] });
    canvas.draw(&drawing);
    let scale = Scale::linear(legend.range, 6);
    let (name, unit) = legend.quantity;
    let bar = ColourBar {
        map: legend.map,
        title: scale.title(name, unit),
        scale,
        beyond: [false; 2],
        upright: false,
        title_above: true,
        text: 0.85 * text,
    };
    bar.draw(canvas, start, length);
}

/// Makes what is below letters lighter.
fn lighten(drawing: &mut Drawing, rect: Rect) {
    (0..3).for_each(|_| drawing.area(rect.corners(), Paint::Wash(WHITE)));
}

/// The edges of a container whose nearer side isn't drawn, as faint lines.
pub fn draw_edges(canvas: &mut Canvas, view: &View, model: &Model, pose: &Pose) {
    let rotation = pose.rotation.as_quat();
    let world = |n: u32| pose.to_world(model.vertices[n as usize].as_dvec3()).as_vec3();
    let mut drawing = Drawing::default();
    let pen = Pen::new(Paint::Wash(INK), (1.6e-3 * view.size[1] as f64).max(1.0));
    for edge in &model.edges {
        let ends = edge.ends.map(world);
        let faces_eye = |normal: Vec3| (rotation * normal).dot(view.origin - ends[0]) > 0.0;
        if edge.normals.into_iter().any(faces_eye)
            && let Some(line) = line(view, ends)
        {
            drawing.stroke(line.to_vec(), pen);
        }
    }
    canvas.draw(&drawing);
}

/// A line on the picture, if it isn't behind the eye or all beside the picture.
fn line(view: &View, ends: [Vec3; 2]) -> Option<[[f64; 2]; 2]> {
    let [mut a, mut b] = ends.map(|p| view.local(p));
    if a.z.max(b.z) <= view.near {
        return None;
    }
    let t = (view.near - a.z) / (b.z - a.z);
    let cut = a.lerp(b, t);
    if a.z < view.near {
        a = cut;
    } else if b.z < view.near {
        b = cut;
    }
    let pixels = [a, b].map(|p| view.pixel(p));
    let mut around = Bounds::EMPTY;
    pixels.iter().for_each(|p| around.add(Vec3::new(p[0], p[1], 0.0)));
    let [width, height] = view.size.map(|n| n as f32);
    let seen = around.high.x > 0.0 && around.high.y > 0.0 && around.low.x < width && around.low.y < height;
    // The drawing's own numbers end somewhere.
    let small = around.low.abs().max(around.high.abs()).max_element() < 1e5;
    (seen && small).then(|| pixels.map(|p| p.map(f64::from)))
}
