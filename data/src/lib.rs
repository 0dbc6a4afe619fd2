//! The project's sample meshes, made by a program instead of downloaded: free of any licence question, and
//! the same bytes on every machine.
//!
//! The way of a smooth shape: [`duck`] describes a solid as an implicit function built from [`solids`],
//! [`surface`] meshes its zero set, [`improve`] makes the triangles well shaped. [`canyon`] is a height field
//! over [`noise`], [`lattice`] and [`tank`] are made of boxes, [`drum`] is a prism, [`damaged`] breaks a good
//! mesh in a known way. [`topology`] counts what is wrong with a mesh, [`obj`] writes it.
//!
//! Guarantee: everything is computed with `+ - * /` and the square root, which IEEE 754 rounds exactly, and
//! with integers. No sine, power or logarithm is called, whose last bits differ between platforms.

pub mod canyon;
pub mod damaged;
pub mod drum;
pub mod duck;
pub mod improve;
pub mod lattice;
pub mod mesh;
pub mod noise;
pub mod obj;
pub mod solids;
pub mod surface;
pub mod tank;
pub mod topology;

use mesh::Mesh;

/// One sample: the file's name, a line of text for the file's head, and the mesh.
pub struct Sample {
    /// File name, relative to the folder `data/`.
    pub file: &'static str,
    /// What it is, in one line.
    pub title: &'static str,
    /// The mesh, in metres.
    pub mesh: Mesh,
}

/// All samples, in the order of the README.
pub fn samples() -> Vec<Sample> {
    let sample = |file, title, mesh| Sample { file, title, mesh };
    vec![
        sample("duck.obj", "A bath duck, closed, 1.3 x 1.3 x 1.5 m, y up, beak towards +z", duck::duck()),
        sample(
            "canyon.obj",
            "A canyon, closed, 6.4 x 3.2 x 38.4 m, y up, downstream is +z",
            canyon::canyon(),
        ),
        sample("grid.obj", "A thin grid of 9 x 9 holes, closed, 1 x 0.03 x 1 m", lattice::grid()),
        sample("bad_holes.obj", "A duck with known damage: see README.md", damaged::bad_duck()),
        sample("tank.obj", "A cube of 3.1 m, closed, to be baked inverted as a tank", tank::tank()),
        sample("drum.obj", "A drum with four baffles, closed, axis z, to be baked inverted", drum::drum()),
    ]
}
