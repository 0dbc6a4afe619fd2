//! Where the fluid comes from: boxes, solids, nozzles.

use super::body::{Source, check_source};
use super::numbers::{Region, Rotation};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use volmap_bake::parameters::Parameters;
use volmap_bake::primitive::Primitive;
use volmap_documents::{At, Checked};
use volmap_fluid::lattice::{self, MAX_PARTICLES};
use volmap_formats::text::{number, thousands};
use volmap_runtime::Pose;

/// How the particles of a box or a solid lie at the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Packing {
    /// On a cubic lattice of spacing 2 rp. It leaves a shell empty where walls and bodies aren't faces of the lattice.
    #[default]
    Lattice,
    /// As many as the space less bodies holds, by its volume. Before time 0 they are spread until the density is at
    /// rest everywhere, up to walls and bodies, and let settle until they have the pressures of their depth, bodies
    /// held. It takes as long as some hundred steps.
    Relaxed,
}

impl Packing {
    fn is_lattice(&self) -> bool {
        *self == Packing::Lattice
    }
}

/// A box of particles on a cubic lattice of spacing 2 rp; the first lie rp from the faces of `min`. What is
/// left of an edge that is no multiple of 2 rp stays empty at `max`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Block {
    /// Lowest corner, metres.
    pub min: [f64; 3],
    /// Highest corner, metres.
    pub max: [f64; 3],
    /// Velocity at the start, m/s. Default: 0.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// How its particles lie. Default: on the lattice.
    #[serde(default, skip_serializing_if = "Packing::is_lattice")]
    pub packing: Packing,
}

/// A solid filled with particles: a cubic lattice of spacing 2 rp along the world's axes, of which the points
/// at least rp deep in the solid are taken, and as far from bodies as fluid rests from them: rp, with some boundary
/// methods up to 2.8 rp. A container (an inverted map) is filled with what it can hold.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Fill {
    /// Volume map of the solid; any support radius.
    pub map: Option<PathBuf>,
    /// Or its mesh, which is baked on first use.
    pub mesh: Option<PathBuf>,
    /// Or a box, sphere, cylinder, capsule or plane, with its exact distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Primitive>,
    /// How the mesh or the shape is baked: parameters of `volmap bake`, with `_` for `-`.
    pub bake: Parameters,
    /// Place of the solid's origin, metres.
    pub translation: [f64; 3],
    /// Rotation of the solid, before the translation.
    pub rotation: Rotation,
    /// Only this part of it is filled. Default: all of it.
    pub within: Option<Region>,
    /// Velocity at the start, m/s.
    pub velocity: [f64; 3],
    /// How its particles lie. Default: on the lattice.
    #[serde(skip_serializing_if = "Packing::is_lattice")]
    pub packing: Packing,
}

/// A nozzle. Layers of particles leave it, spaced 2 rp in the direction of the flow and across it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EmitterSettings {
    /// Middle of the nozzle, metres.
    pub position: [f64; 3],
    /// Direction of the flow; needn't have length 1.
    pub direction: [f64; 3],
    /// Speed of the flow, m/s.
    pub speed: f64,
    /// Shape of the opening.
    pub nozzle: Nozzle,
    /// First layer, seconds.
    #[serde(default)]
    pub start: f64,
    /// No layer after this, seconds. Default: until `max_particles`.
    #[serde(default)]
    pub stop: Option<f64>,
    /// No layer that would exceed this number.
    #[serde(default = "default_max_particles")]
    pub max_particles: u64,
}

fn default_max_particles() -> u64 {
    1_000_000
}

/// Opening of a nozzle, across its direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Nozzle {
    /// A disc.
    Circle {
        /// Its radius, metres.
        radius: f64,
    },
    /// A rectangle.
    Box {
        /// Edge along the horizontal, metres (for a vertical flow: along x).
        width: f64,
        /// The other edge, metres.
        height: f64,
    },
}

impl Default for EmitterSettings {
    /// A jet downwards of 1 m/s and 20 cm across.
    fn default() -> Self {
        EmitterSettings {
            position: [0.0; 3],
            direction: [0.0, -1.0, 0.0],
            speed: 1.0,
            nozzle: Nozzle::Circle { radius: 0.1 },
            start: 0.0,
            stop: None,
            max_particles: default_max_particles(),
        }
    }
}

impl Block {
    /// Its box.
    pub fn region(&self) -> Region {
        Region { min: self.min, max: self.max }
    }

    pub(super) fn check(&self, at: &At, spacing: f64) -> Checked {
        self.region().check(at)?;
        at.vector("velocity", self.velocity)?;
        let counts = lattice::counts(self.region().corners(), spacing);
        let total: f64 = counts.iter().map(|&n| n as f64).product();
        at.require("max", total >= 1.0, || format!("the box is thinner than a particle, {spacing} m"))?;
        at.require("max", total <= MAX_PARTICLES as f64, || {
            format!(
                "the box holds {} particles, more than {}; check it and particle_radius",
                number(total),
                thousands(MAX_PARTICLES)
            )
        })
    }
}

impl Fill {
    /// Its map, mesh or shape.
    pub fn source(&self) -> Option<Source<'_>> {
        Source::of(self.map.as_deref(), self.mesh.as_deref(), self.shape, &self.bake)
    }

    /// Where the solid is.
    pub fn pose(&self) -> Pose {
        Pose { rotation: self.rotation.to_quat(), translation: self.translation.into() }
    }

    pub(super) fn check(&self, at: &At) -> Checked {
        let given = [self.map.is_some(), self.mesh.is_some(), self.shape.is_some()];
        check_source(at, given, self.shape, &self.bake)?;
        at.vector("translation", self.translation)?;
        self.rotation.check(&at.key("rotation"))?;
        if let Some(within) = &self.within {
            within.check(&at.key("within"))?;
        }
        at.require("packing", self.packing.is_lattice() || self.map.is_none(), || {
            "\"relaxed\" needs `mesh` or `shape`: its particles are spread between walls around the solid, which a map \
             alone doesn't give"
                .into()
        })?;
        at.vector("velocity", self.velocity)
    }
}

impl EmitterSettings {
    pub(super) fn check(&self, at: &At, particle_radius: f64) -> Checked {
        at.vector("position", self.position)?;
        at.direction("direction", self.direction)?;
        at.positive("speed", self.speed)?;
        at.not_negative("start", self.start)?;
        if let Some(stop) = self.stop {
            at.finite("stop", stop)?;
            at.require("stop", stop > self.start, || {
                format!("{stop} s is not after start, {} s", self.start)
            })?;
        }
        at.require("max_particles", self.max_particles <= MAX_PARTICLES, || {
            format!("is more than {}", thousands(MAX_PARTICLES))
        })?;
        let nozzle = at.key("nozzle");
        let across = |at: &At, name, length: f64| {
            at.positive(name, length)?;
            at.require(name, length <= 1e4 * particle_radius, || {
                format!("{length} m is over 10,000 particle radii")
            })
        };
        let least = match self.nozzle {
            Nozzle::Circle { radius } => across(&nozzle.key("circle"), "radius", radius).map(|()| radius)?,
            Nozzle::Box { width, height } => {
                across(&nozzle.key("box"), "width", width)?;
                across(&nozzle.key("box"), "height", height)?;
                0.5 * width.min(height)
            }
        };
        let reason = || format!("is narrower than a particle, whose radius is {particle_radius} m");
        at.require("nozzle", least >= particle_radius * (1.0 - 1e-6), reason)
    }
}
