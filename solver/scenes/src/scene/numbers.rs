//! Boxes, rotations and numbers that may be one or three.

use glam::{DQuat, DVec3};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;
use volmap_documents::{At, Checked};

/// A box along the axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Lowest corner, metres.
    pub min: [f64; 3],
    /// Highest corner, metres.
    pub max: [f64; 3],
}

impl Region {
    /// Whether a point lies in it.
    pub fn contains(&self, point: DVec3) -> bool {
        let [min, max] = self.corners();
        point.cmpge(min).all() && point.cmple(max).all()
    }

    /// Lowest and highest corner, metres.
    pub fn corners(&self) -> [DVec3; 2] {
        [self.min.into(), self.max.into()]
    }

    pub(super) fn check(&self, at: &At) -> Checked {
        at.vector("min", self.min)?;
        at.vector("max", self.max)?;
        let ordered = (0..3).all(|axis| self.min[axis] < self.max[axis]);
        at.require("max", ordered, || {
            format!("{:?} is not above min, {:?}, on every axis", self.max, self.min)
        })
    }
}

/// A rotation: `axis` and `degrees`, or `quaternion`. Default: none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Rotation {
    /// Axis; needn't have length 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Angle about the axis, degrees, right-handed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub degrees: Option<f64>,
    /// x, y, z, w instead; needn't have length 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quaternion: Option<[f64; 4]>,
}

impl Rotation {
    /// About an axis, degrees.
    pub fn about(axis: [f64; 3], degrees: f64) -> Rotation {
        Rotation { axis: Some(axis), degrees: Some(degrees), quaternion: None }
    }

    /// As a quaternion of length 1; none if what is given has no direction.
    pub fn to_quat(&self) -> DQuat {
        if let Some(quaternion) = self.quaternion {
            let length = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            return DQuat::from_array(quaternion.map(|x| x / length));
        }
        match self.axis.and_then(|axis| DVec3::from(axis).try_normalize()) {
            Some(axis) => DQuat::from_axis_angle(axis, self.degrees.unwrap_or(0.0).to_radians()),
            None => DQuat::IDENTITY,
        }
    }

    pub(super) fn check(&self, at: &At) -> Checked {
        match (self.axis, self.degrees, self.quaternion) {
            (None, None, None) => Ok(()),
            (Some(axis), Some(degrees), None) => {
                at.direction("axis", axis)?;
                at.finite("degrees", degrees)
            }
            (None, None, Some(quaternion)) => {
                quaternion.into_iter().try_for_each(|x| at.finite("quaternion", x))?;
                let squared: f64 = quaternion.iter().map(|x| x * x).sum();
                at.require("quaternion", squared > 1e-24, || "has no length".into())
            }
            _ => Err(at.problem_here("give `axis` and `degrees`, or `quaternion` alone")),
        }
    }
}

/// One number for all axes, or three.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PerAxis<T>(pub [T; 3]);

impl<T: Serialize> Serialize for PerAxis<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.0.serialize(serializer)
    }
}

/// By hand: serde's untagged enumerations lose the place and the cause of errors.
impl<'de, T: Deserialize<'de> + Copy + FromNumber> Deserialize<'de> for PerAxis<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrThree(PhantomData))
    }
}

impl<T: JsonSchema> JsonSchema for PerAxis<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("PerAxis_{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<T>();
        json_schema!({ "anyOf": [one, { "type": "array", "items": one, "minItems": 3, "maxItems": 3 }] })
    }
}

/// What a file's number may become.
pub trait FromNumber: Sized {
    /// `None`: it can't.
    fn from_float(value: f64) -> Option<Self>;
    /// `None`: it can't.
    fn from_integer(value: i64) -> Option<Self>;
}

impl FromNumber for f64 {
    fn from_float(value: f64) -> Option<f64> {
        Some(value)
    }

    fn from_integer(value: i64) -> Option<f64> {
        Some(value as f64)
    }
}

impl FromNumber for u32 {
    fn from_float(_: f64) -> Option<u32> {
        None
    }

    fn from_integer(value: i64) -> Option<u32> {
        value.try_into().ok()
    }
}

struct OneOrThree<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de> + Copy + FromNumber> Visitor<'de> for OneOrThree<T> {
    type Value = PerAxis<T>;

    fn expecting(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str("a number, or three in brackets")
    }

    fn visit_f64<E: serde::de::Error>(self, value: f64) -> Result<PerAxis<T>, E> {
        let number = T::from_float(value);
        number.map(|x| PerAxis([x; 3])).ok_or_else(|| E::custom(format!("{value} is not a whole number")))
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<PerAxis<T>, E> {
        let number = T::from_integer(value);
        number.map(|x| PerAxis([x; 3])).ok_or_else(|| E::custom(format!("{value} is out of range")))
    }

    fn visit_u64<E: serde::de::Error>(self, value: u64) -> Result<PerAxis<T>, E> {
        let value = i64::try_from(value).map_err(|_| E::custom(format!("{value} is out of range")))?;
        self.visit_i64(value)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<PerAxis<T>, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = list.next_element::<T>()? {
            if items.len() == 3 {
                return Err(A::Error::invalid_length(4, &self));
            }
            items.push(item);
        }
        let count = items.len();
        items.try_into().map(PerAxis).map_err(|_| A::Error::invalid_length(count, &self))
    }
}
