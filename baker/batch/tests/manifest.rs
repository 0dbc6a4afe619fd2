//! Manifests of a batch: what they say, what they refuse and where, and which assets they mean.

use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use volmap_bake::parameters::{ByteSize, Fraction, Parameters};
use volmap_batch::assets::{Expanded, PlannedAsset, expand};
use volmap_batch::manifest::{Gates, Manifest, from_patterns, load, parse};
use volmap_documents::Syntax;

const MANIFEST: &str = r#"
version = 1
[defaults]
bake = { support_radius = 0.1, invert = true }
gates = { max_error = "1%", max_bytes = "2MB", must_be_closed = true }
timeout = 60

[[assets]]
mesh = "meshes/**/*.obj"
exclude = ["**/old/*"]
tags = ["props", "all"]

[[assets]]
mesh = ["meshes/duck.obj", "meshes/missing.obj"]
tags = ["all", "birds"]
bake = { particle_radius = 0.01 }
gates = { must_be_closed = false }
error_points = 50
report = true
maps = [
    { name = "near", bake = { tolerance = "2%" }, tags = ["detail"] },
    { name = "far", bake = { support_radius = 0.4 }, gates = { max_bytes = 1000 }, timeout = 5 },
]
"#;

fn toml(text: &str) -> Result<Manifest, String> {
    parse(text, Syntax::Toml, "m.toml").map_err(|error| error.to_string())
}

fn json(text: &str) -> Result<Manifest, String> {
    parse(text, Syntax::Json, "m.json").map_err(|error| error.to_string())
}

/// A folder with empty files.
fn folder(files: &[&str]) -> TempDir {
    let folder = TempDir::new().unwrap();
    for file in files {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, "").unwrap();
    }
    folder
}

fn expanded(text: &str, folder: &TempDir) -> Result<Expanded, String> {
    expand(&toml(text)?, folder.path()).map_err(|error| error.to_string())
}

fn names(expanded: &Expanded) -> Vec<&str> {
    expanded.assets.iter().map(|asset| asset.name.as_str()).collect()
}

/// Names of the assets of one entry.
fn names_of(entry: &str, folder: &TempDir) -> Vec<String> {
    let expanded = expanded(&format!("version = 1\n[[assets]]\n{entry}"), folder).unwrap();
    names(&expanded).into_iter().map(String::from).collect()
}

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data")
}

#[test]
fn later_entries_go_over_earlier_ones_and_maps_over_all() {
    let folder = folder(&["meshes/duck.obj", "meshes/a/rock.obj", "meshes/old/duck.obj", "meshes/duck.mtl"]);
    let found = expanded(MANIFEST, &folder).unwrap();
    let wanted = ["a/rock", "duck.near", "duck.far", "missing.near", "missing.far"];
    assert_eq!((names(&found), found.notes.len()), (wanted.to_vec(), 0));
    let [rock, near, far, missing, _] = &found.assets[..] else { unreachable!() };
    let gates = Gates {
        max_error: Some(Fraction(0.01)),
        max_bytes: Some(ByteSize(2_000_000)),
        must_be_closed: Some(true),
        ..Gates::default()
    };
    let defaults = Parameters { support_radius: Some(0.1), invert: Some(true), ..Parameters::default() };
    let expected = PlannedAsset {
        name: "a/rock".into(),
        mesh: folder.path().join("meshes/a/rock.obj"),
        mesh_name: "meshes/a/rock.obj".into(),
        tags: vec!["props".into(), "all".into()],
        parameters: defaults.clone(),
        gates,
        timeout: Some(60.0),
        report_timeout: None,
        error_points: 200,
        report: false,
        fault: None,
    };
    assert_eq!(*rock, expected);
    assert_eq!(near.tags, ["props", "all", "birds", "detail"]);
    let bake = |asset: &PlannedAsset| serde_json::to_value(&asset.parameters).unwrap();
    assert_eq!(
        (bake(near)["particle_radius"].clone(), bake(near)["tolerance"].clone()),
        (0.01.into(), 0.02.into())
    );
    assert!(bake(near)["support_radius"].is_null() && bake(near)["invert"] == true);
    assert!(bake(far)["particle_radius"].is_null() && bake(far)["support_radius"] == 0.4);
    assert_eq!((near.timeout, near.error_points, near.report), (Some(60.0), 50, true));
    assert_eq!((far.timeout, far.gates.max_bytes), (Some(5.0), Some(ByteSize(1000))));
    assert_eq!(far.gates.must_be_closed, Some(false));
    // A path without a file is an asset, too, and what globs say of it holds.
    assert_eq!(missing.tags, ["props", "all", "birds", "detail"]);
}

#[test]
fn globs_find_meshes_in_order() {
    let files = ["b.obj", "a.STL", "a/x.obj", "a-b.obj", ".hidden/x.obj", ".h.obj", "read.me", "[1].obj"];
    let folder = folder(&files);
    assert_eq!(names_of(r#"mesh = "*""#, &folder), ["[1]", "a-b", "a", "b"]);
    assert_eq!(names_of(r#"mesh = "**""#, &folder), ["[1]", "a-b", "a", "a/x", "b"]);
    assert_eq!(names_of(r#"mesh = "**/*.obj""#, &folder), ["[1]", "a-b", "a/x", "b"]);
    assert_eq!(names_of(r#"mesh = ".hidden/*.obj""#, &folder), ["x"]);
    assert_eq!(names_of(r#"mesh = ".*""#, &folder), [".h"]);
    assert_eq!(names_of(r#"mesh = "[1].obj""#, &folder), ["[1]"]);
    assert_eq!(names_of(r#"mesh = "./a/../a//x.obj""#, &folder), ["x"]);
    assert_eq!(names_of(r#"mesh = ["b.obj", "*.obj"]"#, &folder), ["b", "[1]", "a-b"]);
    let named = "mesh = [\"*.obj\", \"a/*\"]\nexclude = \"a-*\"\nname = \"out/{parent}_{stem}\"";
    let parent = folder.path().file_name().unwrap().to_str().unwrap();
    assert_eq!(
        names_of(named, &folder),
        [format!("out/{parent}_[1]"), format!("out/{parent}_b"), "out/a_x".into()]
    );
    let none =
        expanded("version = 1\n[[assets]]\nmesh = [\"no/*.obj\", \"*.ply\", \"b.obj\"]", &folder).unwrap();
    assert_eq!(names(&none), ["b"]);
    assert_eq!(none.notes, ["no mesh matches `no/*.obj`", "no mesh matches `*.ply`"]);
}

#[cfg(unix)]
#[test]
fn links_to_files_are_taken_and_those_to_folders_are_not() {
    let folder = folder(&["real/a.obj"]);
    std::os::unix::fs::symlink(folder.path().join("real"), folder.path().join("loop")).unwrap();
    std::os::unix::fs::symlink(folder.path().join("real/a.obj"), folder.path().join("b.obj")).unwrap();
    assert_eq!(names_of(r#"mesh = "**/*.obj""#, &folder), ["b", "real/a"]);
}

#[test]
fn two_assets_have_two_names() {
    let folder = folder(&["a/duck.obj", "b/Duck.obj", "b/duck.stl", "a.obj"]);
    let message = |entry: &str| expanded(&format!("version = 1\n[[assets]]\n{entry}"), &folder).unwrap_err();
    let same = message(r#"mesh = ["a/duck.obj", "b/duck.stl"]"#);
    assert!(
        same.starts_with("b/duck.stl: its asset would have the name of that of a/duck.obj, duck.h5;"),
        "{same}"
    );
    let case = message(r#"mesh = ["b/*"]"#);
    assert!(case.contains("b/Duck.obj, duck.h5, but for large and small letters; tell them apart"), "{case}");
    let bad = "version = 1\n[[assets]]\nmesh = \"a.obj\"\nname = \"x/{map}/y\"";
    let bad = expanded(bad, &folder).unwrap().assets.remove(0).fault.unwrap();
    assert!(bad.starts_with("a.obj: can't name its asset: `x//y`: a part of the name is empty"), "{bad}");
    assert_eq!(names_of(r#"mesh = ["a.obj", "a/*"]"#, &folder), ["a", "duck"]);
    assert_eq!(names_of("mesh = \"*/duck.*\"\nname = \"{parent}_{stem}\"", &folder), ["a_duck", "b_duck"]);
}

#[test]
fn mistakes_are_placed_and_the_likely_word_is_named() {
    let replaced = |from: &str, to: &str| {
        assert!(MANIFEST.contains(from));
        toml(&MANIFEST.replace(from, to)).unwrap_err()
    };
    for (from, to, message) in [
        ("timeout = 60", "timeot = 60", "m.toml:6:1: unknown key `timeot`; did you mean `timeout`?"),
        ("invert =", "inverted =", "m.toml:4:32: unknown key `inverted`; did you mean `invert`?"),
        ("exclude =", "exclud =", "m.toml:10:1: unknown key `exclud`; did you mean `exclude`?"),
        (
            "max_bytes = 1000",
            "max_byte = 1000",
            "m.toml:22:64: unknown key `max_byte`; did you mean `max_bytes`?",
        ),
        (
            "support_radius = 0.1",
            "support_radius = -1",
            "m.toml:4:10: defaults.bake.support_radius: -1 is not positive",
        ),
        ("tolerance = \"2%\"", "tolerance = 2", "m.toml:21:43: invalid value `2`: give 0.05% to 50%"),
        ("timeout = 5", "timeout = 0", "m.toml:22:84: assets[1].maps[1].timeout: 0 is no time"),
        ("\"2MB\"", "\"much\"", "m.toml:5:41: invalid value `much`: give a size as 4GiB or 500MB"),
        (
            "name = \"far\"",
            "name = \"Near\"",
            "m.toml:22:7: assets[1].maps[1].name: two maps are called `Near`",
        ),
        ("name = \"far\"", "name = \"a/b\"", "m.toml:22:7: assets[1].maps[1].name: `a/b` has a character"),
        ("\"**/old/*\"", "\"[a\"", "m.toml:10:1: assets[0].exclude: `[a` is no glob"),
        ("\"meshes/**/*.obj\"", "[]", "m.toml:9:1: assets[0].mesh: names no file"),
        (
            "\"meshes/**/*.obj\"",
            "3",
            "m.toml:9:8: invalid type: integer `3`, expected a path, a glob, or a list of them",
        ),
        (
            "tags = [\"props\"",
            "name = \"{file}\"\ntags = [\"props\"",
            "m.toml:11:1: assets[0].name: `{file}` stands for nothing",
        ),
        (
            "particle_radius = 0.01",
            "particle_radius = 0.01, support_radius = 1",
            "m.toml:16:10: assets[1].bake.particle_radius: can't be used with `support_radius`",
        ),
        (
            "error_points = 50",
            "error_points = 100000000",
            "m.toml:18:1: assets[1].error_points: 100000000 are more",
        ),
        (
            "version = 1",
            "version = 2",
            "m.toml:2:1: version: 2 is not known; this program reads 1: take a newer volmap",
        ),
        (
            "version = 1",
            "version = 0",
            "m.toml:2:1: version: 0 is not known; this program reads 1: give that",
        ),
        ("version = 1", "", "m.toml:1:1: the key `version` is missing"),
    ] {
        let found = replaced(from, to);
        assert!(found.starts_with(message), "\n{found}\n{message}");
    }
    let found =
        json("{\"version\": 1, \"assets\": [\n  {\"mesh\": \"a\", \"bake\": {\"resolution\": [1, 2]}}]}")
            .unwrap_err();
    assert!(found.starts_with("m.json:2:") && found.contains("give N, or NX,NY,NZ"), "{found}");
    let found = toml("version = 2\nassets = []\nnew = 1").unwrap_err();
    assert_eq!(found, "m.toml:1:1: is of version 2; this program reads 1: take a newer volmap");
    let found = toml("version = 1\nassets = []").unwrap_err();
    assert_eq!(found, "m.toml:2:1: assets: there are none; give one at least");
    let gate = "version = 1\n[[assets]]\nmesh = \"a\"\ngates = { max_error = 0.1 }\nerror_points = 0";
    assert!(expanded(gate, &folder(&[])).unwrap_err().starts_with("a: max_error needs points"));
}

#[test]
fn json_and_toml_are_the_same_and_come_back() {
    let manifest = toml(MANIFEST).unwrap();
    let text = serde_json::to_string_pretty(&manifest).unwrap();
    assert_eq!(json(&text).unwrap(), manifest);
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../batch.schema.json");
    let published: serde_json::Value = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    assert!(published == Manifest::schema(), "baker/batch.schema.json is old");
    let parameters = published["$defs"]["Parameters"]["properties"].as_object().unwrap();
    assert_eq!(parameters.len(), 30);
    assert!(parameters.values().all(|key| key["description"].is_string()));
}

#[test]
fn patterns_of_the_command_line_are_a_manifest() {
    let folder = folder(&["m/a.obj", "m/b.obj"]);
    let parameters = Parameters { support_radius: Some(0.1), ..Parameters::default() };
    let found = expand(&from_patterns(&["m/*.obj".into()], None, &parameters), folder.path()).unwrap();
    assert_eq!(names(&found), ["a", "b"]);
    assert!(
        found.assets.iter().all(|asset| asset.parameters == parameters && asset.gates == Gates::default())
    );
    let bad = Parameters { support_radius: Some(f64::NAN), ..Parameters::default() };
    let message =
        expand(&from_patterns(&["m/*.obj".into()], None, &bad), folder.path()).unwrap_err().to_string();
    assert_eq!(message, "defaults.bake.support_radius: NaN is not a usable length");
    assert!(expand(&from_patterns(&["[".into()], None, &parameters), folder.path()).is_err());
    assert!(expand(&from_patterns(&[], None, &parameters), folder.path()).is_err());
}

#[test]
fn parameters_without_effect_are_noted() {
    let kernel = "version = 1\n[defaults]\nbake = { kernel = \"wendland\" }\n[[assets]]\nmesh = \"a\"\n";
    let found = expanded(kernel, &folder(&[])).unwrap();
    assert_eq!(found.notes, ["`kernel` has no effect: no asset has density = true"]);
    let used = format!("{kernel}[[assets]]\nmesh = \"b\"\nbake = {{ density = true }}");
    assert!(expanded(&used, &folder(&[])).unwrap().notes.is_empty());
}

#[test]
fn the_sample_manifest_names_every_sample() {
    let manifest = load(&data().join("batch.toml")).unwrap();
    let found = expand(&manifest, &data()).unwrap();
    let wanted = ["bad_holes", "canyon", "drum", "duck.near", "duck.far", "grid", "tank"];
    assert_eq!((names(&found), found.notes.len()), (wanted.to_vec(), 0));
    for asset in &found.assets {
        assert!(asset.mesh.is_file() && asset.tags[0] == "sample", "{}", asset.name);
        let container = ["drum", "tank"].contains(&asset.name.as_str());
        assert_eq!(asset.parameters.recipe().bake.map.invert, container, "{}", asset.name);
        assert_eq!(asset.gates.must_be_closed, Some(asset.name != "bad_holes"), "{}", asset.name);
    }
}

#[test]
fn files_that_are_no_manifests_are_refused() {
    let folder = folder(&["a.yaml", "empty.toml"]);
    let message = |name: &str| load(&folder.path().join(name)).unwrap_err().to_string();
    assert!(message("a.yaml").ends_with("manifests are files that end in .toml or .json"));
    assert!(message("empty.toml").contains("empty.toml:1:1: the key `version` is missing"));
    assert!(message("none.toml").contains("none.toml: No such file"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_mutation_panics(
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..12, "[-0-9a-z.*/\\[\\]{}\"=,\n# é]{0,6}"), 1..4),
        as_json in any::<bool>(),
    ) {
        let manifest = toml(MANIFEST).unwrap();
        let mut text = if as_json { serde_json::to_string_pretty(&manifest).unwrap() } else { MANIFEST.to_owned() };
        for (at, length, insert) in cuts {
            let mut characters: Vec<char> = text.chars().collect();
            let start = at.index(characters.len() + 1);
            let end = (start + length).min(characters.len());
            characters.splice(start..end, insert.chars());
            text = characters.into_iter().collect();
        }
        match if as_json { json(&text) } else { toml(&text) } {
            // What is accepted comes back the same.
            Ok(manifest) => prop_assert_eq!(json(&serde_json::to_string(&manifest).unwrap()).unwrap(), manifest),
            Err(message) => prop_assert!(message.starts_with(if as_json { "m.json:" } else { "m.toml:" }), "{message}"),
        }
    }

    #[test]
    fn no_pattern_panics(pattern in "[ab./*?\\[\\]{}!,é\\\\-]{0,12}", name in "[ab./{}a-z: ]{0,12}") {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("a.obj"), "").unwrap();
        let mut manifest = from_patterns(&[pattern], None, &Parameters::default());
        manifest.assets[0].name = Some(name);
        // Above the folder anything may lie.
        if !manifest.assets[0].mesh.0[0].contains("..") && !manifest.assets[0].mesh.0[0].starts_with('/') {
            let _ = expand(&manifest, folder.path());
        }
    }
}
