//! What can go wrong with a mesh file, with the place and the cure. The text is complete in itself; `source()` repeats
//! nothing of it.

use crate::text::quoted;
use std::path::{Path, PathBuf};

/// What to do with points.
pub(super) const RECONSTRUCT: &str =
    "reconstruct a surface first (in MeshLab: Filters > Remeshing > Screened Poisson)";

/// Why a mesh could not be read, cleaned or placed.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// Any of the others, with the file's name.
    #[error("{}: {error}", path.display())]
    InFile {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        error: Box<MeshError>,
    },
    /// The operating system refused.
    #[error("{what}: {error}")]
    Io {
        /// What was tried.
        what: String,
        /// The system's answer.
        error: std::io::Error,
    },
    /// Neither the content nor the extension is one of ours.
    #[error("{problem}")]
    UnknownFormat {
        /// What the file seems to be.
        problem: String,
    },
    /// The content breaks its format's rules.
    #[error("{format}, {place}: {problem}")]
    Malformed {
        /// Name of the format that it was read as.
        format: &'static str,
        /// Line, byte offset, or number of the face, vertex or accessor.
        place: String,
        /// What is wrong, and the cure.
        problem: String,
    },
    /// A valid file that uses what volmap doesn't read.
    #[error("{format}: {feature} is not supported; {cure}")]
    Unsupported {
        /// Name of the format that it was read as.
        format: &'static str,
        /// What is used.
        feature: String,
        /// What to do instead.
        cure: String,
    },
    /// Points only.
    #[error("a point cloud: {points} points and no faces; {RECONSTRUCT}")]
    PointCloud {
        /// How many points.
        points: usize,
    },
    /// Nothing that bounds a solid.
    #[error("the mesh has no faces ({left_out}); export its surface as triangles or polygons")]
    NoFaces {
        /// What it has instead.
        left_out: String,
    },
    /// All faces collapsed.
    #[error(
        "all faces ({faces}) collapse to points or lines {}",
        match *weld_tolerance > 0.0 {
            true => format!(
                "when vertices within {weld_tolerance} are welded; lower the weld tolerance, or check the model's scale"
            ),
            false => "without any welding; check that the model was exported with its surface".to_string(),
        }
    )]
    AllDegenerate {
        /// Faces before cleaning.
        faces: usize,
        /// The tolerance that was used, in the file's unit.
        weld_tolerance: f64,
    },
    /// It would take more memory than its size justifies.
    #[error("{problem}")]
    TooLarge {
        /// What is too large, and the cure.
        problem: String,
    },
    /// A setting is out of its range.
    #[error("{0}")]
    Setting(String),
    /// A bug of ours or of a library, contained.
    #[error("{format}: the reader failed on this file ({message}); please report it, with the file")]
    Panicked {
        /// Name of the format that it was read as.
        format: &'static str,
        /// The panic's message.
        message: String,
    },
}

impl MeshError {
    pub(super) fn in_file(self, path: &Path) -> MeshError {
        match self {
            MeshError::InFile { .. } => self,
            error => MeshError::InFile { path: path.to_path_buf(), error: Box::new(error) },
        }
    }

    pub(super) fn malformed(
        format: &'static str,
        place: impl Into<String>,
        problem: impl Into<String>,
    ) -> MeshError {
        MeshError::Malformed { format, place: printable(place.into()), problem: printable(problem.into()) }
    }

    pub(super) fn unsupported(
        format: &'static str,
        feature: impl Into<String>,
        cure: impl Into<String>,
    ) -> MeshError {
        MeshError::Unsupported { format, feature: printable(feature.into()), cure: printable(cure.into()) }
    }
}

/// Names inside a file and the messages of libraries may quote anything.
fn printable(text: String) -> String {
    quoted(&text, 400)
}
