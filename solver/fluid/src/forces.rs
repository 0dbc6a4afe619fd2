//! Forces: what acts on the fluid between the divergence solve and the density solve (Band et al. 2018, Algorithm 1),
//! each in a file of its own.
//!
//! ```text
//! divergence solve -> accelerate (all explicit forces) -> v += dt a -> solve (all implicit forces) -> density solve
//! ```
//! With implicit viscosity, the last two take turns. A [`Force`] has settings, a limit on the time step,
//! [channels](crate::channels) of the particles, and does one of two things: it adds accelerations, or it solves for
//! new velocities. [`ForceSettings`] lists those that a scene can ask for by a table of their own, `[forces.NAME]`; a
//! program can add others of its own by [`Setup::own_forces`](crate::setup::Setup::own_forces).

pub mod damping;
pub mod gravity;
pub mod implicit_viscosity;
mod velocity_sums;
pub mod viscosity;
pub mod xsph;

use crate::bodies::Bodies;
use crate::boundary::Boundary;
use crate::channels::{ChannelDeclaration, Channels};
use crate::coupling::Motions;
use crate::discretization::Discretization;
use crate::neighbours::Neighbours;
use crate::pairs::Quad;
use crate::report::SolveReport;
use crate::settings::{FluidSettings, SolverSettings, World};
use volmap_runtime::DVec3;

/// Something that acts on the fluid beside pressure.
pub trait Force: Send + Sync {
    /// Its name, in messages.
    fn name(&self) -> &'static str;

    /// Whether its settings can be used.
    ///
    /// # Errors
    /// The first that can't.
    fn check(&self) -> Result<(), Defect> {
        Ok(())
    }

    /// The particles' channels that it needs.
    fn channels(&self) -> Vec<ChannelDeclaration> {
        Vec::new()
    }

    /// The longest time step that it is stable with, seconds.
    fn longest_step(&self) -> f64 {
        f64::INFINITY
    }

    /// Whether it needs the [bends](crate::pairs::lists::Lists::bends) of the pairs.
    fn needs_bends(&self) -> bool {
        false
    }

    /// An explicit force: adds its accelerations (m/s^2) at these velocities (m/s), and may change its channels.
    fn accelerate(
        &mut self,
        _step: &ForceStep,
        _velocities: &[Quad],
        _channels: &mut Channels,
        _accelerations: &mut [Quad],
    ) {
    }

    /// An implicit force: changes the velocities (m/s), which explicit forces have changed before; none if it has
    /// nothing to solve. With implicit viscosity, pressures have changed them too, and it may be asked several times in
    /// a step (`StepReport::passes`), each time anew.
    fn solve(
        &mut self,
        _step: &ForceStep,
        _velocities: &mut [Quad],
        _channels: &mut Channels,
    ) -> Option<Solved> {
        None
    }

    /// Bytes held.
    fn memory_bytes(&self) -> usize {
        0
    }
}

/// A setting that can't be used.
#[derive(Clone, Debug, PartialEq)]
pub struct Defect {
    /// Its key.
    pub key: &'static str,
    /// What is wrong, and the cure.
    pub reason: String,
}

/// What a force sees of a step, beside the velocities. Particles are in the order of their cells; lists have one
/// element for each. The fourth number of a quad is 0.
pub struct ForceStep<'a> {
    /// Its length, seconds.
    pub dt: f64,
    /// Gravity, support radius and so on.
    pub world: &'a World,
    /// Kernel and volume of the sums over neighbours.
    pub with: Discretization,
    /// Mass of a particle, kg.
    pub particle_mass: f64,
    /// Who is near whom.
    pub neighbours: &'a Neighbours,
    /// What the particles see of the bodies.
    pub boundary: &'a Boundary,
    /// The bodies.
    pub bodies: &'a Bodies,
    /// Centres of the particles, metres.
    pub positions: &'a [DVec3],
    /// The same in support radii from the first one.
    pub places: &'a [Quad],
    /// Relative densities D = rho / rho_0.
    pub densities: &'a [f32],
}

/// What came of an implicit force.
#[derive(Clone, Debug, Default)]
pub struct Solved {
    /// How the solve went.
    pub report: SolveReport,
    /// Force (N) and torque (N m) of the fluid on each body; empty if it has none.
    pub on_bodies: Motions,
}

/// The forces of a simulation, in the order in which they act.
#[derive(Default)]
pub struct Forces {
    list: Vec<Box<dyn Force>>,
}

impl Forces {
    /// Those of the settings, then `others`.
    pub fn new(
        world: &World,
        fluid: &FluidSettings,
        solver: &SolverSettings,
        settings: &ForceSettings,
        others: Vec<Box<dyn Force>>,
    ) -> Forces {
        let mut list: Vec<Box<dyn Force>> = vec![
            Box::new(gravity::Gravity { acceleration: world.gravity }),
            Box::new(viscosity::Viscosity::new(fluid, world)),
            Box::new(xsph::Xsph { part: fluid.xsph }),
            Box::new(implicit_viscosity::ImplicitViscosity::new(fluid, world, &solver.viscosity)),
        ];
        list.extend(settings.list());
        list.extend(others);
        Forces { list }
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Force> {
        self.list.iter().map(|force| &**force)
    }

    /// The longest step that all are stable with, seconds.
    pub fn longest_step(&self) -> f64 {
        self.iter().map(Force::longest_step).fold(f64::INFINITY, f64::min)
    }

    /// Writes the accelerations by all explicit forces, m/s^2.
    pub fn accelerate(
        &mut self,
        step: &ForceStep,
        velocities: &[Quad],
        channels: &mut Channels,
        accelerations: &mut [Quad],
    ) {
        // What doesn't change any number that is added to it, zeros of either sign included.
        accelerations.fill([-0.0, -0.0, -0.0, 0.0]);
        for force in &mut self.list {
            force.accelerate(step, velocities, channels, accelerations);
        }
    }

    /// Changes the velocities by all implicit forces: iterations of all, the largest error, and all forces on the
    /// bodies.
    pub fn solve(&mut self, step: &ForceStep, velocities: &mut [Quad], channels: &mut Channels) -> Solved {
        let mut sum = Solved::default();
        for force in &mut self.list {
            let Some(solved) = force.solve(step, velocities, channels) else { continue };
            sum.report.iterations += solved.report.iterations;
            sum.report.error = sum.report.error.max(solved.report.error);
            if sum.on_bodies.is_empty() {
                sum.on_bodies = solved.on_bodies;
            } else {
                for (sum, more) in sum.on_bodies.iter_mut().zip(solved.on_bodies) {
                    *sum = [sum[0] + more[0], sum[1] + more[1]];
                }
            }
        }
        sum
    }

    /// Bytes held.
    pub fn memory_bytes(&self) -> usize {
        self.iter().map(Force::memory_bytes).sum()
    }
}

/// Makes [`ForceSettings`] of one line for each force: the key of its table, and its settings, which are the force.
macro_rules! forces_of_settings {
    ($($(#[$about:meta])* $key:ident: $force:ty,)*) => {
        /// Forces that are off unless a scene has their table.
        #[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct ForceSettings {
            $($(#[$about])* #[serde(skip_serializing_if = "Option::is_none")] pub $key: Option<$force>,)*
        }

        impl ForceSettings {
            /// Those that are on.
            fn list(&self) -> Vec<Box<dyn Force>> {
                let mut list: Vec<Box<dyn Force>> = Vec::new();
                $(if let Some(force) = &self.$key { list.push(Box::new(force.clone())); })*
                list
            }

            /// Whether all are off.
            pub fn is_none(&self) -> bool {
                *self == ForceSettings::default()
            }

            /// Whether all settings can be used.
            ///
            /// # Errors
            /// The first that can't, with the key of its table.
            pub fn check(&self) -> Result<(), (&'static str, Defect)> {
                $(if let Some(force) = &self.$key {
                    force.check().map_err(|defect| (stringify!($key), defect))?;
                })*
                Ok(())
            }
        }
    };
}

forces_of_settings! {
    /// Drag of the air on all of the fluid.
    damping: damping::Damping,
}
