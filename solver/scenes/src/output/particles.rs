//! Particles of a frame as a file for other programs, and the list of such files that ParaView plays.

use super::{Frame, publish};
use crate::error::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::Path;
use volmap_formats::export::points::{Points, Positions, Values, write_bgeo, write_ply, write_vtu};
use volmap_runtime::DVec3;

/// What particles are written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ParticleFormat {
    /// VTK's XML: ParaView, VTK, meshio, splashsurf.
    Vtu,
    /// Binary PLY: splashsurf, mesh programs.
    Ply,
    /// Houdini's classic geometry: partio, splashsurf.
    Bgeo,
}

impl ParticleFormat {
    /// The ending of its files.
    pub fn extension(self) -> &'static str {
        match self {
            ParticleFormat::Vtu => "vtu",
            ParticleFormat::Ply => "ply",
            ParticleFormat::Bgeo => "bgeo",
        }
    }
}

/// Writes the particles: places (m), `velocity` (m/s), `density` (kg/m^3), `pressure` (Pa), `id`, and what forces have
/// them carry. VTU has `radius` (m) and `mass` (kg) of each as well. VTU, as field data, and PLY, as comments, tell the
/// time (`TimeValue`, s) and what all particles share, with units in the names.
///
/// Places are in single precision. Those of a frame with an [`origin`](Frame::origin) are in double precision in VTU;
/// in PLY and BGEO, whose readers have single precision, they are relative to the origin, which each particle has as
/// `origin`.
///
/// # Errors
/// Lists of different lengths, or a file that can't be written.
pub fn write(path: &Path, format: ParticleFormat, frame: &Frame) -> Result<(), Error> {
    let origin = frame.origin.unwrap_or(DVec3::ZERO);
    let exact: Vec<[f64; 3]>;
    let rounded: Vec<[f32; 3]>;
    let positions = if frame.origin.is_some() && format == ParticleFormat::Vtu {
        exact = frame.positions.iter().map(|place| place.to_array()).collect();
        Positions::F64(&exact)
    } else {
        rounded = frame.positions.iter().map(|place| (*place - origin).as_vec3().to_array()).collect();
        Positions::F32(&rounded)
    };
    let density: Vec<f32> = frame.density.iter().map(|part| part * frame.rest_density as f32).collect();
    let mut arrays = vec![
        ("velocity", Values::Vector(frame.velocities)),
        ("density", Values::F32(&density)),
        ("pressure", Values::F32(frame.pressure)),
        ("id", Values::U32(frame.ids)),
    ];
    arrays.extend(frame.channels);
    let same =
        [frame.particle_radius, frame.particle_mass].map(|value| vec![value as f32; frame.positions.len()]);
    let origins: Vec<[f32; 3]>;
    match format {
        // Equal numbers shrink to nothing there.
        ParticleFormat::Vtu => {
            arrays.extend([("radius", Values::F32(&same[0])), ("mass", Values::F32(&same[1]))]);
        }
        ParticleFormat::Ply | ParticleFormat::Bgeo if frame.origin.is_some() => {
            origins = vec![origin.as_vec3().to_array(); frame.positions.len()];
            arrays.push(("origin", Values::Vector(&origins)));
        }
        ParticleFormat::Ply | ParticleFormat::Bgeo => {}
    }
    let points = Points { positions, arrays, facts: facts(frame) };
    let written = match format {
        ParticleFormat::Vtu => write_vtu(path, &points),
        ParticleFormat::Ply => write_ply(path, &points),
        ParticleFormat::Bgeo => write_bgeo(path, &points),
    };
    Ok(written?)
}

/// What all particles share.
fn facts(frame: &Frame) -> Vec<(&'static str, Vec<f64>)> {
    let mut facts = vec![
        ("TimeValue", vec![frame.time]),
        ("particle_radius [m]", vec![frame.particle_radius]),
        ("particle_mass [kg]", vec![frame.particle_mass]),
        ("rest_density [kg/m^3]", vec![frame.rest_density]),
    ];
    facts.extend(frame.origin.map(|origin| ("origin [m]", origin.to_array().to_vec())));
    facts
}

/// A frame in ParaView's collection.
#[derive(Clone, Debug, PartialEq)]
pub struct CollectionEntry {
    /// Seconds.
    pub time: f64,
    /// Path of the particles' file, relative to the collection.
    pub file: String,
}

/// Writes ParaView's collection (`.pvd`) of a run's frames.
///
/// # Errors
/// A file that can't be written.
pub fn write_collection(path: &Path, entries: &[CollectionEntry]) -> Result<(), Error> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n\
         <Collection>\n",
    );
    for CollectionEntry { time, file } in entries {
        _ = writeln!(text, "<DataSet timestep=\"{time}\" part=\"0\" file=\"{file}\"/>");
    }
    text += "</Collection>\n</VTKFile>\n";
    publish(path, text.as_bytes())
}
