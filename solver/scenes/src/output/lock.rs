//! Keeps two runs out of one folder. The system releases the lock when the program ends, however it ends.

use super::io_error;
use crate::error::Error;
use std::fs::{File, TryLockError};
use std::path::Path;

/// The file that is locked. It stays, empty: another run may be about to lock it.
const NAME: &str = ".volmap-sim";

/// The folder belongs to one run until this is dropped.
pub struct FolderLock(#[expect(dead_code, reason = "the file is locked while it is open")] File);

impl FolderLock {
    /// Locks a folder, which is created if it is missing.
    ///
    /// # Errors
    /// [`Error::RunActive`] if another run is at work there; a folder that can't be written to.
    pub fn take(folder: &Path) -> Result<FolderLock, Error> {
        std::fs::create_dir_all(folder).map_err(io_error(folder))?;
        let path = folder.join(NAME);
        let options = &mut File::options();
        let file = options.write(true).create(true).truncate(false).open(&path).map_err(io_error(&path))?;
        // Some file systems of networks have no locks: runs must be possible there all the same.
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(Error::RunActive { folder: folder.to_owned() }),
            _ => Ok(FolderLock(file)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_run_at_a_time() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("new");
        let first = FolderLock::take(&out).unwrap();
        let refused = FolderLock::take(&out).err().unwrap().to_string();
        assert!(refused.contains("another run is at work in this folder"), "{refused}");
        drop(first);
        FolderLock::take(&out).unwrap();
    }
}
