//! Files that appear whole or not at all, even if the program is killed.
//!
//! On Linux an unfinished file has no name in its folder (`O_TMPFILE`), so it goes with the process; a link gives
//! it one when it is complete. Elsewhere, and on file systems without such files, it is a temporary file that is
//! renamed.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// A file that is being written for `target`.
pub struct Unfinished {
    file: Inner,
    folder: PathBuf,
    target: PathBuf,
}

enum Inner {
    /// Without a name; reached through its descriptor.
    #[cfg(target_os = "linux")]
    Nameless(File),
    Named(NamedTempFile),
}

impl Unfinished {
    /// Begins a file in the folder of `target`.
    pub fn beside(target: &Path) -> io::Result<Unfinished> {
        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        };
        if target.is_dir() {
            return Err(io::Error::new(io::ErrorKind::IsADirectory, "is a folder; name a file in it"));
        }
        let file = match nameless(&folder) {
            #[cfg(target_os = "linux")]
            Some(file) => Inner::Nameless(file),
            _ => Inner::Named(named(&folder)?),
        };
        Ok(Unfinished { file, folder, target: target.to_owned() })
    }

    /// Where to write, until it is published.
    pub fn path(&self) -> PathBuf {
        match &self.file {
            #[cfg(target_os = "linux")]
            Inner::Nameless(file) => linux::descriptor_path(file),
            Inner::Named(file) => file.path().to_owned(),
        }
    }

    /// Makes the content durable and gives it the target's name, in place of an older file.
    pub fn publish(self) -> io::Result<()> {
        match self.file {
            #[cfg(target_os = "linux")]
            Inner::Nameless(file) => {
                file.sync_all()?;
                linux::link(&file, &self.folder, &self.target)
            }
            Inner::Named(file) => {
                file.as_file().sync_all()?;
                file.persist(&self.target)?;
                Ok(())
            }
        }
    }
}

fn named(folder: &Path) -> io::Result<NamedTempFile> {
    tempfile::Builder::new().prefix(".volmap-").suffix(".part").tempfile_in(folder)
}

#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> Option<File> {
    linux::nameless(folder)
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &Path) -> Option<File> {
    None
}

#[cfg(target_os = "linux")]
mod linux {
    use rustix::fs::{AtFlags, CWD, Mode, OFlags, linkat, open, rename};
    use std::fs::File;
    use std::io;
    use std::os::fd::AsRawFd;
    use std::path::{Path, PathBuf};

    /// A file without a name, if the file system has such.
    pub fn nameless(folder: &Path) -> Option<File> {
        let flags = OFlags::RDWR | OFlags::TMPFILE | OFlags::CLOEXEC;
        let file = File::from(open(folder, flags, Mode::from_raw_mode(0o644)).ok()?);
        // Without /proc it couldn't be reached.
        descriptor_path(&file).exists().then_some(file)
    }

    pub fn descriptor_path(file: &File) -> PathBuf {
        PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
    }

    /// A link can't replace a file: an existing target is replaced by renaming a complete file onto it.
    pub fn link(file: &File, folder: &Path, target: &Path) -> io::Result<()> {
        let from = descriptor_path(file);
        let link_to = |to: &Path| linkat(CWD, &from, CWD, to, AtFlags::SYMLINK_FOLLOW);
        if !target.exists() && link_to(target).is_ok() {
            return Ok(());
        }
        let own_name = super::named(folder)?.into_temp_path();
        std::fs::remove_file(&own_name)?;
        link_to(&own_name)?;
        Ok(rename(&*own_name, target)?)
    }
}
