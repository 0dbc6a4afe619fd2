//! What the solver may be told: Band et al. 2018, *MLS pressure boundaries for divergence-free and viscous SPH
//! fluids*, Algorithm 1, and Bender and Koschier 2017, *Divergence-Free SPH*.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use volmap_runtime::{ClosureKind, DVec3, Dimension, KernelKind};

/// Largest [`SolverSettings::relaxation`].
pub const MOST_RELAXATION: f64 = 0.7;

/// Both pressure solves and the time step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolverSettings {
    /// The solve that keeps the density: source term, Algorithm 1, CORRECT DENSITY ERROR.
    pub density: SolveSettings,
    /// The solve that keeps the velocity free of divergence: CORRECT DIVERGENCE ERROR.
    #[serde(with = "DivergenceSolve")]
    #[schemars(with = "DivergenceSolve")]
    pub divergence: SolveSettings,
    /// The solve for implicit viscosity and for the drag of bodies.
    pub viscosity: ViscositySolveSettings,
    /// Relaxation of the Jacobi steps, omega of Algorithm 1, up to 0.7: with more, fluids gain energy and burst, some
    /// kernels from 0.8 on, the default from 0.85 on. With so many neighbours that such steps would not converge, as
    /// with support radii of 5 particle radii, it is less in proportion.
    pub relaxation: f64,
    /// The boundary's pressure in the force on the fluid.
    pub boundary_pressure: BoundaryPressure,
    /// The density solve's pressures begin as this part of the last step's, 0 to 1, where something still presses; 0:
    /// from zero, as Algorithm 1 has it. Those of the divergence solve always begin from zero: an impact is over in
    /// the next step, and its pressures would throw the fluid back.
    pub warm_start: f64,
    /// The time step.
    pub time_step: TimeStepSettings,
}

/// One of the two solves.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SolveSettings {
    /// Whether it is done at all.
    pub enabled: bool,
    /// Largest mean error of the density, in parts of the rest density.
    pub max_error: f64,
    /// Iterations at least.
    pub min_iterations: u32,
    /// Iterations at most; the statistics tell when they did not suffice.
    pub max_iterations: u32,
}

/// The viscous solve, by conjugate gradients: Weiler et al. 2018, *A Physically Consistent Implicit Viscosity Solver
/// for SPH Fluids*. Done where the fluid's viscosity is implicit or bodies' surfaces have a drag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ViscositySolveSettings {
    /// Largest residual, in parts of the velocities: root of the sum of squares of the one over that of the other.
    pub max_error: f64,
    /// Iterations at most; the statistics tell when they did not suffice.
    pub max_iterations: u32,
    /// How often implicit viscosity and density are solved for in turns in a step at most; once is enough in most.
    /// Only where steps are longer than explicit viscosity would allow.
    pub max_passes: u32,
}

/// [`SolveSettings`] of the divergence solve in a scene's file: what isn't given has other defaults there.
#[derive(Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "DivergenceSolve")]
#[serde(remote = "SolveSettings", deny_unknown_fields, default = "SolveSettings::of_divergence")]
struct DivergenceSolve {
    /// Whether it is done at all.
    enabled: bool,
    /// Largest mean change of the density in a step, in parts of the rest density.
    max_error: f64,
    /// Iterations at least.
    min_iterations: u32,
    /// Iterations at most; the statistics tell when they did not suffice.
    max_iterations: u32,
}

/// The time step: dt = factor * 0.4 * 2 rp / |v|max, within bounds. Read from a file, bounds that aren't given give way
/// to those that are.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TimeStepSettings {
    /// First step, seconds, if it adapts at most `max` unless it is given; every step, if it doesn't adapt.
    pub initial: f64,
    /// Whether the step follows the CFL condition.
    pub adaptive: bool,
    /// Factor of the CFL condition.
    pub cfl_factor: f64,
    /// Smallest step, seconds.
    pub min: f64,
    /// Largest step, seconds.
    pub max: f64,
}

/// [`TimeStepSettings`] as a file gives them.
#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct GivenTimeStep {
    initial: Option<f64>,
    adaptive: Option<bool>,
    cfl_factor: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
}

impl<'de> Deserialize<'de> for TimeStepSettings {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<TimeStepSettings, D::Error> {
        let given = GivenTimeStep::deserialize(deserializer)?;
        let default = TimeStepSettings::default();
        let adaptive = given.adaptive.unwrap_or(default.adaptive);
        let max = given.max.unwrap_or(default.max);
        let first = given.initial.filter(|_| adaptive).unwrap_or(max);
        let min = given.min.unwrap_or(default.min.min(max).min(first));
        let within = if adaptive { default.initial.max(min).min(max) } else { default.initial };
        Ok(TimeStepSettings {
            initial: given.initial.unwrap_or(within),
            adaptive,
            cfl_factor: given.cfl_factor.unwrap_or(default.cfl_factor),
            min,
            max,
        })
    }
}

/// The fluid.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FluidSettings {
    /// Rest density rho_0, kg/m^3.
    pub rest_density: f64,
    /// Kinematic viscosity nu, m^2/s (Bender et al. 2020, Eq. 16 with mu = nu rho).
    pub viscosity: f64,
    /// How it is computed. Default: explicit.
    pub viscosity_method: ViscosityMethod,
    /// XSPH velocity smoothing, parts of the velocity difference (0: off). It keeps momentum, but not angular momentum:
    /// in a collision with a body 11 % of it was lost with 0.5. Viscosity keeps both.
    pub xsph: f64,
    /// Volume of a particle in parts of its cube (2 rp)^3; SPlisHSPlasH: 1, up to 2.17 0.8.
    pub volume_factor: f64,
}

/// How the fluid's viscosity is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ViscosityMethod {
    /// From the velocities before the step; it bounds the step, by r^2 / (120 nu) for the cubic spline. For thin
    /// fluids.
    #[default]
    Explicit,
    /// From those after it, for which a system is solved (`solver.viscosity`); steps are as long as without
    /// viscosity. For thick fluids.
    Implicit,
}

/// How the fluid sees bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryMethod {
    /// By the volume of the body in reach and a closure (Bender et al. 2020).
    #[default]
    VolumeMap,
    /// By the density itself, baked for the scene's kernel (Koschier and Bender 2017).
    DensityMap,
    /// By particles on the surface of its mesh (Akinci et al. 2012).
    Particles,
    /// By distance and curvature at the closest point of its map (after Nogina and Sellan 2026).
    TubeMap,
}

/// How boundary particles lie on a body's surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundarySampling {
    /// As evenly as they can.
    #[default]
    Even,
    /// Blue noise, as most programs have it: a bumpier wall, for comparison.
    BlueNoise,
}

/// The boundary's pressure p_b in the force on the fluid, beside the particle's own pressure (Band et al. 2018, Eq. 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum BoundaryPressure {
    /// None: forces are the gradient of the boundary's density, and a fluid at rest is calmer (solver/VALIDATION.md).
    #[default]
    Own,
    /// That of the particle (Akinci et al. 2012; Eq. 15 of Bender et al. 2020).
    Mirror,
    /// The mean of the fluid's near the site, and its weight (Adami et al. 2012; Band et al. 2018, Eq. 3).
    Sph,
    /// The fluid's, extrapolated by moving least squares (Band et al. 2018, Eq. 4 to 16).
    Mls,
}

impl BoundaryPressure {
    /// Whether it is extrapolated from the fluid to sites.
    pub fn is_extrapolated(self) -> bool {
        matches!(self, BoundaryPressure::Sph | BoundaryPressure::Mls)
    }
}

impl World {
    /// The closure whose maps bodies need: those of other methods than volume maps have the kernel's support radius.
    pub fn map_closure(&self) -> ClosureKind {
        match self.boundary {
            BoundaryMethod::VolumeMap => self.closure,
            BoundaryMethod::DensityMap | BoundaryMethod::Particles | BoundaryMethod::TubeMap => {
                ClosureKind::Calibrated
            }
        }
    }
}

/// What the whole scene shares.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    /// In how many dimensions. In two everything is in the plane z = 0; scenes' files are in three.
    pub dimension: Dimension,
    /// Particle radius rp, metres: half of the particles' spacing.
    pub particle_radius: f64,
    /// Support radius r of the kernel, metres; 4 rp as a rule.
    pub support_radius: f64,
    /// The kernel.
    pub kernel: KernelKind,
    /// How the fluid sees bodies.
    pub boundary: BoundaryMethod,
    /// How boundary particles lie.
    pub sampling: BoundarySampling,
    /// From the boundary's volume to its density; of volume maps.
    pub closure: ClosureKind,
    /// Gravity, m/s^2.
    pub gravity: DVec3,
}

impl Default for SolverSettings {
    fn default() -> Self {
        SolverSettings {
            density: SolveSettings::default(),
            divergence: SolveSettings::of_divergence(),
            viscosity: ViscositySolveSettings::default(),
            relaxation: 0.5,
            boundary_pressure: BoundaryPressure::Own,
            warm_start: 0.5,
            time_step: TimeStepSettings::default(),
        }
    }
}

impl Default for SolveSettings {
    /// Those of the density solve.
    fn default() -> Self {
        SolveSettings { enabled: true, max_error: 5e-4, min_iterations: 2, max_iterations: 100 }
    }
}

impl SolveSettings {
    /// The defaults of the divergence solve.
    pub fn of_divergence() -> SolveSettings {
        SolveSettings { enabled: true, max_error: 1e-3, min_iterations: 1, max_iterations: 100 }
    }
}

impl Default for ViscositySolveSettings {
    fn default() -> Self {
        ViscositySolveSettings { max_error: 1e-3, max_iterations: 200, max_passes: 10 }
    }
}

impl FluidSettings {
    /// The part of the viscosity that is explicit, and the part that is implicit, m^2/s.
    pub fn viscosities(&self) -> [f64; 2] {
        match self.viscosity_method {
            ViscosityMethod::Explicit => [self.viscosity, 0.0],
            ViscosityMethod::Implicit => [0.0, self.viscosity],
        }
    }
}

impl Default for TimeStepSettings {
    fn default() -> Self {
        TimeStepSettings { initial: 1e-3, adaptive: true, cfl_factor: 1.0, min: 1e-4, max: 2e-3 }
    }
}

impl Default for FluidSettings {
    fn default() -> Self {
        FluidSettings {
            rest_density: 1000.0,
            viscosity: 0.01,
            viscosity_method: ViscosityMethod::Explicit,
            xsph: 0.0,
            volume_factor: 1.0,
        }
    }
}

impl Default for World {
    fn default() -> Self {
        World {
            dimension: Dimension::Three,
            particle_radius: 0.025,
            support_radius: 0.1,
            kernel: KernelKind::CubicSpline,
            boundary: BoundaryMethod::VolumeMap,
            sampling: BoundarySampling::Even,
            closure: ClosureKind::Mirror,
            gravity: DVec3::new(0.0, -9.81, 0.0),
        }
    }
}
