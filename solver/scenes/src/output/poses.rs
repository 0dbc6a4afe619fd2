//! Where rigid bodies were: `poses.csv` while the simulation runs, `poses.json` at its end.

use super::{Frame, publish};
use crate::error::Error;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A body in a frame; one row of `poses.csv`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseRow {
    /// The frame's number.
    pub frame: u64,
    /// Seconds.
    pub time: f64,
    /// The body's name.
    pub body: String,
    /// Place of the mesh's origin, metres.
    pub x: f64,
    /// Place of the mesh's origin, metres.
    pub y: f64,
    /// Place of the mesh's origin, metres.
    pub z: f64,
    /// Rotation from the mesh's frame to the world: a unit quaternion, i.
    pub qx: f64,
    /// The quaternion's j.
    pub qy: f64,
    /// The quaternion's k.
    pub qz: f64,
    /// The quaternion's real part.
    pub qw: f64,
    /// Velocity of the centre of mass, m/s.
    pub vx: f64,
    /// Velocity of the centre of mass, m/s.
    pub vy: f64,
    /// Velocity of the centre of mass, m/s.
    pub vz: f64,
    /// Angular velocity, rad/s.
    pub wx: f64,
    /// Angular velocity, rad/s.
    pub wy: f64,
    /// Angular velocity, rad/s.
    pub wz: f64,
}

/// The rows of a frame.
pub fn rows(number: u64, frame: &Frame) -> Vec<PoseRow> {
    let row = |body: &super::BodyFrame| {
        let [x, y, z] = body.pose.translation.to_array();
        let [qx, qy, qz, qw] = body.pose.rotation.to_array();
        let [vx, vy, vz] = body.velocity.to_array();
        let [wx, wy, wz] = body.angular_velocity.to_array();
        let (time, body) = (frame.time, body.name.to_owned());
        PoseRow { frame: number, time, body, x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz }
    };
    frame.bodies.iter().map(row).collect()
}

#[derive(Serialize)]
struct Poses<'a> {
    bodies: &'a [BodyFile],
    frames: Vec<PosesOfFrame<'a>>,
}

/// A body and the file of its mesh.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct BodyFile {
    /// The body's name.
    pub name: String,
    /// The mesh's path, relative to the run's folder.
    pub mesh: String,
}

#[derive(Serialize)]
struct PosesOfFrame<'a> {
    frame: u64,
    time: f64,
    bodies: Vec<NamedPose<'a>>,
}

#[derive(Serialize)]
struct NamedPose<'a> {
    name: &'a str,
    position: [f64; 3],
    /// x, y, z, w.
    rotation: [f64; 4],
    velocity: [f64; 3],
    angular_velocity: [f64; 3],
}

/// Writes the poses of all frames.
///
/// # Errors
/// A file that can't be written.
pub fn write_json(path: &Path, bodies: &[BodyFile], rows: &[PoseRow]) -> Result<(), Error> {
    let frames = rows.chunk_by(|a, b| a.frame == b.frame);
    let poses = Poses { bodies, frames: frames.map(poses_of_frame).collect() };
    publish(path, &serde_json::to_vec_pretty(&poses).expect("numbers and text"))
}

fn poses_of_frame(rows: &[PoseRow]) -> PosesOfFrame<'_> {
    PosesOfFrame {
        frame: rows[0].frame,
        time: rows[0].time,
        bodies: rows
            .iter()
            .map(|row| NamedPose {
                name: &row.body,
                position: [row.x, row.y, row.z],
                rotation: [row.qx, row.qy, row.qz, row.qw],
                velocity: [row.vx, row.vy, row.vz],
                angular_velocity: [row.wx, row.wy, row.wz],
            })
            .collect(),
    }
}
