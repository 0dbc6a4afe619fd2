//! 3MF: core specification 1.3, with the paths of the production extension. What slicers say of a model's parts is
//! looked up (`slicer.rs`), for they write modifiers and negative parts as objects like any other.
//!
//! Own reader on `zip` and `quick-xml`: `threemf` holds whole documents without a limit, reads
//! neither paths nor prefixed elements, and refuses resources in mixed order.

mod slicer;

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Cursor, Read};

use glam::{DAffine3, DVec3};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, XmlVersion};
use zip::ZipArchive;

use self::slicer::{Slicer, Volume};
use super::xml::attribute;
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::show;

pub const NAME: &str = "3MF";

/// Components may contain components; no real file goes deeper.
const MAX_DEPTH: usize = 64;
/// Instances take time even if they are empty.
const MAX_INSTANCES: usize = 1_000_000;

type Archive<'a> = ZipArchive<Cursor<&'a [u8]>>;

#[derive(Default)]
struct Part {
    unit: f64,
    objects: BTreeMap<u64, Object>,
    items: Vec<Reference>,
    /// Elements of objects that aren't read: shapes of extensions.
    unknown: BTreeSet<String>,
}

#[derive(Default)]
struct Object {
    /// `model` if the file doesn't say; also `solidsupport`, `support`, `surface`, `other`.
    kind: String,
    name: String,
    vertices: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    components: Vec<Reference>,
}

#[derive(Clone)]
struct Reference {
    /// Of another part, if any.
    path: Option<String>,
    object: u64,
    affine: DAffine3,
    /// Slicers mark what is not to be printed.
    printable: bool,
}

/// What is left to add: the part that refers to an object, how, and how deep it is among components; the object that it
/// is a component of.
struct Todo {
    here: String,
    reference: Reference,
    depth: usize,
    parent: Option<u64>,
}

/// Reads the items of the build, or all objects with meshes if nothing is to be built.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut raw = RawMesh::new(NAME);
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
        raw.bad("the archive", format!("{error}; the file was cut or isn't 3MF: export it again"))
    })?;
    let mut budget = Budget::new(bytes.len());
    let root = root_part(&mut archive)?;
    let mut parts = BTreeMap::new();
    load_part(&mut archive, &root, &mut budget, &mut parts)?;
    raw.unit = Some(parts[&root].unit);
    let mut items = parts[&root].items.clone();
    if items.is_empty() {
        let with_mesh = parts[&root].objects.iter().filter(|(_, o)| !o.triangles.is_empty());
        items = with_mesh.map(|(&object, _)| Reference::to(object)).collect();
    }
    let todo = |item| Todo { here: root.clone(), reference: item, depth: 0, parent: None };
    let mut todo: Vec<Todo> = items.into_iter().rev().map(todo).collect();
    let slicer = Slicer::read(&mut archive, &mut budget)?;
    let mut taken = BTreeSet::new();
    let mut left_out = LeftOut::default();
    let mut instances = 0;
    while let Some(Todo { here, reference, depth, parent }) = todo.pop() {
        let path = reference.path.clone().unwrap_or(here);
        load_part(&mut archive, &path, &mut budget, &mut parts)?;
        let place = format!("{path}, object {}", reference.object);
        let Some(object) = parts[&path].objects.get(&reference.object) else {
            return Err(raw.bad(place, "there is no such object; the file is damaged: export again"));
        };
        instances += 1;
        if depth > MAX_DEPTH || instances > MAX_INSTANCES {
            return Err(
                raw.bad(place, "components contain each other, or there are over a million; export again")
            );
        }
        taken.insert((path.clone(), reference.object));
        let role = slicer.part(parent, reference.object);
        if let Some(reason) = reason_to_leave_out(object, &reference, role) {
            left_out.add(reason, &object.name, reference.object);
            continue;
        }
        let volumes = slicer.volumes(reference.object);
        add_object(&mut raw, object, &reference.affine, volumes, &mut budget, &place)?;
        volumes.iter().for_each(|volume| left_out.add(volume.role.clone(), &volume.name, reference.object));
        let id = reference.object;
        for component in object.components.iter().rev() {
            let affine = reference.affine * component.affine;
            let reference = Reference { affine, ..component.clone() };
            todo.push(Todo { here: path.clone(), reference, depth: depth + 1, parent: Some(id) });
        }
        if todo.len() > MAX_INSTANCES {
            return Err(raw.bad(place, "the file has over a million components; split it"));
        }
    }
    note_unused(&parts, &taken, &mut left_out);
    raw.notes.extend(left_out.notes());
    Ok(raw)
}

/// What is left out, by the reason, and the names of some.
#[derive(Default)]
struct LeftOut(BTreeMap<String, Vec<String>>);

impl LeftOut {
    fn add(&mut self, reason: String, name: &str, object: u64) {
        let name = if name.is_empty() { String::new() } else { format!(" ({})", show(name.as_bytes())) };
        self.0.entry(reason).or_default().push(format!("object {object}{name}"));
    }

    fn notes(self) -> impl Iterator<Item = String> {
        const MOST: usize = 5;
        self.0.into_iter().map(|(reason, names)| {
            let some = names.iter().take(MOST).cloned().collect::<Vec<_>>().join(", ");
            match names.len().saturating_sub(MOST) {
                0 => format!("left out, {reason}: {some}"),
                more => format!("left out, {reason}: {some} and {more} more"),
            }
        })
    }
}

/// Why an object of the build isn't part of the solid.
fn reason_to_leave_out(object: &Object, reference: &Reference, role: Option<&str>) -> Option<String> {
    if let Some(role) = role {
        return Some(role.to_owned());
    }
    if !reference.printable {
        return Some("not to be printed".into());
    }
    match object.kind.as_str() {
        "" | "model" | "surface" => None,
        kind => Some(format!("of the type `{}`", show(kind.as_bytes()))),
    }
}

/// Objects that nothing refers to, and shapes that aren't read.
fn note_unused(parts: &BTreeMap<String, Part>, taken: &BTreeSet<(String, u64)>, left_out: &mut LeftOut) {
    for (path, part) in parts {
        for (&id, object) in &part.objects {
            if !object.triangles.is_empty() && !taken.contains(&(path.clone(), id)) {
                left_out.add("not in the build".into(), &object.name, id);
            }
        }
        for name in &part.unknown {
            left_out.0.entry("elements that are not read".into()).or_default().push(format!("`{name}`"));
        }
    }
}

impl Reference {
    fn to(object: u64) -> Reference {
        Reference { path: None, object, affine: DAffine3::IDENTITY, printable: true }
    }
}

fn add_object(
    raw: &mut RawMesh,
    object: &Object,
    affine: &DAffine3,
    without: &[Volume],
    budget: &mut Budget,
    place: &str,
) -> Result<(), MeshError> {
    if object.triangles.is_empty() {
        return Ok(());
    }
    raw.objects += 1;
    // Growing a list holds up to three times its size for a moment.
    budget.take(object.vertices.len(), 3 * 24, "the build")?;
    budget.take(object.triangles.len(), 3 * 20, "the build")?;
    let (first, count) = (raw.positions.len(), object.vertices.len());
    let Some(first) = u32::try_from(first).ok().filter(|_| first + count < u32::MAX as usize) else {
        return Err(MeshError::TooLarge { problem: "too many vertices; split the build".into() });
    };
    raw.positions.extend(object.vertices.iter().map(|&p| affine.transform_point3(DVec3::from(p)).to_array()));
    let mirrored = affine.matrix3.determinant() < 0.0;
    for (k, &[a, b, c]) in object.triangles.iter().enumerate() {
        if let Some(bad) = [a, b, c].into_iter().find(|&v| v as usize >= count) {
            return Err(raw.bad(
                format!("{place}, triangle {k} (counted from 0)"),
                format!("refers to vertex {bad}, but there are only {count}; export the file again"),
            ));
        }
        if without.iter().any(|volume| volume.triangles.contains(&k)) {
            continue;
        }
        let (b, c) = if mirrored { (c, b) } else { (b, c) };
        raw.faces.push(&[first + a, first + b, first + c]);
    }
    Ok(())
}

fn bad(place: &str, problem: impl Into<String>) -> MeshError {
    MeshError::malformed(NAME, place, problem)
}

fn entry_name(path: &str) -> String {
    path.trim_start_matches('/').to_string()
}

/// The part that the package's relationships call the 3D model, or else the first of its kind.
fn root_part(archive: &mut Archive) -> Result<String, MeshError> {
    let mut found = None;
    if let Ok(entry) = archive.by_name("_rels/.rels") {
        let mut reader = Reader::from_reader(BufReader::new(entry.take(1 << 20)));
        let mut buffer = Vec::new();
        while let Ok(event) = reader.read_event_into(&mut buffer) {
            match event {
                Event::Eof => break,
                Event::Start(tag) | Event::Empty(tag) => {
                    let kind = attribute(&tag, "Type").unwrap_or_default();
                    if kind.ends_with("/3dmodel") {
                        found = attribute(&tag, "Target");
                    }
                }
                _ => {}
            }
            buffer.clear();
        }
    }
    let found = found.map(|path| entry_name(&path));
    let found = found.filter(|path| archive.index_for_name(path).is_some());
    let first = || archive.file_names().flatten().find(|name| name.ends_with(".model"));
    found
        .or_else(|| first().map(|name| name.into_owned()))
        .ok_or_else(|| bad("the archive", "there is no 3D model in it: it is a ZIP, but not a 3MF file"))
}

fn load_part(
    archive: &mut Archive,
    path: &str,
    budget: &mut Budget,
    parts: &mut BTreeMap<String, Part>,
) -> Result<(), MeshError> {
    if parts.contains_key(path) {
        return Ok(());
    }
    let entry = archive.by_name(path);
    let entry = entry.map_err(|error| bad(path, format!("{error}; export the file again")))?;
    let limit = budget.left() / 4;
    // One more than the limit tells whether there is more.
    let limited = BufReader::new(entry.take(limit + 1));
    let mut reader = Reader::from_reader(limited);
    let part = read_part(&mut reader, path)?;
    // Every byte of XML makes at most four in memory: a vertex of 24 takes 27 characters.
    let text = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX);
    budget.take(text, 4, path)?;
    parts.insert(path.to_string(), part);
    Ok(())
}

fn read_part<R: BufRead>(reader: &mut Reader<R>, path: &str) -> Result<Part, MeshError> {
    let mut part = Part::default();
    let mut object: Option<(u64, Object)> = None;
    let mut buffer = Vec::new();
    let mut depth = 0usize;
    loop {
        buffer.clear();
        let event = reader.read_event_into(&mut buffer);
        let place = || format!("{path}, byte {}", reader.buffer_position());
        let event = event.map_err(|error| {
            bad(&place(), format!("{error}; the file was cut or is damaged: export it again"))
        })?;
        match &event {
            Event::Eof if depth > 0 => {
                return Err(bad(&place(), "the XML ends early; the file was cut: export it again"));
            }
            Event::Eof => return Ok(part),
            Event::Start(tag) | Event::Empty(tag) => {
                depth += usize::from(matches!(event, Event::Start(_)));
                element(tag, &mut part, &mut object, &place)?;
            }
            Event::End(tag) => {
                depth = depth.saturating_sub(1);
                if tag.local_name().as_ref() == "object"
                    && let Some((id, object)) = object.take()
                {
                    part.objects.insert(id, object);
                }
            }
            _ => {}
        }
    }
}

fn element(
    tag: &BytesStart,
    part: &mut Part,
    object: &mut Option<(u64, Object)>,
    place: &dyn Fn() -> String,
) -> Result<(), MeshError> {
    let name = tag.local_name();
    match (name.as_ref(), object) {
        ("model", _) => {
            check_extensions(tag)?;
            part.unit = unit(tag, place)?;
        }
        ("object", object) => {
            let text = |name: &str| attribute(tag, name).unwrap_or_default();
            let new = Object { kind: text("type"), name: text("name"), ..Object::default() };
            *object = Some((parse(tag, "id", place)?, new));
        }
        ("vertex", Some((_, object))) => {
            let p = ["x", "y", "z"].map(|name| parse::<f64>(tag, name, place));
            let [x, y, z] = p;
            object.vertices.push([x?, y?, z?]);
        }
        ("triangle", Some((_, object))) => {
            let t = ["v1", "v2", "v3"].map(|name| parse::<u32>(tag, name, place));
            let [a, b, c] = t;
            object.triangles.push([a?, b?, c?]);
        }
        ("component", Some((_, object))) => object.components.push(reference(tag, place)?),
        ("item", _) => part.items.push(reference(tag, place)?),
        (name, Some(_)) if !is_known(name) => {
            part.unknown.insert(show(name.as_bytes()));
        }
        _ => {}
    }
    Ok(())
}

/// Elements of objects that leave their shape as it is.
fn is_known(name: &str) -> bool {
    const KNOWN: [&str; 12] = [
        "mesh",
        "vertices",
        "triangles",
        "components",
        "metadatagroup",
        "metadata",
        "trianglesets",
        "triangleset",
        "ref",
        "refrange",
        "vertex",
        "triangle",
    ];
    KNOWN.contains(&name)
}

/// Core specification, section 2.3.1: a file can't be read without the extensions that it requires. Materials,
/// sets of triangles and the paths of production don't change shapes, or are read.
fn check_extensions(tag: &BytesStart) -> Result<(), MeshError> {
    const READ: [&str; 3] = ["/production/", "/material/", "/trianglesets/"];
    let required = attribute(tag, "requiredextensions").unwrap_or_default();
    for prefix in required.split_ascii_whitespace() {
        let key = format!("xmlns:{prefix}");
        let space = tag.attributes().flatten().find(|a| a.key.as_ref() == key);
        let space = space.and_then(|a| Some(a.normalized_value(XmlVersion::default()).ok()?.into_owned()));
        let space = space.unwrap_or_default();
        if !READ.iter().any(|known| space.contains(known)) {
            let name = if space.is_empty() { prefix } else { &space };
            return Err(MeshError::unsupported(
                NAME,
                format!("the required extension {}", show_long(name)),
                "export the model as plain triangles: without beam lattices, slices, volumes, implicit shapes \
                 and encryption",
            ));
        }
    }
    Ok(())
}

/// Names of extensions are addresses.
fn show_long(name: &str) -> String {
    crate::text::quoted(name, 120)
}

fn parse<T: std::str::FromStr>(
    tag: &BytesStart,
    name: &str,
    place: &dyn Fn() -> String,
) -> Result<T, MeshError> {
    let text = attribute(tag, name).unwrap_or_default();
    text.trim().parse().map_err(|_| {
        let (name, text) = (show(name.as_bytes()), show(text.as_bytes()));
        bad(&place(), format!("the attribute {name} is not a valid number: `{text}`; export again"))
    })
}

fn unit(tag: &BytesStart, place: &dyn Fn() -> String) -> Result<f64, MeshError> {
    let name = attribute(tag, "unit").unwrap_or("millimeter".into());
    Ok(match name.as_str() {
        "micron" => 1e-6,
        "millimeter" => 1e-3,
        "centimeter" => 1e-2,
        "inch" => 0.0254,
        "foot" => 0.3048,
        "meter" => 1.0,
        other => {
            let problem = format!("`{}` is not a unit of 3MF", show(other.as_bytes()));
            return Err(bad(&place(), problem));
        }
    })
}

/// An object and its transform: four rows of three numbers, for points as rows (section 3.3).
fn reference(tag: &BytesStart, place: &dyn Fn() -> String) -> Result<Reference, MeshError> {
    let object = parse(tag, "objectid", place)?;
    let path = attribute(tag, "path").map(|path| entry_name(&path));
    let mut affine = DAffine3::IDENTITY;
    if let Some(text) = attribute(tag, "transform") {
        let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
        let Ok(m) = <[f64; 12]>::try_from(numbers) else {
            return Err(bad(&place(), "a transform needs 12 numbers; export the file again"));
        };
        affine = DAffine3::from_cols_array(&m);
    }
    let printable = attribute(tag, "printable").is_none_or(|value| !matches!(value.as_str(), "0" | "false"));
    Ok(Reference { path, object, affine, printable })
}
