//! What a mesh is made of, what is wrong with it, and turning its triangles the same way.
//!
//! `topology` sorts the edges, `boundary` follows the rims of holes, `parts` splits the mesh, `nesting` finds what lies
//! inside what, by `crossings`, `fans` go round the vertices, `diagnosis` reports all of it and `orientation` repairs
//! the direction of the triangles. `preparation` does all of it once.

pub mod boundary;
pub mod crossings;
pub mod diagnosis;
pub mod fans;
pub mod nesting;
pub mod orientation;
pub mod parts;
pub mod preparation;
pub mod topology;

pub use diagnosis::{Diagnosis, diagnose};
pub use orientation::{OrientationRepair, orient};
pub use preparation::{Prepared, prepare};
