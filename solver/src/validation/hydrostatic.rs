//! Water at rest in a tank.

use super::{Experiment, Outcome, Run};
use crate::error::Error;

/// It.
pub const EXPERIMENT: Experiment = Experiment { name: "hydrostatic", title: "", about: "", run };

fn run(_: &Run) -> Result<Outcome, Error> {
    Ok(Outcome::default())
}
