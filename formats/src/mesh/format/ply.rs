//! PLY: Greg Turk, "The PLY Polygon File Format", 1994; ASCII and binary in both byte orders.
//!
//! Own reader: `ply-rs-bw` refuses property names that scanners and CloudCompare write, such as
//! `scalar_C2C[<0.1]`, and takes any element count of a header for true if it has no properties.

use crate::mesh::binary::{Endian, Scalar, as_count, as_index};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::{Words, any_number, ends_early, not_a_number, parse, show};
use crate::text::thousands;

pub const NAME: &str = "PLY";

struct Element {
    name: Vec<u8>,
    count: usize,
    properties: Vec<Property>,
}

struct Property {
    name: Vec<u8>,
    /// The type of a list's length.
    list: Option<Scalar>,
    value: Scalar,
}

/// Where values come from.
struct Body<'a> {
    /// Place and, in ASCII, words.
    words: Words<'a>,
    /// The byte order, if binary.
    binary: Option<Endian>,
}

/// Reads a PLY: elements `vertex`, `face` and `tristrips`; others are skipped.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut words = Words::new(bytes, NAME);
    let (binary, elements) = header(&mut words)?;
    let mut body = Body { words, binary };
    let mut raw = RawMesh::new(NAME);
    for element in &elements {
        let smallest = element.properties.iter().map(|p| body.smallest(p)).sum();
        let name = show(&element.name);
        body.words.room_for(element.count, smallest, &format!("`{name}` elements"))?;
        match element.name.as_slice() {
            b"vertex" => read_vertices(&mut body, element, &mut raw)?,
            b"face" => read_faces(&mut body, element, &mut raw)?,
            b"tristrips" => read_strips(&mut body, element, &mut raw)?,
            kind => {
                skip_element(&mut body, element)?;
                match kind {
                    b"edge" => raw.skipped.lines = raw.skipped.lines.saturating_add(element.count),
                    _ if element.count == 0 => {}
                    _ => raw.notes.push(format!(
                        "the element `{name}` ({} of them) is not read: left out",
                        thousands(element.count as u64)
                    )),
                }
            }
        }
    }
    raw.objects = 1;
    if let Some(note) = body.rest() {
        raw.notes.push(note);
    }
    Ok(raw)
}

fn header(words: &mut Words) -> Result<(Option<Endian>, Vec<Element>), MeshError> {
    let mut elements: Vec<Element> = Vec::new();
    let mut binary = None;
    let first = words.clone();
    let magic = words.next_line().unwrap_or_default();
    if magic.trim_ascii() != b"ply" {
        return Err(first.bad("a PLY file starts with the line `ply`"));
    }
    loop {
        let here = words.clone();
        let Some(line) = words.next_line() else {
            return Err(words.bad("the header has no `end_header`; the file was cut or isn't PLY"));
        };
        let items: Vec<&[u8]> = crate::mesh::text::words(line).collect();
        let bad = || here.bad(format!("`{}` is not a valid header line", show(line)));
        match items.as_slice() {
            [] | [b"comment" | b"obj_info", ..] => {}
            [b"end_header"] => break,
            [b"format", format, ..] => {
                binary = Some(match *format {
                    b"ascii" => None,
                    b"binary_little_endian" => Some(Endian::Little),
                    b"binary_big_endian" => Some(Endian::Big),
                    _ => return Err(bad()),
                });
            }
            [b"element", name, count] => elements.push(Element {
                name: name.to_vec(),
                count: parse(count).ok_or_else(bad)?,
                properties: Vec::new(),
            }),
            [b"property", kind @ ..] => {
                let element = elements.last_mut().ok_or_else(bad)?;
                element.properties.push(property(kind).ok_or_else(bad)?);
            }
            // Blender 2.4 wrote its name without `comment`. Before the elements nothing shifts.
            _ if elements.is_empty() && binary.is_some() => {}
            _ => return Err(bad()),
        }
    }
    let binary = binary.ok_or_else(|| words.bad("the header has no `format` line"))?;
    Ok((binary, elements))
}

fn property(items: &[&[u8]]) -> Option<Property> {
    let (list, value, name) = match items {
        [b"list", length, value, name @ ..] => (Some(scalar(length)?), value, name),
        [value, name @ ..] => (None, value, name),
        [] => return None,
    };
    Some(Property { name: name.join(&b' '), list, value: scalar(value)? })
}

fn scalar(word: &[u8]) -> Option<Scalar> {
    Some(match word {
        b"char" | b"int8" => Scalar::I8,
        b"uchar" | b"uint8" => Scalar::U8,
        b"short" | b"int16" => Scalar::I16,
        b"ushort" | b"uint16" => Scalar::U16,
        b"int" | b"int32" => Scalar::I32,
        b"uint" | b"uint32" => Scalar::U32,
        b"int64" => Scalar::I64,
        b"uint64" => Scalar::U64,
        b"float" | b"float32" => Scalar::F32,
        b"double" | b"float64" => Scalar::F64,
        _ => return None,
    })
}

impl Body<'_> {
    fn bad(&self, problem: impl Into<String>) -> MeshError {
        match self.binary {
            None => self.words.bad(problem),
            Some(_) => MeshError::malformed(NAME, format!("byte {}", self.words.offset()), problem),
        }
    }

    /// What to say of bytes after the last element.
    fn rest(&self) -> Option<String> {
        let rest = self.words.rest();
        let blank = rest.iter().all(|b| b.is_ascii_whitespace() || matches!(b, 0 | 0x1A));
        (!blank).then(|| {
            let bytes = thousands(rest.len() as u64);
            format!("{bytes} bytes after the last element that the header announces are left out")
        })
    }

    /// The fewest bytes that a property takes.
    fn smallest(&self, property: &Property) -> usize {
        match self.binary {
            None => 2,
            Some(_) => property.list.unwrap_or(property.value).size(),
        }
    }

    fn value(&mut self, kind: Scalar, name: &[u8]) -> Result<f64, MeshError> {
        let Some(endian) = self.binary else {
            let Some(word) = self.words.next() else {
                return Err(self.bad(ends_early(&format!("property `{}`", show(name)))));
            };
            return any_number(word).ok_or_else(|| self.bad(not_a_number(word, &show(name))));
        };
        let rest = self.words.rest();
        if rest.len() < kind.size() {
            return Err(self.bad(ends_early(&format!("property `{}`", show(name)))));
        }
        self.words.skip_bytes(kind.size());
        Ok(kind.read(rest, endian))
    }

    fn list(&mut self, property: &Property, into: &mut Vec<f64>) -> Result<(), MeshError> {
        into.clear();
        let Some(length) = property.list else {
            into.push(self.value(property.value, &property.name)?);
            return Ok(());
        };
        let length = self.value(length, &property.name)?;
        let length = as_count(length).ok_or_else(|| self.bad(not_a_length(length, &property.name)))?;
        let size = if self.binary.is_some() { property.value.size() } else { 2 };
        self.words.room_for(length, size, "items of a list")?;
        for _ in 0..length {
            into.push(self.value(property.value, &property.name)?);
        }
        Ok(())
    }
}

fn not_a_length(length: f64, name: &[u8]) -> String {
    format!(
        "{length} is not a length of the list `{}`; the header doesn't fit the data: export the file again",
        show(name)
    )
}

fn read_vertices(body: &mut Body, element: &Element, raw: &mut RawMesh) -> Result<(), MeshError> {
    let axis = |name: &[u8]| {
        let found = |p: &Property| p.name == name;
        let capital = |p: &Property| p.name.eq_ignore_ascii_case(name);
        element.properties.iter().position(found).or(element.properties.iter().position(capital))
    };
    let (Some(x), Some(y), Some(z)) = (axis(b"x"), axis(b"y"), axis(b"z")) else {
        return Err(body.bad("the element `vertex` needs the properties x, y and z"));
    };
    raw.positions.reserve_exact(element.count);
    let mut list = Vec::new();
    for _ in 0..element.count {
        let mut p = [0.0; 3];
        for (k, property) in element.properties.iter().enumerate() {
            body.list(property, &mut list)?;
            let value = list.first().copied().unwrap_or(f64::NAN);
            for (c, axis) in p.iter_mut().zip([x, y, z]) {
                if axis == k {
                    *c = value;
                }
            }
        }
        raw.positions.push(p);
    }
    Ok(())
}

/// The list of corners: `vertex_indices` or `vertex_index`, or the only list there is.
fn corner_list(body: &Body, element: &Element) -> Result<usize, MeshError> {
    let is_list = |p: &Property| p.list.is_some();
    let named = element
        .properties
        .iter()
        .position(|p| is_list(p) && matches!(p.name.as_slice(), b"vertex_indices" | b"vertex_index"));
    let lists = element.properties.iter().filter(|p| is_list(p)).count();
    let only = element.properties.iter().position(is_list).filter(|_| lists == 1);
    named.or(only).ok_or_else(|| {
        body.bad(format!("the element `{}` needs a list property `vertex_indices`", show(&element.name)))
    })
}

fn read_faces(body: &mut Body, element: &Element, raw: &mut RawMesh) -> Result<(), MeshError> {
    if element.count == 0 {
        return Ok(());
    }
    let corners_at = corner_list(body, element)?;
    let (mut list, mut corners) = (Vec::new(), Vec::new());
    for _ in 0..element.count {
        for (k, property) in element.properties.iter().enumerate() {
            body.list(property, &mut list)?;
            if k == corners_at {
                corners.clear();
                for &value in &list {
                    corners.push(index(body, value)?);
                }
            }
        }
        raw.add_face(&corners);
    }
    Ok(())
}

fn index(body: &Body, value: f64) -> Result<u32, MeshError> {
    as_index(value).ok_or_else(|| {
        body.bad(format!("{value} is not a vertex number; the file is damaged: export it again"))
    })
}

/// Strips of triangles, ended by -1 each.
fn read_strips(body: &mut Body, element: &Element, raw: &mut RawMesh) -> Result<(), MeshError> {
    if element.count == 0 {
        return Ok(());
    }
    let corners_at = corner_list(body, element)?;
    let (mut list, mut strip) = (Vec::new(), Vec::new());
    for _ in 0..element.count {
        for (k, property) in element.properties.iter().enumerate() {
            body.list(property, &mut list)?;
            if k != corners_at {
                continue;
            }
            for part in list.split(|&value| value == -1.0) {
                strip.clear();
                for &value in part {
                    strip.push(index(body, value)?);
                }
                if !strip.is_empty() {
                    raw.add_strip(&strip);
                }
            }
        }
    }
    Ok(())
}

fn skip_element(body: &mut Body, element: &Element) -> Result<(), MeshError> {
    if element.properties.is_empty() {
        return Ok(());
    }
    let mut list = Vec::new();
    for _ in 0..element.count {
        for property in &element.properties {
            body.list(property, &mut list)?;
        }
    }
    Ok(())
}
