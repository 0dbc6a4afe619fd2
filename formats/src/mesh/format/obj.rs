//! Wavefront OBJ: "Object Files (.obj)", appendix B1 of the Advanced Visualizer manual.
//!
//! Own reader: `tobj` gives no line numbers, refuses names that aren't UTF-8 and doesn't join
//! continued lines.

mod plain;

use std::borrow::Cow;

use self::plain::vertex_index;
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::skipped::Skipped;
use crate::mesh::text::{Words, not_a_number, number, parse, show, words};

pub const NAME: &str = "OBJ";

/// Whether a line is a vertex: OBJ has no header.
pub fn looks_so(bytes: &[u8]) -> bool {
    super::lines(bytes).any(|line| {
        let mut words = words(line);
        matches!(words.next(), Some(b"v" | b"V")) && words.take(3).all(|word| number(word).is_some())
    })
}

/// Reads an OBJ. Materials, normals and texture coordinates are ignored; index ranges are checked.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let lines = Words::new(bytes, NAME);
    let mut reader = Reader {
        raw: RawMesh::new(NAME),
        corners: Vec::new(),
        highest: (0, lines.clone()),
        left_out: LeftOut::default(),
        lines,
    };
    while reader.plain_line() || reader.line()? {}
    let Reader { mut raw, highest, left_out, .. } = reader;
    raw.notes.extend(left_out.note());
    let count = raw.positions.len();
    if highest.0 as usize >= count && !raw.faces.is_empty() {
        return Err(highest.1.bad(format!(
            "the face refers to vertex {} (counted from 1), but the file has only {count}; it is \
             damaged or was cut: export it again",
            u64::from(highest.0) + 1
        )));
    }
    raw.objects = raw.objects.max(1);
    Ok(raw)
}

struct Reader<'a> {
    lines: Words<'a>,
    raw: RawMesh,
    /// Of the face that is read.
    corners: Vec<u32>,
    /// The highest vertex that a face asked for, and where: vertices may follow their faces.
    highest: (u32, Words<'a>),
    left_out: LeftOut,
}

/// Statements that OBJ doesn't have, or that lead to other files.
#[derive(Default)]
pub struct LeftOut {
    count: usize,
    /// The first one's word and line.
    first: Option<(String, usize)>,
}

impl LeftOut {
    /// Takes a statement that is neither a vertex, a face, a line, a point nor an object.
    pub fn add(&mut self, word: &[u8], here: &Words, skipped: &mut Skipped) {
        if is_curved(word) {
            skipped.other += 1;
        }
        if is_curved(word) || is_attribute(word) {
            return;
        }
        self.count += 1;
        self.first.get_or_insert_with(|| (show(word), here.line()));
    }

    /// What to say of them.
    pub fn note(&self) -> Option<String> {
        let (word, line) = self.first.as_ref()?;
        Some(match self.count {
            1 => format!("line {line} begins with `{word}`, which is not read: left out"),
            n => format!(
                "{n} lines begin with words that are not read, the first with `{word}` in line {line}: left out"
            ),
        })
    }
}

impl<'a> Reader<'a> {
    /// Reads a line of the usual kind. False, and nothing done: it isn't.
    fn plain_line(&mut self) -> bool {
        match self.lines.rest() {
            [b'v', rest @ ..] if rest.first().is_some_and(u8::is_ascii_whitespace) => {
                let Some((position, length)) = plain::vertex(rest) else {
                    return false;
                };
                self.raw.positions.push(position);
                self.lines.finish_line(1 + length);
            }
            [b'f', rest @ ..] if rest.first().is_some_and(u8::is_ascii_whitespace) => {
                let Some(length) = plain::face(rest, self.raw.positions.len(), &mut self.corners) else {
                    return false;
                };
                if self.corners.iter().any(|&corner| corner > self.highest.0) {
                    self.add_face(self.lines.clone());
                } else {
                    self.raw.add_face(&self.corners);
                }
                self.lines.finish_line(1 + length);
            }
            _ => return false,
        }
        true
    }

    /// Reads any line. False: there is none.
    fn line(&mut self) -> Result<bool, MeshError> {
        let here = self.lines.clone();
        let Some(line) = logical_line(&mut self.lines) else {
            return Ok(false);
        };
        let raw = &mut self.raw;
        let mut words = words(&line);
        match words.next() {
            Some(b"v" | b"V") => raw.positions.push(position(&here, words)?),
            Some(b"f" | b"fo" | b"F" | b"FO") => {
                face(&here, words, raw.positions.len(), &mut self.corners)?;
                self.add_face(here);
            }
            Some(b"o" | b"O") => raw.objects += 1,
            Some(b"p" | b"P") => raw.skipped.points += 1,
            Some(b"l" | b"L") => raw.skipped.lines += 1,
            Some(word) => self.left_out.add(word, &here, &mut raw.skipped),
            None => {}
        }
        Ok(true)
    }

    fn add_face(&mut self, here: Words<'a>) {
        if let Some(&max) = self.corners.iter().max()
            && max > self.highest.0
        {
            self.highest = (max, here);
        }
        self.raw.add_face(&self.corners);
    }
}

/// A line without its comment, joined with those that a backslash continues it with. Comments and names, such as
/// `C:\models\`, may end in a backslash that continues nothing.
pub fn logical_line<'a>(lines: &mut Words<'a>) -> Option<Cow<'a, [u8]>> {
    let line = without_comment(lines.next_line()?);
    let Some(start) = continued(line).filter(|_| !is_name(line)) else {
        return Some(Cow::Borrowed(line));
    };
    let mut joined = start.to_vec();
    while let Some(line) = lines.next_line() {
        let line = without_comment(line);
        joined.push(b' ');
        match continued(line) {
            Some(part) => joined.extend_from_slice(part),
            None => {
                joined.extend_from_slice(line);
                break;
            }
        }
    }
    Some(Cow::Owned(joined))
}

/// What comes before the backslash that a line ends in.
fn continued(line: &[u8]) -> Option<&[u8]> {
    line.trim_ascii_end().strip_suffix(b"\\")
}

/// Whether a line gives a name that people choose, or a file's.
fn is_name(line: &[u8]) -> bool {
    let word = words(line).next();
    matches!(
        word,
        Some(b"o" | b"g" | b"usemtl" | b"mtllib" | b"usemap" | b"maplib" | b"shadow_obj" | b"trace_obj")
    )
}

fn without_comment(line: &[u8]) -> &[u8] {
    let end = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
    &line[..end]
}

/// The first three numbers; a weight or a colour may follow.
pub fn position<'a>(here: &Words, mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], MeshError> {
    let mut p = [0.0; 3];
    for c in &mut p {
        let word = words.next().ok_or_else(|| {
            here.bad("a vertex needs three coordinates; the line was cut: export the file again")
        })?;
        *c = number(word).ok_or_else(|| here.bad(not_a_number(word, "vertex coordinate")))?;
    }
    Ok(p)
}

/// Corners `v`, `v/vt`, `v//vn` or `v/vt/vn`; v counts from 1, or backwards from -1. Lines have them too.
pub fn face<'a>(
    here: &Words,
    words: impl Iterator<Item = &'a [u8]>,
    count: usize,
    corners: &mut Vec<u32>,
) -> Result<(), MeshError> {
    corners.clear();
    for word in words {
        let vertex = word.split(|&b| b == b'/').next().unwrap_or(word);
        let Some(v) = parse::<i64>(vertex).filter(|&v| v != 0) else {
            return Err(here.bad(format!(
                "`{}` is not a corner of a face: a vertex number from 1 up, or from -1 down, was \
                 expected",
                show(word)
            )));
        };
        corners.push(vertex_index(v, count).ok_or_else(|| {
            here.bad(format!(
                "the face refers to vertex `{}`, but only {count} came before it; the file is \
                 damaged or was cut: export it again",
                show(word)
            ))
        })?);
    }
    Ok(())
}

/// Free-form curves and surfaces.
fn is_curved(word: &[u8]) -> bool {
    matches!(word, b"curv" | b"curv2" | b"surf" | b"bzp" | b"bsp" | b"cdp" | b"cdc")
}

/// Statements that describe no element of their own: names, materials, what is drawn how, and parts of curves.
fn is_attribute(word: &[u8]) -> bool {
    const WORDS: [&[u8]; 36] = [
        b"vn",
        b"vt",
        b"vp",
        b"g",
        b"s",
        b"usemtl",
        b"mtllib",
        b"usemap",
        b"maplib",
        b"lod",
        b"bevel",
        b"c_interp",
        b"d_interp",
        b"shadow_obj",
        b"trace_obj",
        b"deg",
        b"bmat",
        b"step",
        b"cstype",
        b"parm",
        b"trim",
        b"hole",
        b"scrv",
        b"sp",
        b"end",
        b"con",
        b"mg",
        b"ctech",
        b"stech",
        b"res",
        b"VN",
        b"VT",
        b"VP",
        b"G",
        b"S",
        b"USEMTL",
    ];
    WORDS.contains(&word)
}
