//! What stands in an asset, for people and for programs.

mod summary;

use serde_json::{Map, Value as Json, json};
use std::fmt::Write;
pub use summary::to_summary;
use volmap_formats::asset::{Array, Asset, Attributes, DensityField, Exterior, Value};

/// All but the fields themselves, as JSON.
pub fn to_json(asset: &Asset, file_bytes: u64) -> Json {
    let mut out = json!({
        "format": "volmap",
        "format_version": asset.format_version(),
        "file_bytes": file_bytes,
        "dimension": asset.dimension.count(),
        "support_radius": asset.support_radius,
        "exterior": exterior(asset),
        "grid": {
            "origin": asset.grid.origin,
            "cell_size": asset.grid.cell_size,
            "resolution": asset.grid.resolution,
        },
        "cells": {
            "grid": asset.grid.resolution.iter().map(|&n| u64::from(n)).product::<u64>(),
            "band": asset.band_count(),
            "by_level": asset.cells_by_level(),
            "solid": asset.solid_count(),
        },
        "quadrature": {
            "name": asset.quadrature.name,
            "degree": asset.quadrature.degree,
            "points": asset.quadrature.points,
            "ball_volume": asset.quadrature.ball_volume,
        },
        "fields": {
            "signed_distance": field(&asset.signed_distance, "m"),
            "volume": field(&asset.volume, asset.dimension.volume_unit()),
        },
        "bake": object(&asset.bake),
        "source": object(&asset.source),
        "diagnosis": object(&asset.diagnosis),
    });
    if let Some(density) = &asset.density {
        out["fields"]["density"] = density_field(density);
    }
    out
}

/// The same for people, line by line.
pub fn to_text(asset: &Asset, file_bytes: u64) -> String {
    let json = to_json(asset, file_bytes);
    let mut out = String::new();
    let empty = Map::new();
    for (name, value) in json.as_object().unwrap_or(&empty) {
        match value {
            Json::Object(entries) => {
                _ = writeln!(out, "{name}");
                entries.iter().for_each(|(key, value)| line(&mut out, "  ", key, value));
            }
            value => line(&mut out, "", name, value),
        }
    }
    // Their readers of HDF5 open an asset without an error, and show nothing.
    let programs = "`volmap export` writes .vtkhdf and .vti for ParaView, VTK, pyvista and xarray, \
     .ply for mesh programs";
    line(&mut out, "", "other programs", &programs.into());
    out
}

fn line(out: &mut String, indent: &str, name: &str, value: &Json) {
    let text = match value {
        Json::String(text) => text.replace('\n', &format!("\n{indent}{:25}", "")),
        Json::Object(entries) => {
            let pairs: Vec<String> = entries.iter().map(|(key, value)| format!("{key} {value}")).collect();
            pairs.join(", ")
        }
        Json::Array(items) => items.iter().map(Json::to_string).collect::<Vec<_>>().join(", "),
        other => other.to_string(),
    };
    let width = 24 - indent.len();
    _ = writeln!(out, "{indent}{name:width$} {text}");
}

/// What lies outside the domain, in a word.
pub fn exterior(asset: &Asset) -> &'static str {
    match asset.exterior {
        Exterior::Fluid => "fluid",
        Exterior::Solid => "solid",
    }
}

fn field(values: &Array, units: &str) -> Json {
    let range = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    };
    let (low, high) = match values {
        Array::F32(v) => range(&mut v.iter().map(|&x| x.into())),
        Array::F64(v) => range(&mut v.iter().copied()),
        Array::Rounded(v) => range(&mut v.values()),
        Array::U32(v) => range(&mut v.iter().map(|&x| x.into())),
    };
    let precision = values.type_name();
    let mut out =
        json!({ "nodes": values.len(), "precision": precision, "min": low, "max": high, "units": units });
    if let Array::Rounded(rounded) = values {
        out["max_error"] = rounded.max_error.into();
    }
    out
}

/// Attributes as an object.
pub fn object(attributes: &Attributes) -> Map<String, Json> {
    attributes.iter().map(|(name, value)| (name.clone(), to_value(value))).collect()
}

fn density_field(density: &DensityField) -> Json {
    let mut out = field(&density.values, "1");
    out["kernel"] = density.kernel.as_str().into();
    out["extension_length"] = density.extension_length.into();
    out["quadrature"] = density.quadrature.as_str().into();
    out["degree"] = density.degree.into();
    out["points"] = density.points.into();
    out["kernel_integral"] = density.kernel_integral.into();
    out
}

fn to_value(value: &Value) -> Json {
    match value {
        Value::Integer(v) if v.len() == 1 => v[0].into(),
        Value::Real(v) if v.len() == 1 => v[0].into(),
        Value::Integer(v) => v.clone().into(),
        Value::Real(v) => v.clone().into(),
        Value::Text(text) => text.clone().into(),
    }
}
