//! From a body's file to its volume map: opened, or baked on first use and kept in a cache.

use super::body::{Body, Source};
use super::numbers::Region;
use super::surface::Surface;
use crate::error::Error;
use crate::output::io_error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use volmap_bake::bake::bake;
use volmap_bake::content_key;
use volmap_bake::input::{self, Input};
use volmap_bake::mesh::prepare;
use volmap_bake::parameters::{DensityKernel, Group, Parameters, PrecisionName, RadiusPart, Tolerance};
use volmap_bake::plan::{Extent, GridChoice, MapSettings, plan};
use volmap_bake::primitive::{PlacedPrimitive, Primitive};
use volmap_bake::recipe::Recipe;
use volmap_bake::sdf::{MeshDistance, SignMethod};
use volmap_bake::watch::Watch;
use volmap_fluid::boundary::density_map;
use volmap_fluid::settings::{BoundaryMethod, World};
use volmap_formats::asset::{self, Asset, Exterior, Value};
use volmap_formats::mesh::TriangleMesh;
use volmap_formats::text::printable_line;
use volmap_runtime::{ClosureKind, DVec3, Dimension, KernelKind, MapErrors, Pose, VolumeMap};

/// Part by which a map's support radius may differ from the scene's: other programs store it in single
/// precision.
const SAME_RADIUS: f64 = 1e-6;

/// A map and, if it comes from one, its mesh.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The map, in the body's frame.
    pub map: Arc<VolumeMap>,
    /// The mesh as it was baked: scaled, triangles the right way round.
    pub mesh: Option<Arc<TriangleMesh>>,
    /// The shape that the mesh stands for.
    pub primitive: Option<PlacedPrimitive>,
    /// The surface of the map's solid: that of the union where parts of the mesh overlap, moved by the thickness.
    pub surface: Surface,
    /// Where the map comes from.
    pub origin: Origin,
    /// BLAKE3 of the map's bytes, or of the content key of the mesh and its bake.
    pub content: [u8; 32],
}

/// Where a map comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An asset that the scene names.
    Asset,
    /// Baked before.
    Cache,
    /// Baked now.
    Baked,
}

/// Opens and bakes what a scene needs, each once.
pub struct Library<'a> {
    closure: ClosureKind,
    /// That of the maps, metres.
    support_radius: f64,
    /// Edge of their cells by default, metres.
    cell_size: f64,
    /// How exact maps are that would have too many such cells.
    errors: MapErrors,
    /// The kernel whose density bodies need in their maps, if they need one.
    density: Option<KernelKind>,
    /// The scene's: how far planes reach.
    domain: Option<Region>,
    /// Bytes that a bake may need; none: as many as by default.
    max_memory: Option<u64>,
    cache: PathBuf,
    shapes: Vec<(String, Shape)>,
    /// What went wrong without harm.
    pub notes: Vec<String>,
    watch: &'a Watch,
    on_bake: &'a mut dyn FnMut(&Path),
}

/// The surface of a body's or fill's solid as far as its file tells it, with its overlapping parts; none if it can't be
/// read, or only the map has it.
pub fn surface_without_map(source: Source, bake: &Parameters) -> Option<Surface> {
    let mut recipe = bake.recipe();
    let mut input = match source {
        Source::Map(_) => return None,
        Source::Mesh(path, _) => input::load(path, &recipe.input).ok()?,
        Source::Shape(shape, _) => {
            recipe.input.shape = Some(shape);
            input::from_shape(shape, &recipe.input).ok()?
        }
    };
    prepare(&mut input.mesh, recipe.bake.keep_orientation);
    Some(Surface::new(Arc::new(input.mesh), input.placed_shape, recipe.bake.map.surface_offset()))
}

impl<'a> Library<'a> {
    /// Nothing opened yet; maps are those that the world's boundary method takes, and kept in `cache`. `on_bake` is
    /// called with the mesh before each bake, which may take seconds.
    pub fn new(
        world: &World,
        cache: PathBuf,
        watch: &'a Watch,
        on_bake: &'a mut dyn FnMut(&Path),
    ) -> Library<'a> {
        let density = (world.boundary == BoundaryMethod::DensityMap).then_some(world.kernel);
        let closure = world.map_closure();
        Library {
            closure,
            support_radius: closure.map_radius(world.support_radius),
            cell_size: closure.cell_size(world.support_radius),
            errors: closure.map_errors(),
            density,
            domain: None,
            max_memory: None,
            cache,
            shapes: Vec::new(),
            notes: Vec::new(),
            watch,
            on_bake,
        }
    }

    /// Planes reach as far as this.
    pub fn within(self, domain: Option<Region>) -> Library<'a> {
        Library { domain, ..self }
    }

    /// Bakes may need so many bytes.
    pub fn with_memory(self, bytes: u64) -> Library<'a> {
        Library { max_memory: Some(bytes), ..self }
    }

    /// A plane in the frame of a body or a solid with this pose, as far as the scene's domain; other shapes as they
    /// are.
    pub fn bounded(&self, shape: Option<Primitive>, pose: Pose) -> Option<Primitive> {
        let corners = self.domain.map(|domain| {
            let [min, max] = domain.corners();
            let corner =
                |n: usize| DVec3::from([0, 1, 2].map(|k| if n >> k & 1 == 1 { max[k] } else { min[k] }));
            let own = (0..8).map(|n| pose.rotation.conjugate() * (corner(n) - pose.translation));
            let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            let (low, high) = own.fold(nothing, |(low, high), x| (low.min(x), high.max(x)));
            [low.to_array(), high.to_array()]
        });
        shape.map(|shape| shape.within(corners))
    }

    /// The body with a plane as far as the scene's domain, and with the cells that its map needs if it turns and leaves
    /// them open: equal ones of the closure's size would be too rough.
    pub fn with_cells(&self, body: &Body) -> Body {
        let mut body = body.clone();
        body.shape = self.bounded(body.shape, body.pose());
        if body.turns() && !gives_cells(&body.bake) && self.density.is_none() {
            body.bake = self.by_errors(body.bake, 1.0);
        }
        body
    }

    /// With cells of several sizes, as exact as the closure needs; volumes may be so many times as wrong.
    fn by_errors(&self, mut given: Parameters, times: f64) -> Parameters {
        given.tolerance = Some(Tolerance(times * self.errors.volume));
        given.distance_tolerance = Some(RadiusPart(self.errors.distance));
        if !given.gives(Group::Precision) {
            given.precision = Some(PrecisionName::F32);
        }
        given
    }

    /// The map of a source; `key` is the scene's name for it, as `bodies[0]`. The same source gives the same
    /// map.
    ///
    /// # Errors
    /// A file that is missing or can't be used; a mesh that can't be baked.
    pub fn obtain(&mut self, source: Source, key: &str) -> Result<Shape, Error> {
        self.obtain_with(source, key, None)
    }

    fn obtain_with(
        &mut self,
        source: Source,
        key: &str,
        density: Option<KernelKind>,
    ) -> Result<Shape, Error> {
        let path = source.path();
        if !matches!(source, Source::Shape(..)) && !path.is_file() {
            let what = source.key();
            let reason = format!("there is no file {}; paths are relative to the scene file", path.display());
            return Err(Error::Scene { place: format!("{key}.{what}"), reason });
        }
        let identity = format!("{source:?} {density:?}");
        if let Some((_, shape)) = self.shapes.iter().find(|(name, _)| *name == identity) {
            return Ok(shape.clone());
        }
        let shape = match source {
            Source::Map(path) => self.open_asset(path)?,
            Source::Mesh(path, given) => self.bake_or_open(path, given, density)?,
            Source::Shape(shape, given) => {
                let given = Parameters { shape: Some(shape), ..given.clone() };
                self.bake_or_open(path, &given, density).map_err(|error| of_shape(error, key))?
            }
        };
        self.shapes.push((identity, shape.clone()));
        Ok(shape)
    }

    /// The same for a body: its map must have the support radius that the closure takes.
    ///
    /// # Errors
    /// As [`Library::obtain`], and a map of another radius, or without the density that is needed.
    pub fn obtain_for_body(&mut self, source: Source, key: &str) -> Result<Shape, Error> {
        if let Some(given) = source.bake() {
            self.check_given(given, &format!("{key}.bake"))?;
        }
        let shape = self.obtain_with(source, key, self.density)?;
        let (has, needs) = (shape.map.support_radius(), self.support_radius);
        if (has - needs).abs() <= SAME_RADIUS * needs {
            self.note_coarse_cells(source.path(), &shape.map);
            return self.with_density(shape, source, key);
        }
        let file = source.path().display();
        let invert = invert(&shape.map);
        let reason = format!(
            "{file} was baked for a support radius of {has} m, but closure `{}` takes one of {needs} m here; bake \
            its mesh \
             again with support_radius = {needs}{invert}, or name the mesh in the scene instead",
            self.closure
        );
        Err(Error::Scene { place: format!("{key}.map"), reason })
    }

    /// Refuses parameters that the scene decides otherwise.
    fn check_given(&self, given: &Parameters, key: &str) -> Result<(), Error> {
        let refuse = |name: &str, reason: String| {
            Err(Error::Scene { place: format!("{key}.{name}"), reason: format!("{reason}; leave it out") })
        };
        let radius =
            [("support_radius", given.support_radius, 1.0), ("particle_radius", given.particle_radius, 4.0)];
        for (name, value, times) in radius {
            let has = times * value.unwrap_or(self.support_radius / times);
            if (has - self.support_radius).abs() > SAME_RADIUS * self.support_radius {
                let (closure, needs) = (self.closure, self.support_radius);
                return refuse(
                    name,
                    format!(
                        "gives a map of support radius {has} m, but closure `{closure}` takes one of {needs} m here"
                    ),
                );
            }
        }
        let Some(kernel) = self.density else { return Ok(()) };
        if given.density == Some(false) {
            return refuse("density", "is false, but boundary = \"density_map\" needs the density".into());
        }
        match given.kernel {
            Some(DensityKernel(other)) if other != kernel => {
                refuse("kernel", format!("is {other}, but kernel = \"{kernel}\" in the scene"))
            }
            _ => Ok(()),
        }
    }

    /// The shape, if its map has the density that bodies need.
    fn with_density(&self, shape: Shape, source: Source, key: &str) -> Result<Shape, Error> {
        let Some(kernel) = self.density else { return Ok(shape) };
        let Some(defect) = density_map::defect(shape.map.density_kernel(), kernel) else { return Ok(shape) };
        let file = source.path().display();
        let (radius, invert) = (self.support_radius, invert(&shape.map));
        let reason = format!(
            "{file} can't be used with boundary = \"density_map\": {defect}; name the mesh in the scene instead, or \
            bake it \
             again with support_radius = {radius}{invert}, density = true, kernel = \"{kernel}\" (its gamma ends at r, \
             as in the paper, and the fluid keeps farther from walls)"
        );
        Err(Error::Scene { place: format!("{key}.map"), reason })
    }

    fn note_larger_error(&mut self, path: &Path, times: f64) {
        let percent = 100.0 * self.errors.volume;
        self.notes.push(format!(
            "{}: volumes may be wrong by {} % of the full ball instead of {percent} %, for which the bake would need more \
             memory than is allowed; allow more (--max-memory), or choose by `bake.tolerance` or `bake.cell_size`",
            path.display(),
            times * percent
        ));
    }

    fn note_coarse_cells(&mut self, path: &Path, map: &VolumeMap) {
        let (cell, most) = (map.grid().cell_size.max_element(), COARSE * self.cell_size);
        if map.levels() == 1 && map.exterior() == Exterior::Solid && cell > most {
            self.notes.push(format!(
                "{}: cells of {cell} m are coarse for a container: where walls meet, particles find them up to \
                {:.3} m too \
                 near; bake with cells of a quarter of the support radius",
                path.display(),
                0.25 * cell
            ));
        }
    }

    fn bake_or_open(
        &mut self,
        path: &Path,
        given: &Parameters,
        density: Option<KernelKind>,
    ) -> Result<Shape, Error> {
        let mut recipe = self.recipe(given, density);
        let mut identity = content_key::identify(path, recipe.effective())?;
        let mut input = content_key::load(path, &recipe, &identity)?;
        let mut times = self.times_error(given, &input, &recipe);
        let found = loop {
            if let Some(times) = times {
                recipe = self.recipe(&self.by_errors(given.clone(), times), density);
                identity = identity.with_parameters(recipe.effective());
            }
            let found = self.cached_or_baked(path, &identity.key, input.clone(), &recipe);
            match times {
                Some(before) if found.as_ref().is_err_and(is_of_memory) && before < MOST_TIMES => {
                    times = Some(2.0 * before)
                }
                _ => break found,
            }
        };
        let (asset, opened) = found.map_err(|error| cannot_bake(path, error))?;
        let origin = if opened.is_some() { Origin::Cache } else { Origin::Baked };
        let map = opened.map_or_else(|| VolumeMap::from_asset(&asset), Ok)?;
        if let Some(times) = times.filter(|times| *times > 1.0) {
            self.note_larger_error(path, times);
        }
        self.note_warnings(path, &asset);
        let diagnosis = prepare(&mut input.mesh, recipe.bake.keep_orientation).diagnosis;
        // The bake has found whether there are any: looking for them takes as long as building the tree.
        let union = has_hidden_triangles(&asset)
            .then(|| MeshDistance::new(&input.mesh, SignMethod::Auto, &diagnosis).union_mesh())
            .flatten();
        let primitive = input.placed_shape;
        let mesh = Arc::new(input.mesh);
        let outer = union.map_or(mesh.clone(), Arc::new);
        let surface = Surface::new(outer, primitive, recipe.bake.map.surface_offset());
        let content = *blake3::hash(identity.key.as_bytes()).as_bytes();
        Ok(Shape { map: Arc::new(map), mesh: Some(mesh), primitive, surface, origin, content })
    }

    /// How many times as wrong as the closure would have them volumes may be, in cells of several sizes, so that these are
    /// found in the memory that is allowed. None where nothing is gained: cells that are given, or so few equal ones that
    /// no search is worth it, maps with a density, which have equal cells, or too little memory for any search.
    fn times_error(&self, given: &Parameters, input: &Input, recipe: &Recipe) -> Option<f64> {
        let map = &recipe.bake.map;
        let is_endless = input.placed_shape.is_some_and(|placed| placed.shape().is_unbounded());
        if gives_cells(given) || map.density.is_some() || is_endless {
            return None;
        }
        let cells = equal_cells(input, map).filter(|cells| *cells > MOST_EQUAL_CELLS)?;
        let needed = (cells * BYTES_OF_SEARCH) as f64;
        [1.0, 2.0, 4.0, MOST_TIMES].into_iter().find(|times| needed <= times * map.max_memory as f64)
    }

    /// From the cache, opened as a map already, or baked, and what came of it kept if that can be.
    fn cached_or_baked(
        &mut self,
        path: &Path,
        key: &str,
        input: Input,
        recipe: &Recipe,
    ) -> Result<(Asset, Option<VolumeMap>), volmap_bake::Error> {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let cached = self.cache.join(format!("{stem}-{}.h5", &key[..24]));
        let opened = cached.is_file().then(|| asset::read(&cached).ok()).flatten();
        if let Some((map, asset)) =
            opened.and_then(|asset| Some((VolumeMap::from_asset(&asset).ok()?, asset)))
        {
            return Ok((asset, Some(map)));
        }
        self.watch.check()?;
        (self.on_bake)(path);
        let asset = bake(input, &recipe.bake, self.watch)?.asset;
        let kept = std::fs::create_dir_all(&self.cache).map_err(|error| error.to_string());
        let kept = kept.and_then(|()| {
            asset::write(&cached, &asset, recipe.compression).map_err(|error| error.to_string())
        });
        if let Err(error) = kept {
            self.notes.push(format!("{}: the map is not kept in the cache: {error}", path.display()));
        }
        Ok((asset, None))
    }

    fn open_asset(&mut self, path: &Path) -> Result<Shape, Error> {
        let bytes = std::fs::read(path).map_err(io_error(path))?;
        let content = *blake3::hash(&bytes).as_bytes();
        let in_file = |error| volmap_runtime::Error::InFile { path: path.to_owned(), error: Box::new(error) };
        let asset = asset::from_bytes(bytes).map_err(|error| in_file(error.into()))?;
        let map = VolumeMap::from_asset(&asset).map_err(in_file)?;
        if map.dimension() == Dimension::Two {
            let reason = "it is a map in two dimensions, and scenes are in three; name a mesh instead";
            return Err(Error::Scene { place: path.display().to_string(), reason: reason.into() });
        }
        self.note_warnings(path, &asset);
        Ok(Shape {
            map: Arc::new(map),
            mesh: None,
            primitive: None,
            surface: Surface::default(),
            origin: Origin::Asset,
            content,
        })
    }

    /// What the bake said of the mesh, which stands in the asset: told each time, not only when it was baked.
    fn note_warnings(&mut self, path: &Path, asset: &Asset) {
        let Some(Value::Text(warnings)) = asset.diagnosis.get("warnings") else { return };
        let notes =
            warnings.lines().map(|warning| format!("{}: {}", path.display(), printable_line(warning)));
        self.notes.extend(notes);
    }

    /// What is given, and what the scene decides: the support radius, the density, and the cells if they are left open.
    fn recipe(&self, given: &Parameters, density: Option<KernelKind>) -> Recipe {
        let mut given = given.clone();
        if let Some(kernel) = density {
            (given.density, given.kernel) = (Some(true), Some(DensityKernel(kernel)));
        }
        let mut recipe = given.recipe();
        recipe.bake.kernel_radius = Some(self.support_radius / self.closure.map_radius(1.0));
        let map = &mut recipe.bake.map;
        map.support_radius.get_or_insert(self.support_radius);
        map.max_memory = self.max_memory.unwrap_or(map.max_memory);
        if map.grid == GridChoice::FromRadius {
            map.grid = GridChoice::CellSize(self.cell_size);
        }
        if let Some(settings) = map.density.as_mut().filter(|_| density.is_some()) {
            settings.extension = density_map::EXTENSION;
        }
        recipe
    }
}

/// Whether parts of the mesh lie inside others.
fn has_hidden_triangles(asset: &Asset) -> bool {
    matches!(asset.diagnosis.get("hidden_triangles"), Some(Value::Integer(count)) if count.iter().any(|n| *n > 0))
}

/// The parameter that bakes a map like this one as a container.
fn invert(map: &VolumeMap) -> &'static str {
    if map.exterior() == Exterior::Solid { ", invert = true" } else { "" }
}

/// Whether the size of the cells is given, or how exact they are.
fn gives_cells(given: &Parameters) -> bool {
    given.gives(Group::Cells) || given.distance_tolerance.is_some() || given.normal_tolerance.is_some()
}

/// How many equal cells there would be, about, whatever is allowed; none if that can't be planned.
fn equal_cells(input: &Input, map: &MapSettings) -> Option<u64> {
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let corners = |triangle: &[u32; 3]| triangle.map(|v| DVec3::from(input.mesh.vertices[v as usize]));
    let area = input.mesh.triangles.iter().map(|triangle| area(corners(triangle))).sum();
    let [min, max] = input::bounds(&input.mesh);
    let unlimited = MapSettings { max_memory: u64::MAX, ..map.clone() };
    plan(&Extent { min, max, area }, &unlimited).ok().map(|plan| plan.estimate.cells)
}

/// Equal cells of a map, at most: 3 MB or so, which are as quickly baked as cells of several sizes are found.
const MOST_EQUAL_CELLS: u64 = 50_000;
/// Memory of the search for cells of several sizes, bytes for each equal cell instead, about: a canyon of 43 million, rough
/// and 1,500 support radii long, takes 240. With twice the error it takes half of that.
const BYTES_OF_SEARCH: u64 = 240;
/// How many times as wrong volumes may be where memory is short.
const MOST_TIMES: f64 = 8.0;

/// Containers with cells so many times larger are worth a note.
const COARSE: f64 = 1.2;

/// Whether a bake would need more memory than is allowed.
fn is_of_memory(error: &volmap_bake::Error) -> bool {
    match error {
        volmap_bake::Error::Sized { reason, .. } => is_of_memory(reason),
        error => matches!(error, volmap_bake::Error::Memory { .. }),
    }
}

/// What a bake says of its parameters, with the mesh that it is about and the scene's keys.
fn cannot_bake(path: &Path, error: volmap_bake::Error) -> Error {
    let reason = match error {
        volmap_bake::Error::Setting { parameter, reason } => format!("bake.{parameter}: {reason}"),
        volmap_bake::Error::Memory { needed, allowed } => format!(
            "it would need about {} MiB, more than {} MiB; take larger cells (`bake.cell_size`)",
            needed >> 20,
            allowed >> 20
        ),
        volmap_bake::Error::Sized { about, reason } => match cannot_bake(path, *reason) {
            Error::Scene { place, reason } => {
                return Error::Scene { place, reason: format!("{about}: {reason}") };
            }
            other => return other,
        },
        other => return Error::Bake(other),
    };
    Error::Scene { place: path.display().to_string(), reason: format!("can't be baked: {reason}") }
}

/// What is wrong with a shape or its placement, with the scene's keys.
fn of_shape(error: Error, key: &str) -> Error {
    match error {
        Error::Bake(volmap_bake::Error::Setting { parameter, reason }) => {
            let place = if parameter == "shape" { "shape".to_owned() } else { format!("bake.{parameter}") };
            Error::Scene { place: format!("{key}.{place}"), reason }
        }
        other => other,
    }
}
