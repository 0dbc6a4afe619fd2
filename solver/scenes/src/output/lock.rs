//! Keeps two runs out of one folder. The system releases the lock when the program ends, however it ends.

use super::io_error;
use crate::error::Error;
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// The file that is locked. It stays, empty: another run may be about to lock it.
const NAME: &str = ".volmap-sim";

/// The folder belongs to one run until this is dropped.
pub struct FolderLock {
    folder: PathBuf,
    /// Whether it is new.
    is_new: bool,
    /// Locked while it is open.
    _file: File,
}

impl FolderLock {
    /// Locks a folder, which is created if it is missing.
    ///
    /// # Errors
    /// [`Error::RunActive`] if another run is at work there; a folder that can't be written to.
    pub fn take(folder: &Path) -> Result<FolderLock, Error> {
        let is_new = !folder.exists();
        std::fs::create_dir_all(folder).map_err(io_error(folder))?;
        let path = folder.join(NAME);
        let options = &mut File::options();
        let file = options.write(true).create(true).truncate(false).open(&path).map_err(io_error(&path))?;
        // Some file systems of networks have no locks: runs must be possible there all the same.
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => Err(Error::RunActive { folder: folder.to_owned() }),
            _ => Ok(FolderLock { folder: folder.to_owned(), is_new, _file: file }),
        }
    }

    /// Gives the folder back when nothing came of the run: a new one, in which there is nothing else, is removed.
    pub fn give_back(self) {
        let is_alone = std::fs::read_dir(&self.folder).is_ok_and(|entries| entries.count() == 1);
        if self.is_new && is_alone {
            // Where that fails, an empty file stays.
            _ = std::fs::remove_file(self.folder.join(NAME)).and_then(|()| std::fs::remove_dir(&self.folder));
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
        // A folder that was there stays.
        FolderLock::take(&out).unwrap().give_back();
        assert!(out.join(NAME).exists());
        let other = folder.path().join("other");
        FolderLock::take(&other).unwrap().give_back();
        assert!(!other.exists());
    }
}
