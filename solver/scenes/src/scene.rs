//! The scene file: parsed, checked, turned into particles and bodies.
//!
//! ```text
//! file -> read (keys, types) -> check (ranges) -> Scene -> prepare: maps, sources -> Prepared
//! ```
//! The boundaries are those of Bender et al. 2020, *Implicit Frictional Boundary Handling for SPH*; the
//! scene's concepts follow the papers' own program. A [`Scene`] can be made in Rust as well as by [`load`]:
//! [`prepare()`] checks it either way. SI units throughout, y up as a rule.

pub mod body;
mod check;
mod count;
pub mod cut;
mod defaults;
pub mod fluid;
pub mod map;
pub mod memory;
pub mod nozzle;
pub mod numbers;
pub mod output;
mod overlap;
pub mod placement;
pub mod prepare;
mod read;
pub mod solid;
pub mod sources;
mod space;
mod spread;
pub mod summary;
pub mod surface;
pub mod walls;

pub use body::{Body, FreeMotion, Keyframe, Material, Motion, Spin};
pub use fluid::{Block, EmitterSettings, Fill, Nozzle, Packing};
pub use numbers::{Region, Rotation};
pub use output::{OutputSettings, Picture, StopSettings};
pub use prepare::{Prepared, PreparedBody, SourceFile, prepare, prepare_within};
pub use read::{load, parse};
pub use summary::{SceneSummary, info};
pub use volmap_documents::Syntax;

use crate::error::Error;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use volmap_documents::{At, Checked};
use volmap_fluid::forces::ForceSettings;
use volmap_fluid::settings::{BoundaryMethod, BoundarySampling, FluidSettings, SolverSettings, World};
use volmap_runtime::{ClosureKind, Dimension, KernelKind};

/// The version of the format that this program reads.
pub const VERSION: u32 = 1;

/// A scene for volmap-sim, version 1. Lengths in metres, times in seconds, masses in kilograms, angles in
/// degrees; files are named relative to the scene's own file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "volmap scene")]
pub struct Scene {
    /// Version of this format: 1.
    pub version: u32,
    /// Radius of the fluid's particles, metres: half of their spacing.
    pub particle_radius: f64,
    /// Support radius of the kernel, metres: 3.5 to 4 particle radii of `cubic_spline`, to 10 of others. Maps must be
    /// baked for it. Default: 4 particle radii.
    #[serde(default)]
    pub support_radius: Option<f64>,
    /// SPH kernel; water doesn't stay at rest with `poly6`, which is refused.
    #[serde(default)]
    pub kernel: KernelKind,
    /// How the fluid sees bodies.
    #[serde(default)]
    pub boundary: BoundaryMethod,
    /// How boundary particles lie, with `particles` only. Default: even.
    #[serde(default)]
    pub boundary_sampling: Option<BoundarySampling>,
    /// How a map's volume becomes a density, with `volume_map` only. Default: mirror.
    #[serde(default)]
    pub closure: Option<ClosureKind>,
    /// Gravity, m/s^2. Default: 9.81 downwards.
    #[serde(default = "default_gravity")]
    pub gravity: [f64; 3],
    /// Particles that leave this box are removed and counted. Default: fluid and bodies of the start, with a margin
    /// on each side as wide as the diagonal of all that.
    #[serde(default)]
    pub domain: Option<Region>,
    /// Folder where baked meshes are kept. Default: `volmap` in the user's cache folder.
    #[serde(default)]
    pub cache: Option<PathBuf>,
    /// The fluid's properties.
    #[serde(default)]
    pub fluid: FluidSettings,
    /// Forces beside pressure, gravity and viscosity.
    #[serde(default, skip_serializing_if = "ForceSettings::is_none")]
    pub forces: ForceSettings,
    /// Boxes filled with particles at the start.
    #[serde(default)]
    pub blocks: Vec<Block>,
    /// Solids filled with particles at the start.
    #[serde(default)]
    pub fills: Vec<Fill>,
    /// Nozzles that add particles during the run.
    #[serde(default)]
    pub emitters: Vec<EmitterSettings>,
    /// What the fluid touches.
    #[serde(default)]
    pub bodies: Vec<Body>,
    /// Pressure solves and time step.
    #[serde(default)]
    pub solver: SolverSettings,
    /// What the run leaves.
    #[serde(default)]
    pub output: OutputSettings,
    /// When the run ends.
    #[serde(default)]
    pub stop: StopSettings,
    /// What was decided when it was read that the user should know.
    #[serde(skip)]
    pub notes: Vec<String>,
}

fn default_gravity() -> [f64; 3] {
    World::default().gravity.to_array()
}

impl Default for Scene {
    /// No fluid, no bodies.
    fn default() -> Self {
        Scene {
            version: VERSION,
            particle_radius: World::default().particle_radius,
            support_radius: None,
            kernel: World::default().kernel,
            boundary: BoundaryMethod::default(),
            boundary_sampling: None,
            closure: None,
            gravity: default_gravity(),
            domain: None,
            cache: None,
            fluid: FluidSettings::default(),
            forces: ForceSettings::default(),
            blocks: Vec::new(),
            fills: Vec::new(),
            emitters: Vec::new(),
            bodies: Vec::new(),
            solver: SolverSettings::default(),
            output: OutputSettings::default(),
            stop: StopSettings::default(),
            notes: Vec::new(),
        }
    }
}

impl Scene {
    /// Support radius r of the kernel, metres.
    pub fn support_radius(&self) -> f64 {
        self.support_radius.unwrap_or(4.0 * self.particle_radius)
    }

    /// Distance of neighbouring particles of a lattice at rest, metres.
    pub fn spacing(&self) -> f64 {
        2.0 * self.particle_radius
    }

    /// The same of the fluid's particles by their volume, at which nozzles give them.
    pub fn rest_spacing(&self) -> f64 {
        self.world().rest_spacing(&self.fluid)
    }

    /// Paths of its maps and meshes.
    pub(crate) fn paths_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        let bodies = self.bodies.iter_mut().flat_map(|body| [&mut body.map, &mut body.mesh]);
        let fills = self.fills.iter_mut().flat_map(|fill| [&mut fill.map, &mut fill.mesh]);
        bodies.chain(fills).flatten()
    }

    /// What the solver needs of it all the time.
    pub fn world(&self) -> World {
        World {
            dimension: Dimension::Three,
            particle_radius: self.particle_radius,
            support_radius: self.support_radius(),
            kernel: self.kernel,
            boundary: self.boundary,
            sampling: self.boundary_sampling.unwrap_or_default(),
            closure: self.closure.unwrap_or(World::default().closure),
            gravity: self.gravity.into(),
        }
    }

    /// The JSON Schema of the file.
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Scene).to_value()
    }

    /// Checks every number, without looking at any file.
    ///
    /// # Errors
    /// The first value that can't be used, named by its key.
    pub fn validate(&self) -> Result<(), Error> {
        self.check().map_err(|problem| Error::Scene { place: problem.key(), reason: problem.reason })
    }

    fn check(&self) -> Checked {
        let top = At::top();
        if self.version != VERSION {
            return Err(top
                .problem("version", format!("{} is not known; this program reads {VERSION}", self.version)));
        }
        top.within("particle_radius", self.particle_radius, [1e-6, 1e3])?;
        check::kernel(&top, self)?;
        top.vector("gravity", self.gravity)?;
        if let Some(domain) = &self.domain {
            domain.check(&top.key("domain"))?;
        }
        check::boundary(&top, self)?;
        check::fluid(&top.key("fluid"), &self.fluid)?;
        check::forces(&top.key("forces"), &self.forces)?;
        check::solver(&top.key("solver"), &self.solver)?;
        check::viscosity(&top.key("fluid"), &self.fluid, &self.solver, &self.world())?;
        for (i, block) in self.blocks.iter().enumerate() {
            block.check(&top.key("blocks").item(i), self.spacing())?;
        }
        for (i, fill) in self.fills.iter().enumerate() {
            fill.check(&top.key("fills").item(i))?;
        }
        for (i, emitter) in self.emitters.iter().enumerate() {
            emitter.check(&top.key("emitters").item(i), self.particle_radius)?;
        }
        body::check_all(&top.key("bodies"), &self.bodies)?;
        self.output.check(&top.key("output"))?;
        self.stop.check(&top.key("stop"))
    }
}
