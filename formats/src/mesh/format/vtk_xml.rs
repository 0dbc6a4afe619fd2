//! VTK XML: "VTK File Formats", VTK User's Guide, "XML File Formats": VTU and VTP.
//!
//! Data arrays are ASCII, base64 or, in the appended section, raw or base64; compressed by zlib,
//! LZ4, LZMA or not. Points, cells and `vtkGhostType` are decoded.

mod array;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use self::array::{Decoder, Source};
use super::vtk_cells::{Cells, POLYHEDRON, corners, polyhedron};
use super::vtk_ghosts::{Ghosts, LeftOut, is_ghost};
use super::xml::{attribute, line_of};
use crate::mesh::binary::as_count;
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{find, show};

pub const GRID_NAME: &str = "VTU";
pub const POLYGONS_NAME: &str = "VTP";

const SURFACE: &str = "extract its surface (in ParaView: Extract Surface, save as .vtp)";

/// A part of the grid with its own points.
#[derive(Default)]
struct Piece {
    points: usize,
    cells: usize,
    arrays: Vec<(String, String, Vec<f64>)>,
    ghosts: Ghosts,
}

/// Whether a VTK XML file says that it holds polygons. `None`: it isn't VTK XML.
pub fn holds_polygons(start: &[u8]) -> Option<bool> {
    let head = &start[..start.len().min(4096)];
    find(head, b"<VTKFile").filter(|_| head.starts_with(b"<"))?;
    Some(find(head, b"\"PolyData\"").or(find(head, b"'PolyData'")).is_some())
}

/// Reads a VTU or VTP, by what the file says itself; errors before that call it `format`.
pub fn read(bytes: &[u8], format: &'static str) -> Result<RawMesh, MeshError> {
    let mut raw = RawMesh::new(format);
    let (xml, appended) = split_appended(bytes);
    let mut reader = Reader::from_reader(xml);
    let mut decoder: Option<Decoder> = None;
    let mut budget = Budget::new(bytes.len());
    let mut piece = Piece::default();
    let mut section = String::new();
    let mut left_out = LeftOut::default();
    loop {
        let event = reader.read_event();
        let at = reader.buffer_position() as usize;
        let place = || line_of(bytes, at);
        let event = event.map_err(|error| raw.bad(place(), format!("invalid XML: {error}")))?;
        match event {
            Event::Start(tag) | Event::Empty(tag)
                if tag.local_name().as_ref() == "DataArray" && is_read(&section, &tag) =>
            {
                let decoder = decoder.as_ref().ok_or_else(|| raw.bad(place(), "no VTKFile"))?;
                let name = attribute(&tag, "Name").unwrap_or_default();
                let source = source(&tag, xml, at, appended);
                let problem = |problem: array::Problem| problem.into_error(&raw, line_of(bytes, at));
                let kind = attribute(&tag, "type").unwrap_or_default();
                let values = decoder.decode(&source, &kind, &mut budget).map_err(problem)?;
                match section.as_str() {
                    "CellData" | "PointData" => piece.ghosts.add(section == "CellData", &name, &values),
                    _ => piece.arrays.push((section.clone(), name, values)),
                }
            }
            Event::Start(tag) | Event::Empty(tag) => match tag.local_name().as_ref() {
                "VTKFile" => decoder = Some(file_tag(&tag, &mut raw, [Some(xml), appended], &place)?),
                "Piece" => piece = Piece::new(&tag),
                name if is_section(name) => section = name.to_string(),
                _ => {}
            },
            Event::End(tag) => match tag.local_name().as_ref() {
                "Piece" => std::mem::take(&mut piece).add(&mut raw, &mut budget, &mut left_out, &place)?,
                name if name == section => section.clear(),
                _ => {}
            },
            Event::Eof => break,
            _ => {}
        }
    }
    if decoder.is_none() {
        return Err(raw.bad("line 1", "there is no VTKFile element: it isn't a VTK XML file"));
    }
    check_closed(bytes, &raw)?;
    raw.notes.extend(left_out.note());
    Ok(raw)
}

/// Whether an array is needed: points, cells, and what tells which cells are hidden.
fn is_read(section: &str, tag: &BytesStart) -> bool {
    let ghost = || attribute(tag, "Name").is_some_and(|name| is_ghost(&name));
    is_geometry(section) || (matches!(section, "CellData" | "PointData") && ghost())
}

fn check_closed(bytes: &[u8], raw: &RawMesh) -> Result<(), MeshError> {
    let end = bytes.len();
    let tail = &bytes[end.saturating_sub(256)..];
    if find(tail, b"</VTKFile").is_some() {
        return Ok(());
    }
    Err(raw.bad(line_of(bytes, end), "the file ends without `</VTKFile>`; it was cut: export it again"))
}

fn is_section(name: &str) -> bool {
    is_geometry(name) || matches!(name, "PointData" | "CellData" | "FieldData")
}

fn is_geometry(section: &str) -> bool {
    matches!(section, "Points" | "Cells" | "Verts" | "Lines" | "Strips" | "Polys")
}

/// XML readers can't pass raw bytes: what comes before them, and the bytes after the underscore.
fn split_appended(bytes: &[u8]) -> (&[u8], Option<&[u8]>) {
    let Some(tag) = find_fast(bytes, b"<AppendedData") else {
        return (bytes, None);
    };
    let open = bytes[tag..].iter().position(|&b| b == b'>').map(|k| tag + k);
    let data = open.and_then(|open| {
        let rest = &bytes[open..];
        rest.iter().position(|&b| b == b'_').map(|k| &rest[k + 1..])
    });
    (&bytes[..tag], data)
}

/// Candidates are rare, so a search for the first byte comes first.
fn find_fast(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    let mut from = 0;
    while let Some(k) = bytes[from..].iter().position(|&b| b == needle[0]) {
        if bytes[from + k..].starts_with(needle) {
            return Some(from + k);
        }
        from += k + 1;
    }
    None
}

fn source<'a>(tag: &BytesStart, xml: &'a [u8], at: usize, appended: Option<&'a [u8]>) -> Source<'a> {
    let rest = &xml[at.min(xml.len())..];
    let text = &rest[..rest.iter().position(|&b| b == b'<').unwrap_or(rest.len())];
    match attribute(tag, "format").unwrap_or_default().as_str() {
        "appended" => {
            let offset = attribute(tag, "offset").and_then(|text| text.trim().parse().ok());
            let data = offset.and_then(|offset: usize| appended.and_then(|data| data.get(offset..)));
            Source::Appended(data)
        }
        "binary" => Source::Inline(text),
        _ => Source::Ascii(text),
    }
}

fn file_tag(
    tag: &BytesStart,
    raw: &mut RawMesh,
    [xml, appended]: [Option<&[u8]>; 2],
    place: &dyn Fn() -> String,
) -> Result<Decoder, MeshError> {
    let kind = attribute(tag, "type").unwrap_or_default();
    raw.format = match kind.as_str() {
        "PolyData" => POLYGONS_NAME,
        "UnstructuredGrid" => GRID_NAME,
        "" => return Err(raw.bad(place(), "VTKFile has no type")),
        _ => {
            let files = piece_files(xml.unwrap_or_default());
            let cure = if files.is_empty() { SURFACE.to_owned() } else { one_of(&files) };
            let feature = format!("a VTK XML file of type {}", show(kind.as_bytes()));
            return Err(MeshError::unsupported(raw.format, feature, cure));
        }
    };
    let text = |name: &str| attribute(tag, name).unwrap_or_default();
    Decoder::new(&text("byte_order"), &text("header_type"), &text("compressor"), appended)
        .map_err(|problem| problem.into_error(raw, place()))
}

/// The files that a collection (`.pvd`), a parallel file (`.pvtu`, `.pvtp`) or a multi-block one (`.vtm`) lists.
fn piece_files(xml: &[u8]) -> Vec<String> {
    let mut reader = Reader::from_reader(xml);
    let mut files = Vec::new();
    while let Ok(event) = reader.read_event() {
        match event {
            Event::Eof => break,
            Event::Start(tag) | Event::Empty(tag) => {
                let name = match tag.local_name().as_ref() {
                    "Piece" => attribute(&tag, "Source"),
                    "DataSet" => attribute(&tag, "file"),
                    _ => None,
                };
                files.extend(name.filter(|name| !name.is_empty()));
            }
            _ => {}
        }
    }
    files
}

fn one_of(files: &[String]) -> String {
    const MOST: usize = 3;
    let names: Vec<String> =
        files.iter().take(MOST).map(|name| format!("`{}`", show(name.as_bytes()))).collect();
    let names = names.join(", ");
    match files.len() {
        1 => format!("it names the file with the mesh: give {names}"),
        0..=MOST => format!("it names the files with the meshes: give one of {names}"),
        n => format!("it names the files with the meshes: give one of {names} and {} more", n - MOST),
    }
}

impl Piece {
    fn new(tag: &BytesStart) -> Piece {
        let count =
            |name: &str| attribute(tag, name).and_then(|text| text.trim().parse().ok()).unwrap_or(0usize);
        let polygons = ["NumberOfVerts", "NumberOfLines", "NumberOfStrips", "NumberOfPolys"];
        Piece {
            points: count("NumberOfPoints"),
            cells: polygons.iter().fold(count("NumberOfCells"), |n, k| n.saturating_add(count(k))),
            arrays: Vec::new(),
            ghosts: Ghosts::default(),
        }
    }

    fn polyhedra(&mut self) -> Polyhedra {
        let mut array = |name: &str| self.take("Cells", name).unwrap_or_default();
        Polyhedra {
            stream: array("faces"),
            stream_ends: array("faceoffsets"),
            corners: array("face_connectivity"),
            face_ends: array("face_offsets"),
            faces: array("polyhedron_to_faces"),
            cell_ends: array("polyhedron_offsets"),
        }
    }

    fn take(&mut self, section: &str, name: &str) -> Option<Vec<f64>> {
        let array = self.arrays.iter_mut().find(|(s, n, _)| s == section && (n == name || name.is_empty()));
        array.map(|(_, _, values)| std::mem::take(values))
    }

    fn add(
        mut self,
        raw: &mut RawMesh,
        budget: &mut Budget,
        left_out: &mut LeftOut,
        place: &dyn Fn() -> String,
    ) -> Result<(), MeshError> {
        raw.objects += 1;
        let first = u32::try_from(raw.positions.len()).unwrap_or(u32::MAX);
        let points = self.take("Points", "").unwrap_or_default();
        if Some(points.len()) != self.points.checked_mul(3) {
            return Err(raw.bad(
                place(),
                format!(
                    "the piece announces {} points, but its array has {} numbers; the file was cut \
                     or is damaged: export it again",
                    self.points,
                    points.len()
                ),
            ));
        }
        raw.positions.extend(points.chunks_exact(3).map(|p| [p[0], p[1], p[2]]));
        self.ghosts.check(raw, self.cells, self.points, place)?;
        let polyhedra = self.polyhedra();
        polyhedra.check(budget)?;
        let mut faces = Cells::default();
        let mut cells = 0usize;
        // The order of the cells' data.
        for (section, kind) in [("Verts", 2), ("Lines", 4), ("Polys", 7), ("Strips", 6), ("Cells", 0)] {
            let kinds = self.take(section, "types");
            let lists = (self.take(section, "connectivity"), self.take(section, "offsets"));
            let (Some(list), Some(offsets)) = lists else {
                continue;
            };
            let part = Part {
                place,
                section,
                first,
                kind,
                connectivity: &list,
                offsets: &offsets,
                kinds: kinds.as_deref(),
                first_cell: cells,
                ghosts: &self.ghosts,
                polyhedra: &polyhedra,
            };
            part.add(raw, &mut faces, left_out)?;
            cells += offsets.len();
        }
        if cells != self.cells {
            return Err(raw.bad(
                place(),
                format!(
                    "the piece announces {} cells, but its arrays have {cells}; the file was cut or \
                     is damaged: export it again",
                    self.cells
                ),
            ));
        }
        faces.finish(raw);
        Ok(())
    }
}

/// One list of cells.
struct Part<'a> {
    place: &'a dyn Fn() -> String,
    section: &'a str,
    /// The piece's first point.
    first: u32,
    /// The type of all cells, unless each has its own.
    kind: u8,
    /// The corners of all cells.
    connectivity: &'a [f64],
    /// Where each cell ends in them.
    offsets: &'a [f64],
    /// The type of each cell.
    kinds: Option<&'a [f64]>,
    /// Cells of the piece that came before.
    first_cell: usize,
    ghosts: &'a Ghosts,
    polyhedra: &'a Polyhedra,
}

/// The faces of a piece's polyhedra, as one of two kinds of arrays.
#[derive(Default)]
struct Polyhedra {
    /// `faces`: a stream for each polyhedron; before version 2.3.
    stream: Vec<f64>,
    /// `faceoffsets`: where each cell's stream ends; -1 if it is no polyhedron.
    stream_ends: Vec<f64>,
    /// `face_connectivity` and `face_offsets`: corners of all faces, and where each face ends in them.
    corners: Vec<f64>,
    face_ends: Vec<f64>,
    /// `polyhedron_to_faces` and `polyhedron_offsets`: faces of all polyhedra, and where each cell ends in them.
    faces: Vec<f64>,
    cell_ends: Vec<f64>,
}

impl Polyhedra {
    /// Polyhedra may name a face as often as they like.
    fn check(&self, budget: &mut Budget) -> Result<(), MeshError> {
        for &face in &self.faces {
            let corners = as_count(face).and_then(|face| part(&self.corners, &self.face_ends, face));
            budget.take(corners.map_or(0, <[f64]>::len), 8, "the file")?;
        }
        Ok(())
    }

    /// The faces of a cell, by the number of its first point.
    fn of_cell(
        &self,
        raw: &RawMesh,
        cell: usize,
        first: u32,
        at: &dyn Fn() -> String,
    ) -> Result<Vec<Vec<u32>>, MeshError> {
        let missing =
            || raw.bad(at(), "the faces of this polyhedron are missing or damaged: export the file again");
        if !self.stream_ends.is_empty() {
            let end = self.stream_ends.get(cell).copied().and_then(as_count).ok_or_else(missing)?;
            let before = self.stream_ends[..cell].iter().rev().find_map(|&end| as_count(end)).unwrap_or(0);
            let stream = self.stream.get(before..end).ok_or_else(missing)?;
            return polyhedron(raw, stream, first, at);
        }
        let faces = part(&self.faces, &self.cell_ends, cell).ok_or_else(missing)?;
        let face = |&face: &f64| {
            let list = as_count(face).and_then(|face| part(&self.corners, &self.face_ends, face));
            corners(raw, list.ok_or_else(missing)?, first, at)
        };
        faces.iter().map(face).collect()
    }
}

/// The `k`th part of a list, by where the parts end.
fn part<'a>(list: &'a [f64], ends: &[f64], k: usize) -> Option<&'a [f64]> {
    let end = as_count(*ends.get(k)?)?;
    let start = if k == 0 { 0 } else { as_count(ends[k - 1])? };
    list.get(start..end)
}

impl Part<'_> {
    fn add(&self, raw: &mut RawMesh, faces: &mut Cells, left_out: &mut LeftOut) -> Result<(), MeshError> {
        let mut start = 0;
        for (k, &end) in self.offsets.iter().enumerate() {
            let at = || format!("{}, {}, cell {k} (counted from 0)", (self.place)(), self.section);
            let cell =
                as_count(end).filter(|&end| start <= end).and_then(|end| self.connectivity.get(start..end));
            let Some(cell) = cell else {
                return Err(raw.bad(at(), "the offsets don't rise within the connectivity; export again"));
            };
            let kind = match self.section {
                "Cells" => self.kinds.and_then(|kinds| kinds.get(k).copied()).and_then(as_count),
                _ => Some(usize::from(self.kind)),
            };
            let Some(kind) = kind.and_then(|kind| u8::try_from(kind).ok()) else {
                return Err(raw.bad(at(), "the array `types` has no valid type for this cell"));
            };
            start += cell.len();
            let points = cell.iter().filter_map(|&corner| as_count(corner));
            if self.ghosts.leave_out(self.first_cell + k, points, left_out) {
                continue;
            }
            if kind == POLYHEDRON {
                faces.add_polyhedron(raw, self.polyhedra.of_cell(raw, k, self.first, &at)?)?;
                continue;
            }
            let corners = corners(raw, cell, self.first, &at)?;
            faces.add(raw, kind, &corners)?;
        }
        Ok(())
    }
}
