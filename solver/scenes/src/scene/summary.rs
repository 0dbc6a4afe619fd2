//! What is in a scene, for people and for programs.

use super::body::{self, Motion};
use super::map::Origin;
use super::nozzle;
use super::prepare::{Prepared, prepare};
use super::sources::SourceCount;
use super::{Scene, load};
use crate::error::Error;
use serde::Serialize;
use std::fmt::{self, Display, Formatter};
use std::path::Path;
use volmap_fluid::lattice;
use volmap_fluid::settings::BoundaryMethod;
use volmap_formats::text::{bytes, thousands};

/// The largest memory of a run over its particles, measured at 1 to 3 million (640 to 720: solver/BENCHMARKS.md); a run of
/// few takes some 30 MB more.
const BYTES_PER_PARTICLE: u64 = 700;
/// Seconds a particle and step, measured at 60 thousand to 3 million (0.75 to 1.25e-6: solver/BENCHMARKS.md) with
/// [`ITERATIONS`] on two threads of one core of an AMD EPYC (Zen 3). Other scenes and machines are several times off.
const SECONDS_PER_PARTICLE: f64 = 1e-6;
/// Iterations of both solves together that `SECONDS_PER_PARTICLE` is for.
const ITERATIONS: u32 = 8;

/// What is in a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The scene file.
    pub scene: String,
    /// Particle radius, metres.
    pub particle_radius: f64,
    /// Support radius, metres.
    pub support_radius: f64,
    /// Kernel and boundary; of volume maps the closure, too.
    pub methods: Vec<String>,
    /// Particles at the start, if they are known without any map.
    pub particles: Option<u64>,
    /// Particles by source.
    pub sources: Vec<SourceFacts>,
    /// Bodies.
    pub bodies: Vec<BodyFacts>,
    /// Estimate of the run's largest memory with the particles of the start, bytes; without maps that aren't opened.
    pub memory: u64,
    /// Estimate of a step with the particles of the start and 8 iterations, on the two threads of one core that it was
    /// measured on, seconds.
    pub step_seconds: f64,
    /// Simulated seconds.
    pub end: f64,
    /// What a careful person would look at.
    pub notes: Vec<String>,
}

/// What a source gives.
#[derive(Clone, Debug, Serialize)]
pub struct SourceFacts {
    /// Particles, if they are known; of a nozzle those of a layer.
    pub particles: Option<u64>,
    /// In words.
    pub text: String,
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
    /// Particles on its surface, with particle boundaries, once its mesh is read.
    pub boundary_particles: Option<u64>,
    /// Its map, once it is opened.
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

/// Reads a scene and tells what is in it; opens no map and bakes nothing.
///
/// # Errors
/// As [`load`].
pub fn info(path: &Path) -> Result<Summary, Error> {
    let scene = load(path)?;
    let mut out = outline(&scene, path);
    for (i, block) in scene.blocks.iter().enumerate() {
        let particles = lattice::counts(block.region().corners(), scene.spacing()).iter().product();
        out.sources.push(SourceFacts { particles: Some(particles), text: format!("blocks[{i}]") });
    }
    for (i, fill) in scene.fills.iter().enumerate() {
        let file = fill.source().map(|source| source.path().display().to_string()).unwrap_or_default();
        out.sources.push(SourceFacts { particles: None, text: format!("fills[{i}], {file}") });
    }
    let counts: Vec<u64> = out.sources.iter().filter_map(|source| source.particles).collect();
    out.particles = scene.fills.is_empty().then(|| counts.iter().sum());
    out.add_emitters(&scene);
    out.estimate(counts.iter().sum());
    Ok(out)
}

/// Reads a scene, opens or bakes its maps and places its particles: whatever a run could refuse is told here.
///
/// # Errors
/// As [`load`] and [`prepare()`].
pub fn check(path: &Path, on_bake: &mut dyn FnMut(&Path)) -> Result<Summary, Error> {
    let scene = load(path)?;
    let prepared = prepare(&scene, on_bake)?;
    Ok(summarize(&scene, &prepared, path))
}

/// The summary of a scene that is prepared.
pub fn summarize(scene: &Scene, prepared: &Prepared, path: &Path) -> Summary {
    let mut out = outline(scene, path);
    let count =
        |count: &SourceCount| SourceFacts { particles: Some(count.particles), text: count.key.clone() };
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

fn outline(scene: &Scene, path: &Path) -> Summary {
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
    Summary {
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

impl Summary {
    fn add_emitters(&mut self, scene: &Scene) {
        for (i, settings) in scene.emitters.iter().enumerate() {
            let layer = nozzle::emitter(settings, scene.particle_radius).layer().len() as u64;
            let rate = layer as f64 * settings.speed / scene.spacing();
            let text = format!("emitters[{i}]: {layer} a layer, {rate:.0} a second");
            self.sources.push(SourceFacts { particles: Some(layer), text });
        }
    }

    fn estimate(&mut self, particles: u64) {
        self.memory = particles * BYTES_PER_PARTICLE;
        self.step_seconds = particles as f64 * SECONDS_PER_PARTICLE;
    }
}

impl Display for Summary {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        writeln!(f, "scene      {}", self.scene)?;
        let words = ["kernel", "boundary", "closure"].iter().zip(&self.methods);
        writeln!(
            f,
            "particles  {} of radius {} m, support radius {} m, {}",
            self.particles.map_or("some".into(), thousands),
            self.particle_radius,
            self.support_radius,
            words.map(|(word, method)| format!("{word} {method}")).collect::<Vec<_>>().join(", ")
        )?;
        for source in &self.sources {
            match source.particles {
                _ if source.text.starts_with("emitters") => writeln!(f, "           {}", source.text)?,
                Some(particles) => writeln!(f, "           {}: {}", source.text, thousands(particles))?,
                None => writeln!(f, "           {}: known once its map is", source.text)?,
            }
        }
        for (i, body) in self.bodies.iter().enumerate() {
            let label = if i == 0 { "bodies" } else { "" };
            write!(f, "{label:10} {}: {}, {}", body.name, body.motion, body.file)?;
            if let Some(count) = body.boundary_particles {
                write!(f, "; {} boundary particles", thousands(count))?;
            }
            match &body.map {
                Some(MapFacts { origin, resolution: [x, y, z], memory }) => {
                    writeln!(f, "; {origin}, {x} x {y} x {z} cells, {}", bytes(*memory))?;
                }
                None => writeln!(f)?,
            }
        }
        let step = 1e3 * self.step_seconds;
        writeln!(
            f,
            "cost       about {} of memory, {step:.0} ms a step of {ITERATIONS} iterations on two threads of one core",
            bytes(self.memory)
        )?;
        write!(f, "end        {} s", self.end)?;
        self.notes.iter().try_for_each(|note| write!(f, "\nnote       {note}"))
    }
}
