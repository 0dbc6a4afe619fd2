//! An asset in a few lines for people: what the bake said of it.

use super::exterior;
use std::fmt::Write;
use volmap_formats::asset::{Array, Asset, Attributes, Dimension, Value};
use volmap_formats::text::{bytes, percent, significant, thousands};

/// Holes that are listed.
const MAX_HOLES: usize = 6;

/// What there is to say first of an asset; what it doesn't hold is left out.
pub fn to_summary(asset: &Asset) -> String {
    let mut out = String::new();
    let mut line = |name: &str, text: String| _ = writeln!(out, "{name:<10} {text}");
    mesh(asset, &mut line);
    grid(asset, &mut line);
    error(asset, &mut line);
    text(&asset.diagnosis, "warnings")
        .unwrap_or_default()
        .lines()
        .for_each(|text| line("warning", text.into()));
    out
}

fn mesh(asset: &Asset, line: &mut impl FnMut(&str, String)) {
    if let Some(shape) = text(&asset.bake, "shape").filter(|shape| !shape.is_empty()) {
        line("shape", shape.into());
    } else if let Some(file) = text(&asset.source, "file") {
        let triangles = integer(&asset.source, "triangles").map(|n| format!(": {} triangles", thousands(n)));
        line("mesh", format!("{file}{}", triangles.unwrap_or_default()));
    }
    if let Some(state) = state(&asset.diagnosis) {
        line("", state);
    }
    let corner = |name| Some(place(reals(&asset.source, name)?));
    if let (Some(low), Some(high)) = (corner("bounds_min"), corner("bounds_max")) {
        let area = real(&asset.source, "area").map(|area| format!(", area {} m^2", digits(area)));
        line("", format!("box {low} to {high} m{}", area.unwrap_or_default()));
    }
    if let Some(placed) = placed(&asset.bake) {
        line("placed", placed);
    }
    holes(&asset.diagnosis, line);
    if let Some(reason) = text(&asset.bake, "sign_reason") {
        line("sign", reason.into());
    }
}

fn state(found: &Attributes) -> Option<String> {
    let word =
        |name: &str| Some(if integer(found, name)? == 1 { name.to_owned() } else { format!("NOT {name}") });
    let mut parts = vec![word("closed")?, word("oriented")?, word("manifold")?];
    let components = integer(found, "components")?;
    parts.push(format!("{components} component{}", if components == 1 { "" } else { "s" }));
    if !parts[..2].iter().any(|part| part.starts_with("NOT")) {
        parts.extend(real(found, "volume").map(|volume| format!("volume {} m^3", digits(volume))));
    }
    let cavities = integer(found, "cavities").filter(|n| *n > 0);
    parts.extend(cavities.map(|n| format!("{n} hollow")));
    Some(parts.join(", "))
}

/// What was done to the file's coordinates, in the order in which it was done.
fn placed(bake: &Attributes) -> Option<String> {
    let other = |name, usual: &[f64]| reals(bake, name).filter(|values| *values != usual);
    let mut steps = Vec::new();
    steps.extend(real(bake, "unit").filter(|unit| *unit != 1.0).map(|unit| format!("unit {unit} m")));
    steps.extend(text(bake, "up_axis").filter(|axis| *axis != "y").map(|axis| format!("{axis} up")));
    steps.extend(other("scale", &[1.0; 3]).map(|scale| format!("scale {}", place(scale))));
    let degrees = real(bake, "rotation_degrees").filter(|degrees| *degrees != 0.0);
    let axis = reals(bake, "rotation_axis").map(place).unwrap_or_default();
    steps.extend(degrees.map(|degrees| format!("{degrees} degrees around {axis}")));
    steps.extend(other("translation", &[0.0; 3]).map(|way| format!("moved by {} m", place(way))));
    (!steps.is_empty()).then(|| steps.join(", then "))
}

fn holes(found: &Attributes, line: &mut impl FnMut(&str, String)) {
    let lengths = reals(found, "boundary_loop_lengths").unwrap_or_default();
    let centers = reals(found, "boundary_loop_centers").unwrap_or_default();
    for (length, center) in lengths.iter().zip(centers.chunks(3)).take(MAX_HOLES) {
        line("hole", format!("{} m long, around {} m", digits(*length), place(center)));
    }
    let all = integer(found, "boundary_loops").unwrap_or(0) as usize;
    if all > MAX_HOLES {
        line("", format!("and {} shorter", all - MAX_HOLES));
    }
}

/// The cells of each level and their edges.
fn levels(asset: &Asset) -> String {
    let level = |(level, count): (usize, &u64)| {
        let edge = asset.grid.cell_size[0] / f64::from(1u32 << level);
        format!("{} of {} m", thousands(*count), digits(edge))
    };
    let counts = asset.cells_by_level();
    let levels: Vec<String> = counts.iter().enumerate().map(level).collect();
    format!("{}: {}", thousands(asset.band_count()), levels.join(", "))
}

fn grid(asset: &Asset, line: &mut impl FnMut(&str, String)) {
    let axes = if asset.dimension == Dimension::Two { 2 } else { 3 };
    let cells = &asset.grid.resolution[..axes];
    let edges = &asset.grid.cell_size[..axes];
    let joined = |parts: Vec<String>| parts.join(" x ");
    let edge = match edges.iter().all(|edge| *edge == edges[0]) {
        true => digits(edges[0]),
        false => joined(edges.iter().map(|edge| digits(*edge)).collect()),
    };
    let resolution = joined(cells.iter().map(u32::to_string).collect());
    line("grid", format!("{resolution} cells of {edge} m, support radius {} m", asset.support_radius));
    let (band, all) = (asset.band_count(), cells.iter().map(|n| u64::from(*n)).product::<u64>());
    let kept = match asset.is_adaptive() {
        true => levels(asset),
        false => {
            format!("{} of {} kept ({})", thousands(band), thousands(all), percent(band as f64 / all as f64))
        }
    };
    line("cells", format!("{kept}; outside the domain is {}", exterior(asset)));
    let fields = [
        Some(&asset.signed_distance),
        Some(&asset.volume),
        asset.density.as_ref().map(|found| &found.values),
    ];
    let fields = fields.into_iter().flatten();
    let size: usize = fields.map(|field| field.len() * field.element_size()).sum();
    let nodes = thousands(asset.volume.len() as u64);
    line("nodes", format!("{nodes}, {} of memory, volume by {}", bytes(size as u64), asset.quadrature.name));
    if let Some(density) = &asset.density {
        line(
            "density",
            format!("over rest density, for the kernel {}, by {}", density.kernel, density.quadrature),
        );
    }
    if let Array::Rounded(_) = asset.volume {
        let allowed = real(&asset.bake, "max_rounding")
            .map(|part| format!(", at most {} of r and of the ball", percent(part)));
        line("rounding", format!("16 bits{}", allowed.unwrap_or_default()));
    }
}

/// What was measured, if something was.
fn error(asset: &Asset, line: &mut impl FnMut(&str, String)) {
    let Some(max) = real(&asset.bake, "volume_error_max") else { return };
    let points = integer(&asset.bake, "volume_error_points").unwrap_or(0);
    let rms = real(&asset.bake, "volume_error_rms").map(|rms| format!(", rms {}", percent(rms)));
    let rms = rms.unwrap_or_default();
    line(
        "error",
        format!("largest {} of the ball at {} points of the fluid{rms}", percent(max), thousands(points)),
    );
}

fn integer(attributes: &Attributes, name: &str) -> Option<u64> {
    match attributes.get(name) {
        Some(Value::Integer(list)) => list.first().copied(),
        _ => None,
    }
}

fn reals<'a>(attributes: &'a Attributes, name: &str) -> Option<&'a [f64]> {
    match attributes.get(name) {
        Some(Value::Real(list)) => Some(list),
        _ => None,
    }
}

fn real(attributes: &Attributes, name: &str) -> Option<f64> {
    reals(attributes, name)?.first().copied()
}

fn text<'a>(attributes: &'a Attributes, name: &str) -> Option<&'a str> {
    match attributes.get(name) {
        Some(Value::Text(text)) => Some(text),
        _ => None,
    }
}

fn place(x: &[f64]) -> String {
    format!("({})", x.iter().map(|x| digits(*x)).collect::<Vec<_>>().join(", "))
}

/// Lengths, areas and volumes with four digits.
fn digits(x: f64) -> String {
    significant(x, 4)
}
