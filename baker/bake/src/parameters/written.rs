//! Values of a file, written as on the command line or as numbers.

use schemars::JsonSchema;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serializer};
use std::fmt::Display;
use std::str::FromStr;

/// A number, several, or a text as on the command line.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "give a number, a list of numbers, or a text as on the command line")]
#[schemars(inline)]
pub enum Written {
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
///
/// # Errors
/// What the value's own reader says, in the command line's words.
pub fn written<'de, T, D>(deserializer: D) -> Result<Option<T>, D::Error>
where
    T: FromStr<Err: Display>,
    D: Deserializer<'de>,
{
    let Some(written) = Option::<Written>::deserialize(deserializer)? else { return Ok(None) };
    let text = written.to_string();
    let value = text.parse().map_err(|error| D::Error::custom(format!("invalid value `{text}`: {error}")))?;
    Ok(Some(value))
}

/// Writes a value as its text.
///
/// # Errors
/// The serializer's.
pub fn displayed<T: Display, S: Serializer>(value: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
    match value {
        Some(value) => serializer.collect_str(value),
        None => serializer.serialize_none(),
    }
}
