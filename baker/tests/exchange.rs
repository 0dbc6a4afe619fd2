//! `volmap export` and `volmap import` as a user calls them.

use assert_cmd::Command;
use std::path::Path;
use tempfile::TempDir;

/// A folder with the asset of the duck, and how to call the program there.
struct Place(TempDir);

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::tempdir().unwrap());
        let duck = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/duck.obj");
        let bake = ["bake", duck.to_str().unwrap(), "-o", "duck.h5", "--resolution", "14", "-q"];
        place.command(&bake).assert().success();
        place
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_volmap"));
        command.current_dir(self.0.path()).args(arguments);
        command
    }

    fn output(&self, arguments: &[&str]) -> String {
        String::from_utf8(self.command(arguments).assert().success().get_output().stdout.clone()).unwrap()
    }

    fn error(&self, arguments: &[&str]) -> String {
        String::from_utf8(self.command(arguments).assert().failure().get_output().stderr.clone()).unwrap()
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.0.path().join(name)).unwrap()
    }
}

#[test]
fn every_format_is_written_and_told() {
    let place = Place::new();
    for (file, start, told) in [
        ("a.vtkhdf", &b"\x89HDF"[..], "cubic cells"),
        ("a.vti", b"<?xml", "15 x 15 x 15 points"),
        ("a.PLY", b"ply\n", "triangles"),
        ("a.cdm", b"", "nodes"),
        ("a.cdf", b"", "nodes"),
    ] {
        let text = place.output(&["export", "duck.h5", "-o", file]);
        assert!(text.starts_with(file) && text.contains(told), "{text}");
        let first = place.bytes(file);
        assert!(first.starts_with(start));
        place.output(&["export", "duck.h5", "-o", file]);
        assert!(place.bytes(file) == first, "{file}: other bytes");
    }
    let text = place.output(&["export", "duck.h5", "-o", "b.ply", "--iso", "-0.05", "--cell-size", "0.1"]);
    assert!(text.contains("closed"), "{text}");
    let text =
        place.output(&["export", "duck.h5", "-o", "b.vti", "--field", "volume", "--resolution", "9,8,7"]);
    assert!(text.contains("10 x 9 x 8 points") && place.bytes("b.vti").len() < place.bytes("a.vti").len());
}

#[test]
fn a_map_goes_out_and_comes_back() {
    let place = Place::new();
    place.output(&["export", "duck.h5", "-o", "duck.cdm"]);
    place.output(&["import", "duck.cdm", "-o", "back.h5", "--support-radius", "0.1"]);
    let info = place.output(&["info", "back.h5", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&info).unwrap();
    assert_eq!((&json["source"]["file"], &json["exterior"]), (&"duck.cdm".into(), &"fluid".into()));
    assert_eq!(json["fields"]["volume"]["precision"], "f64");
    place.output(&["export", "back.h5", "-o", "again.cdm"]);
    assert!(place.bytes("duck.cdm") == place.bytes("again.cdm"));
    let other = ["import", "duck.cdm", "-o", "wall.h5", "--support-radius", "0.1", "--exterior", "solid"];
    let told = place.command(&other).assert().success().get_output().stderr.clone();
    let told = String::from_utf8(told).unwrap();
    let parts = ["warning: ", "`mapInvert`", "`mapThickness`", "--invert", "a --thickness of -T"];
    assert!(parts.iter().all(|part| told.contains(part)), "{told}");
    assert!(place.output(&["info", "wall.h5"]).contains("solid"));
}

#[test]
fn what_makes_no_sense_is_refused_and_nothing_is_written() {
    let place = Place::new();
    place.output(&["export", "duck.h5", "-o", "duck.cdm"]);
    place.output(&["export", "duck.h5", "-o", "duck.cdf"]);
    let cases: [(&[&str], &str); 12] = [
        (&["export", "duck.h5", "-o", "x.stl"], ".vtkhdf, .vti, .ply, .cdm or .cdf"),
        (&["export", "duck.h5", "-o", "x.cdm", "--iso", "0"], "--iso"),
        (&["export", "duck.h5", "-o", "x.ply", "--field", "volume"], "--field"),
        (&["export", "duck.h5", "-o", "x.vtkhdf", "--resolution", "9"], "--resolution"),
        (&["export", "duck.h5", "-o", "x.ply", "--iso", "0.2"], "band"),
        (&["export", "duck.h5", "-o", "x.ply", "--iso", "nan"], "band"),
        (&["export", "duck.h5", "-o", "x.vti", "--resolution", "5000"], "points"),
        (&["export", "duck.h5", "-o", "x.vti", "--cell-size", "-1"], "length"),
        (&["export", "duck.h5", "-o", "nowhere/x.vti"], "no folder"),
        (&["import", "duck.cdf", "-o", "x.h5", "--support-radius", "0.1"], "without a volume"),
        (&["import", "duck.h5", "-o", "x.h5", "--support-radius", "0.1"], "not a Discregrid map"),
        (&["import", "duck.cdm", "-o", "x.h5", "--support-radius", "-1"], "--support-radius"),
    ];
    for (arguments, part) in cases {
        let text = place.error(arguments);
        assert!(text.contains(part) && !text.contains("panicked"), "{arguments:?}: {text}");
    }
    assert!(place.error(&["export", "duck.h5", "-o", "duck.h5"]).contains("overwrite"));
    assert!(
        place
            .error(&["import", "duck.cdm", "-o", "duck.cdm", "--support-radius", "0.1"])
            .contains("overwrite")
    );
    let written = std::fs::read_dir(place.0.path()).unwrap().map(|entry| entry.unwrap().file_name());
    assert!(written.into_iter().all(|name| !name.to_string_lossy().starts_with('x')));
}
