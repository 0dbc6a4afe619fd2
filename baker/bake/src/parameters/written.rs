//! Values of a document, written as on the command line or as numbers.

use super::number::{Angle, Numbers, Resolution, Scale, Unit};
use super::part::{Fraction, RadiusPart, RoundingPart, Tolerance};
use super::size::ByteSize;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::borrow::Cow;
use std::fmt::Display;
use std::str::FromStr;

/// A number, several, or a text as on the command line.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "give a number, a list of numbers, or a text as on the command line")]
enum Written {
    /// As 0.01.
    Number(f64),
    /// As [40, 30, 20].
    Numbers(Vec<f64>),
    /// As "1%" or "40,30,20".
    Text(String),
}

impl Display for Written {
    /// As on the command line.
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Written::Number(number) => number.fmt(f),
            Written::Numbers(numbers) => {
                f.write_str(&numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(","))
            }
            Written::Text(text) => f.write_str(text),
        }
    }
}

/// Reads a value as the command line does: one reader, one set of errors.
pub(super) fn deserialize<'de, T, D>(deserializer: D) -> Result<T, D::Error>
where
    T: FromStr<Err: Display>,
    D: Deserializer<'de>,
{
    let text = Written::deserialize(deserializer)?.to_string();
    text.parse().map_err(|error| D::Error::custom(format!("invalid value `{text}`: {error}")))
}

macro_rules! as_written {
    ($([$($generic:tt)*] $type:ty),+) => { $(
        impl<'de, $($generic)*> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                deserialize(deserializer)
            }
        }

        impl<$($generic)*> JsonSchema for $type {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> Cow<'static, str> {
                "Written".into()
            }

            fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                Written::json_schema(generator)
            }
        }
    )+ };
}

as_written!([] Resolution, [] Scale, [] Unit, [const N: usize] Numbers<N>);
as_written!([] Fraction, [] Tolerance, [] RadiusPart, [] RoundingPart, [] ByteSize, [] Angle);
