//! All settings that an asset's bytes follow from.

use crate::input::InputSettings;
use crate::sdf::sign::SignMethod;
use crate::settings::MapSettings;
use volmap_formats::asset::Compression;

/// What an asset depends on beside the mesh's file. Made by [`crate::parameters::Parameters::recipe`], or by hand.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Recipe {
    /// How the mesh is read.
    pub input: InputSettings,
    /// How it is baked.
    pub bake: BakeSettings,
    /// How the asset is compressed.
    pub compression: Compression,
}

/// What a bake depends on beside the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BakeSettings {
    /// Grid, field and rule.
    pub map: MapSettings,
    /// How inside and outside are told apart.
    pub sign: SignMethod,
    /// Leave the triangles' orientation as it comes.
    pub keep_orientation: bool,
    /// Compare both signs at every node.
    pub check_sign: bool,
    /// Support radius of the kernels that the map is for, metres, if it is another than the map's: lengths are compared
    /// with it.
    pub kernel_radius: Option<f64>,
    /// The unit of the file's numbers was given, so that nobody need suspect it.
    pub unit_is_given: bool,
}
