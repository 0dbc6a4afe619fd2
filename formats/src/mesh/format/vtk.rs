//! VTK legacy: "VTK File Formats", VTK User's Guide, "Simple Legacy Formats", versions 1 to 5.1.
//!
//! Own reader: `vtkio` panics on damaged files and builds a C library for compression.

use super::vtk_cells::{Cells, POLYHEDRON, corners, polyhedron};
use super::vtk_ghosts::{Ghosts, LeftOut, is_ghost};
use crate::mesh::binary::{Endian, Scalar, as_count};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{Words, ends_early, not_a_number, parse, show, words};

pub const NAME: &str = "VTK";

const SURFACE: &str = "extract its surface (in ParaView: Extract Surface, save as .vtp)";

struct File<'a> {
    words: Words<'a>,
    binary: bool,
}

/// Connectivity and where each cell ends in it.
#[derive(Default)]
struct Lists {
    corners: Vec<f64>,
    ends: Vec<usize>,
}

/// Reads a data set of type POLYDATA or UNSTRUCTURED_GRID.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut file = header(bytes)?;
    let mut raw = RawMesh::new(NAME);
    raw.objects = 1;
    let mut cells = Lists::default();
    let mut kinds = Vec::new();
    let mut sections = Vec::new();
    let mut dataset = false;
    let mut ghosts = Ghosts::default();
    while let Some(word) = file.words.next() {
        let word = word.to_ascii_uppercase();
        match word.as_slice() {
            b"DATASET" => {
                dataset = true;
                dataset_kind(&mut file)?;
            }
            b"FIELD" => skip_field(&mut file)?,
            b"METADATA" => skip_metadata(&mut file),
            b"POINTS" => read_points(&mut file, &mut raw)?,
            b"VERTICES" => sections.push((2, read_lists(&mut file)?)),
            b"LINES" => sections.push((4, read_lists(&mut file)?)),
            b"POLYGONS" => sections.push((7, read_lists(&mut file)?)),
            b"TRIANGLE_STRIPS" => sections.push((6, read_lists(&mut file)?)),
            b"CELLS" => cells = read_lists(&mut file)?,
            b"CELL_TYPES" => {
                let count = file.words.count("the number of cell types")?;
                kinds = file.values(count, Scalar::I32, "cell types")?;
            }
            // What follows belongs to points and cells that were read before.
            b"POINT_DATA" | b"CELL_DATA" => {
                ghosts = find_ghosts(&mut file, word == b"CELL_DATA")?;
                break;
            }
            _ => {
                return Err(file.words.bad(format!("`{}` is not a known section", show(&word))));
            }
        }
    }
    if !dataset {
        return Err(file.words.bad(ends_early("`DATASET`")));
    }
    // The order of the cells' data.
    sections.sort_by_key(|(kind, _)| [2, 4, 7, 6].iter().position(|k| k == kind));
    let count = sections.iter().fold(cells.ends.len(), |n, (_, lists)| n + lists.ends.len());
    ghosts.check(&raw, count, raw.positions.len(), &|| "the data of points and cells".into())?;
    let mut shown = Shown { faces: Cells::default(), ghosts, left_out: LeftOut::default(), first_cell: 0 };
    for (kind, lists) in &sections {
        lists.add(&mut raw, &mut shown, |_| Some(*kind))?;
    }
    if kinds.len() != cells.ends.len() {
        return Err(file.words.bad(format!(
            "{} cells, but {} cell types; the file was cut or is damaged: export it again",
            cells.ends.len(),
            kinds.len()
        )));
    }
    cells.add(&mut raw, &mut shown, |k| as_count(kinds[k]).and_then(|k| u8::try_from(k).ok()))?;
    shown.faces.finish(&mut raw);
    raw.notes.extend(shown.left_out.note());
    Ok(raw)
}

/// The cells that are taken.
struct Shown {
    faces: Cells,
    ghosts: Ghosts,
    left_out: LeftOut,
    /// Cells of the sections before.
    first_cell: usize,
}

/// Looks for `vtkGhostType` in what follows `POINT_DATA` or `CELL_DATA`: `SCALARS vtkGhostType type [components]` and a
/// line with `LOOKUP_TABLE`, or in a field `vtkGhostType components tuples type`.
fn find_ghosts(file: &mut File, mut of_cells: bool) -> Result<Ghosts, MeshError> {
    let mut ghosts = Ghosts::default();
    let mut count = file.words.count("the number of values")?;
    while let Some(line) = file.words.next_line() {
        let items: Vec<&[u8]> = words(line).take(5).collect();
        let number = |word: &[u8]| parse::<usize>(word);
        let is_ghost = |name: &[u8]| std::str::from_utf8(name).is_ok_and(is_ghost);
        let (name, kind) = match items[..] {
            [b"POINT_DATA" | b"CELL_DATA", n] if number(n).is_some() => {
                (of_cells, count) = (items[0] == b"CELL_DATA", number(n).unwrap_or(0));
                continue;
            }
            [b"SCALARS", name, kind, ..] if is_ghost(name) => {
                file.words.next_line();
                (name, kind)
            }
            [name, b"1", tuples, kind] if is_ghost(name) && number(tuples) == Some(count) => (name, kind),
            _ => continue,
        };
        let kind = scalar(&file.words, kind)?;
        let values = file.values_here(count, kind, "values of vtkGhostType")?;
        ghosts.add(of_cells, &show(name), &values);
    }
    Ok(ghosts)
}

impl Lists {
    fn add(
        &self,
        raw: &mut RawMesh,
        shown: &mut Shown,
        kind: impl Fn(usize) -> Option<u8>,
    ) -> Result<(), MeshError> {
        let mut start = 0;
        for (k, &end) in self.ends.iter().enumerate() {
            let at = || format!("cell {k} (counted from 0)");
            let cell = &self.corners[start..end];
            start = end;
            let kind = kind(k).ok_or_else(|| raw.bad(at(), "the cell type is not a type number"))?;
            let points = cell.iter().filter_map(|&corner| as_count(corner));
            if shown.ghosts.leave_out(shown.first_cell + k, points, &mut shown.left_out) {
                continue;
            }
            if kind == POLYHEDRON {
                shown.faces.add_polyhedron(raw, polyhedron(raw, cell, 0, &at)?)?;
                continue;
            }
            shown.faces.add(raw, kind, &corners(raw, cell, 0, &at)?)?;
        }
        shown.first_cell += self.ends.len();
        Ok(())
    }
}

fn header(bytes: &[u8]) -> Result<File<'_>, MeshError> {
    let mut words = Words::new(bytes, NAME);
    let first = words.clone();
    let magic = words.next_line().unwrap_or_default();
    if !magic.starts_with(b"# vtk DataFile") {
        return Err(first.bad("a VTK file starts with `# vtk DataFile Version`"));
    }
    // The title.
    words.next_line();
    let mode = words.word("`ASCII` or `BINARY`")?.to_ascii_uppercase();
    let binary = match mode.as_slice() {
        b"ASCII" => false,
        b"BINARY" => true,
        _ => return Err(words.bad(format!("`{}` is neither ASCII nor BINARY", show(&mode)))),
    };
    Ok(File { words, binary })
}

fn dataset_kind(file: &mut File) -> Result<(), MeshError> {
    let kind = file.words.word("the type of the data set")?.to_ascii_uppercase();
    match kind.as_slice() {
        b"POLYDATA" | b"UNSTRUCTURED_GRID" => Ok(()),
        b"STRUCTURED_GRID" | b"STRUCTURED_POINTS" | b"RECTILINEAR_GRID" | b"FIELD" => {
            Err(MeshError::unsupported(NAME, format!("data set {}", show(&kind)), SURFACE))
        }
        _ => Err(file.words.bad(format!("`{}` is not a type of data set", show(&kind)))),
    }
}

/// `vtkIdType` is written as 32 bits, whatever it is in memory.
fn scalar(file: &Words, word: &[u8]) -> Result<Scalar, MeshError> {
    Ok(match word.to_ascii_lowercase().as_slice() {
        b"char" | b"vtktypeint8" => Scalar::I8,
        b"unsigned_char" | b"vtktypeuint8" => Scalar::U8,
        b"short" | b"vtktypeint16" => Scalar::I16,
        b"unsigned_short" | b"vtktypeuint16" => Scalar::U16,
        b"int" | b"vtktypeint32" | b"vtkidtype" => Scalar::I32,
        b"unsigned_int" | b"vtktypeuint32" => Scalar::U32,
        b"long" | b"vtktypeint64" => Scalar::I64,
        b"unsigned_long" | b"vtktypeuint64" => Scalar::U64,
        b"float" => Scalar::F32,
        b"double" => Scalar::F64,
        _ => return Err(file.bad(format!("`{}` is not a known number type", show(word)))),
    })
}

impl File<'_> {
    /// `count` numbers, from the next line on; the words that announce them were read.
    fn values(&mut self, count: usize, kind: Scalar, what: &str) -> Result<Vec<f64>, MeshError> {
        let size = if self.binary { kind.size() } else { 2 };
        self.words.room_for(count, size, what)?;
        self.words.next_line();
        self.values_here(count, kind, what)
    }

    /// `count` numbers.
    fn values_here(&mut self, count: usize, kind: Scalar, what: &str) -> Result<Vec<f64>, MeshError> {
        let size = if self.binary { kind.size() } else { 2 };
        self.words.room_for(count, size, what)?;
        let mut values = Vec::with_capacity(count);
        if self.binary {
            let rest = self.words.rest();
            if rest.len() < count * size {
                return Err(self.words.bad(ends_early(what)));
            }
            values.extend(rest[..count * size].chunks_exact(size).map(|item| kind.read(item, Endian::Big)));
            self.words.skip_bytes(count * size);
            return Ok(values);
        }
        for _ in 0..count {
            let word = self.words.word(what)?;
            let value = crate::mesh::text::any_number(word);
            values.push(value.ok_or_else(|| self.words.bad(not_a_number(word, what)))?);
        }
        Ok(values)
    }
}

fn read_points(file: &mut File, raw: &mut RawMesh) -> Result<(), MeshError> {
    let count = file.words.count("the number of points")?;
    let word = file.words.word("the type of the points")?;
    let kind = scalar(&file.words, word)?;
    let values = file.values(count.saturating_mul(3), kind, "point coordinates")?;
    raw.positions = values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    Ok(())
}

/// `n size`, then each cell as its length and its corners; since 5.1 `n size`, then the arrays
/// OFFSETS (n, starting with 0) and CONNECTIVITY (size).
fn read_lists(file: &mut File) -> Result<Lists, MeshError> {
    let count = file.words.count("the number of cells")?;
    let size = file.words.count("the size of the cells' list")?;
    let mut ahead = file.words.clone();
    ahead.next_line();
    if ahead.next().is_some_and(|word| word.eq_ignore_ascii_case(b"OFFSETS")) {
        file.words.next_line();
        return read_offsets(file, count, size);
    }
    let values = file.values(size, Scalar::I32, "numbers of cells")?;
    let mut lists = Lists::default();
    let mut at = 0;
    file.words.room_for_read(count, size)?;
    for k in 0..count {
        let length = values.get(at).copied().and_then(as_count);
        let end = length.and_then(|n| n.checked_add(at + 1)).filter(|&end| end <= values.len());
        let Some(end) = end else {
            return Err(file.words.bad(format!(
                "cell {k} of {count} (the section ends here) doesn't fit the announced {size} numbers; \
                 the file is damaged: export it again"
            )));
        };
        lists.corners.extend_from_slice(&values[at + 1..end]);
        lists.ends.push(lists.corners.len());
        at = end;
    }
    Ok(lists)
}

impl Words<'_> {
    /// Every cell takes at least one number.
    fn room_for_read(&self, count: usize, size: usize) -> Result<(), MeshError> {
        if count <= size {
            return Ok(());
        }
        Err(self.bad(format!("{count} cells don't fit {size} numbers; export the file again")))
    }
}

fn read_offsets(file: &mut File, count: usize, size: usize) -> Result<Lists, MeshError> {
    let mut arrays = Vec::new();
    for (name, length) in [("OFFSETS", count), ("CONNECTIVITY", size)] {
        let word = file.words.word(name)?;
        if !word.eq_ignore_ascii_case(name.as_bytes()) {
            return Err(file.words.bad(format!("`{name}` was expected, not `{}`", show(word))));
        }
        let word = file.words.word("the type of the numbers")?;
        let kind = scalar(&file.words, word)?;
        arrays.push(file.values(length, kind, name)?);
    }
    let corners = arrays.pop().unwrap_or_default();
    let offsets = arrays.pop().unwrap_or_default();
    let ends: Option<Vec<usize>> = offsets.iter().map(|&value| as_count(value)).collect();
    let ends = ends.filter(|ends| {
        ends.is_sorted() && ends.iter().all(|&e| e <= corners.len()) && ends.first().is_none_or(|&e| e == 0)
    });
    let Some(mut ends) = ends else {
        return Err(file.words.bad(
            "the OFFSETS of this section (it ends here) don't rise from 0 to the number of \
             CONNECTIVITY entries; the file is damaged: export it again",
        ));
    };
    if !ends.is_empty() {
        ends.remove(0);
    }
    Ok(Lists { corners, ends })
}

/// `name arrays`, then for each array `name components tuples type` and its values.
fn skip_field(file: &mut File) -> Result<(), MeshError> {
    file.words.word("the name of a field")?;
    let arrays = file.words.count("the number of arrays")?;
    for _ in 0..arrays {
        let mut name = file.words.word("the name of an array")?;
        if name.eq_ignore_ascii_case(b"METADATA") {
            skip_metadata(file);
            name = file.words.word("the name of an array")?;
        }
        let components = file.words.count(&format!("components of {}", show(name)))?;
        let tuples = file.words.count("tuples")?;
        let kind = file.words.word("the type of an array")?;
        let count = components.saturating_mul(tuples);
        let kind = match kind {
            b"string" => {
                file.words.next_line();
                skip_strings(file, count)?;
                continue;
            }
            kind => scalar(&file.words, kind)?,
        };
        file.values(count, kind, "values of a field")?;
    }
    Ok(())
}

/// ASCII: a line each. Binary: a length of 1, 2, 4 or 8 bytes, by its two highest bits, and bytes.
fn skip_strings(file: &mut File, count: usize) -> Result<(), MeshError> {
    file.words.room_for(count, 1, "strings")?;
    for _ in 0..count {
        if !file.binary {
            file.words.next_line();
            continue;
        }
        let rest = file.words.rest();
        let head = rest.first().copied().unwrap_or(0);
        let bytes = 8usize >> (head >> 6);
        let Some(raw) = rest.get(..bytes) else {
            return Err(file.words.bad(ends_early("a string")));
        };
        let length = raw[1..].iter().fold(usize::from(head & 63), |n, &b| (n << 8) | usize::from(b));
        file.words.skip_bytes(bytes.saturating_add(length).min(rest.len()));
    }
    Ok(())
}

/// Lines up to an empty one.
fn skip_metadata(file: &mut File) {
    file.words.next_line();
    while let Some(line) = file.words.next_line() {
        if words(line).next().is_none() {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_string_length_takes_one_to_eight_bytes() {
        assert_eq!([0u8, 0x40, 0x80, 0xC0].map(|head| 8usize >> (head >> 6)), [8, 4, 2, 1]);
    }
}
