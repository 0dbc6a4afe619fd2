//! How coarse a file's coordinates are. Far from the origin, single precision and six or seven printed digits leave
//! steps that can be larger than the cells: what the surface then is, is lost in the file.

/// Digits that programs print, or that single precision has.
const DECIMAL_DIGITS: [i32; 2] = [6, 7];
/// Bits of single precision.
const SINGLE_BITS: i32 = 23;
/// Values that an axis has at least before its step is looked for: a box or a plate has fewer, however exact.
const DISTINCT: usize = 4;
/// Part of a step by which a multiple may be off.
const OFF: f64 = 1e-4;

/// Largest step of the coordinates along an axis, in the file's unit, if they look rounded to one: all are its
/// multiples and the largest has as many digits as single precision or a printed number of 6 or 7 digits.
pub fn coordinate_step(positions: &[[f64; 3]]) -> Option<f64> {
    (0..3).filter_map(|axis| step_along(positions, axis)).reduce(f64::max)
}

fn step_along(positions: &[[f64; 3]], axis: usize) -> Option<f64> {
    let values = || positions.iter().map(|position| position[axis]);
    let largest = values().fold(0.0, |most: f64, x| most.max(x.abs()));
    if largest < f64::MIN_POSITIVE || !largest.is_finite() {
        return None;
    }
    let binary = largest.log2().floor() as i32 - SINGLE_BITS;
    let decimal = DECIMAL_DIGITS.map(|digits| largest.log10().floor() as i32 + 1 - digits);
    let steps = [2f64.powi(binary), 10f64.powi(decimal[0]), 10f64.powi(decimal[1])];
    let is_multiple = |step: f64| values().all(|x| (x / step - (x / step).round()).abs() <= OFF);
    let step = steps.into_iter().filter(|&step| step > 0.0 && is_multiple(step)).reduce(f64::max)?;
    has_distinct(values()).then_some(step)
}

fn has_distinct(values: impl Iterator<Item = f64>) -> bool {
    let mut seen: Vec<f64> = Vec::new();
    for value in values {
        if !seen.contains(&value) {
            seen.push(value);
        }
        if seen.len() >= DISTINCT {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circle(centre: f64, stored: impl Fn(f64) -> f64) -> Vec<[f64; 3]> {
        (0..100).map(|i| [stored(centre + (f64::from(i) * 0.0628).sin()), 0.0, 1.0]).collect()
    }

    #[test]
    fn rounded_numbers_far_from_the_origin_show_their_step() {
        let single = |x: f64| f64::from(x as f32);
        assert_eq!(coordinate_step(&circle(4_650_000.0, single)), Some(0.5));
        assert_eq!(coordinate_step(&circle(500_000.0, single)), Some(0.03125));
        let tens = circle(0.0, |x| ((4_650_000.0 + 100.0 * x) / 10.0).round() * 10.0);
        assert_eq!(coordinate_step(&tens), Some(10.0), "six digits printed");
        assert_eq!(coordinate_step(&circle(4_650_000.0, f64::round)), None, "fewer than 4 values");
        let ring = circle(0.0, |x| (4_650_000.0 + 100.0 * x).round());
        assert_eq!(coordinate_step(&ring), Some(1.0), "seven digits printed");
    }

    #[test]
    fn exact_numbers_have_none() {
        assert_eq!(coordinate_step(&circle(4_650_000.0, |x| x)), None);
        // Few digits may be all that there are.
        let whole = [[0.0, 0.0, 0.0], [1.0, 0.5, 2.0], [3.0, 7.0, 2.0], [5.0, 4.0, 9.0]];
        assert!(coordinate_step(&whole).unwrap() < 2e-5);
        assert_eq!(coordinate_step(&[]), None);
    }
}
