//! What a run begins with. [`Session::new`](crate::session::Session::new) and [`check`] take it from here, so that
//! whatever a run would refuse, `check` refuses too.

use crate::assemble::assemble;
use crate::error::Error;
use crate::packing::pack;
use crate::scene::memory::Limit;
use crate::scene::sources::SourceCount;
use crate::scene::walls::Relaxed;
use crate::scene::{self, PreparedBody, Scene, SceneSummary, SourceFile, cut, placement, summary};
use std::path::Path;
use volmap_bake::watch::Watch;
use volmap_fluid::bodies::MOST_UNLIKE;
use volmap_fluid::simulation::Simulation;
use volmap_formats::text::{significant, thousands};

/// A simulation at time 0, and what is known of its parts.
pub struct Plan {
    /// The simulation.
    pub simulation: Simulation,
    /// Bodies in the scene's order.
    pub bodies: Vec<PreparedBody>,
    /// Particles by source.
    pub counts: Vec<SourceCount>,
    /// Files of the bodies, then of the fills, in the scene's order.
    pub files: Vec<SourceFile>,
    /// What the user should look at.
    pub notes: Vec<String>,
    /// Sources whose particles [`Plan::pack`] spreads.
    relaxed: Vec<Relaxed>,
}

impl Plan {
    /// Spreads the particles of relaxed sources, which takes as long as some hundred steps. Before the first step; a
    /// run that goes on from a checkpoint needs none of it.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub fn pack(&mut self, scene: &Scene, watch: &Watch) -> Result<(), Error> {
        let notes = pack(&mut self.simulation, scene, &self.bodies, &self.relaxed, watch)?;
        self.notes.extend(notes);
        for source in &self.relaxed {
            let range = source.particles.start as u32..source.particles.end as u32;
            let count = self.simulation.particles().ids.iter().filter(|id| range.contains(id)).count();
            let counts = self.counts.iter_mut().filter(|count| count.key == source.key);
            counts.for_each(|source| source.particles = count as u64);
        }
        Ok(())
    }
}

/// Checks a scene, opens or bakes its maps, places its particles and bodies. `end` is that of the run, seconds;
/// `on_bake` is called with each mesh before it is baked.
///
/// # Errors
/// As [`scene::prepare()`] and [`Simulation::new`]; a run without fluid until its end.
pub fn plan(scene: &Scene, end: f64, watch: &Watch, on_bake: &mut dyn FnMut(&Path)) -> Result<Plan, Error> {
    plan_within(scene, end, None, watch, on_bake)
}

/// The same of a run that may need so much memory, bytes.
///
/// # Errors
/// As [`plan()`], and a run or a bake that would need more.
pub fn plan_within(
    scene: &Scene,
    end: f64,
    max_memory: Option<u64>,
    watch: &Watch,
    on_bake: &mut dyn FnMut(&Path),
) -> Result<Plan, Error> {
    let prepared = match max_memory {
        Some(bytes) => scene::prepare_within(scene, Limit { bytes, end }, watch, on_bake)?,
        None => scene::prepare(scene, watch, on_bake)?,
    };
    let first = scene.emitters.iter().map(|emitter| emitter.start).fold(f64::INFINITY, f64::min);
    if prepared.particles.positions.is_empty() && first >= end {
        let reason = format!(
            "the first begins at {first} s, but the run ends at {end} s and has no other fluid; begin earlier, or end \
             later (stop.time)"
        );
        return Err(Error::Scene { place: "emitters".into(), reason });
    }
    let (bodies, files) = (prepared.bodies.clone(), prepared.files.clone());
    let (counts, mut notes) = (prepared.particles.counts.clone(), prepared.notes.clone());
    notes.extend(placement::notes(&bodies, scene.particle_radius, scene.domain.as_ref()));
    let jets = prepared.emitters.iter().flat_map(|emitter| emitter.places());
    let fluid: Vec<_> = prepared.particles.positions.iter().copied().chain(jets).collect();
    notes.extend(cut::notes(&bodies, &fluid, scene.domain.as_ref()));
    let relaxed = prepared.relaxed.clone();
    let simulation = Simulation::new(assemble(scene, prepared)?)?;
    notes.extend(unlike_masses(&simulation));
    Ok(Plan { simulation, bodies, counts, files, notes, relaxed })
}

/// A note if a free body is so much heavier than another one that it sinks into it.
fn unlike_masses(simulation: &Simulation) -> Option<String> {
    let bodies = simulation.bodies();
    let masses = (0..bodies.posed().len()).filter_map(|body| Some((body, bodies.mass(body)?.mass)));
    let [lightest, heaviest] = [
        masses.clone().min_by(|a, b| a.1.total_cmp(&b.1))?,
        masses.clone().max_by(|a, b| a.1.total_cmp(&b.1))?,
    ];
    let ratio = heaviest.1 / lightest.1;
    (ratio > MOST_UNLIKE).then(|| {
        format!(
            "body `{}` is {} times as heavy as `{}`: on top of each other the heavy one sinks into the light one, by \
             some {} mm; contacts hold up to {} times",
            bodies.name(heaviest.0),
            significant(ratio, 2),
            bodies.name(lightest.0),
            significant(1.2 * ratio / MOST_UNLIKE, 2),
            thousands(MOST_UNLIKE as u64)
        )
    })
}

/// Reads a scene, prepares all that its run begins with, and does the first step. What a run would refuse that may need
/// so much memory (bytes; none: any number) is an error here.
///
/// # Errors
/// As [`scene::load`], [`plan_within`] and [`Simulation::step`].
pub fn check(
    path: &Path,
    max_memory: Option<u64>,
    watch: &Watch,
    on_bake: &mut dyn FnMut(&Path),
) -> Result<SceneSummary, Error> {
    let scene = scene::load(path)?;
    let mut plan = plan_within(&scene, scene.stop.time, max_memory, watch, on_bake)?;
    plan.pack(&scene, watch)?;
    let masses = (0..plan.bodies.len()).map(|body| plan.simulation.bodies().mass(body).copied()).collect();
    let mut summary = summary::summarize(&scene, path, &plan.bodies, &plan.counts, masses);
    summary.notes.extend(std::mem::take(&mut plan.notes));
    plan.simulation.step()?;
    Ok(summary)
}
