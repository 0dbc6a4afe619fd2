//! A run: a scene simulated into a folder, from the beginning or from its check-point.

use crate::assemble::assemble;
use crate::error::Error;
use crate::output::{self, BodyFrame, Frame, Output, StepStatistics};
use crate::resume::{self, Identity};
use crate::scene::{self, Picture, Prepared, PreparedBody, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};
use volmap_fluid::channels::{Channel, ChannelValues};
use volmap_fluid::simulation::{Simulation, StepReport};
use volmap_fluid::stages::Stages;
use volmap_formats::asset::Exterior;
use volmap_formats::export::points::Values;
use volmap_formats::mesh::TriangleMesh;

/// How a run begins and ends.
#[derive(Clone, Debug, Default)]
pub struct RunSettings {
    /// Goes on from the folder's check-point.
    pub resume: bool,
    /// Replaces a run that is in the folder.
    pub overwrite: bool,
    /// Ends after this many steps in all; before, if the scene says so.
    pub steps: Option<u64>,
    /// Ends at this time, seconds, instead of the scene's.
    pub until: Option<f64>,
}

/// A run at work.
pub struct Session {
    simulation: Simulation,
    output: Output,
    scene: Scene,
    identity: Identity,
    folder: PathBuf,
    end: f64,
    last_step: Option<u64>,
    next_checkpoint: f64,
    /// What a careful person would look at before the run.
    pub notes: Vec<String>,
}

/// What a step of a run was like.
pub struct Progress<'a> {
    /// The step.
    pub statistics: &'a StepStatistics,
    /// Where the run will end, seconds; the last step, if that is fixed.
    pub end: f64,
    /// See `end`.
    pub last_step: Option<u64>,
}

const CHECKPOINT: &str = "checkpoint";
const STATISTICS: &str = "stats.csv";

impl Session {
    /// Reads a scene, bakes what isn't baked, and opens the folder. `on_bake` hears of each mesh before it is baked.
    ///
    /// # Errors
    /// A scene, mesh, map or check-point that can't be used; a folder with another run.
    pub fn open(
        path: &Path,
        folder: &Path,
        settings: &RunSettings,
        on_bake: &mut dyn FnMut(&Path),
    ) -> Result<Session, Error> {
        let checkpoint = folder.join(CHECKPOINT);
        refuse_to_replace(folder, settings)?;
        let scene = scene::load(path)?;
        let prepared = scene::prepare(&scene, on_bake)?;
        let notes = prepared.notes.clone();
        let identity = Identity::new(&scene, prepared.files.clone());
        let meshes = body_meshes(&prepared.bodies);
        let world = picture_world(&scene, &prepared, &meshes);
        let names: Vec<String> = prepared.bodies.iter().map(|body| body.name.clone()).collect();
        let mut simulation = Simulation::new(assemble(&scene, prepared)?)?;
        let start = if settings.resume {
            let frames = resume::load(&mut simulation, &checkpoint, &identity)?;
            Some(output::folder::Start { step: simulation.steps(), frames })
        } else {
            None
        };
        if !settings.resume {
            // One of an earlier run would be another run's; it goes before the tables that belong to it.
            std::fs::remove_file(&checkpoint)
                .or_else(ignore_missing)
                .map_err(output::io_error(&checkpoint))?;
        }
        if settings.overwrite {
            output::folder::clear(folder)?;
        }
        let meshes: Vec<(&str, &TriangleMesh)> = names
            .iter()
            .zip(&meshes)
            .filter_map(|(name, mesh)| Some((name.as_str(), mesh.as_deref()?)))
            .collect();
        let output = Output::open(folder, &folder_settings(&scene), world, &meshes, start)?;
        let interval = scene.output.checkpoint_interval;
        let mut session = Session {
            next_checkpoint: simulation.time() + interval,
            end: settings.until.unwrap_or(scene.stop.time),
            last_step: settings.steps.or(scene.stop.steps),
            folder: folder.to_owned(),
            simulation,
            output,
            scene,
            identity,
            notes,
        };
        if !settings.resume {
            session.write_frame()?;
        }
        Ok(session)
    }

    /// Simulates until the end, or until `go_on` says no; tells `go_on` of every step.
    ///
    /// # Errors
    /// [`Error::Simulation`]; files that can't be written. What has been written stays, and the last check-point.
    pub fn run(
        &mut self,
        go_on: &mut dyn FnMut(&Progress) -> bool,
    ) -> Result<output::statistics::Summary, Error> {
        while !self.is_done() {
            let before = self.simulation.time();
            let report = self.simulation.step()?;
            let writing = Instant::now();
            self.write_frame_if_due(before)?;
            let statistics = statistics(&self.simulation, &report, writing.elapsed());
            if self.scene.output.statistics {
                self.output.step(&statistics)?;
            }
            // It counts the frames and rows before it.
            self.checkpoint_if_due()?;
            if !go_on(&Progress { statistics: &statistics, end: self.end, last_step: self.last_step }) {
                break;
            }
        }
        self.checkpoint()?;
        self.output.finish()
    }

    /// Whether the run has come to its end, and wasn't stopped before.
    pub fn is_done(&self) -> bool {
        self.simulation.time() >= self.end - 1e-12
            || self.last_step.is_some_and(|last| self.simulation.steps() >= last)
    }

    /// A frame, if the last step, which began at `before`, came to or over a multiple of the frames' interval.
    fn write_frame_if_due(&mut self, before: f64) -> Result<(), Error> {
        // The tolerance is for times that are sums of steps.
        let intervals = |time: f64| (time * self.scene.output.frames_per_second + 1e-9).floor();
        if intervals(self.simulation.time()) > intervals(before) {
            self.write_frame()?;
        }
        Ok(())
    }

    fn checkpoint_if_due(&mut self) -> Result<(), Error> {
        let interval = self.scene.output.checkpoint_interval;
        if interval > 0.0 && self.simulation.time() >= self.next_checkpoint {
            self.checkpoint()?;
            self.next_checkpoint = self.simulation.time() + interval;
        }
        Ok(())
    }

    fn write_frame(&mut self) -> Result<(), Error> {
        if self.scene.output.frames_per_second <= 0.0 {
            return Ok(());
        }
        let simulation = &self.simulation;
        let particles = simulation.particles();
        let states: Vec<_> =
            (0..simulation.bodies().posed().len()).map(|body| simulation.bodies().state(body)).collect();
        let bodies: Vec<BodyFrame> = states
            .iter()
            .enumerate()
            .map(|(body, state)| BodyFrame {
                name: simulation.bodies().name(body),
                pose: state.pose,
                velocity: state.velocity,
                angular_velocity: state.angular_velocity,
            })
            .collect();
        let channels: Vec<_> = particles.channels.iter().filter_map(in_frames).collect();
        self.output.frame(&Frame {
            time: simulation.time(),
            step: simulation.steps(),
            particle_radius: self.scene.particle_radius,
            positions: &particles.positions,
            velocities: &particles.velocities,
            density: simulation.densities(),
            pressure: &simulation.pressures(),
            ids: &particles.ids,
            channels: &channels,
            bodies: &bodies,
        })
    }

    fn checkpoint(&self) -> Result<(), Error> {
        resume::save(&self.simulation, self.output.frames(), &self.folder.join(CHECKPOINT), &self.identity)
    }

    /// The simulation.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
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

/// A folder with a run in it is left alone unless one says what is to be done.
fn refuse_to_replace(folder: &Path, settings: &RunSettings) -> Result<(), Error> {
    let file = folder.join(STATISTICS);
    let refuse =
        |reason: &str| Err(Error::Scene { place: folder.display().to_string(), reason: reason.into() });
    if settings.resume && !folder.join(CHECKPOINT).exists() {
        return refuse("has no check-point to resume from: begin with `overwrite` instead of `resume`");
    }
    if !settings.resume && !settings.overwrite && file.exists() {
        return refuse("has a run already: `resume` goes on with it, `overwrite` replaces it");
    }
    Ok(())
}

fn ignore_missing(error: std::io::Error) -> std::io::Result<()> {
    if error.kind() == std::io::ErrorKind::NotFound { Ok(()) } else { Err(error) }
}

fn folder_settings(scene: &Scene) -> output::FolderSettings {
    let settings = &scene.output;
    let frames_per_second = settings.frames_per_second.round().clamp(1.0, 1000.0) as u16;
    output::FolderSettings {
        particles: settings.formats.clone(),
        pictures: !settings.preview.is_empty(),
        picture: output::picture::PictureSettings { camera: settings.camera.clone(), ..Default::default() },
        animate: settings.preview.contains(&Picture::Apng),
        animation: output::animation::AnimationSettings { frames_per_second, ..Default::default() },
    }
}

/// The mesh of each body, as it was given or from its map's surface; none where there is no surface.
fn body_meshes(bodies: &[PreparedBody]) -> Vec<Option<Arc<TriangleMesh>>> {
    let surface = |body: &PreparedBody| output::bodies::surface_of_map(&body.map).ok().map(Arc::new);
    bodies.iter().map(|body| body.mesh.clone().or_else(|| surface(body))).collect()
}

fn picture_world(
    scene: &Scene,
    prepared: &Prepared,
    meshes: &[Option<Arc<TriangleMesh>>],
) -> output::picture::World {
    let mut bounds = output::picture::Bounds::EMPTY;
    for &position in &prepared.particles.positions {
        bounds.add(position.as_vec3());
    }
    for place in prepared.emitters.iter().flat_map(|emitter| emitter.layer()) {
        bounds.add(place.as_vec3());
    }
    let mut props = Vec::new();
    for (body, mesh) in prepared.bodies.iter().zip(meshes) {
        let Some(mesh) = mesh else { continue };
        for &vertex in &mesh.vertices {
            bounds.add(body.pose.to_world(vertex.into()).as_vec3());
        }
        props.push(output::picture::Prop {
            name: body.name.clone(),
            model: output::picture::Model::new(mesh),
            pose: body.pose,
            container: body.map.exterior() == Exterior::Solid,
            colour: body.settings.colour.map(|colour| colour.map(|channel| (channel * 255.0).round() as u8)),
        });
    }
    output::picture::World {
        bounds: bounds.or_unit(),
        gravity: scene.world().gravity.as_vec3(),
        rest_density: scene.fluid.rest_density,
        props,
    }
}

fn statistics(simulation: &Simulation, report: &StepReport, writing: Duration) -> StepStatistics {
    let ms = |duration: Duration| 1e3 * duration.as_secs_f64();
    let stages: &Stages = &report.stages;
    StepStatistics {
        step: simulation.steps(),
        time: simulation.time(),
        dt: report.dt,
        particles: simulation.particles().len() as u64,
        density_iterations: report.density.iterations,
        divergence_iterations: report.divergence.iterations,
        viscosity_iterations: report.viscosity.iterations,
        density_error: report.density.error,
        divergence_error: report.divergence.error,
        viscosity_error: report.viscosity.error,
        max_speed: report.max_speed,
        neighbours: simulation.mean_neighbours(),
        near_bodies: report.near_bodies as u64,
        emitted: report.emitted as u64,
        removed: report.removed as u64,
        inside_body: report.inside as u64,
        step_ms: ms(stages.total() + writing),
        sort_ms: ms(stages.sort),
        neighbours_ms: ms(stages.neighbours),
        boundary_ms: ms(stages.boundary),
        density_ms: ms(stages.density),
        divergence_ms: ms(stages.divergence),
        pressure_ms: ms(stages.pressure),
        viscosity_ms: ms(stages.non_pressure + stages.advance),
        rigid_ms: ms(stages.rigid),
        output_ms: ms(writing),
    }
}
