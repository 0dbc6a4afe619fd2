//! Scenes of fluids and bodies: their files, and runs of them into folders.
//!
//! ```text
//! scene file -> scene -> assemble -> volmap_fluid::simulation -> session -> output: frames, pictures, check-points
//! ```

pub mod assemble;
pub mod error;
pub mod output;
pub mod resume;
pub mod scene;
pub mod session;

pub use error::Error;
