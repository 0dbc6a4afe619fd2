//! Rows of a picture in bands, each drawn by one thread: things are sorted into the bands that they touch, in their
//! order, so that the picture doesn't depend on the number of threads.

use rayon::prelude::*;
use std::ops::Range;

/// Rows of a band.
pub const BAND: usize = 16;
/// Things that are sorted at a time.
const CHUNK: usize = 1 << 14;

/// The numbers of the things that touch each band.
pub struct Bands {
    /// By chunks of things, then by bands.
    chunks: Vec<Vec<Vec<u32>>>,
}

impl Bands {
    /// `rows` are those that a thing touches; they may lie outside of the picture's `height`.
    pub fn new<T: Sync>(things: &[T], height: usize, rows: impl Fn(&T) -> Range<f32> + Sync) -> Bands {
        let count = height.div_ceil(BAND);
        let sort = |(chunk, things): (usize, &[T])| {
            let mut bands = vec![Vec::new(); count];
            for (number, thing) in things.iter().enumerate() {
                let Range { start, end } = rows(thing);
                // Casts end at the limits of the type; NaN is 0 .. 0.
                let (first, last) = ((start.max(0.0) as usize) / BAND, (end.max(0.0) as usize) / BAND);
                if start < height as f32 && end >= 0.0 {
                    let touched = &mut bands[first..(last + 1).min(count)];
                    touched.iter_mut().for_each(|band| band.push((chunk * CHUNK + number) as u32));
                }
            }
            bands
        };
        Bands { chunks: things.par_chunks(CHUNK).enumerate().map(sort).collect() }
    }

    /// The things of a band, by their numbers.
    pub fn of(&self, band: usize) -> impl Iterator<Item = usize> + '_ {
        self.chunks.iter().flat_map(move |bands| bands[band].iter().map(|&number| number as usize))
    }
}
