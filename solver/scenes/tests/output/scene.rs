//! A wave that breaks in a tank, and a duck that swims in it.

use glam::{DQuat, DVec3, Vec3};
use std::path::Path;
use volmap_bake::random::Random;
use volmap_formats::mesh::{CleanSettings, TriangleMesh, load};
use volmap_runtime::Pose;
use volmap_scenes::output::picture::{Bounds, Model, Prop, World};
use volmap_scenes::output::{BodyFrame, Frame};

/// Particles and a duck.
pub struct Scene {
    pub radius: f64,
    pub positions: Vec<DVec3>,
    pub velocities: Vec<[f32; 3]>,
    pub density: Vec<f32>,
    pub pressure: Vec<f32>,
    pub ids: Vec<u32>,
    pub bodies: Vec<BodyFrame<'static>>,
}

/// The tank: 3.1 m long, 1.6 m high, 1.2 m wide.
const LOW: DVec3 = DVec3::new(-1.55, 0.0, -0.6);
const HIGH: DVec3 = DVec3::new(1.55, 1.6, 0.6);
pub const NAME: &str = "duck";

/// Height of the water.
fn height(x: f64, z: f64, time: f64) -> f64 {
    let t = x + 0.6 - 1.2 * time;
    0.42 + 0.55 / (1.0 + 9.0 * t * t) + 0.05 * (4.0 * x + 3.0 * z + 5.0 * time).sin()
}

impl Scene {
    pub fn new(radius: f64, time: f64) -> Scene {
        let (mut positions, mut velocities, mut pressure) = (Vec::new(), Vec::new(), Vec::new());
        let count = ((HIGH - LOW) / (2.0 * radius)).as_ivec3();
        let mut add = |p: DVec3, v: DVec3, depth: f64| {
            positions.push(p);
            velocities.push(v.as_vec3().to_array());
            pressure.push((9810.0 * depth) as f32);
        };
        let duck = duck_pose(time);
        let mut random = Random::knuth(1);
        let mut noise = || 0.5 * random.signed();
        for n in 0..count.x * count.y * count.z {
            let cell = DVec3::new(
                (n % count.x) as f64,
                (n / count.x % count.y) as f64,
                (n / count.x / count.y) as f64,
            );
            let p = LOW + 2.0 * radius * (cell + 0.5) + 0.3 * radius * DVec3::new(noise(), noise(), noise());
            let top = height(p.x, p.z, time);
            let out_of_duck = (duck.to_map(p) / DVec3::new(0.42, 0.36, 0.5)).length() > 1.0;
            if p.y < top - radius && out_of_duck {
                let crest = (top - 0.42).max(0.0);
                add(p, DVec3::new(4.5 * crest * (p.y / top), 0.8 * crest, 0.0), top - p.y);
            } else if p.y < top + 0.3 && top > 0.75 && noise() > 0.485 {
                // Spray over the crest.
                add(p + DVec3::new(0.2, 0.1, 0.0), DVec3::new(3.5, 1.0, 0.0), 0.0);
            }
        }
        let many = positions.len();
        let velocity = DVec3::new(0.3, 0.1, 0.0);
        Scene {
            radius,
            positions,
            velocities,
            density: (0..many).map(|n| 1.0 + 1e-3 * (n % 7) as f32).collect(),
            pressure,
            ids: (0..many as u32).rev().collect(),
            bodies: vec![BodyFrame { name: NAME, pose: duck, velocity, angular_velocity: DVec3::Z }],
        }
    }

    pub fn frame(&self, step: u64) -> Frame<'_> {
        Frame {
            time: 0.04 * step as f64,
            step,
            particle_radius: self.radius,
            particle_mass: 1000.0 * (2.0 * self.radius).powi(3),
            rest_density: 1000.0,
            origin: None,
            positions: &self.positions,
            velocities: &self.velocities,
            density: &self.density,
            pressure: &self.pressure,
            ids: &self.ids,
            channels: &[],
            bodies: &self.bodies,
        }
    }
}

fn duck_pose(time: f64) -> Pose {
    let rotation = DQuat::from_rotation_z(0.15) * DQuat::from_rotation_y(0.9 + 0.5 * time);
    Pose { rotation, translation: DVec3::new(0.75 + 0.1 * time, 0.62, 0.1) }
}

/// The duck of the sample meshes at 0.7 of its size.
pub fn duck() -> TriangleMesh {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/duck.obj");
    let (mut mesh, _) = load(&path, &CleanSettings::default()).unwrap();
    mesh.vertices.iter_mut().flatten().for_each(|x| *x *= 0.7);
    mesh
}

/// A box, as a container's mesh: seen from outside, counter-clockwise.
fn tank() -> TriangleMesh {
    let corner = |n: usize| {
        let pick = |axis: usize| if n >> axis & 1 == 0 { LOW[axis] } else { HIGH[axis] };
        [pick(0), pick(1), pick(2)]
    };
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh { vertices: (0..8).map(corner).collect(), triangles }
}

pub fn world() -> World {
    let prop = |name: &str, mesh: &TriangleMesh, container| Prop {
        name: name.to_owned(),
        model: Model::new(mesh),
        pose: if container { Pose::default() } else { duck_pose(0.0) },
        container,
        colour: None,
    };
    World {
        origin: DVec3::ZERO,
        bounds: Bounds { low: LOW.as_vec3(), high: HIGH.as_vec3() },
        gravity: Vec3::new(0.0, -9.81, 0.0),
        rest_density: 1000.0,
        props: vec![prop("tank", &tank(), true), prop(NAME, &duck(), false)],
    }
}
