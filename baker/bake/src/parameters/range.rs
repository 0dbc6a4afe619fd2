//! What the numbers of a parameter may be, beyond what their type says.

/// What numbers may be, beyond what their type says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Whatever their type says.
    Any,
    /// A length of either sign.
    Length,
    /// A length, or 0.
    LengthFromZero,
    /// A length.
    PositiveLength,
    /// None of them 0.
    NotZero,
    /// Three lower ends and three upper ends, each below its upper one.
    Box,
}

/// Lengths beyond this are mistakes, metres.
const MAX_LENGTH: f64 = 1e12;

impl Range {
    /// Whether these numbers can be used.
    pub(super) fn check(self, numbers: &[f64]) -> Result<(), String> {
        numbers.iter().try_for_each(|&number| self.check_number(number))?;
        let is_box = |[low @ .., _, _, _]: &[f64; 6]| low.iter().zip(&numbers[3..]).all(|(a, b)| a < b);
        match (self, <&[f64; 6]>::try_from(numbers)) {
            (Range::Box, Ok(corners)) if !is_box(corners) => {
                Err("is not a box; give xmin, ymin, zmin, xmax, ymax, zmax".into())
            }
            _ => Ok(()),
        }
    }

    fn check_number(self, number: f64) -> Result<(), String> {
        let is_length = matches!(self, Range::Length | Range::LengthFromZero | Range::PositiveLength);
        match self {
            _ if is_length && !(-MAX_LENGTH..=MAX_LENGTH).contains(&number) => {
                Err(format!("{number} is not a usable length"))
            }
            Range::PositiveLength if number <= 0.0 => Err(format!("{number} is not positive")),
            Range::LengthFromZero if number < 0.0 => Err(format!("{number} is negative")),
            Range::NotZero if number == 0.0 => Err("is 0".into()),
            _ => Ok(()),
        }
    }
}
