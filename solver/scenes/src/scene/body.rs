//! What the fluid touches: a map or a mesh, where it is, how it moves, what it is made of.

use super::numbers::Rotation;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use volmap_bake::parameters::Parameters;
use volmap_bake::primitive::Primitive;
use volmap_documents::{At, Checked};
use volmap_formats::text::number;
use volmap_runtime::Pose;

/// A solid body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Body {
    /// Name in outputs and messages; unique. Default: the file's, with a number if it is not the only one.
    pub name: String,
    /// Volume map, baked for the scene's support radius.
    pub map: Option<PathBuf>,
    /// Or a mesh, which is baked on first use.
    pub mesh: Option<PathBuf>,
    /// Or a box, sphere, cylinder, capsule or plane, which is baked by its exact distance. A plane is the half-space
    /// below it, within `domain`; it can't move.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shape: Option<Primitive>,
    /// How the mesh or the shape is baked: parameters of `volmap bake`, with `_` for `-`. The support radius and, for density maps,
    /// the kernel are the scene's. Default of the cells: a quarter of the support radius; with closure `mirror` an
    /// eighth, and a twelfth for bodies that turn by `motion`.
    pub bake: Parameters,
    /// Place of the body's origin at the start, metres.
    pub translation: [f64; 3],
    /// Rotation at the start, before the translation.
    pub rotation: Rotation,
    /// How it moves.
    pub motion: Motion,
    /// What it is made of.
    pub material: Material,
    /// Red, green, blue in pictures, 0 to 1. Default: by the program.
    pub colour: Option<[f64; 3]>,
}

/// How a body moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
pub enum Motion {
    /// Not at all.
    #[default]
    Static,
    /// From pose to pose, linearly and along the shortest rotation; at rest before the first and after the
    /// last.
    Keyframes(Vec<Keyframe>),
    /// At a constant rate about an axis.
    Spin(Spin),
    /// By gravity, contacts and the fluid.
    Free(FreeMotion),
}

/// A pose at a time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Keyframe {
    /// Seconds.
    pub time: f64,
    /// Place of the body's origin, metres.
    #[serde(default)]
    pub translation: [f64; 3],
    /// Rotation, before the translation.
    #[serde(default)]
    pub rotation: Rotation,
}

/// A constant rotation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spin {
    /// Axis in the world; needn't have length 1.
    pub axis: [f64; 3],
    /// Turns per minute, right-handed.
    pub rpm: f64,
    /// A point of the axis in the world, metres. Default: the body's origin.
    #[serde(default)]
    pub centre: Option<[f64; 3]>,
}

/// A body that forces move. Its mass follows from `density` or is `mass`; one of them is needed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FreeMotion {
    /// Density of the solid, kg/m^3.
    pub density: Option<f64>,
    /// Or mass, kg.
    pub mass: Option<f64>,
    /// Velocity at the start, m/s.
    pub velocity: [f64; 3],
    /// Angular velocity at the start, rad/s.
    pub angular_velocity: [f64; 3],
    /// World axes (x, y, z) along which it can't move; `velocity` is 0 there.
    pub fixed_translation: [bool; 3],
    /// World axes (x, y, z) about which it can't turn; `angular_velocity` is 0 there.
    pub fixed_rotation: [bool; 3],
}

/// What a body's surface is like.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Coulomb's coefficient of friction between bodies; of two, the mean counts.
    pub friction: f64,
    /// Restitution between bodies: 0 stays, 1 bounces.
    pub restitution: f64,
    /// How the fluid sticks: kinematic viscosity between it and the body, m^2/s, as the fluid's own (Bender et al.
    /// 2020, Eq. 16 and 17, mu_B over rho_0). 0: it slips.
    pub fluid_viscosity: f64,
    /// Tangential friction between fluid and body, m^2/s (Eq. 18 and 19): as `fluid_viscosity`, but the fluid comes off
    /// freely.
    pub fluid_friction: f64,
}

impl Default for Material {
    fn default() -> Self {
        Material { friction: 0.5, restitution: 0.0, fluid_viscosity: 0.0, fluid_friction: 0.0 }
    }
}

impl Material {
    fn check(&self, at: &At) -> Checked {
        at.not_negative("friction", self.friction)?;
        at.within("restitution", self.restitution, [0.0, 1.0])?;
        at.not_negative("fluid_viscosity", self.fluid_viscosity)?;
        at.not_negative("fluid_friction", self.fluid_friction)
    }
}

/// What a map is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source<'a> {
    /// An asset.
    Map(&'a Path),
    /// A mesh and how it is baked.
    Mesh(&'a Path, &'a Parameters),
    /// A shape and how it is baked.
    Shape(Primitive, &'a Parameters),
}

impl<'a> Source<'a> {
    /// The one that is given; `None` unless it is exactly one.
    pub fn of(
        map: Option<&'a Path>,
        mesh: Option<&'a Path>,
        shape: Option<Primitive>,
        bake: &'a Parameters,
    ) -> Option<Source<'a>> {
        match (map, mesh, shape) {
            (Some(map), None, None) => Some(Source::Map(map)),
            (None, Some(mesh), None) => Some(Source::Mesh(mesh, bake)),
            (None, None, Some(shape)) => Some(Source::Shape(shape, bake)),
            _ => None,
        }
    }

    /// Its file; of a shape its name.
    pub fn path(&self) -> &'a Path {
        match self {
            Source::Map(path) | Source::Mesh(path, _) => path,
            Source::Shape(shape, _) => Path::new(shape.name()),
        }
    }

    /// How it is baked, if it is.
    pub fn bake(&self) -> Option<&'a Parameters> {
        match self {
            Source::Map(_) => None,
            Source::Mesh(_, bake) | Source::Shape(_, bake) => Some(bake),
        }
    }

    /// The scene's key for it.
    pub fn key(&self) -> &'static str {
        match self {
            Source::Map(_) => "map",
            Source::Mesh(..) => "mesh",
            Source::Shape(..) => "shape",
        }
    }
}

impl Body {
    /// Whether it turns as it is told to, whatever the fluid does.
    pub fn turns(&self) -> bool {
        match &self.motion {
            Motion::Spin(spin) => spin.rpm != 0.0,
            Motion::Keyframes(frames) => frames.windows(2).any(|pair| pair[0].rotation != pair[1].rotation),
            Motion::Static | Motion::Free(_) => false,
        }
    }

    /// Its map, mesh or shape.
    pub fn source(&self) -> Option<Source<'_>> {
        Source::of(self.map.as_deref(), self.mesh.as_deref(), self.shape, &self.bake)
    }

    /// Where it is at the start.
    pub fn pose(&self) -> Pose {
        let (rotation, translation) = match &self.motion {
            Motion::Keyframes(frames) if !frames.is_empty() => {
                // Times increase and aren't negative: what comes first is the pose at the start.
                (&frames[0].rotation, frames[0].translation)
            }
            _ => (&self.rotation, self.translation),
        };
        Pose { rotation: rotation.to_quat(), translation: translation.into() }
    }

    fn check(&self, at: &At) -> Checked {
        let given = [self.map.is_some(), self.mesh.is_some(), self.shape.is_some()];
        check_source(at, given, self.shape, &self.bake)?;
        let is_plane = self.shape.is_some_and(|shape| shape.is_unbounded());
        at.require("motion", !is_plane || self.motion == Motion::Static, || {
            "a plane has no end and no mass: it can't move; take a box".into()
        })?;
        let plain = |c: char| c.is_alphanumeric() || " _-.+".contains(c);
        let usable = self.name.chars().all(plain) && !self.name.starts_with('.') && self.name.len() <= 100;
        at.require("name", usable, || "use letters, digits, spaces and _-.+: outputs are named so".into())?;
        at.vector("translation", self.translation)?;
        self.rotation.check(&at.key("rotation"))?;
        self.motion.check(&at.key("motion"))?;
        if matches!(self.motion, Motion::Keyframes(_)) {
            let own = self.translation != [0.0; 3] || self.rotation != Rotation::default();
            at.require("motion", !own, || {
                "keyframes say where the body is; leave out its own translation and rotation".into()
            })?;
        }
        if self.bake.invert == Some(true) && matches!(self.motion, Motion::Free(_)) {
            return Err(at.problem("motion", "a container without an outside has no mass: it can't be free"));
        }
        self.material.check(&at.key("material"))?;
        let mut channels = self.colour.iter().flatten();
        channels.try_for_each(|&channel| at.within("colour", channel, [0.0, 1.0]))
    }
}

pub(super) fn check_all(at: &At, bodies: &[Body]) -> Checked {
    for (i, body) in bodies.iter().enumerate() {
        body.check(&at.item(i))?;
        let same = bodies[..i].iter().position(|other| !body.name.is_empty() && other.name == body.name);
        if let Some(other) = same {
            return Err(at
                .item(i)
                .problem("name", format!("{:?} is that of bodies[{other}] too", body.name)));
        }
    }
    Ok(())
}

/// Names of all bodies: their own, or their files' with a number where that is needed.
pub fn names(bodies: &[Body]) -> Vec<String> {
    let mut out: Vec<String> = Vec::new();
    let given: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    for body in bodies {
        let stem = body.source().and_then(|source| source.path().file_stem());
        let stem = stem.map_or("body".into(), |stem| stem.to_string_lossy());
        let numbered = (1..).map(|n| if n == 1 { stem.to_string() } else { format!("{stem} {n}") });
        let mut free = numbered.filter(|name| !out.contains(name) && !given.contains(&name.as_str()));
        let name = if body.name.is_empty() { free.next().unwrap_or_default() } else { body.name.clone() };
        out.push(name);
    }
    out
}

/// `given` says of `map`, `mesh` and `shape` whether they are there.
pub(super) fn check_source(
    at: &At,
    given: [bool; 3],
    shape: Option<Primitive>,
    bake: &Parameters,
) -> Checked {
    match given {
        [false, false, false] => {
            return Err(at.problem_here(
                "give `map`, an asset, or `mesh`, a mesh that is baked, or `shape`, as { sphere = { radius = 0.5 } }",
            ));
        }
        [true, true, _] => return Err(at.problem("mesh", "give `map` or `mesh`, not both")),
        [true, _, true] | [_, true, true] => {
            return Err(at.problem("shape", "give `map`, `mesh` or `shape`, one of them"));
        }
        [true, ..] if *bake != Parameters::default() => {
            return Err(at.problem("bake", "is for meshes and shapes; `map` is baked already"));
        }
        _ => {}
    }
    if let Some(shape) = shape {
        shape.check().map_err(|reason| at.problem("shape", reason))?;
    }
    at.key("bake")
        .require("shape", bake.shape.is_none(), || "give `shape` beside `bake`, not in it".into())?;
    bake.check().map_err(|mistake| at.key("bake").problem(mistake.key, mistake.reason))
}

impl Motion {
    fn check(&self, at: &At) -> Checked {
        match self {
            Motion::Static => Ok(()),
            Motion::Keyframes(frames) => check_frames(&at.key("keyframes"), frames),
            Motion::Spin(spin) => {
                let at = at.key("spin");
                at.direction("axis", spin.axis)?;
                at.finite("rpm", spin.rpm)?;
                spin.centre.map_or(Ok(()), |centre| at.vector("centre", centre))
            }
            Motion::Free(free) => free.check(&at.key("free")),
        }
    }
}

fn check_frames(at: &At, frames: &[Keyframe]) -> Checked {
    if frames.is_empty() {
        return Err(at.problem_here("there are none; give one at least, or motion = \"static\""));
    }
    for (i, frame) in frames.iter().enumerate() {
        let at = at.item(i);
        at.not_negative("time", frame.time)?;
        at.vector("translation", frame.translation)?;
        frame.rotation.check(&at.key("rotation"))?;
        let before = i.checked_sub(1).map_or(f64::NEG_INFINITY, |before| frames[before].time);
        at.require("time", frame.time > before, || {
            format!("{} s is not after the frame before, {before} s", frame.time)
        })?;
    }
    Ok(())
}

impl FreeMotion {
    fn check(&self, at: &At) -> Checked {
        at.vector("velocity", self.velocity)?;
        at.vector("angular_velocity", self.angular_velocity)?;
        let fixed = [
            ("velocity", self.velocity, "fixed_translation", self.fixed_translation),
            ("angular_velocity", self.angular_velocity, "fixed_rotation", self.fixed_rotation),
        ];
        for (key, velocity, fixing, fixed) in fixed {
            let moving = (0..3).find(|&axis| fixed[axis] && velocity[axis] != 0.0);
            if let Some(axis) = moving {
                let (name, speed) = (["x", "y", "z"][axis], number(velocity[axis]));
                return Err(at.problem(
                    key,
                    format!("{speed} for {name}, which {fixing} fixes: take 0, or leave {name} free there"),
                ));
            }
        }
        match (self.density, self.mass) {
            (Some(density), None) => at.positive("density", density),
            (None, Some(mass)) => at.positive("mass", mass),
            _ => Err(at.problem_here("give `density` (kg/m^3) or `mass` (kg)")),
        }
    }
}
