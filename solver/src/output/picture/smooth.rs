//! The balls' depth, smoothed to that of a surface, but not across steps: a bilateral filter of widening strides
//! (Dammertz et al. 2010, *Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering*), one axis
//! after the other, whose range is narrow as in Truong and Yuksel 2018, *A Narrow-Range Filter for Screen-Space Fluid
//! Rendering*.

use super::splat::Fluid;
use rayon::prelude::*;

/// Weights of the middle and its two neighbours to each side.
const KERNEL: [f32; 3] = [6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Smooths depth and value over about `radius` pixels; steps of the depth of more than `range` metres stay.
pub fn smooth(fluid: &mut Vec<Fluid>, spare: &mut Vec<Fluid>, width: usize, radius: f32, range: f32) {
    spare.resize(fluid.len(), Fluid::NONE);
    let mut stride = 1;
    while (stride as f32) < radius {
        pass(fluid, spare, [width, 1], stride, range);
        pass(spare, fluid, [width, width], stride, range);
        stride *= 2;
    }
}

/// One axis: neighbours are `step` apart, in `[width, step]`.
fn pass(from: &[Fluid], to: &mut [Fluid], [width, step]: [usize; 2], stride: usize, range: f32) {
    let height = from.len() / width;
    let inverse = 1.0 / (range * range);
    to.par_chunks_mut(width).enumerate().with_min_len(8).for_each(|(row, out)| {
        let line = &from[row * width..][..width];
        for (column, pixel) in out.iter_mut().enumerate() {
            let centre = line[column];
            *pixel = centre;
            if centre.depth == f32::INFINITY {
                continue;
            }
            let (at, end) = if step == 1 { (column, width) } else { (row, height) };
            let (mut weights, mut depth, mut value) =
                (KERNEL[0], KERNEL[0] * centre.depth, KERNEL[0] * centre.value);
            for (n, &weight) in KERNEL.iter().enumerate().skip(1) {
                let far = n * stride;
                let index = row * width + column;
                let pair =
                    [(at >= far).then(|| index - far * step), (at + far < end).then(|| index + far * step)];
                // Both or none, so that the surface doesn't bend at borders and steps.
                let [Some(a), Some(b)] = pair.map(|n| n.map(|n| from[n])) else { continue };
                let closeness = |other: Fluid| {
                    let square = (other.depth - centre.depth) * (other.depth - centre.depth) * inverse;
                    if square < 1.0 { (1.0 - square) * (1.0 - square) } else { 0.0 }
                };
                let (near_a, near_b) = (closeness(a), closeness(b));
                let (wa, wb) = (weight * near_a, weight * near_b);
                let side = |w: f32, x: f32| if w > 0.0 { w * x } else { 0.0 };
                weights += wa + wb;
                depth += side(wa, a.depth) + side(wb, b.depth);
                value += side(wa, a.value) + side(wb, b.value);
            }
            (pixel.depth, pixel.value) = (depth / weights, value / weights);
        }
    });
}
