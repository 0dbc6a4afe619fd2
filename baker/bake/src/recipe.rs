//! From parameters, given or not, to all settings of a bake.

use crate::bake::BakeSettings;
use crate::density_map::DensitySettings;
use crate::input::InputSettings;
use crate::parameters::{CompressionName, Numbers, Parameters, PrecisionName, Sign, Up};
use crate::plan::{GridChoice, Precision, Settings};
use crate::sdf::SignMethod;
use std::collections::BTreeMap;
use std::fmt::Debug;
use volmap_formats::asset::Compression;
use volmap_formats::mesh::{Placement, Rotation, UpAxis};

/// All that an asset depends on beside the mesh's file.
#[derive(Clone, Debug, PartialEq)]
pub struct Recipe {
    /// How the mesh is read.
    pub input: InputSettings,
    /// How it is baked.
    pub bake: BakeSettings,
    /// How the asset is compressed.
    pub compression: Compression,
}

impl Parameters {
    /// The settings that follow from the parameters. The limit on memory is the default: it doesn't change an asset.
    pub fn recipe(&self) -> Recipe {
        Recipe {
            input: self.input(),
            bake: BakeSettings {
                map: self.map(),
                sign: match self.sign.unwrap_or_default() {
                    Sign::Auto => SignMethod::Auto,
                    Sign::Pseudonormal => SignMethod::Pseudonormal,
                    Sign::Winding => SignMethod::Winding,
                },
                keep_orientation: self.keep_orientation.unwrap_or(false),
                check_sign: self.check_sign.unwrap_or(false),
            },
            compression: match self.compression.unwrap_or_default() {
                // Numbers of 16 bits gain 5 % from a higher level, others less than 1 %.
                CompressionName::Zstd if self.max_rounding.is_some() => Compression::Zstd(5),
                other => other.into(),
            },
        }
    }

    fn input(&self) -> InputSettings {
        let rotation = self.rotate.map_or(Placement::default().rotation, |Numbers([x, y, z, degrees])| {
            Rotation { axis: [x, y, z], degrees }
        });
        let up_axis = match self.up.unwrap_or_default() {
            Up::X => UpAxis::X,
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        };
        InputSettings {
            unit: self.unit.map(|unit| unit.0),
            placement: Placement {
                unit: 1.0,
                up_axis,
                scale: self.scale.map_or([1.0; 3], |scale| scale.0),
                rotation,
                translation: self.translate.map_or([0.0; 3], |Numbers(t)| t),
            },
            weld_tolerance: self.weld.unwrap_or(0.0),
        }
    }

    fn map(&self) -> Settings {
        let grid = match (self.resolution, self.cell_size, self.tolerance) {
            (Some(cells), ..) => GridChoice::Resolution(cells.0),
            (_, Some(edge), _) => GridChoice::CellSize(edge),
            (.., Some(part)) => GridChoice::Tolerance(part.0),
            _ => GridChoice::FromRadius,
        };
        let corners = |Numbers([a, b, c, d, e, f]): Numbers<6>| [[a, b, c], [d, e, f]];
        let density = DensitySettings::default();
        Settings {
            support_radius: self.support_radius.or(self.particle_radius.map(|radius| 4.0 * radius)),
            grid,
            domain: self.domain.map(corners),
            padding: self.padding.unwrap_or(0.0),
            invert: self.invert.unwrap_or(false),
            thickness: self.thickness.unwrap_or(0.0),
            rule: self.quadrature.unwrap_or_default(),
            density: self.density.unwrap_or(false).then(|| DensitySettings {
                kernel: self.kernel.unwrap_or(density.kernel),
                rule: self.density_quadrature.unwrap_or(density.rule),
                ..density
            }),
            precision: precision(self.max_rounding.map(|part| part.0), self.precision.unwrap_or_default()),
            max_memory: Settings::default().max_memory,
        }
    }
}

/// Rounded to a part, or by name.
pub fn precision(max_rounding: Option<f64>, name: PrecisionName) -> Precision {
    match (max_rounding, name) {
        (Some(part), _) => Precision::Rounded(part),
        (None, PrecisionName::F32) => Precision::F32,
        (None, PrecisionName::F64) => Precision::F64,
    }
}

impl From<CompressionName> for Compression {
    fn from(name: CompressionName) -> Compression {
        match name {
            CompressionName::Zstd => Compression::default(),
            CompressionName::Gzip => Compression::Gzip(6),
        }
    }
}

impl Recipe {
    /// Every parameter by its option's name, given or by default, as a text that differs whenever the value does: what a
    /// content key is made of. `auto` is what the mesh decides; a particle radius stands as the support radius.
    pub fn effective(&self) -> BTreeMap<String, String> {
        let (map, placement) = (&self.bake.map, &self.input.placement);
        let grid = |choice: Option<String>| choice.unwrap_or_else(|| "auto".into());
        let rotation = placement.rotation;
        let [resolution, cell_size, tolerance] = match map.grid {
            GridChoice::FromRadius => [None, None, None],
            GridChoice::Resolution(cells) => [Some(format!("{cells:?}")), None, None],
            GridChoice::CellSize(edge) => [None, Some(format!("{edge:?}")), None],
            GridChoice::Tolerance(part) => [None, None, Some(format!("{part:?}"))],
        };
        let (precision, max_rounding) = match map.precision {
            Precision::F32 => ("f32", None),
            Precision::F64 => ("f64", None),
            Precision::Rounded(part) => ("i16", Some(part)),
        };
        let pairs = [
            ("support_radius", or_auto(map.support_radius)),
            ("resolution", grid(resolution)),
            ("cell_size", grid(cell_size)),
            ("tolerance", grid(tolerance)),
            ("domain", or_auto(map.domain)),
            ("padding", format!("{:?}", map.padding)),
            ("invert", map.invert.to_string()),
            ("thickness", format!("{:?}", map.thickness)),
            ("quadrature", map.rule.to_string()),
            ("density", map.density.is_some().to_string()),
            ("kernel", map.density.map_or("none".into(), |density| density.kernel.to_string())),
            ("density_quadrature", map.density.map_or("none".into(), |density| density.rule.to_string())),
            (
                "density_extension",
                map.density.map_or("none".into(), |density| format!("{:?}", density.extension)),
            ),
            ("sign", format!("{:?}", self.bake.sign).to_lowercase()),
            ("check_sign", self.bake.check_sign.to_string()),
            ("keep_orientation", self.bake.keep_orientation.to_string()),
            ("unit", or_auto(self.input.unit)),
            ("up", format!("{:?}", placement.up_axis).to_lowercase()),
            ("scale", format!("{:?}", placement.scale)),
            ("rotate", format!("{:?} {:?}", rotation.axis, rotation.degrees)),
            ("translate", format!("{:?}", placement.translation)),
            ("weld", format!("{:?}", self.input.weld_tolerance)),
            ("precision", precision.into()),
            ("max_rounding", max_rounding.map_or("none".into(), |part| format!("{part:?}"))),
            ("compression", format!("{:?}", self.compression).to_lowercase()),
        ];
        pairs.map(|(name, value)| (name.to_owned(), value)).into()
    }
}

fn or_auto(value: Option<impl Debug>) -> String {
    value.map_or("auto".into(), |value| format!("{value:?}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Mistake;
    use clap::{Args, Command, FromArgMatches};

    /// Every option with a value that isn't its default.
    const OTHERS: [(&str, &str); 25] = [
        ("support-radius", "0.1"),
        ("particle-radius", "0.02"),
        ("resolution", "40,30,20"),
        ("cell-size", "0.03"),
        ("tolerance", "2%"),
        ("domain", "0,0,0,1,2,3"),
        ("padding", "0.5"),
        ("invert", "true"),
        ("thickness", "-0.1"),
        ("quadrature", "gl30"),
        ("density", "true"),
        ("kernel", "wendland"),
        ("density-quadrature", "gl30"),
        ("sign", "winding"),
        ("check-sign", "true"),
        ("keep-orientation", "true"),
        ("unit", "mm"),
        ("up", "z"),
        ("scale", "1,2,3"),
        ("rotate", "1,0,0,90"),
        ("translate", "0.1,0.2,0.3"),
        ("weld", "1e-3"),
        ("precision", "f64"),
        ("max-rounding", "0.01%"),
        ("compression", "gzip"),
    ];

    fn command() -> Command {
        Parameters::augment_args(Command::new("volmap").no_binary_name(true))
    }

    fn parse(words: &[String]) -> Parameters {
        Parameters::from_arg_matches(&command().get_matches_from(words)).unwrap()
    }

    /// Options that belong to a density come with one.
    fn with_base(name: &str, value: Option<&str>) -> Parameters {
        let of_density = ["kernel", "density-quadrature"].contains(&name);
        let base = of_density.then(|| "--density".to_owned());
        parse(&base.into_iter().chain(value.map(|value| format!("--{name}={value}"))).collect::<Vec<_>>())
    }

    #[test]
    fn each_option_changes_what_is_effective() {
        let command = command();
        let options: Vec<_> = command.get_arguments().filter_map(|arg| arg.get_long()).collect();
        assert_eq!(options, OTHERS.map(|(name, _)| name));
        for (name, value) in OTHERS {
            let effective = |value| with_base(name, value).recipe().effective();
            assert_ne!(effective(Some(value)), effective(None), "{name}");
        }
    }

    #[test]
    fn a_default_that_is_given_changes_nothing() {
        let mut defaults = 0;
        for arg in command().get_arguments() {
            let (name, help) = (arg.get_long().unwrap(), arg.get_help().unwrap().to_string());
            let words = help.rsplit_once("[default: ").map(|(_, rest)| rest.trim_end_matches(']').to_owned());
            let flag = arg.get_num_args().is_some_and(|count| count.min_values() == 0);
            let default =
                if flag { Some("false".to_owned()) } else { words.filter(|text| !text.contains(' ')) };
            let Some(default) = default else { continue };
            assert_eq!(with_base(name, Some(&default)).recipe(), with_base(name, None).recipe(), "{name}");
            defaults += 1;
        }
        assert_eq!(defaults, 14);
        let given = ["--scale=1", "--rotate=0,1,0,0", "--translate=0,0,0"].map(String::from);
        assert_eq!(parse(&given).recipe(), Parameters::default().recipe());
    }

    #[test]
    fn files_say_the_same_as_the_command_line() {
        for (name, value) in OTHERS {
            let given = with_base(name, Some(value));
            let json = serde_json::to_string(&given).unwrap();
            assert_eq!(serde_json::from_str::<Parameters>(&json).unwrap(), given, "{json}");
        }
        let numbers = r#"{"scale": 2, "unit": 0.001, "resolution": [40, 30, 20], "invert": true,
            "domain": [0, 0, 0, 1, 1, 1], "quadrature": "gl30", "sign": "winding", "max_rounding": "0.01%"}"#;
        let words = "--scale=2,2,2 --unit=mm --resolution=40,30,20 --invert --domain=0,0,0,1,1,1 \
                     --quadrature=gl30 --sign=winding --max-rounding=1e-4";
        let words: Vec<_> = words.split_whitespace().map(String::from).collect();
        assert_eq!(parse_json(numbers).unwrap(), parse(&words));
        let [number, part] = [r#"{"tolerance": 0.01}"#, r#"{"tolerance": "1%"}"#].map(parse_json);
        assert_eq!(number.unwrap(), part.unwrap());
        for (text, message) in [
            (r#"{"tolerance": 2}"#, "invalid value `2`: give 0.05% to 50%, or the same as a number, as 0.01"),
            (r#"{"resolution": [1, 2]}"#, "invalid value `1,2`: give N, or NX,NY,NZ"),
            (r#"{"quadrature": "x"}"#, "invalid value `x`: `x` is no quadrature; take"),
            (r#"{"unit": true}"#, "give a number, a list of numbers, or a text as on the command line"),
            (r#"{"sgin": "auto"}"#, "unknown field `sgin`"),
        ] {
            let error = parse_json(text).unwrap_err().to_string();
            assert!(error.starts_with(message), "{error}");
        }
    }

    fn parse_json(text: &str) -> serde_json::Result<Parameters> {
        serde_json::from_str(text)
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
        // Every option reaches through, and none but itself and its group.
        for (name, value) in OTHERS {
            let given = with_base(name, Some(value));
            assert_eq!(given.over(&Parameters::default()), given, "{name}");
            assert_eq!(Parameters::default().over(&given), given, "{name}");
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
            (
                r#"{"max_rounding": 0.1, "precision": "f64"}"#,
                "max_rounding",
                "can't be used with `precision`",
            ),
            (r#"{"density": false, "kernel": "cubic"}"#, "kernel", "has no effect with density = false"),
            (r#"{"support_radius": 0}"#, "support_radius", "0 is not positive"),
            (r#"{"padding": -1}"#, "padding", "-1 is negative"),
            (r#"{"thickness": 1e300}"#, "thickness", "is not a usable length"),
            (r#"{"domain": [0, 0, 0, 1, 0, 1]}"#, "domain", "is not a box"),
        ] {
            let Mistake { key: found, reason: why } = parse_json(text).unwrap().check().unwrap_err();
            assert_eq!(found, key);
            assert!(why.contains(reason), "{why}");
        }
        for (name, value) in OTHERS {
            assert_eq!(with_base(name, Some(value)).check(), Ok(()), "{name}");
        }
        let not_a_number = Parameters { weld: Some(f64::NAN), ..Parameters::default() };
        assert_eq!(not_a_number.check().unwrap_err().key, "weld");
    }
}
