//! Bodies: what the fluid touches, at rest, moved by a script or by forces.
// TEMPORARY until the rigid bodies are merged.
use volmap_runtime::{DVec3, PosedMap};
/// temporary
pub struct Bodies {
    /// temporary
    pub maps: Vec<PosedMap>,
}
impl Bodies {
    /// temporary
    pub fn posed(&self) -> &[PosedMap] {
        &self.maps
    }
    /// temporary
    pub fn velocity_at(&self, _: usize, _: DVec3) -> DVec3 {
        DVec3::ZERO
    }
    /// temporary
    pub fn is_free(&self, _: usize) -> bool {
        false
    }
    /// temporary
    pub fn center_of_mass(&self, _: usize) -> DVec3 {
        DVec3::ZERO
    }
    /// temporary
    pub fn apply(&mut self, _: usize, _: DVec3, _: DVec3) {}
    /// temporary
    pub fn step(&mut self, _: f64) {}
}
