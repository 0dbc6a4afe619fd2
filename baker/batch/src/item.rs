//! An asset on its way through a batch.

use super::assets::PlannedAsset;
use super::job::{Cost, Estimate};
use super::state::Decision;
use super::summary::AssetReport;

/// An asset, and what is known of it so far.
pub struct BatchItem<'e> {
    /// The asset.
    pub asset: &'e PlannedAsset,
    /// What is to be done.
    pub decision: Decision,
    /// In the manifest's order, from 0.
    pub position: usize,
    /// What it costs, or why that can't be told, once it is estimated.
    pub estimate: Option<Result<Estimate, String>>,
    /// What came of it, once it is known.
    pub report: Option<AssetReport>,
}

impl BatchItem<'_> {
    /// What it costs, if that is known.
    pub fn cost(&self) -> Option<Cost> {
        Some(self.estimate.as_ref()?.as_ref().ok()?.cost)
    }
}
