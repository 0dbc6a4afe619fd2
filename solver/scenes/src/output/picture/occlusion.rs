//! What lies behind its surroundings is darkened. Luft, Colditz and Deussen 2006, *Image Enhancement by Unsharp Masking
//! the Depth Buffer*.

use rayon::prelude::*;

/// How much a pixel lies behind the mean of its surroundings, in parts of `scale` metres, 0 to 1. Depths beyond `far`
/// count as `far`. The mean, which changes little from pixel to pixel, is that of every other row and column.
pub fn occlusion(depth: &[f32], width: usize, radius: usize, [scale, far]: [f32; 2]) -> Vec<f32> {
    let (half_width, half_radius) = (width.div_ceil(2), radius / 2);
    let rows = depth.chunks(width.max(1)).step_by(2);
    let mut mean: Vec<f32> = rows.flat_map(|row| row.iter().step_by(2).map(|&d| d.min(far))).collect();
    let half_height = mean.len() / half_width.max(1);
    for _ in 0..2 {
        mean = transposed(&blurred(&mean, half_width, half_radius), half_width);
        mean = transposed(&blurred(&mean, half_height, half_radius), half_height);
    }
    let mut out = vec![0.0; depth.len()];
    let rows = out.par_chunks_mut(width.max(1)).zip(depth.par_chunks(width.max(1))).enumerate();
    rows.with_min_len(8).for_each(|(row, (out, depth))| {
        let mean = &mean[row / 2 * half_width..][..half_width];
        for (column, (out, &depth)) in out.iter_mut().zip(depth).enumerate() {
            *out = ((depth.min(far) - mean[column / 2]) / scale).clamp(0.0, 1.0);
        }
    });
    out
}

/// Means over `2 radius + 1` pixels of a row; beyond its ends it goes on as it ends.
fn blurred(image: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let mut out = vec![0.0; image.len()];
    let inverse = 1.0 / (2 * radius + 1) as f64;
    out.par_chunks_mut(width).zip(image.par_chunks(width)).with_min_len(8).for_each(|(out, row)| {
        let at = |n: isize| f64::from(row[n.clamp(0, width as isize - 1) as usize]);
        let radius = radius as isize;
        let mut sum: f64 = (-radius..=radius).map(at).sum();
        for (n, pixel) in out.iter_mut().enumerate() {
            *pixel = (sum * inverse) as f32;
            sum += at(n as isize + radius + 1) - at(n as isize - radius);
        }
    });
    out
}

fn transposed(image: &[f32], width: usize) -> Vec<f32> {
    let height = image.len() / width.max(1);
    let mut out = vec![0.0; image.len()];
    out.par_chunks_mut(height).enumerate().for_each(|(column, out)| {
        out.iter_mut().enumerate().for_each(|(row, pixel)| *pixel = image[row * width + column]);
    });
    out
}
