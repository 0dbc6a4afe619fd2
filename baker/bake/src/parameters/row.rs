//! What a row of the table of parameters holds, and the macro that makes a table of rows.

use super::Parameters;
use super::range::Range;
use crate::input::{Input, InputSettings};
use crate::recipe::{BakeSettings, Recipe};
use crate::summary::Summary;
use volmap_formats::asset::{Attributes, Value};

/// One parameter of a bake, whatever the type of its value.
#[derive(Clone, Copy, Debug)]
pub struct Parameter {
    /// Its key in manifests and scenes. The command line's option has `-` for `_`.
    pub name: &'static str,
    /// What it does, in one sentence without an end mark.
    pub help: &'static str,
    /// Unit of its numbers, in words; empty if they have none, or the help says it.
    pub unit: &'static str,
    /// What holds if it isn't given, in words; empty for flags, and where nothing is changed then.
    pub default: &'static str,
    /// What stands for the value in help texts.
    pub placeholder: &'static str,
    /// A value that isn't the default, as a text.
    pub example: &'static str,
    /// What it belongs to.
    pub section: Section,
    /// What its numbers may be.
    pub range: Range,
    /// At most one parameter of a group may be given.
    pub group: Option<Group>,
    /// Other parameters that can't be given beside it.
    pub excludes: &'static [&'static str],
    /// The flag without which it has no effect.
    pub needs: Option<&'static str>,
    /// The words that its value may be, if it is one of a few.
    pub words: &'static [&'static str],
    /// Whether it is true or false.
    pub is_flag: bool,
    /// Reads a value from a text, as on the command line.
    pub set: fn(&mut Parameters, &str) -> Result<(), String>,
    /// Whether it is given.
    pub is_given: fn(&Parameters) -> bool,
    /// Its numbers, if it is given and has some.
    pub(super) numbers: fn(&Parameters) -> Vec<f64>,
    /// Whether it is true, if it is given and a flag.
    pub(super) flag: fn(&Parameters) -> Option<bool>,
    /// Copies the value, given or not.
    pub(super) copy: fn(&Parameters, &mut Parameters),
    /// Makes settings of the value, if it is given.
    pub(super) apply: fn(&Parameters, &mut Recipe),
    /// The effective value as a text that differs whenever the value does, for content keys; none if another row's says
    /// it.
    pub(super) key: fn(&Recipe) -> Option<String>,
    /// The effective value as attributes of the asset.
    pub(super) describe: fn(&Baked) -> Vec<(&'static str, Value)>,
    /// Reads what [`Self::describe`] said of the mesh's placement; the error is the attribute that can't be used.
    pub(super) restore: fn(&Attributes, &mut InputSettings) -> Result<(), &'static str>,
}

/// What a parameter is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// Grid, fields and quadrature.
    Map,
    /// Reading the mesh.
    Mesh,
    /// Storing the asset.
    File,
}

/// Parameters that exclude each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// Those that give the support radius.
    Radius,
    /// Those that give the cells.
    Cells,
    /// Those that give the numbers' precision.
    Precision,
}

impl Section {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Section::Map => "Map",
            Section::Mesh => "Mesh",
            Section::File => "File",
        }
    }
}

impl Group {
    /// All groups.
    pub const ALL: [Group; 3] = [Group::Radius, Group::Cells, Group::Precision];

    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Group::Radius => "radius",
            Group::Cells => "cells",
            Group::Precision => "precision",
        }
    }
}

/// A bake, as far as its description needs it.
#[derive(Clone, Copy, Debug)]
pub struct Baked<'a> {
    /// The mesh and its placement.
    pub input: &'a Input,
    /// The settings.
    pub settings: &'a BakeSettings,
    /// What came of them.
    pub summary: &'a Summary,
}

impl Parameter {
    /// What a row says of itself where it says nothing.
    pub(super) const PLAIN: Parameter = Parameter {
        name: "",
        help: "",
        unit: "",
        default: "",
        placeholder: "",
        example: "",
        section: Section::Map,
        range: Range::Any,
        group: None,
        excludes: &[],
        needs: None,
        words: &[],
        is_flag: false,
        set: |_, _| Ok(()),
        is_given: |_| false,
        numbers: |_| Vec::new(),
        flag: |_| None,
        copy: |_, _| (),
        apply: |_, _| (),
        key: |_| None,
        describe: |_| Vec::new(),
        restore: |_, _| Ok(()),
    };

    /// Whether this one and another can't both be given.
    pub fn is_excluded_by(&self, other: &Parameter) -> bool {
        self.group.is_some() && self.group == other.group && self.name != other.name
            || self.excludes.contains(&other.name)
            || other.excludes.contains(&self.name)
    }

    /// The option of the command line, without `--`.
    pub fn option(&self) -> String {
        self.name.replace('_', "-")
    }

    /// What it does, its unit and its default.
    pub fn description(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(", {}", self.unit) };
        let default =
            if self.default.is_empty() { String::new() } else { format!(" [default: {}]", self.default) };
        format!("{}{unit}{default}", self.help.trim())
    }
}

/// Makes [`Parameters`] and [`TABLE`](super::TABLE) of rows.
///
/// A row is a field of `Parameters` with its help as comment, and in braces `apply`, which makes settings of the value,
/// then any other fields of [`Parameter`].
macro_rules! parameters {
    ($(
        $(#[doc = $help:literal])+
        $name:ident: $type:ty {
            apply: $apply:expr,
            $($field:ident: $value:expr,)*
        }
    )+) => {
        /// The parameters of a bake; what isn't given has its default.
        #[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default, expecting = "give a table with options of `volmap bake`")]
        #[schemars(transform = describe_schema)]
        pub struct Parameters {
            $(
                $(#[doc = $help])+
                #[serde(skip_serializing_if = "Option::is_none")]
                pub $name: Option<$type>,
            )+
        }

        /// All parameters, in the order of help texts.
        pub const TABLE: &[Parameter] = &[$( Parameter {
            name: stringify!($name),
            help: concat!($($help),+),
            words: <$type>::WORDS,
            is_flag: <$type>::IS_FLAG,
            set: |parameters, text| {
                parameters.$name = Some(text.parse::<$type>().map_err(|error| error.to_string())?);
                Ok(())
            },
            is_given: |parameters| parameters.$name.is_some(),
            numbers: |parameters| parameters.$name.map_or(Vec::new(), <$type>::numbers),
            flag: |parameters| parameters.$name.and_then(<$type>::flag),
            copy: |from, to| to.$name = from.$name,
            apply: |parameters, recipe| {
                let apply: fn(&mut Recipe, $type) = $apply;
                if let Some(value) = parameters.$name {
                    apply(recipe, value);
                }
            },
            $($field: $value,)*
            ..Parameter::PLAIN
        } ),+];
    };
}

pub(super) use parameters;
