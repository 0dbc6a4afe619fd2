//! Files that appear whole or not at all, even if the program is killed.
//!
//! On Linux a file that is being written has no name in its folder (`O_TMPFILE`), so it goes with the process; a
//! link gives it one when it is complete. To take the place of an older file, and elsewhere, it is a temporary file
//! that is renamed. One that a killed program left can be told from one at work: nobody holds its lock.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use tempfile::NamedTempFile;

/// Refuses a target that could not be made, or that stands for something else than a file: renaming onto a device
/// would take its place.
pub fn check_target(target: &Path) -> io::Result<()> {
    let refuse = |kind, reason: String| Err(io::Error::new(kind, reason));
    let folder = folder_of(target);
    if target.is_dir() {
        refuse(io::ErrorKind::IsADirectory, "is a folder; name a file in it".into())
    } else if target.exists() && !target.is_file() {
        refuse(io::ErrorKind::InvalidInput, "is a device or a pipe; name a file".into())
    } else if !folder.is_dir() {
        refuse(io::ErrorKind::NotFound, format!("there is no folder {}; make it first", folder.display()))
    } else {
        Ok(())
    }
}

fn folder_of(target: &Path) -> &Path {
    target.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes a file of these bytes, durably, in place of an older one.
pub fn publish(bytes: &[u8], target: &Path) -> io::Result<()> {
    let mut file = NewFile::create(target)?;
    file.write_all(bytes)?;
    file.publish()
}

const PREFIX: &str = ".volmap-";
const SUFFIX: &str = ".part";

/// Removes what killed programs left of files in a folder, and says how many. Files that are being written stay.
///
/// # Errors
/// A folder that can't be read.
pub fn clear_leftovers(folder: &Path) -> io::Result<usize> {
    let mut count = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        let lock = if ours { lock_of_left(&entry.path()) } else { None };
        // Held until the file is gone: nobody else takes it for its own.
        if lock.is_some() && std::fs::remove_file(entry.path()).is_ok() {
            count += 1;
        }
    }
    Ok(count)
}

/// Where the file system has no locks nothing is known to be left. (Those of NFS want a file that can be written.)
fn lock_of_left(path: &Path) -> Option<File> {
    path.symlink_metadata().ok().filter(|found| found.is_file())?;
    let file = File::options().read(true).write(true).open(path).ok()?;
    file.try_lock().ok().map(|()| file)
}

/// A file on its way: it gets its name when it is published, and is gone if it never is. Not buffered.
pub struct NewFile {
    target: PathBuf,
    kind: Kind,
}

enum Kind {
    #[cfg(target_os = "linux")]
    Nameless(File),
    Named(NamedTempFile),
}

impl NewFile {
    /// Begins a file, in the folder of its target.
    ///
    /// # Errors
    /// A target that could not be made, or that isn't a file.
    pub fn create(target: &Path) -> io::Result<NewFile> {
        check_target(target)?;
        let folder = folder_of(target);
        #[cfg(target_os = "linux")]
        if let Some(file) = linux::nameless(folder) {
            let _ = file.lock();
            return Ok(NewFile { target: target.to_owned(), kind: Kind::Nameless(file) });
        }
        Ok(NewFile { target: target.to_owned(), kind: Kind::Named(locked(folder)?) })
    }

    /// Gives it its name, durably, in place of an older file.
    ///
    /// # Errors
    /// The system's.
    pub fn publish(self) -> io::Result<()> {
        match self.kind {
            #[cfg(target_os = "linux")]
            Kind::Nameless(file) => {
                file.sync_all()?;
                linux::link(&file, folder_of(&self.target), &self.target)
            }
            Kind::Named(file) => {
                file.as_file().sync_all()?;
                file.persist(&self.target)?;
                Ok(())
            }
        }
    }
}

impl Write for NewFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.kind {
            #[cfg(target_os = "linux")]
            Kind::Nameless(file) => file.write(bytes),
            Kind::Named(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A temporary file that is held against [`clear_leftovers`], which may have taken it before it was locked.
fn locked(folder: &Path) -> io::Result<NamedTempFile> {
    loop {
        let file = named(folder)?;
        let _ = file.as_file().lock();
        if file.path().exists() {
            return Ok(file);
        }
    }
}

fn named(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
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
        let file = File::from(open(folder, flags, Mode::from_raw_mode(0o666)).ok()?);
        // Without /proc it couldn't be linked.
        descriptor_path(&file).exists().then_some(file)
    }

    fn descriptor_path(file: &File) -> PathBuf {
        PathBuf::from(format!("/proc/self/fd/{}", file.as_raw_fd()))
    }

    /// A link can't replace a file: an existing target is replaced by renaming the complete file onto it.
    pub fn link(file: &File, folder: &Path, target: &Path) -> io::Result<()> {
        let from = descriptor_path(file);
        let link_to = |to: &Path| linkat(CWD, &from, CWD, to, AtFlags::SYMLINK_FOLLOW);
        if !target.exists() && link_to(target).is_ok() {
            return Ok(());
        }
        // The file has its lock already, so that it never looks like one that was left.
        let mut names = tempfile::Builder::new();
        names.prefix(super::PREFIX).suffix(super::SUFFIX);
        let own_name = names.make_in(folder, |name| Ok(link_to(name)?))?.into_temp_path();
        rename(&*own_name, target)?;
        // It is the target now, and nothing to be removed.
        let _ = own_name.keep();
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn files_are_new_or_replaced_with_the_permissions_of_any_new_file() {
        let folder = tempfile::tempdir().unwrap();
        let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
        let (plain, target) = (folder.path().join("plain"), folder.path().join("target"));
        std::fs::File::create(&plain).unwrap();
        for content in ["first", "second"] {
            publish(content.as_bytes(), &target).unwrap();
            assert_eq!(std::fs::read_to_string(&target).unwrap(), content);
            assert_eq!(mode(&target), mode(&plain));
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing else stays");
        let mut unfinished = NewFile::create(&folder.path().join("never")).unwrap();
        unfinished.write_all(b"half").unwrap();
        drop(unfinished);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing of an unfinished one");
        assert!(publish(b"x", folder.path()).is_err());
        assert!(publish(b"x", &folder.path().join("missing/target")).is_err());
    }
    #[test]
    fn leftovers_go_and_files_at_work_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at(".volmap-left.part"), "x").unwrap();
        std::fs::write(at("other.part"), "x").unwrap();
        std::fs::create_dir(at(".volmap-folder.part")).unwrap();
        let mut at_work = locked(folder.path()).unwrap();
        at_work.write_all(b"x").unwrap();
        assert_eq!(clear_leftovers(folder.path()).unwrap(), 1);
        assert!(!at(".volmap-left.part").exists() && at("other.part").exists());
        assert!(at_work.path().exists());
        let path = at_work.into_temp_path().keep().unwrap();
        assert_eq!(
            (clear_leftovers(folder.path()).unwrap(), path.exists()),
            (1, false),
            "its program is gone"
        );
        assert!(clear_leftovers(&at("missing")).is_err());
    }
}
