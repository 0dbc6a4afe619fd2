//! Boxes and rotations.

use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
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
