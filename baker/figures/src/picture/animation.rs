//! Animated PNG files (third edition of the PNG standard, W3C 2025), written picture by picture: of each only the
//! rectangle that changed. Programs that know nothing of animations show the first picture.

use super::png::{Effort, encoder};
use png::{EncodingError, Writer};
use std::io::{self, Write};

/// Pictures of one size, one after the other, without end.
pub struct Animation<W: Write> {
    writer: Writer<W>,
    size: [u32; 2],
    announced: u32,
    written: u32,
    /// Pixels of the last picture.
    last: Vec<u8>,
}

impl<W: Write> Animation<W> {
    /// Begins an animation of `count` pictures (at least 1), each shown for `delay[0] / delay[1]` seconds.
    ///
    /// # Errors
    /// No picture at all, or the system's.
    pub fn new(out: W, size: [u32; 2], count: u32, delay: [u16; 2]) -> io::Result<Animation<W>> {
        let mut encoder = encoder(out, size, Effort::Small);
        // 0 repetitions: no end.
        encoder
            .set_animated(count, 0)
            .and_then(|()| encoder.set_frame_delay(delay[0], delay[1]))
            .map_err(io)?;
        let writer = encoder.write_header().map_err(io)?;
        Ok(Animation { writer, size, announced: count, written: 0, last: Vec::new() })
    }

    /// Adds a picture: red, green, blue, from the upper row down.
    ///
    /// # Errors
    /// Another size, more pictures than announced, or the system's.
    pub fn add(&mut self, rgb: &[u8]) -> io::Result<()> {
        let [width, height] = self.size.map(|n| n as usize);
        if rgb.len() != 3 * width * height {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "pictures of different sizes"));
        }
        if self.written == 0 {
            self.writer.write_image_data(rgb).map_err(io)?;
        } else {
            let [left, top, across, down] = changed(&self.last, rgb, width);
            let rows = rgb.chunks(3 * width).skip(top).take(down);
            let part: Vec<u8> = rows.flat_map(|row| &row[3 * left..3 * (left + across)]).copied().collect();
            self.add_part([left, top, across, down].map(|n| n as u32), &part).map_err(io)?;
        }
        self.written += 1;
        rgb.clone_into(&mut self.last);
        Ok(())
    }

    /// The new pixels take the place of the old ones; around them all stays as it is.
    fn add_part(&mut self, [left, top, across, down]: [u32; 4], rgb: &[u8]) -> Result<(), EncodingError> {
        // The rectangle of the picture before must not limit that of this one.
        self.writer.reset_frame_position()?;
        self.writer.set_frame_dimension(across, down)?;
        self.writer.set_frame_position(left, top)?;
        self.writer.write_image_data(rgb)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Another number of pictures than announced, or the system's.
    pub fn finish(self) -> io::Result<()> {
        if self.written != self.announced {
            let reason = format!("{} pictures, but {} announced", self.written, self.announced);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
        }
        self.writer.finish().map_err(io)
    }
}

fn io(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::new(io::ErrorKind::InvalidInput, other),
    }
}

/// The rectangle in which two pictures differ, of at least one pixel: left, top, width, height.
fn changed(a: &[u8], b: &[u8], width: usize) -> [usize; 4] {
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for (row, (a, b)) in a.chunks(3 * width).zip(b.chunks(3 * width)).enumerate() {
        let differs = |at: &usize| a[*at] != b[*at];
        if let (Some(first), Some(last)) = ((0..a.len()).find(differs), (0..a.len()).rfind(differs)) {
            low = [low[0].min(first / 3), low[1].min(row)];
            high = [high[0].max(last / 3 + 1), row + 1];
        }
    }
    match low[0] == usize::MAX {
        true => [0, 0, 1, 1],
        false => [low[0], low[1], high[0] - low[0], high[1] - low[1]],
    }
}

/// Means of squares of `times` x `times` pixels; what is left over at the right and below is cut off.
pub fn smaller([width, height]: [u32; 2], rgb: &[u8], times: u32) -> ([u32; 2], Vec<u8>) {
    let times = times.clamp(1, width.min(height).max(1));
    let (size, n) = ([width / times, height / times], times as usize);
    let mut out = Vec::with_capacity(3 * (size[0] * size[1]) as usize);
    for row in 0..size[1] as usize {
        for column in 0..size[0] as usize {
            for colour in 0..3 {
                let at = |i: usize, j: usize| {
                    u32::from(rgb[3 * ((n * row + j) * width as usize + n * column + i) + colour])
                };
                let sum: u32 = (0..n * n).map(|k| at(k % n, k / n)).sum();
                out.push(((sum + times * times / 2) / (times * times)) as u8);
            }
        }
    }
    (size, out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_changed_is_written() {
        let mut picture = vec![10u8; 3 * 8 * 6];
        let mut file = Vec::new();
        let mut animation = Animation::new(&mut file, [8, 6], 3, [1, 25]).unwrap();
        animation.add(&picture).unwrap();
        picture[3 * (2 * 8 + 3)] = 99;
        picture[3 * (4 * 8 + 5) + 2] = 99;
        animation.add(&picture).unwrap();
        animation.add(&picture).unwrap();
        assert!(animation.add(&picture[1..]).is_err());
        animation.finish().unwrap();
        let controls: Vec<&[u8]> = file
            .windows(4)
            .enumerate()
            .filter(|(_, w)| w == b"fcTL")
            .map(|(at, _)| &file[at + 4..][..26])
            .collect();
        let numbers = |control: &[u8]| -> Vec<u32> {
            control[..20].as_chunks().0.iter().map(|&n| u32::from_be_bytes(n)).collect()
        };
        assert_eq!(numbers(controls[0]), [0, 8, 6, 0, 0]);
        assert_eq!(numbers(controls[1]), [1, 3, 3, 3, 2]);
        assert_eq!(numbers(controls[2]), [3, 1, 1, 0, 0], "nothing changed");
        let short = Animation::new(Vec::new(), [8, 6], 1, [1, 25]).unwrap();
        assert!(short.finish().is_err());
    }

    #[test]
    fn smaller_pictures_are_means() {
        let rgb: Vec<u8> = (0..3 * 5 * 4).map(|n| n as u8).collect();
        let (size, out) = smaller([5, 4], &rgb, 2);
        assert_eq!((size, out.len()), ([2, 2], 12));
        assert_eq!(out[0], (3 + 15 + 18 + 2) / 4, "of bytes 0, 3, 15, 18");
        assert_eq!(smaller([5, 4], &rgb, 1), ([5, 4], rgb));
    }
}
