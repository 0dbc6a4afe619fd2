//! Looks into assets: measures how exact they are, draws them, and carries them to and from other programs.
//!
//! ```text
//! Asset -> report (errors, causes, pictures) -> page
//!       -> slice -> PNG
//!       -> export -> VTKHDF, VTI, PLY, CDM        import: CDM -> Asset
//! ```

pub mod error;
pub mod experiments;
pub mod export;
pub mod import;
pub mod info;
pub mod points;
pub mod report;
pub mod reproduce;
pub mod slice;

pub use error::Error;
