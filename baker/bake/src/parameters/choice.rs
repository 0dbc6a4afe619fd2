//! Parameters that are one of a few words.

use super::value::ParameterValue;
use crate::sdf::SignMethod;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::str::FromStr;
use volmap_formats::asset::Compression;
use volmap_formats::mesh::UpAxis;

/// The axis of a mesh file that points up, by name.
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum Up {
    X,
    #[default]
    Y,
    Z,
}

/// Precision of the stored fields, by name.
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum PrecisionName {
    #[default]
    F32,
    F64,
}

/// How datasets are compressed, by name.
#[allow(missing_docs)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(inline)]
pub enum CompressionName {
    #[default]
    Gzip,
    Zstd,
}

/// The words of an enumeration, for texts; serde has the same words by its own attributes.
macro_rules! words {
    ($($type:ident { $($word:literal => $variant:ident),+ })+) => { $(
        impl ParameterValue for $type {
            const WORDS: &'static [&'static str] = &[$($word),+];
        }

        impl FromStr for $type {
            type Err = String;

            fn from_str(text: &str) -> Result<$type, String> {
                match text {
                    $($word => Ok($type::$variant),)+
                    _ => Err(format!("give one of: {}", $type::WORDS.join(", "))),
                }
            }
        }
    )+ };
}

words! {
    SignMethod { "auto" => Auto, "pseudonormal" => Pseudonormal, "winding" => Winding }
    Up { "x" => X, "y" => Y, "z" => Z }
    PrecisionName { "f32" => F32, "f64" => F64 }
    CompressionName { "gzip" => Gzip, "zstd" => Zstd }
}

impl From<Up> for UpAxis {
    fn from(up: Up) -> UpAxis {
        match up {
            Up::X => UpAxis::X,
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        }
    }
}

impl From<CompressionName> for Compression {
    fn from(name: CompressionName) -> Compression {
        match name {
            CompressionName::Gzip => Compression::default(),
            CompressionName::Zstd => Compression::Zstd(3),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn same_in_texts_and_documents<T: ParameterValue>() {
        for word in T::WORDS {
            let read = word.parse::<T>().map_err(|error| error.to_string()).unwrap();
            assert_eq!(serde_json::to_value(read).unwrap(), *word);
            assert_eq!(serde_json::from_value::<T>((*word).into()).unwrap(), read);
        }
        assert!("none of them".parse::<T>().is_err());
    }

    #[test]
    fn words_are_the_same_everywhere() {
        same_in_texts_and_documents::<SignMethod>();
        same_in_texts_and_documents::<Up>();
        same_in_texts_and_documents::<PrecisionName>();
        same_in_texts_and_documents::<CompressionName>();
    }
}
