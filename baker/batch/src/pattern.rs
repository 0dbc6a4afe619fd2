//! Paths and globs of a manifest, as Git's and most shells': `*` stops at `/`, `**` doesn't, and names that begin with
//! a dot must be named.

use super::left_out::is_foreign;
use globset::{Glob, GlobBuilder, GlobMatcher};
use std::path::{Path, PathBuf};
use volmap_formats::mesh::MeshFormat;
use walkdir::{DirEntry, WalkDir};

/// A path or a glob, relative to a folder, with `/` between its parts.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Without `.` parts.
    text: String,
    /// None: the text is a path.
    glob: Option<GlobPattern>,
}

#[derive(Clone, Debug)]
struct GlobPattern {
    all: GlobMatcher,
    /// For parts that begin with a dot.
    hidden: Vec<GlobMatcher>,
    /// Its last part says nothing of the extension.
    meshes_only: bool,
}

/// The files that a pattern means.
#[derive(Clone, Debug, Default)]
pub struct Files {
    /// Their paths, as the pattern's folder sees them, in the order of their bytes.
    pub paths: Vec<String>,
    /// Those of formats that aren't read.
    pub foreign: Vec<String>,
    /// Folders that couldn't be read, names that aren't Unicode.
    pub notes: Vec<String>,
    /// Folders that couldn't be looked into.
    pub unreadable: Vec<String>,
}

/// What makes a glob of a text.
const SPECIAL: [char; 4] = ['*', '?', '[', '{'];

/// A path without `.` and empty parts; what goes up and down again is left out.
pub fn normal(path: &str) -> String {
    let mut parts: Vec<&str> = Vec::new();
    for part in path.split('/').filter(|part| !part.is_empty() && *part != ".") {
        match (part, parts.last()) {
            ("..", Some(&last)) if last != ".." && !last.contains(SPECIAL) => {
                parts.pop();
            }
            _ => parts.push(part),
        }
    }
    let root = if path.starts_with('/') { "/" } else { "" };
    format!("{root}{}", parts.join("/"))
}

impl Pattern {
    /// Reads a pattern.
    ///
    /// # Errors
    /// In words, if it is no glob.
    pub fn new(text: &str) -> Result<Pattern, String> {
        let plain = normal(text);
        if plain.is_empty() || text.ends_with('/') {
            return Err(format!("`{text}` names no file; files in a folder are folder/*"));
        }
        let glob = plain.contains(SPECIAL).then(|| GlobPattern::new(&plain)).transpose()?;
        Ok(Pattern { text: plain, glob })
    }

    /// The same; what looks like a glob but is the name of a file in `folder` is a path.
    ///
    /// # Errors
    /// In words, if it is no glob.
    pub fn in_folder(text: &str, folder: &Path) -> Result<Pattern, String> {
        let mut pattern = Pattern::new(text)?;
        if pattern.glob.is_some() && folder.join(&pattern.text).is_file() {
            pattern.glob = None;
        }
        Ok(pattern)
    }

    /// The folder of a path, or that of a glob's parts before its first special one, with `/` behind; or nothing.
    pub fn fixed_part(&self) -> &str {
        let head = match &self.glob {
            Some(_) => &self.text[..self.text.find(SPECIAL).unwrap_or(0)],
            None => &self.text,
        };
        &head[..head.rfind('/').map_or(0, |slash| slash + 1)]
    }

    /// Whether it means this path, which is normal, as that of a mesh.
    pub fn matches(&self, path: &str) -> bool {
        let any_file = self.glob.as_ref().is_none_or(|glob| !glob.meshes_only);
        self.covers(path) && (any_file || MeshFormat::from_extension(Path::new(path)).is_some())
    }

    /// Whether it means this path, which is normal, whatever the file is.
    pub fn covers(&self, path: &str) -> bool {
        let Some(glob) = &self.glob else { return self.text == path };
        let Some(rest) = path.strip_prefix(self.fixed_part()) else { return false };
        let named = |part: &str| !part.starts_with('.') || glob.hidden.iter().any(|glob| glob.is_match(part));
        glob.all.is_match(path) && rest.split('/').all(named)
    }

    /// The files that it means; of a path the path, whether a file is there or not. Links to folders aren't followed.
    pub fn files(&self, folder: &Path) -> Files {
        let Some(glob) = &self.glob else {
            return Files { paths: vec![self.text.clone()], ..Files::default() };
        };
        let root = folder.join(self.fixed_part());
        let root = if root.as_os_str().is_empty() { PathBuf::from(".") } else { root };
        if !root.is_dir() {
            return Files::default();
        }
        let visible = |entry: &DirEntry| {
            let hidden = entry.file_name().as_encoded_bytes().starts_with(b".");
            entry.depth() == 0 || !hidden || glob.hidden.iter().any(|glob| glob.is_match(entry.file_name()))
        };
        let mut files = Files::default();
        let walk = WalkDir::new(&root).min_depth(1).max_depth(self.depth()).into_iter();
        for entry in walk.filter_entry(visible) {
            match entry {
                Ok(entry) => self.take(&entry, &root, &mut files),
                Err(error) => files.unreadable.push(error.to_string()),
            }
        }
        files.paths.sort_unstable();
        files
    }

    fn take(&self, entry: &DirEntry, root: &Path, files: &mut Files) {
        // Links to folders are left out; broken ones and what else is no file can't be baked, and are told of then.
        if entry.path().is_dir() {
            return;
        }
        let rest = entry.path().strip_prefix(root).unwrap_or(entry.path());
        let Some(rest) = rest.to_str() else {
            files.notes.push(format!("{}: the name is not Unicode; the file is left out", rest.display()));
            return;
        };
        let rest = if cfg!(windows) { rest.replace('\\', "/") } else { rest.to_owned() };
        let path = format!("{}{rest}", self.fixed_part());
        if self.matches(&path) {
            files.paths.push(path);
        } else if self.covers(&path) && is_foreign(&path) {
            files.foreign.push(path);
        }
    }

    /// Parts of the deepest path that it can mean, below its fixed part.
    fn depth(&self) -> usize {
        let below = &self.text[self.fixed_part().len()..];
        let unbounded = below.contains("**") || below.contains('{');
        if unbounded { usize::MAX } else { 1 + below.matches('/').count() }
    }
}

impl GlobPattern {
    fn new(text: &str) -> Result<GlobPattern, String> {
        let parts = text.split('/').filter(|part| part.starts_with('.') && *part != "..");
        Ok(GlobPattern {
            all: matcher(text)?,
            // Braces may reach over several parts; halves of them are no globs.
            hidden: parts.filter_map(|part| matcher(part).ok()).collect(),
            meshes_only: text.ends_with('*'),
        })
    }
}

fn matcher(text: &str) -> Result<GlobMatcher, String> {
    let glob: Result<Glob, _> = GlobBuilder::new(text).literal_separator(true).backslash_escape(true).build();
    glob.map(|glob| glob.compile_matcher()).map_err(|error| format!("`{text}` is no glob: {}", error.kind()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matches(pattern: &str, path: &str) -> bool {
        Pattern::new(pattern).unwrap().matches(path)
    }

    #[test]
    fn stars_stop_where_they_should() {
        for (pattern, path) in [
            ("a/*.obj", "a/b.obj"),
            ("a/**/*.obj", "a/b.obj"),
            ("a/**/*.obj", "a/b/c/d.obj"),
            ("a/**", "a/b/c.stl"),
            ("**/*.{obj,stl}", "x.stl"),
            ("./a//*.obj", "a/b.obj"),
            ("a/?.obj", "a/b.obj"),
            ("*.[os][bt][jl]", "b.stl"),
            ("../m/*.obj", "../m/a.obj"),
            ("/m/*.obj", "/m/a.obj"),
            (r"a\*/*.obj", "a*/b.obj"),
            ("a/x.obj", "a/x.obj"),
        ] {
            assert!(matches(pattern, path), "{pattern} {path}");
        }
        for (pattern, path) in [
            ("a/*.obj", "a/b/c.obj"),
            ("*", "a.txt"),
            ("a/**", "a/readme.md"),
            ("**/*.obj", ".git/a.obj"),
            ("**/*.obj", "a/.b.obj"),
            ("a/x.obj", "a/X.obj"),
            ("a/*.obj", "a/b.OBJ"),
        ] {
            assert!(!matches(pattern, path), "{pattern} {path}");
        }
        assert!(matches("**/.old/*.obj", "a/.old/x.obj") && !matches("**/.old/*.obj", ".git/.old/x.obj"));
    }

    #[test]
    fn fixed_parts_end_before_the_first_special_one() {
        let fixed = |text| Pattern::new(text).unwrap().fixed_part().to_owned();
        assert_eq!(fixed("a/b/*.obj"), "a/b/");
        assert_eq!(fixed("a/b*/c.obj"), "a/");
        assert_eq!(fixed("a/b.obj"), "a/");
        assert_eq!(fixed("**/*.obj"), "");
        assert_eq!(fixed("/*.obj"), "/");
        assert_eq!(fixed("x/../a/./b.obj"), "a/");
    }

    #[test]
    fn texts_that_name_nothing_are_refused() {
        for text in ["", ".", "a/", "a/[b", "{a,b", "x/.."] {
            assert!(Pattern::new(text).is_err(), "{text}");
        }
    }
}
