//! Real numbers as 16-bit multiples of a step, with a bound on what that changes.
//!
//! The step divides a natural unit (the support radius, the volume of the full ball) into whole parts, so that zero
//! and the unit are kept. A value x becomes the nearest multiple, at most step / 2 away.

/// Numbers in steps; the product with the step is taken in f64.
#[derive(Clone, Debug, PartialEq)]
pub struct Rounded {
    /// Whole numbers of steps.
    pub multiples: Vec<i16>,
    /// In the unit of the numbers, positive.
    pub step: f64,
    /// No number differs by more from what it was before; in the unit of the numbers.
    pub max_error: f64,
}

/// Why numbers can't be rounded as asked.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RoundingError {
    /// The largest number has more steps than 16 bits count.
    #[error("16 bits are too few for it; at least {} % is possible", percent_above(*.smallest))]
    TooFine {
        /// The smallest fraction of the unit that is possible.
        smallest: f64,
    },
    /// The largest number is more than 16 bits count even in steps of half the unit.
    #[error("16 bits are too few for values so large; take smaller cells, or f32")]
    TooLarge,
    /// The fraction isn't between 0 and 1/2, or a number isn't finite.
    #[error("it isn't between 0 and 50 %, or there are values that aren't finite")]
    NotANumber,
}

/// Largest count of steps.
const MOST: f64 = i16::MAX as f64;

impl Rounded {
    /// Rounds `values` so that none changes by more than `fraction` of `unit` (positive). That is checked.
    ///
    /// # Errors
    /// A fraction so small that 16 bits don't hold the largest value, or that isn't between 0 and 1/2; values that
    /// aren't finite.
    pub fn new(values: &[f64], unit: f64, fraction: f64) -> Result<Rounded, RoundingError> {
        if !(fraction > 0.0 && fraction < 0.5) {
            return Err(RoundingError::NotANumber);
        }
        // One part more than needed leaves room for the rounding of the arithmetic itself.
        let parts = (0.5 / fraction).floor() + 1.0;
        let largest = values.iter().fold(0.0f64, |largest, x| largest.max(x.abs()));
        if (largest / (unit / parts)).round() > MOST {
            let most_parts = (MOST * unit / largest).floor();
            if most_parts < 2.0 {
                return Err(RoundingError::TooLarge);
            }
            return Err(RoundingError::TooFine { smallest: 0.5 / most_parts });
        }
        let (step, max_error) = (unit / parts, fraction * unit);
        // Saturates: what doesn't fit or isn't a number is found by the check.
        let multiples = values.iter().map(|x| (x / step).round() as i16).collect();
        let rounded = Rounded { multiples, step, max_error };
        match rounded.worst_error(values) <= max_error {
            true => Ok(rounded),
            false => Err(RoundingError::NotANumber),
        }
    }

    /// The numbers.
    pub fn values(&self) -> impl Iterator<Item = f64> + '_ {
        self.multiples.iter().map(|&steps| f64::from(steps) * self.step)
    }

    /// The largest difference from `values`; infinite if one of them isn't a number.
    pub fn worst_error(&self, values: &[f64]) -> f64 {
        let larger = |worst: f64, error: f64| if error.is_nan() { f64::INFINITY } else { worst.max(error) };
        self.values().zip(values).map(|(rounded, exact)| (rounded - exact).abs()).fold(0.0, larger)
    }
}

/// A fraction as per cent with three digits, rounded up: what is named is possible.
fn percent_above(fraction: f64) -> f64 {
    let percent = 100.0 * fraction;
    let digit = 10f64.powf(percent.log10().floor() - 2.0);
    let above = ((percent / digit).ceil() + 1.0) * digit;
    // Without the digits that binary arithmetic adds.
    format!("{above:.2e}").parse().unwrap_or(above)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_value_changes_by_more_than_the_bound() {
        let values: Vec<f64> = (-5000..5000).map(|i| f64::from(i) * 3.7e-5).collect();
        for fraction in [5e-5, 1e-4, 1.234e-3, 0.1, 0.4999] {
            let rounded = Rounded::new(&values, 0.1, fraction).unwrap();
            assert_eq!(rounded.max_error, fraction * 0.1);
            let worst = rounded.worst_error(&values);
            assert!(worst <= rounded.max_error && worst > 0.5 * rounded.max_error, "{fraction}: {worst}");
        }
    }

    #[test]
    fn zero_and_the_unit_are_kept() {
        let unit = 0.1;
        for fraction in [2e-5, 1e-4, 0.003] {
            let rounded = Rounded::new(&[0.0, unit, -unit], unit, fraction).unwrap();
            let values: Vec<f64> = rounded.values().collect();
            assert_eq!(values[0], 0.0);
            assert!((values[1] - unit).abs() <= f64::EPSILON * unit && values[2] == -values[1], "{values:?}");
        }
    }

    #[test]
    fn the_smallest_bound_that_is_named_is_possible_and_half_of_it_is_not() {
        for largest in [0.05, 0.1, 0.2713, 3.0] {
            let values = [-largest, 0.0123];
            let Err(error @ RoundingError::TooFine { smallest }) = Rounded::new(&values, 0.1, 1e-9) else {
                panic!("{largest} fits");
            };
            let named: f64 = error.to_string().split_whitespace().rev().nth(3).unwrap().parse().unwrap();
            assert!(named >= 100.0 * smallest && named < 103.0 * smallest, "{error}");
            assert!(Rounded::new(&values, 0.1, named / 100.0).is_ok(), "{error}");
            assert!(Rounded::new(&values, 0.1, 0.49 * smallest).is_err());
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(Rounded::new(&[0.0, value], 1.0, 0.01).is_err());
        }
        for fraction in [0.0, -0.1, 0.5, 1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(Rounded::new(&[0.0], 1.0, fraction), Err(RoundingError::NotANumber));
        }
    }
}
