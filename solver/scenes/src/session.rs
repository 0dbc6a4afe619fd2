//! A run: a scene simulated into a folder, from the beginning or from its checkpoint.
//!
//! [`Session::run`] does all of it. [`Session::step`] and [`Session::finish`] are its pieces, for programs that have
//! a loop of their own.

mod contents;

use crate::error::Error;
use crate::output::bodies::BodyMesh;
use crate::output::folder::Start;
use crate::output::lock::FolderLock;
use crate::output::statistics::{EmitterSummary, RunSummary};
use crate::output::{self, Frame, Output, StepStatistics};
use crate::plan::{Plan, plan_within};
use crate::resume::{self, Identity};
use crate::scene::{self, Scene};
use contents::{
    Beginning, body_frames, body_meshes, far_origin, folder_settings, origin_note, picture_world,
};
use std::path::{Path, PathBuf};
use std::time::Instant;
use volmap_bake::watch::Watch;
use volmap_fluid::channels::{Channel, ChannelValues};
use volmap_fluid::emitter::Emitter;
use volmap_fluid::simulation::Simulation;
use volmap_formats::export::points::Values;
use volmap_formats::text::number;
use volmap_runtime::DVec3;

/// How a run begins and ends.
#[derive(Clone, Debug, Default)]
pub struct RunSettings {
    /// What becomes of a run that is in the folder already.
    pub begin: Begin,
    /// Ends after this many steps in all, counted from the beginning of the scene, instead of the scene's number.
    pub steps: Option<u64>,
    /// Ends at this time, seconds, instead of the scene's.
    pub until: Option<f64>,
    /// Bytes that the run may need, by the estimate of [`memory`](crate::scene::memory); none: any number.
    pub max_memory: Option<u64>,
}

/// How a run begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Begin {
    /// At time 0, in a folder without a run.
    #[default]
    New,
    /// At time 0, in place of a run that is in the folder.
    Overwrite,
    /// From the checkpoint in the folder.
    Resume,
}

/// A run in progress.
pub struct Session {
    simulation: Simulation,
    output: Output,
    scene: Scene,
    identity: Identity,
    folder: PathBuf,
    end: f64,
    last_step: Option<u64>,
    next_checkpoint: f64,
    /// Which bodies have left the domain.
    gone: Vec<bool>,
    /// What places in files are relative to, if they need it.
    origin: Option<DVec3>,
    /// What the user should look at before the run: particles left out of bodies, coarse maps, tables that were torn.
    pub notes: Vec<String>,
    /// The folder is this run's alone.
    _lock: FolderLock,
}

/// A step that was done, with its output.
#[derive(Clone, Debug)]
pub struct Step {
    /// Iterations, errors, counts and times.
    pub statistics: StepStatistics,
    /// The number of the frame that was written after it, if one was due.
    pub frame: Option<u64>,
    /// What the user should know of it.
    pub notes: Vec<String>,
}

/// What [`Session::run`] tells after each step.
pub struct Progress<'a> {
    /// The step.
    pub step: &'a Step,
    /// Particles and bodies after the step.
    pub simulation: &'a Simulation,
    /// Time at which the run ends, seconds.
    pub end: f64,
    /// Step after which the run ends, if it has a fixed number of them.
    pub last_step: Option<u64>,
}

const CHECKPOINT: &str = "checkpoint";
const STATISTICS: &str = "stats.csv";

/// In intervals of frames: for times that are sums of steps.
const TOLERANCE: f64 = 1e-9;

impl Session {
    /// Reads a scene file and begins as [`Session::new`].
    ///
    /// # Errors
    /// A scene file that can't be used, and as [`Session::new`].
    pub fn open(
        path: &Path,
        folder: &Path,
        settings: &RunSettings,
        watch: &Watch,
        on_bake: &mut dyn FnMut(&Path),
    ) -> Result<Session, Error> {
        Session::new(scene::load(path)?, folder, settings, watch, on_bake)
    }

    /// Bakes the meshes that aren't baked, opens the folder, and writes the first frame or reads the checkpoint.
    /// `on_bake` is called with each mesh before it is baked.
    ///
    /// # Errors
    /// A scene, mesh, map or checkpoint that can't be used; [`Error::RunActive`], [`Error::RunExists`] and
    /// [`Error::NoCheckpoint`]; [`Error::Cancelled`] if the bakes were stopped.
    pub fn new(
        scene: Scene,
        folder: &Path,
        settings: &RunSettings,
        watch: &Watch,
        on_bake: &mut dyn FnMut(&Path),
    ) -> Result<Session, Error> {
        scene.validate()?;
        let lock = claim(folder, settings.begin)?;
        let end = settings.until.unwrap_or(scene.stop.time);
        let planned = plan_within(&scene, end, settings.max_memory, watch, on_bake).and_then(|mut plan| {
            if settings.begin != Begin::Resume {
                plan.pack(&scene, watch)?;
            }
            Ok(plan)
        });
        let (plan, lock) = match planned {
            Ok(plan) => (plan, lock),
            Err(error) => {
                lock.give_back();
                return Err(error);
            }
        };
        let Plan { mut simulation, bodies, files, mut notes, .. } = plan;
        let identity = Identity::new(&scene, files);
        let meshes = body_meshes(&bodies);
        let beginning = Beginning { scene: &scene, simulation: &simulation, bodies: &bodies };
        let origin = far_origin(&beginning);
        notes.extend(origin.map(|origin| origin_note(&scene, origin)).into_iter().chain(frames_note(&scene)));
        let world = picture_world(&beginning, &meshes, origin.unwrap_or_default());
        let meshes: Vec<BodyMesh> = meshes.into_iter().flatten().collect();
        let start = begin(&mut simulation, folder, settings.begin, &identity)?;
        let output = Output::open(folder, &folder_settings(&scene), world, &meshes, start)?;
        notes.extend(output.notes.iter().cloned());
        let mut session = Session {
            next_checkpoint: simulation.time() + scene.output.checkpoint_interval,
            end,
            gone: vec![false; bodies.len()],
            last_step: settings.steps.or(scene.stop.steps),
            folder: folder.to_owned(),
            simulation,
            output,
            scene,
            identity,
            origin,
            notes,
            _lock: lock,
        };
        if settings.begin != Begin::Resume {
            session.write_frame()?;
        }
        Ok(session)
    }

    /// Simulates until the end, or until the watch is cancelled, and finishes either way: a run that was stopped has
    /// its checkpoint, and [`Session::is_done`] is false. `on_step` is called after each step.
    ///
    /// # Errors
    /// As [`Session::step`] and [`Session::finish`].
    pub fn run(&mut self, watch: &Watch, on_step: &mut dyn FnMut(&Progress)) -> Result<RunSummary, Error> {
        while !self.is_done() && watch.check().is_ok() {
            let step = self.step()?;
            on_step(&Progress {
                step: &step,
                simulation: &self.simulation,
                end: self.end,
                last_step: self.last_step,
            });
        }
        self.finish()
    }

    /// One step, with the frame and the checkpoint that are due after it.
    ///
    /// # Errors
    /// [`Error::Simulation`]; files that can't be written. What has been written stays, and so does the last
    /// checkpoint.
    pub fn step(&mut self) -> Result<Step, Error> {
        let before = self.simulation.time();
        let report = match self.next_frame_time() {
            Some(time) => self.simulation.step_towards(time)?,
            None => self.simulation.step()?,
        };
        let writing = Instant::now();
        let frame = self.write_frame_if_due(before)?;
        let statistics = StepStatistics::of(&self.simulation, &report, writing.elapsed());
        self.output.step(&statistics)?;
        // It counts the frames and rows before it.
        self.checkpoint_if_due()?;
        Ok(Step { statistics, frame, notes: self.gone_bodies() })
    }

    /// A note for each free body that has left the domain in this step, or before the run was resumed.
    fn gone_bodies(&mut self) -> Vec<String> {
        let [low, high] = self.simulation.domain();
        let bodies = self.simulation.bodies();
        let mut notes = Vec::new();
        for (body, gone) in self.gone.iter_mut().enumerate().filter(|(body, _)| bodies.is_free(*body)) {
            let centre = bodies.center_of_mass(body);
            let is_out = centre.cmplt(low).any() || centre.cmpgt(high).any();
            if is_out && !*gone {
                let (name, time) = (bodies.name(body), number(self.simulation.time()));
                let [x, y, z] = centre.to_array().map(number);
                notes.push(format!("body `{name}` left the domain: at {time} s it is at ({x}, {y}, {z}) m"));
            }
            *gone = is_out;
        }
        notes
    }

    /// Writes the checkpoint and what sums up the run so far. The run can go on afterwards, here or by
    /// [`Begin::Resume`].
    ///
    /// # Errors
    /// Files that can't be read or written.
    pub fn finish(&mut self) -> Result<RunSummary, Error> {
        self.checkpoint()?;
        let emitters = self.simulation.emitters().iter();
        let summary =
            |emitter: &Emitter| EmitterSummary { emitted: emitter.state.particles, held: emitter.state.held };
        self.output.finish(emitters.map(summary).collect())
    }

    /// Whether the run has reached its end.
    pub fn is_done(&self) -> bool {
        self.simulation.time() >= self.end - 1e-12
            || self.last_step.is_some_and(|last| self.simulation.steps() >= last)
    }

    /// The simulation: particles, bodies, time.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// The time of the next frame, if steps end there.
    fn next_frame_time(&self) -> Option<f64> {
        let rate = self.scene.output.frames_per_second;
        let passed = (rate * self.simulation.time() + TOLERANCE).floor();
        has_exact_frames(&self.scene).then(|| (passed + 1.0) / rate)
    }

    /// A frame, if the last step, which began at `before`, reached or passed a multiple of the frames' interval.
    fn write_frame_if_due(&mut self, before: f64) -> Result<Option<u64>, Error> {
        let intervals = |time: f64| (time * self.scene.output.frames_per_second + TOLERANCE).floor();
        if intervals(self.simulation.time()) <= intervals(before) {
            return Ok(None);
        }
        self.write_frame()
    }

    /// A frame, unless the scene wants none; returns its number.
    fn write_frame(&mut self) -> Result<Option<u64>, Error> {
        if self.scene.output.frames_per_second <= 0.0 {
            return Ok(None);
        }
        let number = self.output.frames();
        let simulation = &self.simulation;
        let particles = simulation.particles();
        let channels: Vec<_> = particles.channels.iter().filter_map(in_frames).collect();
        self.output.frame(&Frame {
            time: simulation.time(),
            step: simulation.steps(),
            particle_radius: self.scene.particle_radius,
            particle_mass: simulation.particle_mass(),
            rest_density: self.scene.fluid.rest_density,
            origin: self.origin,
            positions: &particles.positions,
            velocities: &particles.velocities,
            density: simulation.densities(),
            pressure: &simulation.pressures(),
            ids: &particles.ids,
            channels: &channels,
            bodies: &body_frames(simulation),
        })?;
        Ok(Some(number))
    }

    fn checkpoint_if_due(&mut self) -> Result<(), Error> {
        let interval = self.scene.output.checkpoint_interval;
        if interval > 0.0 && self.simulation.time() >= self.next_checkpoint {
            self.checkpoint()?;
            self.next_checkpoint = self.simulation.time() + interval;
        }
        Ok(())
    }

    fn checkpoint(&self) -> Result<(), Error> {
        resume::save(&self.simulation, self.output.frames(), &self.folder.join(CHECKPOINT), &self.identity)
    }
}

/// Whether steps are shortened so that frames lie at multiples of their interval: not if they would be shorter than
/// the scene allows.
fn has_exact_frames(scene: &Scene) -> bool {
    let step = &scene.solver.time_step;
    let least = if step.adaptive { step.min } else { step.initial };
    let rate = scene.output.frames_per_second;
    rate > 0.0 && least * rate <= 1.0 + TOLERANCE
}

fn frames_note(scene: &Scene) -> Option<String> {
    let rate = scene.output.frames_per_second;
    (rate > 0.0 && !has_exact_frames(scene)).then(|| {
        format!(
            "output.frames_per_second: {rate} frames are more than steps of solver.time_step, so they lie where steps \
             end, not at multiples of their interval"
        )
    })
}

/// Takes the folder for this run. One that is in it is left alone unless the settings say what becomes of it.
fn claim(folder: &Path, begin: Begin) -> Result<FolderLock, Error> {
    let missing = || Error::NoCheckpoint { folder: folder.to_owned() };
    if begin == Begin::Resume && !folder.is_dir() {
        return Err(missing());
    }
    // First of all: what another run may still write says nothing.
    let lock = FolderLock::take(folder)?;
    match begin {
        Begin::Resume if !folder.join(CHECKPOINT).exists() => Err(missing()),
        Begin::New if folder.join(STATISTICS).exists() => Err(Error::RunExists { folder: folder.to_owned() }),
        _ => Ok(lock),
    }
}

/// A channel of the particles, if frames have it.
fn in_frames(channel: &Channel) -> Option<(&'static str, Values<'_>)> {
    let values = match &channel.values {
        ChannelValues::Numbers(numbers) => Values::F32(numbers),
        ChannelValues::Vectors(vectors) => Values::Vector(vectors),
    };
    channel.declaration.in_frames.then_some((channel.declaration.name, values))
}

/// Brings the simulation to where the run begins, and removes what doesn't belong to it.
fn begin(
    simulation: &mut Simulation,
    folder: &Path,
    begin: Begin,
    identity: &Identity,
) -> Result<Option<Start>, Error> {
    let checkpoint = folder.join(CHECKPOINT);
    if begin == Begin::Resume {
        let frames = resume::load(simulation, &checkpoint, identity)?;
        return Ok(Some(Start { step: simulation.steps(), frames }));
    }
    // A checkpoint of an earlier run goes before the tables that belong to it.
    std::fs::remove_file(&checkpoint).or_else(ignore_missing).map_err(output::io_error(&checkpoint))?;
    if begin == Begin::Overwrite {
        output::folder::clear(folder)?;
    }
    Ok(None)
}

fn ignore_missing(error: std::io::Error) -> std::io::Result<()> {
    if error.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}
