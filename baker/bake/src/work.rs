//! How far a long step is: counted here, shown by whoever calls.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Units of work of a step, and how many are done. Copies count together.
#[derive(Clone, Debug)]
pub struct Work {
    /// All units.
    pub total: u64,
    done: Arc<AtomicU64>,
}

impl Work {
    /// Nothing done yet.
    pub fn new(total: u64) -> Work {
        Work { total, done: Arc::default() }
    }

    /// Counts units as done.
    pub fn add(&self, units: u64) {
        self.done.fetch_add(units, Ordering::Relaxed);
    }

    /// Units done so far.
    pub fn done(&self) -> u64 {
        self.done.load(Ordering::Relaxed)
    }
}
