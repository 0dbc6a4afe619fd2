//! The balls' depth, smoothed to that of a surface, but not across steps: a bilateral filter of widening strides
//! (Dammertz et al. 2010, *Edge-Avoiding A-Trous Wavelet Transform for fast Global Illumination Filtering*), one axis
//! after the other, whose range is narrow as in Truong and Yuksel 2018, *A Narrow-Range Filter for Screen-Space Fluid
//! Rendering*.

use super::splat::Fluid;
use rayon::prelude::*;

/// Weights of the middle and its two neighbours to each side.
const KERNEL: [f32; 3] = [6.0 / 16.0, 4.0 / 16.0, 1.0 / 16.0];

/// Smooths depth and value over about `radius` pixels. Steps of the depth of more than `step` metres from pixel to
/// pixel stay as they are; what is further apart than `range` metres isn't mixed.
pub fn smooth(
    fluid: &mut [Fluid],
    spare: &mut Vec<Fluid>,
    width: usize,
    radius: f32,
    [step, range]: [f32; 2],
) {
    spare.resize(fluid.len(), Fluid::NONE);
    let reach = reach(fluid, width, step);
    let mut stride = 1;
    while (stride as f32) < radius {
        pass(fluid, spare, &reach, [width, 1, stride], range);
        pass(spare, fluid, &reach, [width, width, stride], range);
        stride *= 2;
    }
}

/// Pixels, along rows and columns together, to the nearest step or border: within them nothing but surface is met.
/// Rosenfeld and Pfaltz 1966, *Sequential Operations in Digital Picture Processing*.
fn reach(fluid: &[Fluid], width: usize, step: f32) -> Vec<u16> {
    let mut reach = vec![u16::MAX; fluid.len()];
    let count = fluid.len();
    let height = count / width;
    reach.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
        let inner = row > 0 && row + 1 < height;
        for (column, reach) in line.iter_mut().enumerate() {
            let at = row * width + column;
            let joined = |other: usize| joined(fluid[at], fluid[other], step);
            let whole = inner
                && column > 0
                && column + 1 < width
                && joined(at - 1)
                && joined(at + 1)
                && joined(at - width)
                && joined(at + width);
            *reach = if whole { u16::MAX } else { 0 };
        }
    });
    for at in width..count {
        let near = reach[at - 1].min(reach[at - width]).saturating_add(1);
        reach[at] = reach[at].min(near);
    }
    for at in (0..count - width).rev() {
        let near = reach[at + 1].min(reach[at + width]).saturating_add(1);
        reach[at] = reach[at].min(near);
    }
    reach
}

/// False where there is no fluid.
fn joined(a: Fluid, b: Fluid, step: f32) -> bool {
    (a.depth - b.depth).abs() < step
}

/// One axis: the picture's width, the distance of neighbours along the axis, and the stride are given.
fn pass(from: &[Fluid], to: &mut [Fluid], reach: &[u16], [width, along, stride]: [usize; 3], range: f32) {
    let inverse = 1.0 / (range * range);
    to.par_chunks_mut(width).enumerate().with_min_len(8).for_each(|(row, out)| {
        for (column, pixel) in out.iter_mut().enumerate() {
            let at = row * width + column;
            let centre = from[at];
            *pixel = centre;
            let reach = usize::from(reach[at]);
            if reach < stride || centre.depth == f32::INFINITY {
                continue;
            }
            let mut weights = KERNEL[0];
            let (mut depth, mut value) = (weights * centre.depth, weights * centre.value);
            for (n, &kernel) in KERNEL.iter().enumerate().skip(1) {
                let far = n * stride;
                // Both sides or none, so that the surface doesn't bend at borders and steps; and little by little,
                // so that it has no creases.
                if far > reach {
                    break;
                }
                let room = reach - far + 1;
                let kernel = if room < stride { kernel * (room as f32 / stride as f32) } else { kernel };
                for other in [from[at - far * along], from[at + far * along]] {
                    let square = (other.depth - centre.depth) * (other.depth - centre.depth) * inverse;
                    let near = (1.0 - square).max(0.0);
                    let weight = kernel * near * near;
                    weights += weight;
                    depth += weight * other.depth;
                    value += weight * other.value;
                }
            }
            (pixel.depth, pixel.value) = (depth / weights, value / weights);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bumps_go_and_steps_stay() {
        let (width, height) = (64, 48);
        let pixel = |n: usize| {
            let (x, y) = (n % width, n / width);
            let bump = 0.05 * ((x % 8) as f32 / 8.0 - 0.5) + 0.05 * ((y % 8) as f32 / 8.0 - 0.5);
            let depth = if x < 32 { 2.0 } else { 5.0 };
            let there = !(40..44).contains(&y);
            if there { Fluid { depth: depth + bump, value: depth, thickness: 1.0 } } else { Fluid::NONE }
        };
        let before: Vec<Fluid> = (0..width * height).map(pixel).collect();
        let mut fluid = before.clone();
        smooth(&mut fluid, &mut Vec::new(), width, 12.0, [0.3, 1.0]);
        let spread = |fluid: &[Fluid]| {
            let inner = (16..24).flat_map(|y| (12..20).map(move |x| fluid[y * width + x].depth));
            inner.clone().fold(0.0, f32::max) - inner.fold(f32::INFINITY, f32::min)
        };
        assert!(spread(&before) > 0.08 && spread(&fluid) < 0.01, "{} {}", spread(&before), spread(&fluid));
        for (n, (a, b)) in before.iter().zip(&fluid).enumerate() {
            assert!(a.depth == b.depth || (a.depth - b.depth).abs() < 0.1, "{n}: {a:?} {b:?}");
            assert!((a.value - b.value).abs() < 1e-4 && a.thickness == b.thickness, "{n}: {a:?} {b:?}");
        }
    }
}
