//! The boundary methods that are compared, and the simulations in which they are.

use crate::validation::Run;
use crate::validation::flow::GRAVITY;
use volmap_bake::density_map::DensitySettings;
use volmap_bake::plan::{GridChoice, MapSettings};
use volmap_fluid::Error;
use volmap_fluid::bodies::{Bodies, BodyDescription};
use volmap_fluid::boundary::{Boundary, Wall, density_map};
use volmap_fluid::particles::Particles;
use volmap_fluid::settings::{
    BoundaryMethod, BoundaryPressure, BoundarySampling, FluidSettings, SolverSettings, World,
};
use volmap_fluid::setup::Setup;
use volmap_fluid::shapes::{Shape, baked_by};
use volmap_fluid::simulation::{Simulation, StepReport};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::{ClosureKind, DVec3};

/// A boundary method: how the fluid sees bodies, and their pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// How bodies are seen.
    pub boundary: BoundaryMethod,
    /// How boundary particles lie.
    pub sampling: BoundarySampling,
    /// Closure of volume maps.
    pub closure: ClosureKind,
    /// Pressure at the boundary.
    pub pressure: BoundaryPressure,
}

/// All pressures at the boundary.
pub const PRESSURES: [BoundaryPressure; 4] =
    [BoundaryPressure::Own, BoundaryPressure::Mirror, BoundaryPressure::Sph, BoundaryPressure::Mls];

/// Distance from walls at the start, in rp, with which no method throws fluid off: on boundary particles it rests at 2
/// rp.
pub const CLEARANCE: f64 = 1.9;

/// A simulation without the boundary method.
#[derive(Clone, Debug, Default)]
pub struct Scenery {
    /// Particle radius rp, metres; the support radius is 4 rp.
    pub radius: f64,
    /// Positions of the fluid at rest, metres.
    pub places: Vec<DVec3>,
    /// The bodies.
    pub bodies: Vec<BodyDescription>,
    /// The fluid.
    pub fluid: FluidSettings,
    /// The solver; its boundary pressure is the method's.
    pub solver: SolverSettings,
}

impl Method {
    /// Volume maps with a closure.
    pub const fn maps(closure: ClosureKind, pressure: BoundaryPressure) -> Method {
        Method { closure, ..Method::of(BoundaryMethod::VolumeMap, pressure) }
    }

    /// Another boundary method.
    pub const fn of(boundary: BoundaryMethod, pressure: BoundaryPressure) -> Method {
        Method { boundary, sampling: BoundarySampling::Even, closure: ClosureKind::Mirror, pressure }
    }

    /// Boundary particles as blue noise.
    pub const fn blue_noise(pressure: BoundaryPressure) -> Method {
        let even = Method::of(BoundaryMethod::Particles, pressure);
        Method { sampling: BoundarySampling::BlueNoise, ..even }
    }

    /// How bodies are seen, in words.
    pub fn view(&self) -> String {
        match self.boundary {
            BoundaryMethod::VolumeMap => format!("volume map, {}", self.closure),
            BoundaryMethod::DensityMap => "density map".into(),
            BoundaryMethod::Particles => match self.sampling {
                BoundarySampling::Even => "particles".into(),
                BoundarySampling::BlueNoise => "particles, blue noise".into(),
            },
            BoundaryMethod::TubeMap => "tube map".into(),
        }
    }

    /// The method in words.
    pub fn name(&self) -> String {
        format!("{}, {}", self.view(), pressure_name(self.pressure))
    }

    fn world(&self, radius: f64) -> World {
        World {
            particle_radius: radius,
            support_radius: 4.0 * radius,
            boundary: self.boundary,
            sampling: self.sampling,
            closure: self.closure,
            gravity: DVec3::new(0.0, -GRAVITY, 0.0),
            ..World::default()
        }
    }

    /// Settings with which scenes bake a body for the method.
    pub fn baking(&self, support_radius: f64, container: bool) -> MapSettings {
        let closure = self.world(0.25 * support_radius).map_closure();
        let density = DensitySettings { extension: density_map::EXTENSION, ..DensitySettings::default() };
        MapSettings {
            support_radius: Some(closure.map_radius(support_radius)),
            grid: GridChoice::CellSize(closure.cell_size(support_radius)),
            invert: container,
            density: (self.boundary == BoundaryMethod::DensityMap).then_some(density),
            ..MapSettings::default()
        }
    }

    /// A mesh with the map that the method takes for particles of this radius (metres).
    ///
    /// # Errors
    /// As [`baked_by`].
    pub fn shape(&self, mesh: TriangleMesh, radius: f64, container: bool) -> Result<Shape, Error> {
        baked_by(mesh, self.baking(4.0 * radius, container))
    }

    /// What particles at these positions see of bodies; all lengths in metres.
    ///
    /// # Errors
    /// As [`Boundary::new`].
    pub fn walls(
        &self,
        radius: f64,
        bodies: Vec<BodyDescription>,
        places: &[DVec3],
    ) -> Result<Vec<Wall>, Error> {
        let world = self.world(radius);
        let bodies = Bodies::new(bodies, world.gravity)?;
        let mut boundary = Boundary::new(&world, &FluidSettings::default(), &bodies)?;
        boundary.sample_alone(&bodies, places);
        Ok(boundary.of_particle)
    }

    /// The setup of a simulation by this method, without particles; their radius in metres.
    ///
    /// # Errors
    /// As [`Bodies::new`].
    pub fn setup(
        &self,
        radius: f64,
        fluid: FluidSettings,
        solver: SolverSettings,
        bodies: Vec<BodyDescription>,
    ) -> Result<Setup, Error> {
        let world = self.world(radius);
        let bodies = Bodies::new(bodies, world.gravity)?;
        Ok(Setup {
            fluid,
            solver: SolverSettings { boundary_pressure: self.pressure, ..solver },
            ..Setup::new(world, Particles::default(), bodies)
        })
    }

    /// A simulation by this method.
    ///
    /// # Errors
    /// As [`Simulation::new`].
    pub fn simulation(&self, scenery: &Scenery) -> Result<Simulation, Error> {
        let Scenery { radius, places, bodies, fluid, solver } = scenery;
        let mut setup = self.setup(*radius, fluid.clone(), solver.clone(), bodies.clone())?;
        setup.particles.add(places, &vec![[0.0; 3]; places.len()]);
        Simulation::new(setup)
    }
}

/// A pressure's name in scenes.
pub fn pressure_name(pressure: BoundaryPressure) -> &'static str {
    match pressure {
        BoundaryPressure::Own => "own",
        BoundaryPressure::Mirror => "mirror",
        BoundaryPressure::Sph => "sph",
        BoundaryPressure::Mls => "mls",
    }
}

/// A solver whose steps have one length, seconds.
pub fn fixed_step(solver: SolverSettings, dt: f64) -> SolverSettings {
    let mut solver = solver;
    solver.time_step.initial = dt;
    solver.time_step.adaptive = false;
    solver
}

/// Simulates until a time (seconds) and shows every step to `look`. Returns the time at which the simulation failed, if
/// it did.
///
/// # Errors
/// Those of [`Simulation::step`] that are no failures of the simulation.
pub fn survives(
    run: &Run,
    simulation: &mut Simulation,
    time: f64,
    look: &mut dyn FnMut(&Simulation, &StepReport),
) -> Result<Option<f64>, Error> {
    while simulation.time() < time - 1e-9 {
        run.watch.check()?;
        match simulation.step() {
            Ok(report) => look(simulation, &report),
            Err(Error::Simulation { time, .. }) => return Ok(Some(time)),
            Err(other) => return Err(other),
        }
    }
    Ok(None)
}

/// The largest of increasing lengths of steps up to which all are stable; 0 if the first isn't.
///
/// # Errors
/// Those of `is_stable`.
pub fn largest_step(
    steps: impl IntoIterator<Item = f64>,
    mut is_stable: impl FnMut(f64) -> Result<bool, Error>,
) -> Result<f64, Error> {
    let mut largest = 0.0;
    for step in steps {
        if !is_stable(step)? {
            break;
        }
        largest = step;
    }
    Ok(largest)
}

/// The median; NaN of no values.
pub fn median(values: &[f64]) -> f64 {
    volmap_fluid::observe::percentile(values, 0.5)
}
