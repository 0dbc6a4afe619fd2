//! Particles of a frame as a file for other programs, and the list of such files that ParaView plays.

use super::{Frame, publish};
use crate::error::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt::Write;
use std::path::Path;
use volmap_formats::export::points::{Points, Values, write_bgeo, write_ply, write_vtu};

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

/// Writes the particles, positions in single precision.
///
/// # Errors
/// Lists of different lengths, or a file that can't be written.
pub fn write(path: &Path, format: ParticleFormat, frame: &Frame) -> Result<(), Error> {
    let positions: Vec<[f32; 3]> = frame.positions.iter().map(|p| p.as_vec3().to_array()).collect();
    let arrays = vec![
        ("velocity", Values::Vector(frame.velocities)),
        ("density", Values::F32(frame.density)),
        ("pressure", Values::F32(frame.pressure)),
        ("id", Values::U32(frame.ids)),
    ];
    let points = Points { positions: &positions, arrays };
    let written = match format {
        ParticleFormat::Vtu => write_vtu(path, &points),
        ParticleFormat::Ply => write_ply(path, &points),
        ParticleFormat::Bgeo => write_bgeo(path, &points),
    };
    Ok(written?)
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
