//! How the solves of a step went.

/// How a solve went.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolveReport {
    /// Iterations.
    pub iterations: u32,
    /// Error left: of pressure solves the mean, in parts of the rest density; of viscous ones in parts of the
    /// velocities.
    pub error: f64,
}
