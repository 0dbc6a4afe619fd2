//! What a simulation begins with.

use crate::bodies::Bodies;
use crate::emitter::Emitter;
use crate::forces::{Force, ForceSettings};
use crate::particles::Particles;
use crate::settings::{FluidSettings, SolverSettings, World};
use volmap_runtime::DVec3;

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
