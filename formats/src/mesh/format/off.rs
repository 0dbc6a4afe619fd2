//! OFF: Geomview manual, section 4.2.5; `[ST][C][N][4]OFF` in any order of its letters (pymeshlab writes `NCOFF`), and
//! `nOFF` of dimension 3; ASCII. The numbers may follow without a blank (`OFF8 6 0`), as in ModelNet40.
//!
//! Own reader: `off-rs` rounds to f32 and knows neither normals nor homogeneous coordinates.

use crate::mesh::error::MeshError;
use crate::mesh::raw::{MAX_COORDINATE, RawMesh};
use crate::mesh::text::{Words, ends_early, not_a_number, number, parse, show, words};

/// What comes before a vertex' normal, colour and texture coordinates.
#[derive(Clone, Copy, PartialEq)]
enum Layout {
    Xyz,
    /// Homogeneous: x/w, y/w, z/w.
    Xyzw,
}

pub const NAME: &str = "OFF";

/// Whether a file's first line begins with the keyword.
pub fn starts_with_keyword(line: &[u8]) -> bool {
    words(line).next().is_some_and(|word| keyword(word).is_some())
}

/// The keyword that a word is or begins with, if nothing but a number follows. Every prefix comes once at most.
fn keyword(word: &[u8]) -> Option<&[u8]> {
    const PREFIXES: [&[u8]; 5] = [b"ST", b"C", b"N", b"4", b"n"];
    let mut rest = word;
    let mut left = PREFIXES.to_vec();
    while let Some(k) = left.iter().position(|prefix| rest.starts_with(prefix)) {
        rest = &rest[left.swap_remove(k).len()..];
    }
    let end = rest.strip_prefix(b"OFF").or(rest.strip_prefix(b"off").filter(|_| rest.len() == word.len()))?;
    end.first().is_none_or(u8::is_ascii_digit).then_some(&word[..word.len() - end.len()])
}

/// Reads an OFF.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut lines = Lines(Words::new(bytes, NAME));
    let mut raw = RawMesh::new(NAME);
    let (layout, vertices, faces) = header(&mut lines)?;
    lines.0.room_for(vertices, 6, "vertices")?;
    raw.positions.reserve_exact(vertices);
    for _ in 0..vertices {
        raw.positions.push(position(&mut lines, layout)?);
    }
    lines.0.room_for(faces, 2, "faces")?;
    let mut corners = Vec::new();
    for _ in 0..faces {
        face(&mut lines, vertices, &mut corners)?;
        raw.add_face(&corners);
    }
    raw.objects = 1;
    if let Ok((line, here)) = lines.next("the end") {
        let (number, text) = (here.line(), show(line));
        raw.notes.push(format!("what follows the last face, from line {number} on, is left out: `{text}`"));
    }
    Ok(raw)
}

/// Lines with something in them besides a comment.
struct Lines<'a>(Words<'a>);

impl<'a> Lines<'a> {
    fn next(&mut self, what: &str) -> Result<(&'a [u8], Words<'a>), MeshError> {
        loop {
            let here = self.0.clone();
            let Some(line) = self.0.next_line() else {
                return Err(self.0.bad(ends_early(what)));
            };
            let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
            let line = line[..end].trim_ascii();
            if !line.is_empty() {
                return Ok((line, here));
            }
        }
    }
}

/// The keyword (optional) and the numbers of vertices, faces and edges (optional, never used).
fn header(lines: &mut Lines) -> Result<(Layout, usize, usize), MeshError> {
    let (mut line, mut here) = lines.next("the header")?;
    let mut layout = Layout::Xyz;
    if let Some(word) = words(line).next().and_then(keyword) {
        if word.contains(&b'4') {
            layout = Layout::Xyzw;
        }
        let general = word.contains(&b'n');
        line = line[word.len()..].trim_ascii();
        if line.starts_with(b"BINARY") {
            return Err(MeshError::unsupported(
                NAME,
                "binary OFF",
                "save the mesh as ASCII OFF or binary PLY",
            ));
        }
        if line.is_empty() {
            (line, here) = lines.next("the number of vertices")?;
        }
        if general {
            line = dimension(lines, line, &mut here)?;
        }
    }
    let mut counts = words(line).map(parse::<usize>);
    match (counts.next().flatten(), counts.next().flatten()) {
        (Some(vertices), Some(faces)) => Ok((layout, vertices, faces)),
        _ => Err(here.bad(not_counts(line))),
    }
}

fn not_counts(line: &[u8]) -> String {
    let text = show(line);
    match words(line).next() {
        Some(word) if word.to_ascii_uppercase().ends_with(b"OFF") => format!(
            "`{text}` is not a kind of OFF that is read; those are OFF with ST, C, N, 4 or n before it: export the \
             mesh as OFF or PLY"
        ),
        _ => format!("the numbers of vertices and faces were expected, not `{text}`"),
    }
}

/// `nOFF` says its dimension first. Returns what follows on the line, or else the next line.
fn dimension<'a>(lines: &mut Lines<'a>, line: &'a [u8], here: &mut Words<'a>) -> Result<&'a [u8], MeshError> {
    let word = words(line).next().unwrap_or(line);
    if word != b"3" {
        return Err(here.bad(format!("dimension 3 was expected, not `{}`", show(word))));
    }
    let rest = line[word.len()..].trim_ascii();
    if !rest.is_empty() {
        return Ok(rest);
    }
    let (line, next) = lines.next("the number of vertices")?;
    *here = next;
    Ok(line)
}

/// The first numbers of a line; a normal, a colour and texture coordinates may follow.
fn position(lines: &mut Lines, layout: Layout) -> Result<[f64; 3], MeshError> {
    let (line, here) = lines.next("a vertex")?;
    let mut words = words(line);
    let mut next = || {
        let word = words.next().ok_or_else(|| {
            here.bad("a vertex needs three coordinates; the line was cut: export the file again")
        })?;
        number(word).ok_or_else(|| here.bad(not_a_number(word, "vertex coordinate")))
    };
    let p = [next()?, next()?, next()?];
    if layout == Layout::Xyz {
        return Ok(p);
    }
    let w = next()?;
    let p = p.map(|c| c / w);
    if p.iter().all(|c| c.abs() <= MAX_COORDINATE) {
        return Ok(p);
    }
    Err(here.bad("the homogeneous coordinate w puts this vertex at infinity; repair the line"))
}

/// The number of corners and the corners; a colour may follow. A long list may go on in more lines.
fn face(lines: &mut Lines, vertices: usize, corners: &mut Vec<u32>) -> Result<(), MeshError> {
    let (line, mut here) = lines.next("a face")?;
    let mut rest = line;
    let first = split_word(&mut rest).unwrap_or(line);
    let count = parse::<usize>(first)
        .ok_or_else(|| here.bad(format!("the number of corners was expected, not `{}`", show(first))))?;
    here.room_for(count, 2, "corners of a face")?;
    corners.clear();
    while corners.len() < count {
        let Some(word) = split_word(&mut rest) else {
            (rest, here) = lines.next("the next corner of a face")?;
            continue;
        };
        let index = parse::<u32>(word).filter(|&index| (index as usize) < vertices);
        corners.push(index.ok_or_else(|| {
            here.bad(format!(
                "`{}` is not a vertex number from 0 to {}; the file is damaged: export it again",
                show(word),
                vertices as i64 - 1
            ))
        })?);
    }
    Ok(())
}

fn split_word<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let word = words(rest).next()?;
    let line = rest.trim_ascii_start();
    *rest = &line[word.len()..];
    Some(word)
}
