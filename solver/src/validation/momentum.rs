//! Two blobs and a body.

use super::{Experiment, Outcome, Run};
use crate::error::Error;

/// It.
pub const EXPERIMENT: Experiment = Experiment { name: "momentum", title: "", about: "", run };

fn run(_: &Run) -> Result<Outcome, Error> {
    Ok(Outcome::default())
}
