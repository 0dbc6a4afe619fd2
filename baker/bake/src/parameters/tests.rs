use super::*;
use crate::bake::bake;
use crate::input::{Input, from_bytes, from_shape};
use crate::watch::Watch;
use std::collections::BTreeSet;

/// A tetrahedron whose triangles don't all run the same way round.
const TETRAHEDRON: &[u8] = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 3 4\n";

/// Parameters from texts, as on the command line.
fn parse(pairs: &[(&str, &str)]) -> Parameters {
    let mut out = Parameters::default();
    for (name, text) in pairs {
        let row = TABLE.iter().find(|row| row.name == *name).unwrap_or_else(|| panic!("no {name}"));
        (row.set)(&mut out, text).unwrap_or_else(|error| panic!("{name} {text}: {error}"));
    }
    out
}

/// The row's parameter, with the flag that it needs.
fn with_needs(row: &Parameter, text: Option<&str>) -> Parameters {
    // Coarse cells, where they are found by measuring.
    let flag = match row.name {
        "distance_tolerance" | "normal_tolerance" => Some(("tolerance", "30%")),
        _ => row.needs.map(|flag| (flag, "true")),
    };
    parse(&flag.into_iter().chain(text.map(|text| (row.name, text))).collect::<Vec<_>>())
}

fn parse_json(text: &str) -> serde_json::Result<Parameters> {
    serde_json::from_str(text)
}

#[test]
fn every_row_is_complete() {
    let names: BTreeSet<_> = TABLE.iter().map(|row| row.name).collect();
    assert_eq!((names.len(), TABLE.len()), (30, 30));
    for row in TABLE {
        let sentence = row.help.trim();
        assert!(sentence.len() > 10 && !sentence.ends_with('.'), "{}: {sentence}", row.name);
        assert!(!row.placeholder.is_empty() && !row.example.is_empty(), "{}", row.name);
        assert!(row.needs.is_none_or(|flag| TABLE.iter().any(|row| row.name == flag && row.is_flag)));
        assert!(row.words.is_empty() || row.words.contains(&row.example), "{}", row.name);
    }
}

#[test]
fn every_row_changes_the_settings_and_the_content_key() {
    for row in TABLE {
        let recipe = |text| with_needs(row, text).recipe();
        assert_ne!(recipe(Some(row.example)), recipe(None), "{}", row.name);
        assert_ne!(recipe(Some(row.example)).effective(), recipe(None).effective(), "{}", row.name);
    }
}

/// The tetrahedron, or the shape that is asked for.
fn input(recipe: &Recipe) -> Input {
    match recipe.input.shape {
        Some(shape) => from_shape(shape, &recipe.input).unwrap(),
        None => from_bytes("t.obj".as_ref(), TETRAHEDRON, &recipe.input).unwrap(),
    }
}

/// Attributes of a bake, its diagnosis and its file.
fn asset(parameters: &Parameters) -> (Attributes, Attributes, Vec<u8>) {
    // Small and coarse where nothing else is asked for.
    let coarse = parse_json(
        r#"{"cell_size": 0.4, "support_radius": 0.4, "quadrature": "chord2", "density_quadrature": "chord8"}"#,
    );
    let recipe = parameters.over(&coarse.unwrap()).recipe();
    let asset = bake(input(&recipe), &recipe.bake, &Watch::default()).unwrap().asset;
    let bytes = volmap_formats::asset::encode(&asset, recipe.compression).unwrap();
    (asset.bake, asset.diagnosis, bytes)
}

#[test]
fn every_row_stands_in_the_asset() {
    for row in TABLE {
        // Radii that keep the bake small.
        let text = match row.name {
            "support_radius" => "0.5",
            "particle_radius" => "0.15",
            "cell_size" => "0.3",
            "tolerance" => "30%",
            "distance_tolerance" => "200%",
            "max_rounding" => "1%",
            "unit" => "2",
            _ => row.example,
        };
        let (given, default) = (asset(&with_needs(row, Some(text))), asset(&with_needs(row, None)));
        match row.name {
            // HDF5's filters say it.
            "compression" => assert_ne!(given.2, default.2),
            // What it finds is part of the diagnosis.
            "check_sign" => assert_ne!(given.1, default.1),
            name => assert_ne!(given.0, default.0, "{name}"),
        }
    }
}

#[test]
fn what_an_asset_says_of_its_placement_is_read_back() {
    for row in TABLE.iter().filter(|row| row.section == Section::Mesh) {
        let recipe = with_needs(row, Some(row.example)).recipe();
        let input = input(&recipe);
        let settings = recipe.bake;
        let (bake, ..) = asset(&with_needs(row, Some(row.example)));
        let restored = restore(&bake).unwrap();
        let unit = Some(input.placement.unit);
        assert_eq!(restored, InputSettings { unit, ..recipe.input }, "{}", row.name);
        assert_eq!(flag(&bake, "keep_orientation"), Ok(Some(settings.keep_orientation)));
    }
    assert_eq!(restore(&Attributes::new()), Ok(InputSettings::default()));
    let strange = [("up_axis".to_owned(), Value::from("w"))].into();
    assert_eq!(restore(&strange), Err("up_axis"));
}

#[test]
fn a_default_that_is_given_changes_nothing() {
    let mut defaults = 0;
    for row in TABLE {
        let default = if row.is_flag { "false" } else { row.default };
        if default.is_empty() || default.contains(' ') {
            continue;
        }
        assert_eq!(with_needs(row, Some(default)).recipe(), with_needs(row, None).recipe(), "{}", row.name);
        defaults += 1;
    }
    assert_eq!(defaults, 15);
    let given = parse(&[("scale", "1"), ("rotate", "0,1,0,0"), ("translate", "0,0,0")]);
    assert_eq!(given.recipe(), Parameters::default().recipe());
}

#[test]
fn documents_say_the_same_as_texts() {
    for row in TABLE {
        let given = with_needs(row, Some(row.example));
        let json = serde_json::to_string(&given).unwrap();
        assert_eq!(parse_json(&json).unwrap(), given, "{json}");
        assert_eq!(toml::from_str::<Parameters>(&toml::to_string(&given).unwrap()).unwrap(), given, "{json}");
    }
    let numbers = r#"{"scale": 2, "unit": 0.001, "resolution": [40, 30, 20], "invert": true,
        "domain": [0, 0, 0, 1, 1, 1], "quadrature": "gl30", "sign": "winding", "max_rounding": "0.01%"}"#;
    let texts = [
        ("scale", "2,2,2"),
        ("unit", "mm"),
        ("resolution", "40,30,20"),
        ("invert", "true"),
        ("domain", "0,0,0,1,1,1"),
        ("quadrature", "gl30"),
        ("sign", "winding"),
        ("max_rounding", "1e-4"),
    ];
    assert_eq!(parse_json(numbers).unwrap(), parse(&texts));
    let [number, part] = [r#"{"tolerance": 0.01}"#, r#"{"tolerance": "1%"}"#].map(parse_json);
    assert_eq!(number.unwrap(), part.unwrap());
    for (text, message) in [
        (r#"{"tolerance": 2}"#, "invalid value `2`: give 0.05% to 50%, or the same as a number, as 0.01"),
        (r#"{"resolution": [1, 2]}"#, "invalid value `1,2`: give N, or NX,NY,NZ"),
        (r#"{"quadrature": "x"}"#, "invalid value `x`: `x` is no quadrature; take"),
        (r#"{"unit": true}"#, "give a number, a list of numbers, or a text as on the command line"),
        (r#"{"sgin": "auto"}"#, "unknown field `sgin`"),
        (r#"{"sign": "wind"}"#, "unknown variant `wind`"),
        (r#"{"padding": "wide"}"#, "invalid type: string \"wide\", expected f64"),
    ] {
        let error = parse_json(text).unwrap_err().to_string();
        assert!(error.starts_with(message), "{error}");
    }
}

#[test]
fn what_is_given_later_wins_and_drops_what_it_excludes() {
    let base =
        parse_json(r#"{"particle_radius": 0.1, "tolerance": 0.01, "precision": "f64", "invert": true}"#);
    let base = base.unwrap();
    assert_eq!(Parameters::default().over(&base), base);
    assert_eq!(base.over(&Parameters::default()), base);
    let given =
        parse_json(r#"{"support_radius": 0.2, "cell_size": 0.1, "max_rounding": 1e-4, "invert": false}"#);
    let given = given.unwrap();
    assert_eq!(given.over(&base), given);
    assert_eq!(base.over(&given), base);
    // Every parameter reaches through, and none but itself and its group.
    for row in TABLE {
        let given = with_needs(row, Some(row.example));
        assert_eq!(given.over(&Parameters::default()), given, "{}", row.name);
        assert_eq!(Parameters::default().over(&given), given, "{}", row.name);
    }
}

#[test]
fn contradictions_and_impossible_values_are_told() {
    for (text, key, reason) in [
        (
            r#"{"particle_radius": 1, "support_radius": 4}"#,
            "particle_radius",
            "can't be used with `support_radius`",
        ),
        (r#"{"tolerance": 0.1, "cell_size": 4}"#, "tolerance", "can't be used with `cell_size`"),
        (r#"{"max_rounding": 0.1, "precision": "f64"}"#, "max_rounding", "can't be used with `precision`"),
        (r#"{"density": false, "kernel": "cubic"}"#, "kernel", "has no effect with density = false"),
        (r#"{"support_radius": 0}"#, "support_radius", "0 is not positive"),
        (r#"{"padding": -1}"#, "padding", "-1 is negative"),
        (r#"{"thickness": 1e300}"#, "thickness", "is not a usable length"),
        (r#"{"scale": [1, 0, 1]}"#, "scale", "is 0"),
        (r#"{"domain": [0, 0, 0, 1, 0, 1]}"#, "domain", "is not a box"),
    ] {
        let Mistake { key: found, reason: why } = parse_json(text).unwrap().check().unwrap_err();
        assert_eq!(found, key);
        assert!(why.contains(reason), "{why}");
    }
    for row in TABLE {
        assert_eq!(with_needs(row, Some(row.example)).check(), Ok(()), "{}", row.name);
    }
    let not_a_number = Parameters { weld: Some(f64::NAN), ..Parameters::default() };
    assert_eq!(not_a_number.check().unwrap_err().key, "weld");
}
