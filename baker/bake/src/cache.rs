//! Folders of baked maps that are kept for the next time: the simulations' and those of batches. Nothing in them is
//! ever needed: what is gone is baked again.
//!
//! Only finished maps are listed and removed, by the names that the programs give them; a map that is being written has
//! no such name yet, and one that is open stays readable.

use crate::error::Error;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};
use volmap_formats::asset::clear_leftovers;

/// Hexadecimal digits of a content key at the end of a simulation's map, and of a batch's.
const DIGITS: [usize; 2] = [24, 64];

/// A map that is kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CachedMap {
    /// Its file.
    pub path: PathBuf,
    /// Size, bytes.
    pub bytes: u64,
    /// When it was written.
    pub written: SystemTime,
}

/// Where simulations keep maps if the scene doesn't say: `volmap` in the user's cache folder.
pub fn default_folder() -> PathBuf {
    let folder = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let home =
        || Some(folder("HOME")?.join(if cfg!(target_os = "macos") { "Library/Caches" } else { ".cache" }));
    let found = folder("XDG_CACHE_HOME").or_else(|| folder("LOCALAPPDATA")).or_else(home);
    found.unwrap_or_else(std::env::temp_dir).join("volmap")
}

/// The maps in a folder and, of a batch's cache, in its folders of two digits; the oldest first. None if the folder
/// isn't there.
///
/// # Errors
/// A folder that can't be read.
pub fn list(folder: &Path) -> Result<Vec<CachedMap>, Error> {
    let mut found = Vec::new();
    for entry in entries(folder)? {
        if is_digits(&name(&entry), 2) && entry.is_dir() {
            found.extend(entries(&entry)?.iter().filter_map(|path| cached(path)));
        } else {
            found.extend(cached(&entry));
        }
    }
    found.sort_by(|a, b| (a.written, &a.path).cmp(&(b.written, &b.path)));
    Ok(found)
}

/// Removes maps that were written longer ago than this, and what killed programs left; says which maps went. Folders
/// stay: a bake may be about to write there.
///
/// # Errors
/// A folder that can't be read, a file that can't be removed.
pub fn clear(folder: &Path, older_than: Duration) -> Result<Vec<CachedMap>, Error> {
    // One that can't be looked into is told of below.
    let _ = clear_leftovers(folder);
    let now = SystemTime::now();
    let is_old = |map: &CachedMap| now.duration_since(map.written).unwrap_or_default() >= older_than;
    let old: Vec<CachedMap> = list(folder)?.into_iter().filter(is_old).collect();
    for map in &old {
        match std::fs::remove_file(&map.path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Error::Io { path: map.path.clone(), source: error });
            }
            _ => {}
        }
    }
    Ok(old)
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let io = |source| Error::Io { path: folder.to_owned(), source };
    match std::fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
        found => found.map_err(io)?.map(|entry| Ok(entry.map_err(io)?.path())).collect(),
    }
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The file as a map, if it has the name of one: `duck-0123...f.h5`, or a content key.
fn cached(path: &Path) -> Option<CachedMap> {
    let name = name(path);
    let stem = name.strip_suffix(".h5")?;
    let key = stem.rsplit('-').next()?;
    let is_simulations = key.len() < stem.len() && is_digits(key, DIGITS[0]);
    let found = path.symlink_metadata().ok().filter(|found| found.is_file())?;
    let map = CachedMap { path: path.to_owned(), bytes: found.len(), written: found.modified().ok()? };
    (is_simulations || is_digits(stem, DIGITS[1])).then_some(map)
}

fn is_digits(text: &str, count: usize) -> bool {
    text.len() == count && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_found_by_their_names_and_nothing_else_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let (short, long) = ("0123456789abcdef01234567", "0123456789abcdef".repeat(4));
        std::fs::create_dir(at("01")).unwrap();
        std::fs::create_dir(at("notes")).unwrap();
        let maps = [format!("my duck-{short}.h5"), format!("01/{long}.h5")];
        let others =
            ["duck.h5".to_owned(), format!("{short}.h5"), format!("notes/{long}.h5"), "a.txt".into()];
        maps.iter().chain(&others).for_each(|name| std::fs::write(at(name), "four").unwrap());
        let found = list(folder.path()).unwrap();
        let mut paths: Vec<&PathBuf> = found.iter().map(|map| &map.path).collect();
        paths.sort();
        assert_eq!(paths, [&at(&maps[1]), &at(&maps[0])]);
        assert_eq!(found.iter().map(|map| map.bytes).sum::<u64>(), 8);

        assert_eq!(clear(folder.path(), Duration::from_secs(3600)).unwrap(), []);
        let old = SystemTime::now() - Duration::from_secs(2 * 3600);
        std::fs::File::options().write(true).open(at(&maps[0])).unwrap().set_modified(old).unwrap();
        let gone = clear(folder.path(), Duration::from_secs(3600)).unwrap();
        assert_eq!(gone.iter().map(|map| &map.path).collect::<Vec<_>>(), [&at(&maps[0])]);
        assert_eq!(clear(folder.path(), Duration::ZERO).unwrap().len(), 1);
        assert!(others.iter().all(|name| at(name).exists()) && at("01").is_dir());
        assert_eq!(list(&at("nowhere")).unwrap(), []);
    }
}
