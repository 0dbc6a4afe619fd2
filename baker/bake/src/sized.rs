//! The least error that a file of a given size can have: bakes for several tolerances, the size of each measured.
//!
//! Bytes fall as a power of the tolerance, about its -1.1th, so that a few steps by the power through the last two (the
//! secant of their logarithms) come close.

use crate::error::Error;
use crate::settings::{TOLERANCES, Tolerances};
use volmap_formats::text::{bytes, percent};

/// Where the search begins.
const FIRST: f64 = 0.01;
/// Bakes at most.
const TRIES: usize = 10;
/// Files from this part of the size on are good enough, and what is aimed at.
const ENOUGH: f64 = 0.9;
const AIM: f64 = 0.96;
/// Tolerances that differ by less are as good.
const SAME: f64 = 1.03;
/// Power of the size by which the tolerance changes, before it is known, and by how much at most.
const POWER: f64 = -0.9;
const MOST: f64 = 8.0;

/// The best of the bakes whose files are small enough: that with the smallest tolerance. With it come the tolerances of
/// the volume that were tried, and the bytes of their files. `bytes` is the size of a bake's file.
///
/// # Errors
/// A size that no tolerance reaches; as the bakes.
pub(crate) fn least_error<B>(
    limit: u64,
    bake: impl Fn(Tolerances) -> Result<B, Error>,
    bytes: impl Fn(&B) -> Result<u64, Error>,
) -> Result<(B, Vec<(f64, u64)>), Error> {
    let mut search = Search { limit: limit as f64, fits: None, too_large: None };
    let (mut tried, mut best) = (Vec::new(), None);
    let mut next = Some(FIRST);
    while let Some(tolerance) = next.filter(|_| tried.len() < TRIES) {
        let baked = match bake(Tolerances::of_volume(tolerance)) {
            // Smaller cells than memory has room for: as if the file were too large.
            Err(Error::Memory { .. }) if best.is_some() => break,
            other => other?,
        };
        let size = bytes(&baked)?;
        tried.push((tolerance, size));
        if size <= limit {
            best = Some(baked);
        }
        next = search.after(tolerance, size as f64);
    }
    let best = best.ok_or_else(|| too_small(limit, &tried))?;
    Ok((best, tried))
}

fn too_small(limit: u64, tried: &[(f64, u64)]) -> Error {
    let smallest = tried.iter().min_by_key(|(_, size)| *size);
    let reached = smallest.map_or(String::new(), |(tolerance, size)| {
        format!(": at a tolerance of {} of the ball it takes {}", percent(*tolerance), bytes(*size))
    });
    let reason = format!(
        "no map of this mesh fits into {}{reached}; allow more, or take a larger support radius",
        bytes(limit)
    );
    Error::setting("max_bytes", reason)
}

/// What is known of sizes.
struct Search {
    limit: f64,
    /// The smallest tolerance whose file is small enough, and its bytes.
    fits: Option<[f64; 2]>,
    /// The largest one whose file isn't.
    too_large: Option<[f64; 2]>,
}

impl Search {
    /// The tolerance to try after one with a file of so many bytes; none if that was good enough.
    fn after(&mut self, tolerance: f64, bytes: f64) -> Option<f64> {
        let [least, most] = TOLERANCES;
        let fits = bytes <= self.limit;
        let kept = if fits { &mut self.fits } else { &mut self.too_large };
        *kept = Some([tolerance, bytes]);
        if fits && (bytes >= ENOUGH * self.limit || tolerance <= least) {
            return None;
        }
        let wanted = AIM * self.limit;
        let next = match (self.fits, self.too_large) {
            (Some([upper, few]), Some([lower, many])) => {
                if upper <= SAME * lower {
                    return None;
                }
                let part = ((many / wanted).ln() / (many / few).ln()).clamp(0.1, 0.9);
                lower * (upper / lower).powf(part)
            }
            _ if !fits && tolerance >= most => return None,
            _ => tolerance * (wanted / bytes).powf(POWER).clamp(1.0 / MOST, MOST),
        };
        Some(next.clamp(least, most))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sizes by a power law with steps, as files have.
    fn bytes(tolerance: f64, power: f64) -> f64 {
        (2e5 * (tolerance / 0.01).powf(power) / 3e3).ceil() * 3e3
    }

    #[test]
    fn a_tolerance_is_found_whose_file_is_nearly_as_large_as_allowed() {
        for power in [-0.3, -0.7, -1.2] {
            for limit in [5e4, 1.9e5, 2e5, 4e5, 1e6] {
                let mut search = Search { limit, fits: None, too_large: None };
                let (mut next, mut tries) = (Some(FIRST), 0);
                while let Some(tolerance) = next.filter(|_| tries < TRIES) {
                    next = search.after(tolerance, bytes(tolerance, power));
                    tries += 1;
                }
                let [least, most] = TOLERANCES;
                let reachable = bytes(most, power) <= limit;
                assert_eq!(search.fits.is_some(), reachable, "{power}, {limit}");
                if let Some([tolerance, size]) = search.fits {
                    assert!(
                        size <= limit && (size >= 0.9 * limit || tolerance <= least),
                        "{power}, {limit}: {size}"
                    );
                }
            }
        }
    }
}
