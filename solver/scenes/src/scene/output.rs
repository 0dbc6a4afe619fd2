//! What a run leaves, and when it ends.

use crate::output::particles::ParticleFormat;
use crate::output::picture::Camera;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use volmap_documents::{At, Checked};

/// What a run leaves in its folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct OutputSettings {
    /// Frames per simulated second; 0: none. Steps are shortened so that frame k is at k times the interval.
    pub frames_per_second: f64,
    /// Files of the particles in every frame.
    pub formats: Vec<ParticleFormat>,
    /// Pictures of the run, one of each kind.
    pub preview: Vec<Picture>,
    /// Where pictures are seen from. Default: from where all is seen.
    pub camera: Option<Camera>,
    /// Simulated seconds between checkpoints, from which a run that was stopped goes on; 0: at the end only.
    pub checkpoint_interval: f64,
    /// Whether a line per step goes to stats.csv.
    pub statistics: bool,
}

/// Pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Picture {
    /// One of every frame.
    Png,
    /// All frames in one file that moves.
    Apng,
}

/// When a run ends: at the first of these.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StopSettings {
    /// Simulated seconds.
    pub time: f64,
    /// Steps. Default: any number.
    pub steps: Option<u64>,
}

impl Default for OutputSettings {
    fn default() -> Self {
        OutputSettings {
            frames_per_second: 25.0,
            formats: vec![ParticleFormat::Vtu],
            preview: vec![Picture::Apng],
            camera: None,
            checkpoint_interval: 0.5,
            statistics: true,
        }
    }
}

impl Default for StopSettings {
    fn default() -> Self {
        StopSettings { time: 5.0, steps: None }
    }
}

impl OutputSettings {
    pub(super) fn check(&self, at: &At) -> Checked {
        at.within("frames_per_second", self.frames_per_second, [0.0, 1e6])?;
        at.not_negative("checkpoint_interval", self.checkpoint_interval)?;
        match &self.camera {
            Some(camera) => camera.check(&at.key("camera")),
            None => Ok(()),
        }
    }
}

impl Camera {
    fn check(&self, at: &At) -> Checked {
        at.vector("position", self.position)?;
        at.vector("target", self.target)?;
        at.within("field_of_view", self.field_of_view, [1.0, 170.0])?;
        at.require("target", self.position != self.target, || "is the camera's place".into())
    }
}

impl StopSettings {
    pub(super) fn check(&self, at: &At) -> Checked {
        at.positive("time", self.time)
    }
}
