//! The stages of a bake: their names for progress and for the list of times.

/// A stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Diagnosis and orientation of the mesh.
    Mesh,
    /// The tree for its distance.
    Tree,
    /// Integrating the volume on the exact distance, for a tolerance.
    Reference,
    /// Finding the cells of the band.
    Band,
    /// Sampling Phi at the nodes.
    Distance,
    /// Integrating V at the nodes.
    Volume,
    /// The density: finding and sampling what it needs beyond the band, and integrating it.
    Density,
    /// Comparing the signs.
    CheckSign,
}

impl Stage {
    /// All of them.
    pub const ALL: [Stage; 8] = [
        Stage::Mesh,
        Stage::Tree,
        Stage::Reference,
        Stage::Band,
        Stage::Distance,
        Stage::Volume,
        Stage::Density,
        Stage::CheckSign,
    ];

    /// What is done, as a [`crate::watch::Step`] has it.
    pub fn step(self) -> &'static str {
        match self {
            Stage::Mesh => "examining the mesh",
            Stage::Tree => "building the tree",
            Stage::Reference => "measuring the exact volume",
            Stage::Band => "finding the band",
            Stage::Distance => "sampling the distance",
            Stage::Volume => "integrating the volume",
            Stage::Density => "computing the density",
            Stage::CheckSign => "comparing the signs",
        }
    }

    /// Its name in a list of times.
    pub fn name(self) -> &'static str {
        match self {
            Stage::Mesh => "mesh",
            Stage::Tree => "tree",
            Stage::Reference => "reference",
            Stage::Band => "band",
            Stage::Distance => "distance",
            Stage::Volume => "volume",
            Stage::Density => "density",
            Stage::CheckSign => "check",
        }
    }

    /// The stage of a step.
    pub fn of(step: &str) -> Option<Stage> {
        Stage::ALL.into_iter().find(|stage| stage.step() == step)
    }
}
