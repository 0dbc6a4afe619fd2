//! The contents of a scene, for people and as JSON.

use super::body::{self, Motion};
use super::map::Origin;
use super::nozzle::{self, Flow};
use super::prepare::{Prepared, prepare};
use super::sources::SourceCount;
use super::{Scene, load};
use crate::error::Error;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use volmap_bake::watch::Watch;
use volmap_fluid::lattice;
use volmap_fluid::settings::BoundaryMethod;
use volmap_formats::text::{bytes, significant, thousands};

/// Peak memory of a run per particle, measured at 1 to 3 million particles (640 to 720: solver/BENCHMARKS.md). Each run
/// takes some 30 MB more.
const BYTES_PER_PARTICLE: u64 = 700;
/// Seconds per particle and step, measured at 60 thousand to 3 million particles (0.75 to 1.25e-6:
/// solver/BENCHMARKS.md) with [`ITERATIONS`] on two threads of one core of an AMD EPYC (Zen 3). Other scenes and
/// machines are up to several times faster or slower.
const SECONDS_PER_PARTICLE: f64 = 1e-6;
/// Iterations of both solves together that `SECONDS_PER_PARTICLE` is for.
const ITERATIONS: u32 = 8;
/// In place of a number of particles.
const UNKNOWN: &str = "particle count known after the map is baked";

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
    /// Estimate of the run's peak memory with the particles of the start, bytes; without maps that aren't opened.
    pub memory: u64,
    /// Estimate of a step with the particles of the start and 8 iterations, on the two threads of one core that it was
    /// measured on, seconds.
    pub step_seconds: f64,
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
    /// Key and file of the source.
    pub text: String,
    /// Whether the text tells the particles as well.
    #[serde(skip)]
    pub is_complete: bool,
}

impl SourceFacts {
    fn new(particles: Option<u64>, text: String) -> SourceFacts {
        SourceFacts { particles, flow: None, text, is_complete: false }
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
    /// Its map, if it was opened.
    pub map: Option<MapFacts>,
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
        out.sources.push(SourceFacts::new(None, format!("fills[{i}], {file}")));
    }
    let counts: Vec<u64> = out.sources.iter().filter_map(|source| source.particles).collect();
    out.particles = scene.fills.is_empty().then(|| counts.iter().sum());
    out.add_emitters(&scene);
    out.estimate(counts.iter().sum());
    out.notes = scene.all_notes();
    Ok(out)
}

/// Reads a scene, opens or bakes its maps and places its particles. What a run would refuse is an error here.
///
/// # Errors
/// As [`load`] and [`prepare()`].
pub fn check(path: &Path, watch: &Watch, on_bake: &mut dyn FnMut(&Path)) -> Result<SceneSummary, Error> {
    let scene = load(path)?;
    let prepared = prepare(&scene, watch, on_bake)?;
    Ok(summarize(&scene, &prepared, path))
}

/// The summary of a scene that is prepared.
pub fn summarize(scene: &Scene, prepared: &Prepared, path: &Path) -> SceneSummary {
    let mut out = outline(scene, path);
    let count = |count: &SourceCount| SourceFacts::new(Some(count.particles), count.key.clone());
    out.sources = prepared.particles.counts.iter().map(count).collect();
    let total = prepared.particles.positions.len() as u64;
    out.particles = Some(total);
    for (facts, body) in out.bodies.iter_mut().zip(&prepared.bodies) {
        facts.boundary_particles = body.boundary_particles;
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
    out.estimate(total);
    let mut maps: Vec<_> = prepared.bodies.iter().map(|body| &body.map).collect();
    maps.sort_by_key(|map| std::sync::Arc::as_ptr(map));
    maps.dedup_by(|a, b| std::sync::Arc::ptr_eq(a, b));
    out.memory += maps.iter().map(|map| map.memory_bytes() as u64).sum::<u64>();
    out.notes.extend(prepared.notes.iter().cloned());
    out
}

fn outline(scene: &Scene, path: &Path) -> SceneSummary {
    let body = |(body, name): (&body::Body, String)| BodyFacts {
        name,
        file: body.source().map(|source| source.path().display().to_string()).unwrap_or_default(),
        motion: match body.motion {
            Motion::Static => "static",
            Motion::Keyframes(_) => "keyframes",
            Motion::Spin(_) => "spin",
            Motion::Free(_) => "free",
        },
        boundary_particles: None,
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
        memory: 0,
        step_seconds: 0.0,
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
            self.sources.push(SourceFacts { particles, flow: Some(flow), text, is_complete: true });
        }
    }

    fn estimate(&mut self, particles: u64) {
        self.memory = particles * BYTES_PER_PARTICLE;
        self.step_seconds = particles as f64 * SECONDS_PER_PARTICLE;
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
        let (memory, step) = (bytes(self.memory), 1e3 * self.step_seconds);
        writeln!(
            f,
            "cost       about {memory} of memory; {step:.0} ms per step of {ITERATIONS} iterations on two threads"
        )?;
        write!(f, "end        {} s", self.end)?;
        self.notes.iter().try_for_each(|note| write!(f, "\nnote       {note}"))
    }
}

impl SceneSummary {
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
        self.sources.iter().try_for_each(|source| writeln!(f, "           {source}"))
    }
}

impl Display for SourceFacts {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self.particles {
            _ if self.is_complete => write!(f, "{}", self.text),
            Some(particles) => write!(f, "{}: {}", self.text, thousands(particles)),
            None => write!(f, "{}: {UNKNOWN}", self.text),
        }
    }
}

impl Display for BodyFacts {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        write!(f, "{}: {}, {}", self.name, self.motion, self.file)?;
        if let Some(count) = self.boundary_particles {
            write!(f, "; {} boundary particles", thousands(count))?;
        }
        if let Some(MapFacts { origin, resolution: [x, y, z], memory }) = &self.map {
            write!(f, "; {origin}, {x} x {y} x {z} cells, {}", bytes(*memory))?;
        }
        Ok(())
    }
}
