//! Saving a simulation as a checkpoint, and loading it.

use crate::error::Error;
use crate::output::{Checkpoint, CheckpointWriter};
use crate::scene::{Scene, SourceFile};
use serde::Serialize;
use std::path::Path;
use volmap_bake::parameters::{Parameters, Resolution, Scale, Unit, Up};
use volmap_fluid::channels::ChannelValues;
use volmap_fluid::particles::Particles;
use volmap_fluid::simulation::Simulation;
use volmap_fluid::state::State;

/// What identifies the scene of a checkpoint.
#[derive(Clone, Debug)]
pub struct Identity {
    /// Hash of all in the scene that a run depends on.
    scene: [u8; 32],
    /// The scene's maps and meshes.
    files: Vec<SourceFile>,
}

impl Identity {
    /// The identity of a scene and its files. Output and end of the scene don't count, nor do the folders of files.
    pub fn new(scene: &Scene, files: Vec<SourceFile>) -> Identity {
        let mut run =
            Scene { output: Default::default(), stop: Default::default(), cache: None, ..scene.clone() };
        for path in run.paths_mut() {
            *path = path.file_name().unwrap_or_default().into();
        }
        let text = json(&run);
        // The hash is of the names that scenes had when checkpoints began.
        let name = run.kernel.name();
        let kernel = |name: &str| format!("\"kernel\":\"{name}\"");
        let mut text = text.replacen(&kernel(name), &kernel(&name.replace('_', "-")), 1);
        let bakes =
            scene.bodies.iter().map(|body| &body.bake).chain(scene.fills.iter().map(|fill| &fill.bake));
        for (bake, first) in bakes.filter_map(|bake| Some((bake, FirstBake::of(bake)?))) {
            text = text.replace(&format!("\"bake\":{}", json(bake)), &format!("\"bake\":{}", json(&first)));
        }
        Identity { scene: *blake3::hash(text.as_bytes()).as_bytes(), files }
    }

    fn contents(&self) -> Vec<u8> {
        self.files.iter().flat_map(|file| file.content).collect()
    }

    /// The first file whose content differs.
    fn changed(&self, contents: &[u8]) -> Option<&SourceFile> {
        let (before, _) = contents.as_chunks::<32>();
        let mut pairs = self.files.iter().enumerate();
        pairs.find(|(n, file)| before.get(*n) != Some(&file.content)).map(|(_, file)| file)
    }
}

/// The parameters of a bake that scenes had when checkpoints began.
#[derive(Serialize)]
struct FirstBake {
    invert: bool,
    unit: Option<Unit>,
    up: Up,
    scale: Option<Scale>,
    thickness: f64,
    resolution: Option<Resolution>,
    cell_size: Option<f64>,
}

impl FirstBake {
    /// None if the bake has others.
    fn of(bake: &Parameters) -> Option<FirstBake> {
        let &Parameters { invert, unit, up, scale, thickness, resolution, cell_size, .. } = bake;
        let alone =
            Parameters { invert, unit, up, scale, thickness, resolution, cell_size, ..Parameters::default() };
        (alone == *bake).then(|| FirstBake {
            invert: invert.unwrap_or_default(),
            unit,
            up: up.unwrap_or_default(),
            scale,
            thickness: thickness.unwrap_or_default(),
            resolution,
            cell_size,
        })
    }
}

fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("numbers and text")
}

/// Writes the state after the last step, and the number of frames written so far.
///
/// # Errors
/// A file that can't be written.
pub fn save(simulation: &Simulation, frames: u64, path: &Path, identity: &Identity) -> Result<(), Error> {
    let mut file = CheckpointWriter::create(path, identity.scene)?;
    file.put("files", &identity.contents())?;
    let particles = simulation.particles();
    file.put_points("positions", &particles.positions)?;
    file.put_f32x3("velocities", &particles.velocities)?;
    file.put_f32("pressures", &particles.pressures)?;
    for channel in particles.channels.iter() {
        let name = channel.declaration.name;
        match &channel.values {
            ChannelValues::Numbers(numbers) => file.put_f32(name, numbers)?,
            ChannelValues::Vectors(vectors) => file.put_f32x3(name, vectors)?,
        }
    }
    file.put_u32("ids", &particles.ids)?;
    file.put_f32("densities", simulation.densities())?;
    file.put_f64("time", &[simulation.time(), simulation.body_speed()])?;
    file.put_u64("step", &[simulation.steps(), u64::from(particles.next_id), frames])?;
    let emitters: Vec<_> = simulation.emitters().iter().map(|emitter| &emitter.state).collect();
    file.put("emitters", &serde_json::to_vec(&emitters).expect("numbers"))?;
    file.put("bodies", &simulation.bodies().snapshot()?)?;
    file.finish()
}

/// Reads a state into the simulation of the same scene. Returns the number of frames that had been written.
///
/// # Errors
/// A file that can't be read, is damaged, or belongs to another scene, or to other maps or meshes.
pub fn load(simulation: &mut Simulation, path: &Path, identity: &Identity) -> Result<u64, Error> {
    let file = Checkpoint::open(path, identity.scene)?;
    if let Some(changed) = identity.changed(file.get("files")?) {
        let changed = changed.path.display();
        return Err(file.refuse(format!(
            "{changed} has changed since the checkpoint: put the old file back, or begin again"
        )));
    }
    let [step, next_id, frames] = fixed(&file, "step", file.get_u64("step")?)?;
    let [time, body_speed] = fixed(&file, "time", file.get_f64("time")?)?;
    let mut channels = simulation.particles().channels.clone();
    for channel in channels.iter_mut() {
        let name = channel.declaration.name;
        channel.values = match channel.values {
            ChannelValues::Numbers(_) => ChannelValues::Numbers(file.get_f32(name)?),
            ChannelValues::Vectors(_) => ChannelValues::Vectors(file.get_f32x3(name)?),
        };
    }
    let particles = Particles {
        positions: file.get_points("positions")?,
        velocities: file.get_f32x3("velocities")?,
        pressures: file.get_f32("pressures")?,
        channels,
        ids: file.get_u32("ids")?,
        next_id: next_id as u32,
    };
    let state = State {
        particles,
        densities: file.get_f32("densities")?,
        emitters: serde_json::from_slice(file.get("emitters")?)
            .map_err(|error| file.refuse(format!("emitters: {error}")))?,
        bodies: file.get("bodies")?.to_vec(),
        time,
        step,
        body_speed,
    };
    simulation.restore(state).map_err(|reason| file.refuse(reason))?;
    Ok(frames)
}

fn fixed<T: Copy, const N: usize>(file: &Checkpoint, name: &str, list: Vec<T>) -> Result<[T; N], Error> {
    list.try_into().map_err(|_| file.refuse(format!("{name} has the wrong length")))
}
