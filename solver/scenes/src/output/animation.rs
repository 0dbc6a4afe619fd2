//! All pictures of a run as one animated PNG: made at the end from the files of the pictures, one after the other, so
//! a run that was killed and goes on has them all, and memory holds two.

use super::io_error;
use crate::error::Error;
use std::io::{BufWriter, Error as IoError, ErrorKind};
use std::path::{Path, PathBuf};
use volmap_figures::picture::animation::{Animation, smaller};
use volmap_figures::picture::png;
use volmap_formats::asset::NewFile;

/// An animation.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationSettings {
    /// Pictures a second.
    pub frames_per_second: u16,
    /// So many pixels of the pictures, along each side, are one of the animation.
    pub reduction: u32,
}

impl Default for AnimationSettings {
    fn default() -> Self {
        AnimationSettings { frames_per_second: 25, reduction: 2 }
    }
}

/// Makes an animation of pictures, which are of one size and our own.
///
/// # Errors
/// A file that can't be read or written, or isn't such a picture.
pub fn write(path: &Path, pictures: &[PathBuf], settings: &AnimationSettings) -> Result<(), Error> {
    let read = |picture: &PathBuf| -> Result<([u32; 2], Vec<u8>), Error> {
        let file = std::fs::read(picture).map_err(io_error(picture))?;
        let foreign =
            || io_error(picture)(IoError::new(ErrorKind::InvalidData, "not a picture of this program"));
        let (size, rgb) = png::decode(&file).ok_or_else(foreign)?;
        Ok(smaller(size, &rgb, settings.reduction))
    };
    let Some((first, others)) = pictures.split_first() else { return Ok(()) };
    let (size, rgb) = read(first)?;
    let mut out = BufWriter::with_capacity(1 << 20, NewFile::create(path).map_err(io_error(path))?);
    let delay = [1, settings.frames_per_second.max(1)];
    let count = u32::try_from(pictures.len()).unwrap_or(u32::MAX);
    let mut animation = Animation::new(&mut out, size, count, delay).map_err(io_error(path))?;
    animation.add(&rgb).map_err(io_error(path))?;
    for picture in others {
        animation.add(&read(picture)?.1).map_err(io_error(path))?;
    }
    animation.finish().map_err(io_error(path))?;
    let file = out.into_inner().map_err(|error| io_error(path)(error.into_error()))?;
    file.publish().map_err(io_error(path))
}
