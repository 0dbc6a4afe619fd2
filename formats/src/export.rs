//! Files for other programs: what they hold is told there, how it is computed from a map in the baker.
//!
//! - [`vtkhdf`]: an unstructured grid of curved cells, for ParaView and VTK;
//! - [`vti`]: an image of equally spaced points, for whatever reads VTK's XML;
//! - [`ply`]: a triangle mesh;
//! - [`points`]: particles with values, as VTU, PLY or BGEO;
//! - [`cdm`]: Discregrid's dump, the map of SPlisHSPlasH; read, too.

pub mod cdm;
mod error;
pub mod ply;
pub mod points;
pub mod vti;
pub mod vtkhdf;

pub use error::ExportError;

use crate::asset::publish::publish;
use std::path::Path;

/// Makes a file of these bytes, whole or not at all.
fn publish_to(path: &Path, bytes: &[u8]) -> Result<(), ExportError> {
    publish(bytes, path).map_err(|error| ExportError::Io(error).in_file(path))
}

/// The bytes of numbers, lowest first.
fn le_bytes<T: Copy, const N: usize>(numbers: &[T], bytes_of: fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|&number| bytes_of(number)).collect()
}
