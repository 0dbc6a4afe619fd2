//! The libraries under one name, for those who still call them so.
pub use volmap_bake::Error;
pub use volmap_bake::*;
pub use volmap_batch as batch;
pub use volmap_documents as document;
pub use volmap_figures::*;
pub use volmap_report::{export, import, info, points, report, reproduce, slice};
