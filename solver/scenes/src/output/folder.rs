//! The folder of a run and all that goes into it.

use super::animation::{self, AnimationSettings};
use super::bodies::{BodyMesh, write_mesh};
use super::notes;
use super::particles::{self, CollectionEntry, ParticleFormat};
use super::picture::{Painter, PictureSettings, World};
use super::poses::{self, BodyFile, PoseRow};
use super::statistics::{EmitterSummary, RunSummary, StepStatistics, summarise};
use super::table::{Kept, Table};
use super::{Frame, io_error, publish};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use volmap_fluid::settings::SolverSettings;
use volmap_formats::asset::clear_leftovers;

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub struct FolderSettings {
    /// Formats of the particles' files.
    pub particles: Vec<ParticleFormat>,
    /// Whether each frame is drawn.
    pub pictures: bool,
    /// Size and camera of the pictures.
    pub picture: PictureSettings,
    /// Whether the pictures become an animation at the end.
    pub animate: bool,
    /// Speed and size of the animation.
    pub animation: AnimationSettings,
    /// Whether steps get rows.
    pub statistics: bool,
    /// The limits of the run's solves, for what the summary says of them.
    pub solver: SolverSettings,
}

impl Default for FolderSettings {
    fn default() -> Self {
        FolderSettings {
            particles: vec![ParticleFormat::Vtu],
            pictures: true,
            picture: PictureSettings::default(),
            animate: true,
            animation: AnimationSettings::default(),
            statistics: true,
            solver: SolverSettings::default(),
        }
    }
}

/// A frame that was written; one row of `frames.csv`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameRow {
    /// Its number, from 0.
    pub frame: u64,
    /// Steps done.
    pub step: u64,
    /// Seconds.
    pub time: f64,
    /// Particles.
    pub particles: u64,
}

/// Writes a run into its folder.
pub struct Output {
    folder: PathBuf,
    settings: FolderSettings,
    painter: Option<Painter>,
    steps: Table<StepStatistics>,
    frames: Table<FrameRow>,
    poses: Table<PoseRow>,
    /// All frames so far.
    written: Vec<FrameRow>,
    /// Number of the next frame.
    next: u64,
    bodies: Vec<BodyFile>,
    /// What tables of a run that resumes had lost.
    pub notes: Vec<String>,
}

/// Where a run resumes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Start {
    /// Steps done.
    pub step: u64,
    /// Frames written, which are numbered from 0.
    pub frames: u64,
}

const STEPS: &str = "stats.csv";
const FRAMES: &str = "frames.csv";
const POSES: &str = "poses.csv";
const PARTICLES: &str = "particles";
const PICTURES: &str = "pictures";
const BODIES: &str = "bodies";

impl Output {
    /// Opens the folder of a run that begins (`start` is `None`) or resumes; creates it if it is missing. `bodies` are
    /// the meshes of the bodies that frames have poses of.
    ///
    /// # Errors
    /// A folder or file that can't be written.
    pub fn open(
        folder: &Path,
        settings: &FolderSettings,
        world: World,
        bodies: &[BodyMesh],
        start: Option<Start>,
    ) -> Result<Output, Error> {
        make_folders(folder, settings, !bodies.is_empty())?;
        let mut files = Vec::new();
        for (number, body) in bodies.iter().enumerate() {
            let file = write_mesh(&folder.join(BODIES), number, body)?;
            files.push(BodyFile { name: body.name.clone(), mesh: format!("{BODIES}/{file}") });
        }
        // Frames count from 0: the last one kept is one less than their number.
        let last_frame = start.map(|start| start.frames.checked_sub(1));
        let steps_kept = start.map(|start| Some(Kept { first: 1, last: start.step, several: false }));
        let frames_kept = |several| last_frame.map(|last| last.map(|last| Kept { first: 0, last, several }));
        let steps = open_table::<StepStatistics>(&folder.join(STEPS), steps_kept)?;
        let frames = open_table::<FrameRow>(&folder.join(FRAMES), frames_kept(false))?;
        let poses = open_table::<PoseRow>(&folder.join(POSES), frames_kept(true))?;
        let mut repairs = [
            (STEPS, "step", steps.repair().clone(), settings.statistics),
            (FRAMES, "frame", frames.repair().clone(), true),
            (POSES, "frame", poses.repair().clone(), !bodies.is_empty()),
        ];
        for (_, _, repair, _) in repairs.iter_mut().filter(|(.., is_complete)| !is_complete) {
            repair.gaps.clear();
        }
        Ok(Output {
            painter: settings.pictures.then(|| Painter::new(&settings.picture, world)),
            written: frames.rows()?,
            next: start.map_or(0, |start| start.frames),
            notes: repairs.iter().filter_map(|(file, what, repair, _)| repair.note(file, what)).collect(),
            steps,
            frames,
            poses,
            folder: folder.to_owned(),
            settings: settings.clone(),
            bodies: files,
        })
    }

    /// Frames written so far.
    pub fn frames(&self) -> u64 {
        self.next
    }

    /// Writes a frame.
    ///
    /// # Errors
    /// A file that can't be written; particles' lists of different lengths.
    pub fn frame(&mut self, frame: &Frame) -> Result<(), Error> {
        let number = self.frames();
        for &format in &self.settings.particles {
            particles::write(&self.folder.join(particle_file(number, format)), format, frame)?;
        }
        if let Some(painter) = &mut self.painter {
            publish(&self.folder.join(picture_file(number)), &painter.draw(frame))?;
        }
        self.poses.append(&poses::rows(number, frame))?;
        let particles = frame.positions.len() as u64;
        let row = FrameRow { frame: number, step: frame.step, time: frame.time, particles };
        self.frames.append(std::slice::from_ref(&row))?;
        self.written.push(row);
        self.next = number + 1;
        if self.settings.particles.contains(&ParticleFormat::Vtu) {
            let file = |row: &FrameRow| CollectionEntry {
                time: row.time,
                file: particle_file(row.frame, ParticleFormat::Vtu),
            };
            let files: Vec<_> = self.written.iter().map(file).collect();
            particles::write_collection(&self.folder.join("particles.pvd"), &files)?;
        }
        Ok(())
    }

    /// Writes a step's row, if steps have rows.
    ///
    /// # Errors
    /// A file that can't be written.
    pub fn step(&mut self, step: &StepStatistics) -> Result<(), Error> {
        if self.settings.statistics { self.steps.append(std::slice::from_ref(step)) } else { Ok(()) }
    }

    /// Writes the summary of the run so far: `stats.json`, `poses.json` and the animation. `emitters` are what each of
    /// them gave.
    ///
    /// # Errors
    /// A file that can't be read or written.
    pub fn finish(&self, emitters: Vec<EmitterSummary>) -> Result<RunSummary, Error> {
        let steps = self.steps.rows()?;
        let notes = notes::of_run(&steps, &emitters, &self.settings.solver);
        let summary = RunSummary { notes, emitters, ..summarise(&steps) };
        let json = serde_json::to_vec_pretty(&summary).expect("numbers and text");
        publish(&self.folder.join("stats.json"), &json)?;
        if !self.bodies.is_empty() {
            poses::write_json(&self.folder.join("poses.json"), &self.bodies, &self.poses.rows()?)?;
        }
        if self.settings.pictures && self.settings.animate && self.written.len() > 1 {
            let pictures: Vec<PathBuf> =
                self.written.iter().map(|row| self.folder.join(picture_file(row.frame))).collect();
            animation::write(&self.folder.join("animation.png"), &pictures, &self.settings.animation)?;
        }
        Ok(summary)
    }
}

/// Removes what an earlier run left in its folder, but for the tables, which [`Output::open`] replaces.
///
/// # Errors
/// A file that can't be removed.
pub fn clear(folder: &Path) -> Result<(), Error> {
    let mut files: Vec<PathBuf> =
        ["stats.json", "poses.json", "particles.pvd", "animation.png"].map(|name| folder.join(name)).into();
    for name in [PARTICLES, PICTURES] {
        let Ok(entries) = std::fs::read_dir(folder.join(name)) else { continue };
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        files.extend(paths.filter(|path| path.file_stem().is_some_and(is_frame)));
    }
    for file in files.iter().filter(|file| file.exists()) {
        std::fs::remove_file(file).map_err(io_error(file))?;
    }
    Ok(())
}

fn is_frame(stem: &OsStr) -> bool {
    stem.to_str().and_then(|stem| stem.strip_prefix("frame_")).is_some_and(|n| n.parse::<u64>().is_ok())
}

/// The folders that a run writes into.
fn make_folders(folder: &Path, settings: &FolderSettings, has_bodies: bool) -> Result<(), Error> {
    let needed = [
        ("", true),
        (PARTICLES, !settings.particles.is_empty()),
        (PICTURES, settings.pictures),
        (BODIES, has_bodies),
    ];
    for (name, _) in needed.into_iter().filter(|(_, needed)| *needed) {
        let folder = folder.join(name);
        std::fs::create_dir_all(&folder).map_err(io_error(&folder))?;
        // A run that was killed may have left incomplete files.
        clear_leftovers(&folder).map_err(io_error(&folder))?;
    }
    Ok(())
}

/// `None`: a new table; `Some(None)`: one without rows; `Some(Some(kept))`: these rows.
fn open_table<Row: Default + Serialize + serde::de::DeserializeOwned>(
    path: &Path,
    kept: Option<Option<Kept>>,
) -> Result<Table<Row>, Error> {
    match kept {
        Some(Some(kept)) => Table::resume(path, &Row::default(), kept),
        Some(None) | None => Table::create(path, &Row::default()),
    }
}

fn particle_file(number: u64, format: ParticleFormat) -> String {
    format!("{PARTICLES}/frame_{number:06}.{}", format.extension())
}

fn picture_file(number: u64) -> String {
    format!("{PICTURES}/frame_{number:06}.png")
}
