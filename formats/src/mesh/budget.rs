//! How much a file may expand: compressed blocks, instances and shared data let a small file claim
//! a huge mesh.

use super::error::MeshError;

/// Every file may expand to this many bytes.
pub const BASE: u64 = 256 << 20;
/// And to this many for each byte that it has.
pub const PER_BYTE: u64 = 64;

/// What is left of a file's allowance.
pub(super) struct Budget {
    left: u64,
    total: u64,
}

impl Budget {
    pub fn new(file_bytes: usize) -> Budget {
        let total = BASE.saturating_add(PER_BYTE.saturating_mul(file_bytes as u64));
        Budget { left: total, total }
    }

    /// Takes `count` items of `size` bytes before they are allocated.
    pub fn take(&mut self, count: usize, size: usize, what: &str) -> Result<(), MeshError> {
        let bytes = (count as u64).saturating_mul(size as u64);
        match self.left.checked_sub(bytes) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(MeshError::TooLarge {
                problem: format!(
                    "{what} expands to more than {} MiB, the limit for a file of this size; it is \
                     damaged, or uses so many instances or such strong compression that it must \
                     be split into several files",
                    self.total >> 20
                ),
            }),
        }
    }

    /// Bytes left.
    pub fn left(&self) -> u64 {
        self.left
    }
}
