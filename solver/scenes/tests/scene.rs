//! The scene file: what is accepted, what is refused and where, and that nothing panics.

use proptest::prelude::*;
use std::path::{Path, PathBuf};
use volmap_bake::parameters::{Parameters, Scale, TABLE};
use volmap_scenes::scene::{Motion, Scene, Syntax, load, parse};

const SCENE: &str = r#"
version = 1
particle_radius = 0.025
gravity = [0, -9.81, 0]

[[blocks]]
min = [0, 0, 0]
max = [1, 1, 1]

[[bodies]]
mesh = "tank.obj"
bake = { invert = true, scale = 2 }

[[bodies]]
map = "duck.h5"
[bodies.motion.free]
density = 500.0
[bodies.material]
friction = 0.25

[solver.time_step]
max = 2e-3
"#;

fn toml(text: &str) -> Result<Scene, String> {
    parse(text, Syntax::Toml, "s.toml").map_err(|error| error.to_string())
}

fn json(text: &str) -> Result<Scene, String> {
    parse(text, Syntax::Json, "s.json").map_err(|error| error.to_string())
}

/// The error of the scene with one text replaced by another.
fn error(old: &str, new: &str) -> String {
    assert!(SCENE.contains(old), "{old}");
    toml(&SCENE.replacen(old, new, 1)).expect_err(new)
}

fn sample_scenes() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/scenes");
    let mut found: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    found.sort();
    assert!(found.len() >= 7);
    found
}

#[test]
fn what_is_given_is_read_and_the_rest_is_default() {
    let scene = toml(SCENE).unwrap();
    assert_eq!((scene.support_radius(), scene.spacing()), (0.1, 0.05));
    assert_eq!(scene.bodies[0].bake.scale, Some(Scale([2.0; 3])));
    assert_eq!(scene.bodies[0].bake.invert, Some(true));
    assert!(matches!(&scene.bodies[1].motion, Motion::Free(free) if free.density == Some(500.0)));
    assert_eq!(scene.bodies[1].material.friction, 0.25);
    assert_eq!(scene.solver.time_step.max, 2e-3);
    let rest = Scene { blocks: scene.blocks.clone(), bodies: scene.bodies.clone(), ..Scene::default() };
    assert_eq!(Scene { solver: rest.solver.clone(), ..scene }, rest);
}

#[test]
fn kernels_have_one_name_and_older_ones_are_read() {
    let with = |kernel: &str| {
        toml(&SCENE.replacen("version = 1", &format!("version = 1\nkernel = \"{kernel}\""), 1))
    };
    assert_eq!(with("cubic-spline").unwrap(), with("cubic_spline").unwrap());
    let scene = with("wendland-c2").unwrap();
    assert_eq!(scene, with("wendland_c2").unwrap());
    assert!(serde_json::to_string(&scene).unwrap().contains("\"kernel\":\"wendland_c2\""));
}

#[test]
fn toml_and_json_are_the_same() {
    let scene = toml(SCENE).unwrap();
    assert_eq!(json(&serde_json::to_string_pretty(&scene).unwrap()).unwrap(), scene);
    for path in sample_scenes() {
        let scene = load(&path).unwrap();
        assert_eq!(json(&serde_json::to_string(&scene).unwrap()).unwrap(), scene, "{}", path.display());
    }
}

/// The table of parameters is that of `volmap bake`; each row is a key here too, but for the shape, which is the
/// body's.
#[test]
fn every_parameter_of_a_bake_is_a_key() {
    for row in TABLE.iter().filter(|row| row.name != "shape") {
        let mut expected = Parameters::default();
        (row.set)(&mut expected, row.example).unwrap();
        let is_bare = row.is_flag || row.example.parse::<f64>().is_ok();
        let value = if is_bare { row.example.to_owned() } else { format!("\"{}\"", row.example) };
        let bake = format!("{} = {value}", row.name);
        let scene = toml(&SCENE.replace("invert = true, scale = 2", &bake)).unwrap();
        assert_eq!(scene.bodies[0].bake, expected, "{bake}");
    }
}

#[test]
fn unknown_keys_are_placed_and_the_likely_one_named() {
    let cases = [
        ("gravity =", "gravitty =", "s.toml:4:1: unknown key `gravitty`; did you mean `gravity`?"),
        (
            "particle_radius",
            "radius",
            "s.toml:3:1: unknown key `radius`; did you mean `particle_radius` or `support_radius`?",
        ),
        ("friction", "fricton", "s.toml:19:1: unknown key `fricton`; did you mean `friction`?"),
        ("invert", "inverted", "s.toml:12:10: unknown key `inverted`; did you mean `invert`?"),
        ("motion.free", "motion.fre", "s.toml:16:16: unknown value `fre`; did you mean `free`?"),
        ("max = 2e-3", "\n maximum = 2e-3", "s.toml:23:2: unknown key `maximum`; did you mean `max`?"),
        (
            "version = 1",
            "version = 1\nkernel = \"cubicspline\"",
            "3:10: unknown value `cubicspline`; did you mean `cubic_spline`",
        ),
    ];
    for (old, new, expected) in cases {
        assert!(error(old, new).contains(expected), "{}", error(old, new));
    }
    let far = error("friction", "colour");
    assert!(far.contains("unknown key `colour`; known here: friction, restitution"), "{far}");
}

#[test]
fn json_errors_have_places_too() {
    let text = "{ \"version\": 1, \"particle_radius\": 0.1,\n  \"bodies\": [\n    { \"mesh\": \"a.obj\",\n      \
        \"materiel\": {} } ] }";
    let error = json(text).unwrap_err();
    assert_eq!(error, "s.json:4:7: unknown key `materiel`; did you mean `material`?");
    let error = json(&text.replace("materiel\": {}", "material\": { \"friction\": -1 }")).unwrap_err();
    assert_eq!(error, "s.json:4:21: bodies[0].material.friction: -1 is negative");
    let error = json(&text.replace("\"a.obj\"", "7")).unwrap_err();
    assert!(error.starts_with("s.json:3:") && error.contains("invalid type: integer `7`"), "{error}");
    assert!(json("{").unwrap_err().starts_with("s.json:1:"));
}

#[test]
fn wrong_types_are_placed() {
    let cases = [
        ("0.025", "\"small\"", "s.toml:3:19: invalid type: string \"small\", expected f64"),
        ("[0, -9.81, 0]", "[0, -9.81]", "s.toml:4:11: invalid length 2"),
        ("scale = 2", "scale = [1, 2]", "s.toml:12:33: invalid value `1,2`: give S, or SX,SY,SZ"),
        ("invert = true", "invert = 1", "s.toml:12:19: invalid type: integer `1`, expected a boolean"),
        ("version = 1\n", "", "the key `version` is missing"),
        ("[bodies.motion.free]\ndensity = 500.0", "motion = \"free\"", "needs a table with its settings"),
    ];
    for (old, new, expected) in cases {
        assert!(error(old, new).contains(expected), "{}", error(old, new));
    }
}

#[test]
fn values_out_of_range_are_named_and_placed() {
    let cases = [
        ("0.025", "-0.025", "s.toml:3:1: particle_radius: -0.025 is not within"),
        ("0.025", "nan", "particle_radius: NaN is not within"),
        (
            "0.025",
            "0.025\nsupport_radius = 0.02",
            "s.toml:4:1: support_radius: 0.02 m is 0.80 particle radii",
        ),
        (
            "0.025",
            "0.025\nkernel = \"spiky\"\nsupport_radius = 0.075",
            "0.075 m is 3.00 particle radii; kernel spiky needs 3.5 to 10",
        ),
        (
            "0.025",
            "0.025\nkernel = \"poly6\"",
            "s.toml:4:1: kernel: water doesn't stay at rest with poly6; take cubic_spline, wendland_c2 or spiky",
        ),
        (
            "0.025",
            "0.025\nsupport_radius = 0.1125",
            "0.1125 m is 4.50 particle radii; kernel cubic_spline takes 3.5 to 4, as a rule 4: with more, water \
             doesn't stay at rest; kernel = \"wendland_c2\" takes more",
        ),
        ("-9.81", "inf", "s.toml:4:1: gravity: inf is not a usable number"),
        ("max = [1, 1, 1]", "max = [1, 0, 1]", "s.toml:8:1: blocks[0].max: [1.0, 0.0, 1.0] is not above min"),
        ("max = [1, 1, 1]", "max = [1, 0.01, 1]", "thinner than a particle"),
        ("max = [1, 1, 1]", "max = [1e4, 1e4, 1e4]", "particles, more than 100,000,000"),
        ("500.0", "0", "s.toml:17:1: bodies[1].motion.free.density: 0 is not positive"),
        ("500.0", "1\nmass = 2", "bodies[1].motion.free: give `density` (kg/m^3) or `mass` (kg)"),
        ("max = 2e-3", "min = 0.01", "s.toml:22:1: solver.time_step.min: 0.01 s is more than max, 0.002 s"),
        ("max = 2e-3", "initial = 1.0", "solver.time_step.initial: 1 s is not within"),
        (
            "0.25",
            "0.25\nrestitution = 2",
            "s.toml:20:1: bodies[1].material.restitution: 2 is not within 0 to 1",
        ),
        ("map = \"duck.h5\"\n", "", "s.toml:14:1: bodies[1]: give `map`, an asset, or `mesh`"),
        ("map = \"duck.h5\"", "map = \"a\"\nmesh = \"b\"", "bodies[1].mesh: give `map` or `mesh`, not both"),
        ("map = \"duck.h5\"", "map = \"a\"\nbake = { invert = true }", "bodies[1].bake: is for meshes"),
        ("scale = 2", "scale = [1, 0, 1]", "s.toml:12:25: bodies[0].bake.scale: is 0"),
        (
            "invert = true",
            "resolution = 9, cell_size = 1",
            "bodies[0].bake.cell_size: can't be used with `resolution`",
        ),
        ("map = \"duck.h5\"", "map = \"a\"\nrotation = { degrees = 9 }", "give `axis` and `degrees`"),
        ("map = \"duck.h5\"", "map = \"a\"\nname = \"../x\"", "bodies[1].name: use letters"),
        ("[bodies.motion.free]\ndensity = 500.0", "[bodies.motion]\nkeyframes = []", "there are none"),
        (
            "[solver.time_step]\nmax = 2e-3",
            "[fluid]\nrest_density = 0",
            "fluid.rest_density: 0 is not positive",
        ),
        (
            "0.25",
            "0.25\nfluid_viscosity = -1",
            "s.toml:20:1: bodies[1].material.fluid_viscosity: -1 is negative",
        ),
        ("0.25", "0.25\nfluid_friction = -1", "bodies[1].material.fluid_friction: -1 is negative"),
        (
            "[solver.time_step]\nmax = 2e-3",
            "[fluid]\nviscosity_method = \"implicid\"",
            "unknown value `implicid`; did you mean `implicit`?",
        ),
        (
            "[solver.time_step]\nmax = 2e-3",
            "[solver.viscosity]\nmax_error = 0",
            "solver.viscosity.max_error: 0 is not positive",
        ),
        (
            "[solver.time_step]\nmax = 2e-3",
            "[solver.viscosity]\nmax_passes = 0",
            "solver.viscosity.max_passes: 0 passes solve nothing; 1 solves for viscosity and density once each",
        ),
        (
            "max = 2e-3",
            "max = 2e-3\n[fluid]\nviscosity = 100",
            "viscosity_method = \"implicit\" takes longer ones",
        ),
        ("[solver.time_step]\nmax = 2e-3", "[stop]\ntime = -1", "stop.time: -1 is not positive"),
    ];
    for (old, new, expected) in cases {
        assert!(error(old, new).contains(expected), "{}", error(old, new));
    }
}

#[test]
fn a_later_version_is_told_before_its_keys() {
    let error = error("version = 1", "version = 2\nnovelty = true");
    assert!(error.contains("is of version 2; this program reads 1"), "{error}");
    assert!(toml("version = 2\nparticle_radius = 1.0").unwrap_err().contains("version"));
}

#[test]
fn files_that_are_no_scenes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        load(&path).unwrap_err().to_string()
    };
    assert!(write("scene.yaml", b"").contains(".toml or .json"));
    assert!(write("scene.toml", &[0xff, 0xfe, 0]).contains("UTF-8"));
    assert!(write("large.toml", &vec![b'#'; (16 << 20) + 1]).contains("at most"));
    assert!(write("deep.json", "[".repeat(100_000).as_bytes()).contains("deep.json:1:"));
    assert!(write("deep.toml", format!("a = {}", "[".repeat(100_000)).as_bytes()).contains("deep.toml:1:"));
    assert!(load(&folder.path().join("none.toml")).unwrap_err().to_string().contains("none.toml"));
}

/// After a change of the format: `volmap-sim schema > solver/scene.schema.json`.
#[test]
fn published_schema_is_that_of_the_program() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scene.schema.json");
    let published: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    assert!(published == Scene::schema(), "solver/scene.schema.json is old");
    // Every key of the scene is described.
    let keys = published["properties"].as_object().unwrap();
    assert!(keys.len() >= 15 && keys.values().all(|key| key["description"].is_string()));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_mutation_panics(
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0_usize..12, "[-0-9a-z.\\[\\]{}\"=,\n# é]{0,6}"), 1..4),
        as_json in any::<bool>(),
    ) {
        let scene = toml(SCENE).unwrap();
        let mut text = if as_json { serde_json::to_string_pretty(&scene).unwrap() } else { SCENE.to_owned() };
        for (at, length, insert) in cuts {
            let mut characters: Vec<char> = text.chars().collect();
            let start = at.index(characters.len() + 1);
            let end = (start + length).min(characters.len());
            characters.splice(start..end, insert.chars());
            text = characters.into_iter().collect();
        }
        match if as_json { json(&text) } else { toml(&text) } {
            // What is accepted can be used.
            Ok(scene) => prop_assert!(scene.validate().is_ok()),
            Err(message) => prop_assert!(message.starts_with(if as_json { "s.json:" } else { "s.toml:" }), "{message}"),
        }
    }

    #[test]
    fn no_numbers_panic(numbers in prop::collection::vec(any::<f64>(), 9), count in any::<u64>()) {
        let mut scene = toml(SCENE).unwrap();
        let n = |i: usize| numbers[i % 9];
        scene.particle_radius = n(0);
        scene.support_radius = (count % 2 == 0).then_some(n(1));
        scene.blocks[0].min = [n(2), n(3), n(4)];
        scene.blocks[0].max = [n(5), n(6), n(7)];
        scene.bodies[0].bake.scale = Some(Scale([n(8), n(0), n(1)]));
        scene.stop.steps = Some(count);
        if scene.validate().is_ok() {
            prop_assert!(scene.particle_radius > 0.0 && scene.blocks[0].min[0] < scene.blocks[0].max[0]);
        }
    }
}

#[test]
fn defaults_give_way_to_what_is_given() {
    let scene = |table: &str| toml(&SCENE.replace("[solver.time_step]\nmax = 2e-3", table)).unwrap();
    let step = |table: &str| scene(&format!("[solver.time_step]\n{table}")).solver.time_step;
    assert_eq!(step("max = 5e-4").initial, 5e-4);
    let short = step("max = 5e-5");
    assert_eq!((short.initial, short.min, short.max), (5e-5, 5e-5, 5e-5));
    assert_eq!(step("initial = 2e-5").min, 2e-5);
    assert_eq!(step("min = 1.5e-3").initial, 1.5e-3);
    assert_eq!(step("adaptive = false").initial, 1e-3);
    // What is given isn't changed.
    let refused = |old: &str, new: &str| toml(&SCENE.replace(old, new)).unwrap_err();
    let told = refused("max = 2e-3", "max = 5e-4\ninitial = 1e-3");
    assert!(told.contains("solver.time_step.initial: 0.001 s is not within"), "{told}");

    // The default viscosity against the steps that small particles need.
    let small = SCENE.replace("0.025", "0.001").replace("max = [1, 1, 1]", "max = [0.02, 0.02, 0.02]");
    let scene = toml(&small).unwrap();
    assert_eq!(scene.fluid.viscosities(), [0.0, 0.01]);
    assert!(
        scene.notes[0].contains("fluid.viscosity isn't given: its default, 0.01 m^2/s"),
        "{:?}",
        scene.notes
    );
    assert_eq!(toml(SCENE).unwrap().notes, Vec::<String>::new());
    let thin = toml(&format!("{small}[fluid]\nviscosity = 1e-6")).unwrap();
    assert_eq!(thin.fluid.viscosities(), [1e-6, 0.0]);
    let told = toml(&format!("{small}[fluid]\nviscosity_method = \"explicit\"")).unwrap_err();
    assert!(told.contains("0.01 m^2/s, the default, needs time steps of at most"), "{told}");
    let told = toml(&format!("{small}[fluid]\nviscosity = 0.02")).unwrap_err();
    assert!(told.contains("0.02 m^2/s needs time steps of at most"), "{told}");
}

#[test]
fn velocities_along_fixed_axes_are_refused() {
    let with = |more: &str| SCENE.replace("density = 500.0", &format!("density = 500.0\n{more}"));
    for (more, expected) in [
        (
            "velocity = [0, 1.5, 0]\nfixed_translation = [false, true, false]",
            "bodies[1].motion.free.velocity: 1.5 for y, which fixed_translation fixes",
        ),
        (
            "angular_velocity = [0, 0, -5]\nfixed_rotation = [true, true, true]",
            "bodies[1].motion.free.angular_velocity: -5 for z, which fixed_rotation fixes",
        ),
    ] {
        let error = toml(&with(more)).unwrap_err();
        assert!(error.contains(expected), "{error}");
    }
    assert!(toml(&with("velocity = [1, 0, 0]\nfixed_translation = [false, true, true]")).is_ok());
}
