//! The contents of a scene, for people and as JSON.

use super::body::{self, Body, Motion};
use super::fluid::Fill;
use super::map::{Origin, surface_without_map};
use super::memory::{BYTES_OF_PROGRAM, BYTES_PER_PARTICLE, emitted, of_maps};
use super::nozzle::{self, Flow};
use super::prepare::PreparedBody;
use super::sources::SourceCount;
use super::surface::Surface;
use super::{Scene, load};
use crate::error::Error;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use volmap_fluid::bodies::Mass;
use volmap_fluid::lattice;
use volmap_fluid::settings::BoundaryMethod;
use volmap_formats::text::{bytes, duration, number, percent, significant, thousands};

/// Seconds per particle and step, measured at 60 thousand to 3 million particles (0.23 to 0.28e-6:
/// solver/BENCHMARKS.md) with [`ITERATIONS`] on two threads of an AMD EPYC (Zen 5). Other scenes and machines are up to
/// several times faster or slower.
const SECONDS_PER_PARTICLE: f64 = 0.25e-6;
/// Iterations of both solves together that `SECONDS_PER_PARTICLE` is for.
const ITERATIONS: u32 = 8;
/// In place of a number of particles.
const UNKNOWN: &str = "particle count known after the map is baked";

const FREE: &str = "free";

/// The contents of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneSummary {
    /// The scene file.
    pub scene: String,
    /// Particle radius, metres.
    pub particle_radius: f64,
    /// Support radius, metres.
    pub support_radius: f64,
    /// Kernel and boundary method; with volume maps the closure as well.
    pub methods: Vec<String>,
    /// Particles at the start. `None` if they are known only after a map is baked.
    pub particles: Option<u64>,
    /// Particles by source.
    pub sources: Vec<SourceFacts>,
    /// Bodies.
    pub bodies: Vec<BodyFacts>,
    /// Particles that emitters add until the end, if none blocks.
    pub emitted: u64,
    /// Whether those in bodies and outside the domain are left out of `particles`; `info` doesn't know them.
    pub are_placed: bool,
    /// Estimate of the run's peak memory with all particles, bytes; without maps that aren't opened.
    pub memory: u64,
    /// Estimate of a step with all particles and 8 iterations, on the two threads that it was measured on, seconds.
    pub step_seconds: f64,
    /// Steps until the end, if all are as long as they may be, or as frames are apart. Fast fluid needs more.
    pub least_steps: u64,
    /// Simulated seconds.
    pub end: f64,
    /// What the user should look at.
    pub notes: Vec<String>,
}

/// A source of particles, briefly.
#[derive(Clone, Debug, Serialize)]
pub struct SourceFacts {
    /// Particles, if they are known; of an emitter those of a layer, in the mean.
    pub particles: Option<u64>,
    /// Of an emitter: what it gives.
    pub flow: Option<Flow>,
    /// Of a fill: the part of its solid, without bodies, that its particles have the volume of.
    pub filled: Option<f64>,
    /// Of a fill that isn't placed yet: particles that the solid's volume holds.
    pub holds: Option<u64>,
    /// Key and file of the source.
    pub text: String,
    /// Whether the text tells the particles as well.
    #[serde(skip)]
    pub is_complete: bool,
}

impl SourceFacts {
    fn new(particles: Option<u64>, text: String) -> SourceFacts {
        SourceFacts { particles, flow: None, filled: None, holds: None, text, is_complete: false }
    }
}

/// A body, briefly.
#[derive(Clone, Debug, Serialize)]
pub struct BodyFacts {
    /// Its name.
    pub name: String,
    /// Its file.
    pub file: String,
    /// How it moves.
    pub motion: &'static str,
    /// Boundary particles on its surface, if the method has them and the mesh was read.
    pub boundary_particles: Option<u64>,
    /// Mass of a free body, if it is known.
    pub mass: Option<MassFacts>,
    /// Its map, if it was opened.
    pub map: Option<MapFacts>,
}

/// How heavy a free body is, and why.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MassFacts {
    /// kg.
    pub mass: f64,
    /// Of the solid, m^3.
    pub volume: f64,
    /// Mean, kg/m^3.
    pub density: f64,
    /// What the scene gives: `mass` or `density`.
    pub given: &'static str,
    /// What the volume is that of: `shape`, `mesh` or `map`.
    pub volume_of: &'static str,
}

impl MassFacts {
    /// None of a body that isn't free.
    fn new(body: &Body, mass: &Mass, surface: &Surface) -> Option<MassFacts> {
        let Motion::Free(free) = &body.motion else { return None };
        // An open mesh has no volume; then the map's is taken.
        let closed = || surface.mesh.as_ref().is_some_and(|mesh| Mass::of_mesh(mesh, 1.0).is_some());
        Some(MassFacts {
            mass: mass.mass,
            volume: mass.volume,
            density: mass.mass / mass.volume,
            given: if free.mass.is_some() { "mass" } else { "density" },
            volume_of: match surface.primitive {
                Some(_) => "shape",
                None if closed() => "mesh",
                None => "map",
            },
        })
    }
}

/// The mass of a free body, as far as it is known without its map.
fn mass_without_map(body: &Body) -> Option<MassFacts> {
    let Motion::Free(free) = &body.motion else { return None };
    let surface = surface_without_map(body.source()?, &body.bake)?;
    let mass = surface.mass(free.density.unwrap_or(1.0))?;
    let mass = free.mass.map_or(mass, |given| mass.with_mass(given));
    MassFacts::new(body, &mass, &surface)
}

/// A map, briefly.
#[derive(Clone, Debug, Serialize)]
pub struct MapFacts {
    /// Where it comes from.
    pub origin: &'static str,
    /// Cells of its grid.
    pub resolution: [u32; 3],
    /// Bytes in memory.
    pub memory: u64,
}

/// Reads a scene and sums up its contents. Opens no map and bakes nothing.
///
/// # Errors
/// As [`load`].
pub fn info(path: &Path) -> Result<SceneSummary, Error> {
    let scene = load(path)?;
    let mut out = outline(&scene, path);
    for (i, block) in scene.blocks.iter().enumerate() {
        let particles = lattice::counts(block.region().corners(), scene.spacing()).iter().product();
        out.sources.push(SourceFacts::new(Some(particles), format!("blocks[{i}]")));
    }
    for (i, fill) in scene.fills.iter().enumerate() {
        let file = fill.source().map(|source| source.path().display().to_string()).unwrap_or_default();
        let facts = SourceFacts::new(None, format!("fills[{i}], {file}"));
        let holds = volume_of(fill).map(|volume| (volume / scene.particle_volume()).round() as u64);
        out.sources.push(SourceFacts { holds, ..facts });
    }
    for (facts, body) in out.bodies.iter_mut().zip(&scene.bodies) {
        facts.mass = mass_without_map(body);
    }
    let counts: Vec<u64> = out.sources.iter().filter_map(|source| source.particles).collect();
    out.particles = scene.fills.is_empty().then(|| counts.iter().sum());
    out.are_placed = scene.bodies.is_empty() && scene.domain.is_none();
    out.add_emitters(&scene);
    out.estimate(&scene, counts.iter().sum());
    out.notes = scene.notes.clone();
    Ok(out)
}

/// The summary of a scene that is prepared; `masses` are those of its free bodies.
pub fn summarize(
    scene: &Scene,
    path: &Path,
    bodies: &[PreparedBody],
    counts: &[SourceCount],
    masses: Vec<Option<Mass>>,
) -> SceneSummary {
    let mut out = outline(scene, path);
    let count = |count: &SourceCount| SourceFacts {
        filled: (count.key.starts_with("fills") && count.space > 0.0)
            .then(|| count.particles as f64 * scene.particle_volume() / count.space),
        ..SourceFacts::new(Some(count.particles), count.key.clone())
    };
    out.sources = counts.iter().map(count).collect();
    let total = counts.iter().map(|count| count.particles).sum();
    out.particles = Some(total);
    for ((facts, body), mass) in out.bodies.iter_mut().zip(bodies).zip(masses) {
        facts.boundary_particles = body.boundary_particles;
        facts.mass = mass.and_then(|mass| MassFacts::new(&body.settings, &mass, &body.surface));
        facts.map = Some(MapFacts {
            origin: match body.origin {
                Origin::Asset => "asset",
                Origin::Cache => "baked before",
                Origin::Baked => "baked now",
            },
            resolution: body.map.grid().resolution.to_array(),
            memory: body.map.memory_bytes() as u64,
        });
    }
    out.add_emitters(scene);
    out.estimate(scene, total);
    out.memory += of_maps(bodies.iter().map(|body| &body.map));
    out
}

/// Volume of a fill's solid, m^3, as far as its shape or its mesh tells it.
fn volume_of(fill: &Fill) -> Option<f64> {
    if fill.within.is_some() {
        return None;
    }
    Some(surface_without_map(fill.source()?, &fill.bake)?.mass(1.0)?.volume)
}

fn outline(scene: &Scene, path: &Path) -> SceneSummary {
    let body = |(body, name): (&body::Body, String)| BodyFacts {
        name,
        file: body.source().map(|source| source.path().display().to_string()).unwrap_or_default(),
        motion: match body.motion {
            Motion::Static => "static",
            Motion::Keyframes(_) => "keyframes",
            Motion::Spin(_) => "spin",
            Motion::Free(_) => FREE,
        },
        boundary_particles: None,
        mass: None,
        map: None,
    };
    SceneSummary {
        scene: path.display().to_string(),
        particle_radius: scene.particle_radius,
        support_radius: scene.support_radius(),
        methods: methods(scene),
        particles: None,
        sources: Vec::new(),
        bodies: scene.bodies.iter().zip(body::names(&scene.bodies)).map(body).collect(),
        emitted: 0,
        are_placed: true,
        memory: 0,
        step_seconds: 0.0,
        least_steps: 0,
        end: scene.stop.time,
        notes: Vec::new(),
    }
}

fn methods(scene: &Scene) -> Vec<String> {
    let word = |value: serde_json::Result<serde_json::Value>| {
        value.ok().and_then(|value| Some(value.as_str()?.to_owned())).unwrap_or_default()
    };
    let mut methods =
        vec![word(serde_json::to_value(scene.kernel)), word(serde_json::to_value(scene.boundary))];
    if scene.boundary == BoundaryMethod::VolumeMap {
        methods.push(scene.world().closure.to_string());
    }
    methods
}

impl SceneSummary {
    fn add_emitters(&mut self, scene: &Scene) {
        self.emitted = emitted(scene, scene.stop.time);
        for (i, settings) in scene.emitters.iter().enumerate() {
            let emitter = nozzle::emitter(settings, scene.rest_spacing());
            let flow = nozzle::flow(settings, scene.rest_spacing(), &emitter);
            let text = format!(
                "emitters[{i}]: {} m^3/s asked, {} m^3/s given; {} particles per layer, {} per second",
                significant(flow.asked, 4),
                significant(flow.given, 4),
                significant(emitter.particles_per_layer(), 3),
                significant(emitter.particles_per_second(), 4),
            );
            let particles = Some(emitter.particles_per_layer().round() as u64);
            let facts = SourceFacts::new(particles, text);
            self.sources.push(SourceFacts { flow: Some(flow), is_complete: true, ..facts });
        }
    }

    fn estimate(&mut self, scene: &Scene, particles: u64) {
        let all = particles + self.emitted;
        self.memory = BYTES_OF_PROGRAM + all * BYTES_PER_PARTICLE;
        self.step_seconds = all as f64 * SECONDS_PER_PARTICLE;
        let step = &scene.solver.time_step;
        let longest = if step.adaptive { step.max } else { step.initial };
        let steps = (scene.stop.time / longest - 1e-6).ceil() as u64;
        self.least_steps = steps.max(1).min(scene.stop.steps.unwrap_or(u64::MAX));
    }
}

impl Display for SceneSummary {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(f, "scene      {}", self.scene)?;
        self.fmt_particles(f)?;
        for (i, body) in self.bodies.iter().enumerate() {
            let label = if i == 0 { "bodies" } else { "" };
            writeln!(f, "{label:10} {body}")?;
        }
        self.fmt_cost(f)?;
        write!(f, "end        {} s", self.end)?;
        self.notes.iter().try_for_each(|note| write!(f, "\nnote       {note}"))
    }
}

impl SceneSummary {
    fn fmt_cost(&self, f: &mut Formatter) -> fmt::Result {
        let (memory, step) = (bytes(self.memory), number(1e3 * self.step_seconds));
        let when = match (self.emitted, self.particles) {
            (0, _) => String::new(),
            (more, None) => format!("at the end, with {} particles of emitters: ", thousands(more)),
            (more, Some(0)) => format!("at the end, with up to {} particles: ", thousands(more)),
            (more, Some(first)) => {
                let all = thousands(first + more);
                format!("at the end, with up to {all} particles, {} of them of emitters: ", thousands(more))
            }
        };
        writeln!(
            f,
            "cost       {when}about {memory} of memory, {step} ms per step of {ITERATIONS} iterations on two threads"
        )?;
        // With emitters the fluid grows evenly.
        let mean = match (self.emitted, self.particles) {
            (more, Some(first)) if more > 0 => (first as f64 + 0.5 * more as f64) / (first + more) as f64,
            _ => 1.0,
        };
        let time = duration(self.least_steps as f64 * self.step_seconds * mean);
        writeln!(
            f,
            "steps      at least {}, so about {time} or more; fast fluid needs shorter steps, pictures and files come \
             on top",
            thousands(self.least_steps)
        )
    }

    fn fmt_particles(&self, f: &mut Formatter) -> fmt::Result {
        let words = ["kernel", "boundary", "closure"].iter().zip(&self.methods);
        let methods: Vec<String> = words.map(|(word, method)| format!("{word} {method}")).collect();
        let count = match self.particles {
            Some(count) => thousands(count),
            None => UNKNOWN.into(),
        };
        writeln!(
            f,
            "particles  {count}; radius {} m, support radius {} m, {}",
            self.particle_radius,
            self.support_radius,
            methods.join(", ")
        )?;
        self.sources.iter().try_for_each(|source| writeln!(f, "           {source}"))?;
        if self.are_placed {
            Ok(())
        } else {
            writeln!(f, "           fewer where they lie in bodies or outside the domain")
        }
    }
}

impl Display for SourceFacts {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self.particles {
            _ if self.is_complete => write!(f, "{}", self.text)?,
            Some(particles) => write!(f, "{}: {}", self.text, thousands(particles))?,
            None => write!(f, "{}: {UNKNOWN}", self.text)?,
        }
        match (self.filled, self.holds) {
            (Some(filled), _) => write!(f, ", {} of its solid", percent(filled)),
            (None, Some(holds)) => write!(f, "; its solid has the volume of {}", thousands(holds)),
            (None, None) => Ok(()),
        }
    }
}

impl Display for MassFacts {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let &MassFacts { mass, volume, density, given, volume_of } = self;
        let [mass, volume, density] = [mass, volume, density].map(|x| significant(x, 4));
        match given {
            "mass" => {
                write!(f, "{mass} kg (given; {density} kg/m^3 by the {volume_of}'s volume, {volume} m^3)")
            }
            _ => write!(f, "{mass} kg (density {density} kg/m^3 x volume {volume} m^3 of the {volume_of})"),
        }
    }
}

impl Display for BodyFacts {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{}: {}, {}", self.name, self.motion, self.file)?;
        if let Some(mass) = &self.mass {
            write!(f, "; {mass}")?;
        } else if self.motion == FREE {
            write!(f, "; mass known after the map is baked")?;
        }
        if let Some(count) = self.boundary_particles {
            write!(f, "; {} boundary particles", thousands(count))?;
        }
        if let Some(MapFacts { origin, resolution: [x, y, z], memory }) = &self.map {
            write!(f, "; {origin}, {x} x {y} x {z} cells, {}", bytes(*memory))?;
        }
        Ok(())
    }
}
