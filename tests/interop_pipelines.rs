//! Interop, pipelines: what lies in `data/pipelines`, run by the real programs on some meshes, with jobs killed midway.

mod process;
mod slurm;

use crate::interop_asset::volmap;
use process::{busy_shard, kill, shards, wait_for};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use volmap_tests::python;

/// Meshes, a manifest, and what comes of them; all names have spaces.
struct Place(tempfile::TempDir);

const MANIFEST: &str = r#"
version = 1
[defaults]
bake = { support_radius = 0.2 }
gates = { must_have_solid = false, max_sign_disagreements = 0.1 }
error_points = 20
[[assets]]
mesh = "the meshes/*"
[[assets]]
mesh = "the meshes/tank.obj"
bake = { support_radius = 0.1, invert = true }
[[assets]]
mesh = "the meshes/bad_holes.obj"
maps = [{ name = "near", bake = { support_radius = 0.1 } }, { name = "far" }]
"#;

/// As MANIFEST has them.
const ASSETS: usize = 5;

impl Place {
    fn new() -> Place {
        let place = Place(tempfile::Builder::new().prefix("a place ").tempdir().unwrap());
        std::fs::create_dir(place.at("the meshes")).unwrap();
        for (mesh, name) in
            [("drum", "a drum (old)"), ("bad_holes", "bad_holes"), ("grid", "grid"), ("tank", "tank")]
        {
            std::fs::copy(data(&format!("{mesh}.obj")), place.at(&format!("the meshes/{name}.obj"))).unwrap();
        }
        place.write("the batch.toml", MANIFEST);
        place
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().canonicalize().unwrap().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.at(name), text).unwrap();
    }

    /// What one undisturbed run makes.
    fn undisturbed(&self) -> BTreeMap<String, Vec<u8>> {
        let mut command = Command::new(volmap());
        command.current_dir(self.at("")).args(["batch", "the batch.toml", "--out", "whole", "--quiet"]);
        command.status().unwrap();
        let assets = self.assets("whole");
        assert_eq!(assets.len(), ASSETS);
        assets
    }

    /// All assets in a folder, by their names.
    fn assets(&self, out: &str) -> BTreeMap<String, Vec<u8>> {
        let entries = std::fs::read_dir(self.at(out)).unwrap().map(|entry| entry.unwrap().path());
        let assets = entries.filter(|path| path.extension().is_some_and(|ending| ending == "h5"));
        let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
        assets.map(|path| (name(&path), std::fs::read(path).unwrap())).collect()
    }

    /// How many of the joined summary's assets came to this.
    fn count(&self, out: &str, outcome: &str) -> usize {
        let text = std::fs::read(self.at(out).join("summary.json")).unwrap();
        let summary: Value = serde_json::from_slice(&text).unwrap();
        summary["assets"].as_array().unwrap().iter().filter(|asset| asset["outcome"] == outcome).count()
    }

    /// Snakemake with four shards, two at once.
    fn snakemake(&self, out: &str, more: &[&str]) -> Command {
        let mut command = Command::new(python());
        command.args(["-m", "snakemake", "-s"]).arg(data("pipelines/Snakefile")).args(["--cores", "2"]);
        command.args(more).args(["--config", "manifest=the batch.toml", "shards=4"]);
        command.arg(format!("out={}", self.at(out).display())).arg(format!("volmap={}", volmap().display()));
        command.current_dir(self.at("")).env("XDG_CACHE_HOME", self.at("cache"));
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    /// Runs it to its end; whether it ended well, and what it said.
    fn run_snakemake(&self, out: &str, more: &[&str]) -> (bool, String) {
        said(&self.snakemake(out, more).output().unwrap())
    }
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("data").join(name)
}

fn said(output: &Output) -> (bool, String) {
    let text = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes)).concat();
    (output.status.success(), text)
}

/// Whether the verification names the asset.
fn names(text: &str, asset: &str) -> bool {
    text.lines().any(|line| line.starts_with(&format!("{asset}: ")))
}

#[test]
fn snakemake_bakes_what_changed() {
    let place = Place::new();
    let whole = place.undisturbed();
    let parts = |out: &str| -> Vec<_> {
        let part = |index| place.at(out).join(format!("summary.{index}-of-4.json"));
        (1..=4).map(|index| std::fs::metadata(part(index)).unwrap().modified().unwrap()).collect()
    };
    // One that can't be baked shows at the end, with all others done, in every run.
    place.write("the meshes/broken.obj", "v 0 0\n");
    for _ in 0..2 {
        let (is_good, text) = place.run_snakemake("out", &[]);
        assert!(!is_good && names(&text, "broken"), "{text}");
        assert!(text.contains(&format!("{ASSETS} of {} assets are good", ASSETS + 1)), "{text}");
        assert_eq!(place.count("out", "failed"), 1);
        assert!(place.assets("out") == whole);
    }
    std::fs::remove_file(place.at("the meshes/broken.obj")).unwrap();
    let (is_good, text) = place.run_snakemake("out", &[]);
    assert!(is_good, "{text}");
    assert_eq!(place.count("out", "unchanged"), ASSETS);
    // Nothing changed: no shard is run.
    let before = parts("out");
    let (is_good, text) = place.run_snakemake("out", &[]);
    assert!(is_good && text.contains(&format!("{ASSETS} of {ASSETS} assets are good")), "{text}");
    assert_eq!(parts("out"), before);
    // A mesh changed; then the manifest.
    let mesh = std::fs::read_to_string(data("grid.obj")).unwrap();
    place.write("the meshes/grid.obj", &(mesh + "# changed\n"));
    let (is_good, text) = place.run_snakemake("out", &[]);
    assert!(is_good && parts("out") != before, "{text}");
    assert_eq!((place.count("out", "built"), place.count("out", "unchanged")), (1, ASSETS - 1), "{text}");
    place.write("the batch.toml", &MANIFEST.replace("support_radius = 0.1 } }", "support_radius = 0.15 } }"));
    let (is_good, text) = place.run_snakemake("out", &[]);
    assert!(is_good, "{text}");
    assert_eq!((place.count("out", "built"), place.count("out", "unchanged")), (1, ASSETS - 1), "{text}");
    damage_is_found_and_mended(&place);
}

/// In the next run; parts of another number of shards aren't joined.
fn damage_is_found_and_mended(place: &Place) {
    let before = place.assets("out");
    std::fs::write(place.at("out/tank.h5"), "no asset").unwrap();
    let (is_good, text) = place.run_snakemake("out", &[]);
    assert!(!is_good && names(&text, "tank"), "{text}");
    std::fs::write(place.at("out/summary.3-of-3.json"), "of another time").unwrap();
    let (is_good, text) = place.run_snakemake("out", &[]);
    assert!(is_good && place.count("out", "built") == 1, "{text}");
    assert!(place.assets("out") == before);
}

#[test]
fn snakemake_goes_on_after_kills() {
    let place = Place::new();
    let whole = place.undisturbed();
    // A shard: tried again in the same run.
    let run = place.snakemake("shard", &[]).spawn().unwrap();
    let shard = wait_for(30, "shard at work", || busy_shard(&volmap(), &place.at("shard")));
    assert!(kill(shard, "KILL"));
    let (is_good, text) = said(&run.wait_with_output().unwrap());
    assert!(is_good && text.contains("Killed"), "{text}");
    assert!(place.assets("shard") == whole);

    // Snakemake and its shards, as with the machine that they run on.
    let mut run = place.snakemake("all", &[]).spawn().unwrap();
    wait_for(30, "shard at work", || busy_shard(&volmap(), &place.at("all")));
    run.kill().unwrap();
    run.wait().unwrap();
    wait_for(30, "end of all shards", || {
        let shards = shards(&volmap(), &place.at("all"));
        shards.iter().for_each(|&shard| _ = kill(shard, "KILL"));
        shards.is_empty().then_some(())
    });
    assert!(place.assets("all").len() < ASSETS, "it was too late");
    let (is_good, text) = place.run_snakemake("all", &[]);
    assert!(!is_good && text.contains("--unlock"), "{text}");
    let (is_good, text) = place.run_snakemake("all", &["--unlock"]);
    assert!(is_good, "{text}");
    let (is_good, text) = place.run_snakemake("all", &["--rerun-incomplete"]);
    assert!(is_good, "{text}");
    assert!(place.assets("all") == whole);
}
