//! Parameters that are numbers, or several with commas between.

use serde::{Serialize, Serializer};
use std::str::FromStr;

/// Several finite numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Numbers<const N: usize>(pub [f64; N]);

/// Cells along x, y and z.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct Resolution(pub [u32; 3]);

/// Scale along x, y and z.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Scale(pub [f64; 3]);

/// Metres of a unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Unit(pub f64);

/// An angle in degrees, above 0 and at most 90.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(transparent)]
pub struct Angle(pub f64);

/// Names of units, and their metres.
const UNITS: [(&str, f64); 8] = [
    ("m", 1.0),
    ("dm", 0.1),
    ("cm", 0.01),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("km", 1e3),
    ("in", 0.0254),
    ("ft", 0.3048),
];

/// Values with commas between; none if one isn't a `T`.
pub fn list<T: FromStr>(text: &str) -> Option<Vec<T>> {
    text.split(',').map(|part| part.trim().parse().ok()).collect()
}

impl<const N: usize> Serialize for Numbers<N> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.as_slice().serialize(serializer)
    }
}

impl<const N: usize> FromStr for Numbers<N> {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = list::<f64>(text).and_then(|list| <[f64; N]>::try_from(list).ok());
        let numbers = numbers.filter(|list| list.iter().all(|x| x.is_finite()));
        numbers.map(Numbers).ok_or_else(|| format!("give {N} finite numbers with commas between"))
    }
}

impl FromStr for Resolution {
    type Err = String;

    fn from_str(text: &str) -> Result<Resolution, String> {
        match list::<u32>(text).as_deref() {
            Some([n]) => Ok(Resolution([*n; 3])),
            Some([x, y, z]) => Ok(Resolution([*x, *y, *z])),
            _ => Err("give N, or NX,NY,NZ".into()),
        }
    }
}

impl FromStr for Scale {
    type Err = String;

    fn from_str(text: &str) -> Result<Scale, String> {
        match list::<f64>(text).as_deref() {
            Some([s]) if s.is_finite() => Ok(Scale([*s; 3])),
            _ => text
                .parse()
                .map(|Numbers(scale)| Scale(scale))
                .map_err(|_: String| "give S, or SX,SY,SZ".into()),
        }
    }
}

impl FromStr for Angle {
    type Err = String;

    fn from_str(text: &str) -> Result<Angle, String> {
        let number = text.strip_suffix("deg").unwrap_or(text).trim().parse::<f64>().ok();
        let angle = number.filter(|degrees| *degrees > 0.0 && *degrees <= 90.0);
        angle.map(Angle).ok_or_else(|| "give an angle in degrees, as 3deg or 3, at most 90".into())
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Unit, String> {
        let named = UNITS.iter().find(|(name, _)| *name == text).map(|(_, metres)| *metres);
        let number = || text.parse().ok().filter(|x: &f64| *x > 0.0 && x.is_finite());
        let metres = named.or_else(number);
        metres.map(Unit).ok_or_else(|| "give m, cm, mm, um, km, in, ft, or metres as a number".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_units() {
        assert_eq!("mm".parse(), Ok(Unit(1e-3)));
        assert!(["furlong", "0", "inf", "-1"].iter().all(|text| text.parse::<Unit>().is_err()));
        assert_eq!(("3deg".parse(), "0.5".parse()), (Ok(Angle(3.0)), Ok(Angle(0.5))));
        assert!(["0", "91deg", "-1", "3rad", "nan"].iter().all(|text| text.parse::<Angle>().is_err()));
        assert_eq!("20".parse(), Ok(Resolution([20; 3])));
        assert_eq!(" 1, 2 ,3".parse(), Ok(Resolution([1, 2, 3])));
        assert!(["20,30", "-1", ""].iter().all(|text| text.parse::<Resolution>().is_err()));
        assert_eq!(("2".parse(), "1,-2,3".parse()), (Ok(Scale([2.0; 3])), Ok(Scale([1.0, -2.0, 3.0]))));
        assert!(["1,2", "nan"].iter().all(|text| text.parse::<Scale>().is_err()));
        assert_eq!("1,2,3,4".parse(), Ok(Numbers([1.0, 2.0, 3.0, 4.0])));
        assert!(["1,2,3", "1,2,3,inf", "a,b,c,d"].iter().all(|text| text.parse::<Numbers<4>>().is_err()));
    }
}
