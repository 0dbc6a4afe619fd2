//! The types of parameters' values: each is read from a text, as on the command line, and from a document.

use super::number::{Angle, Numbers, Resolution, Scale, Unit};
use super::part::{RadiusPart, RoundingPart, Tolerance};
use super::size::ByteSize;
use crate::density_map::parse_kernel;
use crate::primitive::Primitive;
use crate::volume_map::quadrature::Rule;
use schemars::JsonSchema;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt::{self, Debug, Display, Formatter};
use std::str::FromStr;
use volmap_runtime::KernelKind;

/// A type of values. Its own reader refuses what is never a value of it; a row's range what this parameter can't be.
pub trait ParameterValue:
    Copy + PartialEq + Debug + FromStr<Err: Display> + Serialize + DeserializeOwned + JsonSchema
{
    /// Its words, if it is one of a few.
    const WORDS: &'static [&'static str] = &[];
    /// Whether an option without a value means `true`.
    const IS_FLAG: bool = false;

    /// The numbers that a range limits.
    fn numbers(self) -> Vec<f64> {
        Vec::new()
    }

    /// True or false, if it is a flag.
    fn flag(self) -> Option<bool> {
        None
    }
}

impl ParameterValue for f64 {
    fn numbers(self) -> Vec<f64> {
        vec![self]
    }
}

impl ParameterValue for bool {
    const IS_FLAG: bool = true;

    fn flag(self) -> Option<bool> {
        Some(self)
    }
}

impl ParameterValue for Resolution {
    fn numbers(self) -> Vec<f64> {
        self.0.map(f64::from).to_vec()
    }
}

impl ParameterValue for Scale {
    fn numbers(self) -> Vec<f64> {
        self.0.to_vec()
    }
}

impl<const N: usize> ParameterValue for Numbers<N> {
    fn numbers(self) -> Vec<f64> {
        self.0.to_vec()
    }
}

impl ParameterValue for Unit {}
impl ParameterValue for Angle {}
impl ParameterValue for ByteSize {}
impl ParameterValue for RadiusPart {}
impl ParameterValue for Tolerance {}
impl ParameterValue for RoundingPart {}
impl ParameterValue for Rule {}
impl ParameterValue for DensityKernel {}
impl ParameterValue for Primitive {}

/// An SPH kernel that a density map can be baked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DensityKernel(pub KernelKind);

impl FromStr for DensityKernel {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        parse_kernel(text).map(DensityKernel)
    }
}

impl Display for DensityKernel {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        f.write_str(self.0.name())
    }
}

/// Rules and kernels are their names.
macro_rules! by_name {
    ($($type:ty),+) => { $(
        impl Serialize for $type {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> Deserialize<'de> for $type {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                super::written::deserialize(deserializer)
            }
        }

        impl JsonSchema for $type {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> std::borrow::Cow<'static, str> {
                "Name".into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                String::json_schema(generator)
            }
        }
    )+ };
}

by_name!(Rule, DensityKernel);
