//! What a simulation begins with.

use crate::bodies::Bodies;
use crate::emitter::Emitter;
use crate::error::Error;
use crate::forces::{Force, ForceSettings};
use crate::particles::Particles;
use crate::settings::{FluidSettings, MOST_RELAXATION, SolverSettings, World};
use volmap_formats::text::number;
use volmap_runtime::DVec3;

/// Least density of a free body, in parts of the fluid's. The fluid that it moves along weighs more than 10,000 times
/// as much then, and what a solve leaves of its errors is enough to throw it about. Air has 1.2e-3 of water's.
pub const LIGHTEST_BODY: f64 = 1e-4;

/// What a simulation begins with. Numbers must be finite and in range: see `volmap_scenes`.
pub struct Setup {
    /// Particle radius, support radius, kernel, closure, gravity.
    pub world: World,
    /// What the fluid is.
    pub fluid: FluidSettings,
    /// How it is solved.
    pub solver: SolverSettings,
    /// The fluid at the start.
    pub particles: Particles,
    /// What adds to it.
    pub emitters: Vec<Emitter>,
    /// What it touches; maps of the world's support radius.
    pub bodies: Bodies,
    /// Particles that leave this box are removed. Default: fluid and bodies of the start, thrice as wide and more.
    pub domain: Option<[DVec3; 2]>,
    /// Forces that have settings of their own.
    pub forces: ForceSettings,
    /// Forces of the program's own, which act after all others.
    pub own_forces: Vec<Box<dyn Force>>,
}

impl Setup {
    /// A fluid without emitters and forces of its own, in the default domain.
    pub fn new(world: World, particles: Particles, bodies: Bodies) -> Setup {
        Setup {
            world,
            fluid: FluidSettings::default(),
            solver: SolverSettings::default(),
            particles,
            emitters: Vec::new(),
            bodies,
            domain: None,
            forces: ForceSettings::default(),
            own_forces: Vec::new(),
        }
    }

    /// Checks what no simulation could be right with.
    ///
    /// # Errors
    /// [`Error::Setup`] for factors of the solver out of their range, and for free bodies lighter than
    /// [`LIGHTEST_BODY`] of the fluid.
    pub(crate) fn check(&self) -> Result<(), Error> {
        let refuse = |place: String, reason: String| Err(Error::Setup { place, reason });
        let SolverSettings { relaxation, warm_start, .. } = self.solver;
        if !(relaxation > 0.0 && relaxation <= MOST_RELAXATION) {
            let reason = format!(
                "{} is not above 0 and up to {MOST_RELAXATION}: with more, fluids gain energy and burst",
                number(relaxation)
            );
            return refuse("relaxation".into(), reason);
        }
        if !(0.0..=1.0).contains(&warm_start) {
            return refuse("warm_start".into(), format!("{} is not within 0 to 1", number(warm_start)));
        }
        if self.particles.is_empty() && self.emitters.is_empty() {
            return Ok(());
        }
        let least = LIGHTEST_BODY * self.fluid.rest_density;
        for body in 0..self.bodies.posed().len() {
            let Some(density) = self.bodies.mass(body).map(|mass| mass.mass / mass.volume) else { continue };
            if density < least {
                let reason = format!(
                    "{} kg/m^3 is less than {} of the fluid's {} kg/m^3: the fluid would throw so light a body \
                     about; give it {} kg/m^3 or more, which floats as high",
                    number(density),
                    number(LIGHTEST_BODY),
                    number(self.fluid.rest_density),
                    number(least),
                );
                return refuse(format!("body `{}`", self.bodies.name(body)), reason);
            }
        }
        Ok(())
    }

    /// The domain, or the default one: all that is there at the start, grown on each side by its own diagonal, or by
    /// what a drop may fall.
    pub(crate) fn domain_or_default(&self) -> [DVec3; 2] {
        self.domain
            .unwrap_or_else(|| default_domain(&self.particles, &self.emitters, &self.bodies, &self.world))
    }
}

/// Of the default domain, in support radii.
const LEAST_MARGIN: f64 = 100.0;

fn default_domain(particles: &Particles, emitters: &[Emitter], bodies: &Bodies, world: &World) -> [DVec3; 2] {
    let mut points: Vec<DVec3> = particles.positions.clone();
    points.extend(emitters.iter().flat_map(Emitter::places));
    for body in bodies.posed() {
        let grid = body.map.grid();
        for corner in 0..8 {
            let pick = |bit: u32, min: f64, max: f64| if corner >> bit & 1 == 0 { min } else { max };
            // In two dimensions grids are endless along z.
            let [min, max] =
                [grid.origin, grid.max_corner()].map(|x| if x.z.is_finite() { x } else { x.with_z(0.0) });
            let at = DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z));
            points.push(body.pose.to_world(at));
        }
    }
    let min = points.iter().fold(DVec3::INFINITY, |min, &x| min.min(x));
    let max = points.iter().fold(DVec3::NEG_INFINITY, |max, &x| max.max(x));
    let margin = DVec3::splat((max - min).length().max(LEAST_MARGIN * world.support_radius));
    [min - margin, max + margin]
}
