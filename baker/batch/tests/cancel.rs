//! A job of a batch ends soon after it was asked to, and leaves nothing behind.

use std::path::Path;
use std::sync::{Arc, Mutex};
use volmap_bake::content_key;
use volmap_bake::parameters::Parameters;
use volmap_bake::watch::{Cancel, Watch};
use volmap_batch::job::{BakeInput, MakeTask};
use volmap_batch::make::make;
use volmap_batch::manifest::Gates;
use volmap_batch::places::Places;

const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

fn task(folder: &Path) -> MakeTask {
    let mesh = folder.join("cube.obj");
    std::fs::write(&mesh, CUBE).unwrap();
    let parameters: Parameters =
        serde_json::from_str(r#"{ "support_radius": 0.2, "cell_size": 0.2 }"#).unwrap();
    let effective = content_key::parameters(&parameters.recipe(), 20);
    let identity = content_key::identify(&mesh, effective).unwrap();
    let places = Places { out: folder.join("out"), cache: Some(folder.join("cache")) };
    let files = places.files("cube", Some(&identity.key), true);
    let input = BakeInput { mesh, parameters, error_points: 20, report: false };
    let (gates, candidates) = (Gates::default(), Vec::new());
    MakeTask { input, identity, gates, max_memory: 1 << 30, candidates, files }
}

fn files(folder: &Path) -> usize {
    let mut found = 0;
    for entry in std::fs::read_dir(folder).into_iter().flatten().map(|entry| entry.unwrap()) {
        found += if entry.path().is_dir() { files(&entry.path()) } else { 1 };
    }
    found
}

#[test]
fn jobs_end_at_any_step_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let task = task(folder.path());
    let names = Arc::new(Mutex::new(Vec::new()));
    let list = names.clone();
    let whole = make(&task, &Watch::new(move |step| list.lock().unwrap().push(step.name))).unwrap();
    // The mesh, the asset, its picture, its report's page and JSON, and the asset in the cache.
    assert_eq!(files(folder.path()), 6);
    let names = names.lock().unwrap().clone();
    assert!(names.starts_with(&["reading"]) && names.ends_with(&["writing"]), "{names:?}");
    for (number, name) in names.iter().enumerate().take(names.len() - 1) {
        let _ = std::fs::remove_dir_all(folder.path().join("out"));
        let _ = std::fs::remove_dir_all(folder.path().join("cache"));
        let (cancel, heard) = (Cancel::default(), Mutex::new(0));
        let own = cancel.clone();
        let watch = Watch::new(move |_| {
            let mut heard = heard.lock().unwrap();
            *heard += 1;
            if *heard == number + 1 {
                own.cancel();
            }
        });
        match make(&task, &watch.stopped_by(&cancel)) {
            Err(error) => assert!(error.is_cancelled(), "{name}: {error}"),
            Ok(_) => panic!("{name}: not cancelled"),
        }
        assert_eq!(files(folder.path()), 1, "{name}");
    }
    let again = make(&task, &Watch::default()).unwrap();
    assert_eq!(again.file_blake3, whole.file_blake3);
}
