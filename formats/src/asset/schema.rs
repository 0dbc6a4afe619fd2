//! What the objects of the file mean: [`Asset`] to [`Tree`] and back. `SPEC.md` is this file in prose.

mod cells;
mod density;

pub use self::density::DensityField;

use super::error::{AssetError, printable};
use super::tree::{Array, Attributes, Tree, Value};
#[cfg(feature = "write")]
use super::tree::{Dataset, MAX_ERROR, STEP};
use super::{Asset, CellRun, Dimension, Exterior, GridSpec, LevelCells, QuadratureSpec};

/// Value of the root attribute `format`.
pub const FORMAT_NAME: &str = "volmap";
/// The newest version that is read. A file gets the lowest version that can hold its content: 1 in space, 2 with a
/// density; 3 and 4 are the same in the plane; 5 with several levels of cells, or weights against a flat wall.
pub const FORMAT_VERSION: u64 = 5;
const ADAPTIVE_VERSION: u64 = 5;

pub(super) const GROUPS: [&str; 8] =
    ["/", "/bake", "/cells", "/diagnosis", "/fields", "/grid", "/quadrature", "/source"];
pub(super) const DATASETS: [&str; 4] =
    ["/cells/band", "/cells/solid", "/fields/signed_distance", "/fields/volume"];
/// What versions 2 and 4 have beside these.
pub(super) const DENSITY: &str = "/fields/density";

/// What version 5 has beside these: nothing in it where the volume is stored plainly.
pub(super) const PLANE_WEIGHT: &str = "/fields/plane_weight";

/// Eq. 13 of Bender et al. 2020, the one extension function of this version.
const EXTENSION: &str = "cubic_spline";
const NODE_LAYOUT: &str = "cubic_serendipity_32";
/// The quadrilateral of versions 3 and 4.
const NODE_LAYOUT_PLANE: &str = "cubic_serendipity_12";
/// Attribute of the grid in versions 3 and 4.
const DIMENSION: &str = "dimension";
/// Cells along an axis of a grid, at most.
pub const MAX_CELLS_PER_AXIS: u32 = 1 << 20;
/// Levels of cells, at most.
pub const MAX_LEVELS: usize = 16;
/// Rows of cells along x (resolution y times z), at most: indices of rows take memory.
pub const MAX_ROWS: u64 = 1 << 24;

/// The file's content for an asset, checksums included.
#[cfg(feature = "write")]
pub(super) fn tree_from_asset(asset: &Asset) -> Tree {
    let mut tree = Tree::default();
    let mut group = |path: &str, attributes: Attributes| _ = tree.groups.insert(path.into(), attributes);
    group("/", root_attributes(asset.format_version()));
    group("/bake", asset.bake.clone());
    group("/cells", Attributes::new());
    group("/diagnosis", asset.diagnosis.clone());
    group("/fields", attributes([("node_layout", asset.dimension.node_layout().into())]));
    group("/grid", grid_attributes(asset));
    group("/quadrature", quadrature_attributes(asset));
    group("/source", asset.source.clone());
    let mut dataset = |path: &str, dataset: Dataset| _ = tree.datasets.insert(path.into(), dataset);
    for (path, cells) in cells::datasets(asset) {
        dataset(path, cells);
    }
    dataset(
        "/fields/signed_distance",
        field_dataset(&asset.signed_distance, "m", "signed distance Phi, negative inside the solid"),
    );
    dataset(
        "/fields/volume",
        field_dataset(
            &asset.volume,
            asset.dimension.volume_unit(),
            "boundary volume, Eq. 12 of Bender et al. 2020",
        ),
    );
    if asset.is_adaptive() {
        dataset(PLANE_WEIGHT, weight_dataset(asset.plane_weight.as_deref().unwrap_or_default()));
    }
    if let Some(density) = &asset.density {
        dataset(DENSITY, density::dataset(density));
    }
    tree.seal();
    tree
}

impl Asset {
    /// Version of the format of its file.
    pub fn format_version(&self) -> u64 {
        if self.is_adaptive() {
            return ADAPTIVE_VERSION;
        }
        let plane = if self.dimension == Dimension::Two { 2 } else { 0 };
        1 + plane + u64::from(self.density.is_some())
    }

    /// Whether it has cells of several levels, or weights against a flat wall.
    pub fn is_adaptive(&self) -> bool {
        !self.finer.is_empty() || self.plane_weight.is_some()
    }

    /// The cells of each level, the grid's first.
    pub fn levels(&self) -> Vec<LevelCells> {
        let first = LevelCells { band: self.band_cells.clone(), solid: self.solid_cells.clone() };
        std::iter::once(first).chain(self.finer.iter().cloned()).collect()
    }

    /// Number of stored cells of each level; one number of a map whose cells have one size.
    pub fn cells_by_level(&self) -> Vec<u64> {
        let finer = self.finer.iter().map(|level| count(&level.band));
        std::iter::once(count(&self.band_cells)).chain(finer).collect()
    }

    /// Number of stored cells.
    pub fn band_count(&self) -> u64 {
        self.cells_by_level().iter().sum()
    }

    /// Number of cells deeper in the solid than the band, of all levels.
    pub fn solid_count(&self) -> u64 {
        count(&self.solid_cells) + self.finer.iter().map(|level| count(&level.solid)).sum::<u64>()
    }
}

fn count(runs: &[CellRun]) -> u64 {
    runs.iter().map(|run| u64::from(run.len)).sum()
}

impl Dimension {
    fn node_layout(self) -> &'static str {
        match self {
            Dimension::Two => NODE_LAYOUT_PLANE,
            Dimension::Three => NODE_LAYOUT,
        }
    }

    /// Unit of the volume: `m^2` or `m^3`.
    pub fn volume_unit(self) -> &'static str {
        match self {
            Dimension::Two => "m^2",
            Dimension::Three => "m^3",
        }
    }
}

#[cfg(feature = "write")]
fn root_attributes(version: u64) -> Attributes {
    attributes([
        ("format", FORMAT_NAME.into()),
        ("format_version", version.into()),
        ("length_unit", "m".into()),
        ("extension_function", EXTENSION.into()),
    ])
}

#[cfg(feature = "write")]
fn grid_attributes(asset: &Asset) -> Attributes {
    let exterior = match asset.exterior {
        Exterior::Fluid => "fluid",
        Exterior::Solid => "solid",
    };
    let mut grid = attributes([
        ("origin", asset.grid.origin.into()),
        ("cell_size", asset.grid.cell_size.into()),
        ("resolution", asset.grid.resolution.into()),
        ("support_radius", asset.support_radius.into()),
        ("exterior", exterior.into()),
    ]);
    if asset.dimension == Dimension::Two {
        grid.insert(DIMENSION.into(), 2u64.into());
    }
    grid
}

#[cfg(feature = "write")]
fn quadrature_attributes(asset: &Asset) -> Attributes {
    let rule = &asset.quadrature;
    attributes([
        ("name", rule.name.as_str().into()),
        ("degree", u64::from(rule.degree).into()),
        ("points", rule.points.into()),
        ("ball_volume", rule.ball_volume.into()),
    ])
}

#[cfg(feature = "write")]
pub(super) fn attributes<const N: usize>(pairs: [(&str, Value); N]) -> Attributes {
    pairs.map(|(name, value)| (name.to_owned(), value)).into()
}

#[cfg(feature = "write")]
fn weight_dataset(weights: &[u32]) -> Dataset {
    let description =
        "0 or 1 at free corner nodes: the part of a flat wall's volume that the volume is without";
    Dataset {
        array: Array::U32(weights.to_vec()),
        shape: vec![weights.len()],
        attributes: attributes([("units", "1".into()), ("description", description.into())]),
    }
}

#[cfg(feature = "write")]
pub(super) fn field_dataset(values: &Array, units: &str, description: &str) -> Dataset {
    let mut attributes = attributes([("units", units.into()), ("description", description.into())]);
    if let Array::Rounded(rounded) = values {
        attributes.insert(STEP.into(), rounded.step.into());
        attributes.insert(MAX_ERROR.into(), rounded.max_error.into());
    }
    Dataset { shape: vec![values.len()], array: values.clone(), attributes }
}

/// Reads an asset's tree from bytes, the kind and version of the file first, so that a foreign or newer
/// file is told as such.
pub(super) fn read(bytes: Vec<u8>) -> Result<Asset, AssetError> {
    asset_from_tree(super::read::read_tree(bytes, &GROUPS, check_format)?)
}

/// The datasets of the file's version.
fn check_format(root: &Attributes) -> Result<Vec<&'static str>, AssetError> {
    if root.get("format") != Some(&Value::Text(FORMAT_NAME.into())) {
        return Err(AssetError::NotAnAsset);
    }
    match root.get("format_version") {
        Some(Value::Integer(v)) if v.len() == 1 && v[0] > FORMAT_VERSION => {
            Err(AssetError::Version { found: v[0], supported: FORMAT_VERSION })
        }
        Some(Value::Integer(v)) if v[..] == [1] || v[..] == [3] => Ok(DATASETS.to_vec()),
        Some(Value::Integer(v)) if v[..] == [2] || v[..] == [4] => Ok([&DATASETS[..], &[DENSITY]].concat()),
        // The last one is a field: it may be read on a second thread.
        Some(Value::Integer(v)) if v[..] == [ADAPTIVE_VERSION] => {
            Ok([&[PLANE_WEIGHT], &DATASETS[..]].concat())
        }
        _ => Err(AssetError::invalid("/@format_version", "isn't a version number")),
    }
}

/// What the content means.
///
/// # Errors
/// Groups, attributes and datasets that are missing or of another type; what [`Asset::check`] refuses.
pub(super) fn asset_from_tree(mut tree: Tree) -> Result<Asset, AssetError> {
    let root = Reader::new(&tree, "/");
    root.expect("length_unit", "m")?;
    root.expect("extension_function", EXTENSION)?;
    let [version] = root.integers("format_version")?;
    let dimension = if matches!(version, 3 | 4) { Dimension::Two } else { Dimension::Three };
    Reader::new(&tree, "/fields").expect("node_layout", dimension.node_layout())?;
    let grid_group = Reader::new(&tree, "/grid");
    if dimension == Dimension::Two && grid_group.integers(DIMENSION)? != [2] {
        return Err(grid_group.invalid(DIMENSION, "isn't 2, as in files of this version"));
    }
    let grid = grid_spec(&grid_group)?;
    let support_radius = grid_group.real("support_radius")?;
    let exterior = match grid_group.text("exterior")?.as_str() {
        "fluid" => Exterior::Fluid,
        "solid" => Exterior::Solid,
        _ => return Err(grid_group.invalid("exterior", "is neither `fluid` nor `solid`")),
    };
    let quadrature = quadrature_spec(&Reader::new(&tree, "/quadrature"))?;
    let mut finer = cells::from_tree(&tree, version == ADAPTIVE_VERSION)?;
    let LevelCells { band: band_cells, solid: solid_cells } = finer.remove(0);
    let mut group = |path: &str| tree.groups.remove(path).unwrap_or_default();
    let (bake, source, diagnosis) = (group("/bake"), group("/source"), group("/diagnosis"));
    let asset = Asset {
        dimension,
        grid,
        support_radius,
        exterior,
        quadrature,
        band_cells,
        solid_cells,
        finer,
        signed_distance: field(&mut tree, "/fields/signed_distance")?,
        volume: field(&mut tree, "/fields/volume")?,
        density: density::from_tree(&mut tree)?,
        plane_weight: plane_weight(&mut tree, version)?,
        bake,
        source,
        diagnosis,
    };
    asset.check()?;
    Ok(asset)
}

fn grid_spec(group: &Reader) -> Result<GridSpec, AssetError> {
    let resolution = group.integers::<3>("resolution")?.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    Ok(GridSpec { origin: group.reals("origin")?, cell_size: group.reals("cell_size")?, resolution })
}

fn quadrature_spec(group: &Reader) -> Result<QuadratureSpec, AssetError> {
    let [degree] = group.integers("degree")?;
    let [points] = group.integers("points")?;
    let degree = u32::try_from(degree).map_err(|_| group.invalid("degree", "is too large"))?;
    Ok(QuadratureSpec { name: group.text("name")?, degree, points, ball_volume: group.real("ball_volume")? })
}

/// `None` if there are none.
fn plane_weight(tree: &mut Tree, version: u64) -> Result<Option<Vec<u32>>, AssetError> {
    if version != ADAPTIVE_VERSION {
        return Ok(None);
    }
    match field(tree, PLANE_WEIGHT)? {
        Array::U32(weights) => Ok(Some(weights).filter(|weights| !weights.is_empty())),
        _ => Err(AssetError::invalid(PLANE_WEIGHT, "isn't u32")),
    }
}

pub(super) fn field(tree: &mut Tree, path: &str) -> Result<Array, AssetError> {
    let dataset = tree.datasets.remove(path).ok_or_else(|| AssetError::Missing(path.into()))?;
    match dataset.shape.len() {
        1 => Ok(dataset.array),
        _ => Err(AssetError::invalid(path, "has more than one axis")),
    }
}

/// Typed access to an object's attributes.
pub(super) struct Reader<'a> {
    pub path: &'a str,
    pub attributes: Option<&'a Attributes>,
}

impl<'a> Reader<'a> {
    fn new(tree: &'a Tree, path: &'a str) -> Reader<'a> {
        Reader { path, attributes: tree.groups.get(path) }
    }

    fn name(&self, name: &str) -> String {
        format!("{}@{name}", self.path)
    }

    pub fn invalid(&self, name: &str, reason: &str) -> AssetError {
        AssetError::invalid(self.name(name), reason)
    }

    fn get(&self, name: &str) -> Result<&'a Value, AssetError> {
        let value = self.attributes.and_then(|attributes| attributes.get(name));
        value.ok_or_else(|| AssetError::Missing(self.name(name)))
    }

    pub fn text(&self, name: &str) -> Result<String, AssetError> {
        match self.get(name)? {
            Value::Text(text) => Ok(text.clone()),
            _ => Err(self.invalid(name, "isn't text")),
        }
    }

    pub fn expect(&self, name: &str, expected: &str) -> Result<(), AssetError> {
        let found = self.text(name)?;
        if found == expected {
            return Ok(());
        }
        Err(self
            .invalid(name, &format!("is `{}`, but this version knows only `{expected}`", printable(&found))))
    }

    pub fn integers<const N: usize>(&self, name: &str) -> Result<[u64; N], AssetError> {
        match self.get(name)? {
            Value::Integer(v) => v.as_slice().try_into().ok(),
            _ => None,
        }
        .ok_or_else(|| self.invalid(name, &format!("isn't {N} unsigned integers")))
    }

    fn reals<const N: usize>(&self, name: &str) -> Result<[f64; N], AssetError> {
        match self.get(name)? {
            Value::Real(v) if v.iter().all(|x| x.is_finite()) => v.as_slice().try_into().ok(),
            _ => None,
        }
        .ok_or_else(|| self.invalid(name, &format!("isn't {N} finite real numbers")))
    }

    pub fn real(&self, name: &str) -> Result<f64, AssetError> {
        Ok(self.reals::<1>(name)?[0])
    }
}

#[cfg(all(test, feature = "write"))]
mod tests {
    use super::super::{CellRun, DensityField, Rounded};
    use super::*;

    fn asset() -> Asset {
        Asset {
            dimension: Dimension::Three,
            grid: GridSpec { origin: [0.0; 3], cell_size: [0.5; 3], resolution: [2, 1, 1] },
            support_radius: 0.1,
            exterior: Exterior::Fluid,
            quadrature: QuadratureSpec { name: "gl4".into(), degree: 4, points: 19, ball_volume: 0.004 },
            band_cells: vec![CellRun { i: 0, j: 0, k: 0, len: 1 }],
            solid_cells: Vec::new(),
            finer: Vec::new(),
            signed_distance: Array::F64(vec![0.5; 32]),
            volume: Array::F64(vec![0.25; 32]),
            density: None,
            plane_weight: None,
            bake: Attributes::new(),
            source: Attributes::new(),
            diagnosis: Attributes::new(),
        }
    }

    fn error_of(change: impl Fn(&mut Tree)) -> Option<String> {
        let mut tree = tree_from_asset(&asset());
        change(&mut tree);
        tree.seal();
        asset_from_tree(tree).err().map(|error| error.to_string())
    }

    fn density() -> Option<DensityField> {
        Some(DensityField {
            kernel: "cubic_spline".into(),
            extension_length: 0.1,
            quadrature: "gl4".into(),
            degree: 4,
            points: 19,
            kernel_integral: 1.01,
            values: Array::F64(vec![0.75; 32]),
        })
    }

    #[test]
    fn versions_tell_dimension_and_density() {
        use Dimension::{Three, Two};
        let all = [(Three, None, 1u64), (Three, density(), 2), (Two, None, 3), (Two, density(), 4)];
        for (dimension, density, version) in all {
            let asset = Asset { dimension, density, ..asset() };
            let tree = tree_from_asset(&asset);
            assert_eq!(tree.groups["/"]["format_version"], version.into());
            assert_eq!(tree.datasets.contains_key(DENSITY), version % 2 == 0);
            assert_eq!(check_format(&tree.groups["/"]).unwrap().contains(&DENSITY), version % 2 == 0);
            assert_eq!(asset_from_tree(tree).unwrap(), asset);
        }
        for version in [Value::from(0u64), 6u64.into(), Value::Integer(vec![1, 1]), 1.0.into()] {
            let root = attributes([("format", FORMAT_NAME.into()), ("format_version", version)]);
            assert!(check_format(&root).is_err());
        }
    }

    /// The cell beside the one of level 0 is split; of its children one is in the band, one solid.
    fn adaptive() -> Asset {
        let finer = LevelCells {
            band: vec![CellRun { i: 2, j: 0, k: 0, len: 1 }],
            solid: vec![CellRun { i: 3, j: 1, k: 1, len: 1 }],
        };
        Asset { finer: vec![finer], plane_weight: Some(vec![1, 0, 1]), ..asset() }
    }

    #[test]
    fn adaptive_maps_are_version_5_and_come_back() {
        let all = adaptive();
        let plain = Asset { plane_weight: None, ..adaptive() };
        let one_level = Asset { finer: Vec::new(), ..adaptive() };
        for asset in [all, plain, one_level] {
            let tree = tree_from_asset(&asset);
            assert_eq!(tree.groups["/"]["format_version"], 5u64.into());
            let listed = check_format(&tree.groups["/"]).unwrap();
            assert_eq!(listed.len(), tree.datasets.len());
            assert!(listed.iter().all(|&path| tree.datasets.contains_key(path)));
            assert_eq!(asset_from_tree(tree).unwrap(), asset);
        }
    }

    #[test]
    fn what_adaptive_maps_cannot_be_is_refused_by_name() {
        type Change = fn(&mut Asset);
        let all: [(&str, Change); 9] = [
            ("`/cells` has levels", |asset| asset.dimension = Dimension::Two),
            ("`/cells` has levels", |asset| asset.density = density()),
            ("more than 16 levels", |asset| asset.finer.resize(16, LevelCells::default())),
            ("`/grid@resolution` is over", |asset| asset.grid.resolution[0] = (1 << 19) + 1),
            ("row 0 of level 1 lies outside", |asset| asset.finer[0].band[0].j = 2),
            ("row 0 of level 1 lies outside", |asset| asset.finer[0].solid[0].len = 0),
            ("row 1 of level 1 is out of order", |asset| {
                asset.finer[0].band.push(CellRun { i: 2, j: 0, k: 0, len: 1 });
            }),
            ("overlaps /cells/band", |asset| asset.finer[0].solid[0] = asset.finer[0].band[0]),
            ("plane_weight` has numbers other", |asset| asset.plane_weight = Some(vec![0, 2])),
        ];
        for (text, change) in all {
            let mut asset = adaptive();
            change(&mut asset);
            let error = asset.check().unwrap_err().to_string();
            assert!(error.contains(text), "{error}");
        }
    }

    #[test]
    fn tables_of_levels_are_refused_by_name() {
        let error = |change: fn(&mut Vec<u32>)| {
            let mut tree = tree_from_asset(&adaptive());
            let Array::U32(numbers) = &mut tree.datasets.get_mut("/cells/band").unwrap().array else {
                panic!()
            };
            change(numbers);
            tree.seal();
            asset_from_tree(tree).err().map(|error| error.to_string())
        };
        assert_eq!(error(|_| ()), None);
        assert!(error(|numbers| numbers[0] = 2).unwrap().contains("`/cells/band` row 1 is out of order"));
        assert!(error(|numbers| numbers[5] = 16).unwrap().contains("`/cells/band` has more than 16 levels"));
        let mut tree = tree_from_asset(&adaptive());
        tree.groups.get_mut("/").unwrap().insert("format_version".into(), 1u64.into());
        tree.seal();
        let error = asset_from_tree(tree).unwrap_err().to_string();
        assert!(error.contains("`/cells/band` isn't a table of u32 with 4 columns"), "{error}");
    }

    #[test]
    fn grids_that_are_not_in_the_plane_are_refused_by_name() {
        let error = |path: &str, name: &str, value: Value| {
            let mut tree = tree_from_asset(&Asset { dimension: Dimension::Two, ..asset() });
            tree.groups.get_mut(path).unwrap().insert(name.into(), value);
            tree.seal();
            asset_from_tree(tree).err().map(|error| error.to_string())
        };
        assert_eq!(error("/grid", "dimension", 2u64.into()), None);
        let bad: [(&str, &str, Value); 4] = [
            ("/grid", "dimension", 3u64.into()),
            ("/grid", "dimension", 2.0.into()),
            ("/grid", "resolution", [2, 1, 2].into()),
            ("/fields", "node_layout", NODE_LAYOUT.into()),
        ];
        for (path, name, value) in bad {
            let error = error(path, name, value).unwrap();
            assert!(error.contains(&format!("{path}@{name}")), "{error}");
        }
    }

    #[test]
    fn attributes_of_a_density_are_refused_by_name() {
        let error = |name: &str, value: Option<Value>| {
            let mut tree = tree_from_asset(&Asset { density: density(), ..asset() });
            let attributes = &mut tree.datasets.get_mut(DENSITY).unwrap().attributes;
            match value {
                Some(value) => attributes.insert(name.into(), value),
                None => attributes.remove(name),
            };
            tree.seal();
            asset_from_tree(tree).err().map(|error| error.to_string())
        };
        let bad: [(&str, Value); 7] = [
            ("kernel", 1u64.into()),
            ("extension_function", "cubic_spline".into()),
            ("extension_length", 0.0.into()),
            ("quadrature", 1.0.into()),
            ("degree", u64::MAX.into()),
            ("points", "19".into()),
            ("kernel_integral", f64::NAN.into()),
        ];
        for (name, value) in bad {
            for value in [None, Some(value)] {
                let error = error(name, value).unwrap();
                assert!(error.contains(&format!("{DENSITY}@{name}")), "{error}");
            }
        }
        assert_eq!(error("units", None), None);
    }

    #[test]
    fn sealed_trees_of_another_schema_are_refused_by_name() {
        assert_eq!(error_of(|_| ()), None);
        let values =
            [0u64.into(), Value::Text("5".into()), Value::Real(vec![]), Value::Real(vec![f64::NAN; 3])];
        let known: Vec<(String, String)> = tree_from_asset(&asset())
            .groups
            .iter()
            .flat_map(|(path, attributes)| attributes.keys().map(|name| (path.clone(), name.clone())))
            .filter(|(path, name)| {
                path != "/" || ["length_unit", "extension_function"].contains(&name.as_str())
            })
            .collect();
        assert_eq!(known.len(), 12);
        for (path, name) in &known {
            let without = error_of(|tree| _ = tree.groups.get_mut(path).unwrap().remove(name)).unwrap();
            assert_eq!(without, format!("`{path}@{name}` is missing; bake the asset again"));
            for value in &values {
                let valid = name == "points" || name == "degree";
                let set = |tree: &mut Tree| {
                    tree.groups.get_mut(path).unwrap().insert(name.clone(), value.clone());
                };
                match error_of(set) {
                    Some(error) => assert!(error.contains(&format!("{path}@{name}")), "{error}"),
                    None => {
                        assert!(valid && *value == 0u64.into() || path == "/quadrature" && name == "name")
                    }
                }
            }
        }
    }

    #[test]
    fn steps_that_are_out_of_range_are_refused_by_name() {
        let rounded = |step: f64, max_error: f64| {
            let mut asset = asset();
            let field = Rounded { multiples: vec![-32768; 32], step, max_error };
            asset.signed_distance = Array::Rounded(field.clone());
            asset.volume = Array::Rounded(field);
            asset_from_tree(tree_from_asset(&asset)).map(|_| ()).map_err(|error| error.to_string())
        };
        assert_eq!(rounded(1e-5, 0.0), Ok(()));
        for step in [0.0, -1e-5, f64::NAN, f64::INFINITY] {
            assert!(
                rounded(step, 1e-5).unwrap_err().contains("/fields/signed_distance@scale_factor"),
                "{step}"
            );
        }
        for bound in [-1e-9, f64::NAN, f64::INFINITY] {
            assert!(
                rounded(1e-5, bound).unwrap_err().contains("/fields/signed_distance@max_error"),
                "{bound}"
            );
        }
        assert!(rounded(1e305, 1e304).unwrap_err().contains("aren't finite"));
    }

    #[test]
    fn checksum_of_16_bits_is_that_of_the_specification() {
        let field = Rounded { multiples: (0..52).collect(), step: 1e-5, max_error: 5e-6 };
        let checksum = field_dataset(&Array::Rounded(field), "m", "").checksum();
        assert!(include_str!("../../SPEC.md").contains(&checksum), "{checksum}");
    }

    #[test]
    fn sealed_datasets_of_another_shape_are_refused_by_name() {
        for path in DATASETS {
            let dataset =
                |tree: &mut Tree, change: fn(&mut Dataset)| change(tree.datasets.get_mut(path).unwrap());
            let cube = error_of(|tree| dataset(tree, |d| d.shape = vec![1, d.array.len(), 1])).unwrap();
            let integers = error_of(|tree| {
                dataset(tree, |d| {
                    d.array = match &d.array {
                        Array::U32(v) => Array::F32(v.iter().map(|&x| x as f32).collect()),
                        other => Array::U32(vec![0; other.len()]),
                    }
                })
            })
            .unwrap();
            let missing = error_of(|tree| _ = tree.datasets.remove(path)).unwrap();
            for error in [cube, integers, missing] {
                assert!(error.contains(path), "{error}");
            }
        }
    }
}
