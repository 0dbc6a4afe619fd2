//! What a mesh is made of, what is wrong with it, and turning its triangles the same way.
//!
//! `topology` sorts the edges, `boundary` follows the rims of holes, `parts` splits the mesh, `nesting`
//! finds what lies inside what, `diagnosis` reports all of it and `orientation` repairs the direction of the triangles.

pub mod boundary;
pub mod diagnosis;
pub mod nesting;
pub mod orientation;
pub mod parts;
pub mod topology;

pub use diagnosis::{Diagnosis, diagnose};
pub use orientation::{OrientationRepair, orient};
