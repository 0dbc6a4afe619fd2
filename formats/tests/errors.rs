//! The text of an error is complete in itself: no source repeats a part of it, so that a program which prints the whole
//! chain says nothing twice. And no text speaks of a command line.

use std::error::Error;
use std::path::Path;
use volmap_formats::asset::{self, AssetError};
use volmap_formats::export::{ExportError, ply};
use volmap_formats::mesh::{self, CleanSettings};

fn check(error: &dyn Error) {
    let text = error.to_string();
    assert!(text.starts_with("missing/"), "{text}");
    assert!(!text.contains("--"), "{text}");
    let mut source = error.source();
    while let Some(error) = source {
        assert!(!text.contains(&error.to_string()), "`{error}` is in `{text}`");
        source = error.source();
    }
}

#[test]
fn no_source_repeats_the_text() {
    let path = Path::new("missing/file.h5");
    let read: AssetError = asset::read(path).unwrap_err();
    let target: AssetError = asset::publish(path, b"").unwrap_err();
    let export: ExportError = ply::write(path, &[], &[], "").unwrap_err();
    check(&read);
    check(&target);
    check(&export);
    check(&mesh::load(Path::new("missing/file.obj"), &CleanSettings::default()).unwrap_err());
}
