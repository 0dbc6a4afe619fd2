//! Parameters that are a part of a whole, as 0.01 or 1%.

use crate::settings::{DISTANCE_TOLERANCES, TOLERANCES};
use serde::Serialize;
use std::str::FromStr;

/// A part, positive.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
#[serde(transparent)]
pub struct Fraction(pub f64);

/// Part of the full ball that cells may be searched for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Tolerance(pub f64);

/// Part of the support radius that a distance may be wrong by.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct RadiusPart(pub f64);

/// Part by which rounding to 16 bits may change a value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct RoundingPart(pub f64);

/// A part of a whole, as a number or in per cent.
fn fraction(text: &str) -> Option<f64> {
    let (number, whole) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 100.0));
    number.trim().parse::<f64>().ok().map(|x| x / whole)
}

impl FromStr for Fraction {
    type Err = String;

    fn from_str(text: &str) -> Result<Fraction, String> {
        let part = fraction(text).filter(|part| *part > 0.0 && part.is_finite());
        part.map(Fraction).ok_or_else(|| "give a part of the ball, as 0.5% or 0.005".into())
    }
}

impl FromStr for Tolerance {
    type Err = String;

    fn from_str(text: &str) -> Result<Tolerance, String> {
        let [least, most] = TOLERANCES;
        let part = fraction(text).filter(|part| (least..=most).contains(part));
        part.map(Tolerance).ok_or_else(|| {
            format!("give {}% to {}%, or the same as a number, as 0.01", 100.0 * least, 100.0 * most)
        })
    }
}

impl FromStr for RadiusPart {
    type Err = String;

    fn from_str(text: &str) -> Result<RadiusPart, String> {
        let [least, most] = DISTANCE_TOLERANCES;
        let part = fraction(text).filter(|part| (least..=most).contains(part));
        part.map(RadiusPart).ok_or_else(|| {
            format!(
                "give {}% to {}% of the support radius, or the same as a number",
                100.0 * least,
                100.0 * most
            )
        })
    }
}

impl FromStr for RoundingPart {
    type Err = String;

    fn from_str(text: &str) -> Result<RoundingPart, String> {
        let part = fraction(text).filter(|part| *part > 0.0 && *part < 0.5);
        part.map(RoundingPart).ok_or_else(|| "give a part as 0.01%, or 1e-4, below 50%".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_ranges() {
        assert_eq!("0.01%".parse::<RoundingPart>(), "1e-4".parse());
        let bad = ["0", "-1%", "50%", "much", "nan", "1"];
        assert!(bad.iter().all(|text| text.parse::<RoundingPart>().is_err()));
        assert_eq!(("1%".parse(), "0.01".parse()), (Ok(Tolerance(0.01)), Ok(Tolerance(0.01))));
        assert!(["0", "200%", "NaN"].iter().all(|text| text.parse::<Tolerance>().is_err()));
        assert_eq!("150 %".parse(), Ok(Fraction(1.5)));
        assert!(["0", "inf", "-1%", "%"].iter().all(|text| text.parse::<Fraction>().is_err()));
    }
}
