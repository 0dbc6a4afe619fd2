//! STL: StereoLithography Interface Specification, 3D Systems 1989; ASCII and binary.
//!
//! Own reader: `stl_io` takes an ASCII file whose first line is only `solid` for a binary one, and
//! rounds ASCII numbers to f32.

use crate::mesh::binary::{Endian, Scalar};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::find;
use crate::mesh::text::{Words, show};

pub const NAME: &str = "STL";

/// 80 free bytes and the number of triangles.
const HEADER: usize = 84;
/// Normal, three corners, two free bytes.
const RECORD: usize = 50;

/// Reads an STL. Every facet has three vertices of its own: welding joins them.
pub fn read(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    if !has_binary_size(bytes) && looks_ascii(bytes) {
        return read_ascii(bytes);
    }
    read_binary(bytes)
}

/// The one sure sign of a binary STL: its size. The free bytes may well say `solid`.
pub fn has_binary_size(bytes: &[u8]) -> bool {
    bytes.len() >= HEADER && announced(bytes).checked_mul(RECORD) == Some(bytes.len() - HEADER)
}

fn announced(bytes: &[u8]) -> usize {
    Scalar::U32.read(&bytes[80..], Endian::Little) as usize
}

/// Starts with `solid`, a line with `facet` or `endsolid` follows, and there is no zero byte, as numbers have.
pub fn looks_ascii(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let head = text[..text.len().min(65536)].to_ascii_lowercase();
    head.starts_with(b"solid")
        && !head.contains(&0)
        && (find(&head, b"facet").is_some() || find(&head, b"endsolid").is_some())
}

fn read_binary(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut raw = RawMesh::new(NAME);
    raw.objects = 1;
    if bytes.len() < HEADER {
        return Err(raw.bad(
            format!("byte {}", bytes.len()),
            "the file ends inside the header of 84 bytes; it was cut, or isn't an STL: export it \
             again",
        ));
    }
    let count = announced(bytes);
    let records = &bytes[HEADER..];
    if count.checked_mul(RECORD).is_none_or(|size| size > records.len()) {
        return Err(raw.bad(
            "byte 80",
            format!(
                "{count} triangles are announced, but only {} fit the {} bytes that follow; the \
                 file was cut, or isn't an STL: export it again",
                records.len() / RECORD,
                records.len()
            ),
        ));
    }
    check_rest(&mut raw, count, records.len())?;
    raw.positions.reserve_exact(3 * count);
    for (k, record) in records.chunks_exact(RECORD).take(count).enumerate() {
        for corner in record[12..48].chunks_exact(12) {
            let at = |c: usize| Scalar::F32.read(&corner[4 * c..], Endian::Little);
            raw.positions.push([at(0), at(1), at(2)]);
        }
        let first = vertex_number(&raw, 3 * k)?;
        raw.faces.push(&[first, first + 1, first + 2]);
    }
    Ok(raw)
}

/// What the records of `bytes` bytes hold besides the announced triangles.
fn check_rest(raw: &mut RawMesh, count: usize, bytes: usize) -> Result<(), MeshError> {
    let (fit, rest) = (bytes / RECORD, bytes - count * RECORD);
    let fitting = || format!("{fit} triangle{} would fit", if fit == 1 { "" } else { "s" });
    if count == 0 {
        return Err(raw.bad(
            "byte 80",
            format!(
                "the header announces 0 triangles, and {bytes} bytes follow ({}); the program that wrote it did \
                 not finish: export the file again",
                fitting()
            ),
        ));
    }
    if rest > 0 {
        let more = if fit > count { format!(" ({})", fitting()) } else { String::new() };
        raw.notes.push(format!(
            "the header announces {count} triangles{more}; {rest} bytes after them are left out"
        ));
    }
    Ok(())
}

fn vertex_number(raw: &RawMesh, k: usize) -> Result<u32, MeshError> {
    u32::try_from(k)
        .ok()
        .filter(|&k| k < u32::MAX - 2)
        .ok_or_else(|| raw.bad(format!("triangle {}", k / 3), "too many triangles; split the mesh"))
}

fn read_ascii(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut words = Words::new(bytes, NAME);
    let mut raw = RawMesh::new(NAME);
    // Inside `outer loop`: its first vertex.
    let mut open: Option<usize> = None;
    let mut in_solid = false;
    while let Some(word) = words.next() {
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => {
                words.next_line();
                raw.objects += 1;
                in_solid = true;
            }
            b"endsolid" => {
                words.next_line();
                in_solid = false;
            }
            // The normal follows; it is often wrong, and the winding says the same.
            b"facet" => {
                words.next_line();
            }
            b"outer" => open = Some(raw.positions.len()),
            b"loop" | b"endfacet" => {}
            b"vertex" if open.is_some() => {
                let what = "vertex coordinate";
                let p = [words.number(what)?, words.number(what)?, words.number(what)?];
                raw.positions.push(p);
            }
            b"endloop" if open.is_some() => {
                close_loop(&words, &mut raw, open.take().unwrap_or(0))?;
            }
            _ => {
                return Err(words.bad(format!(
                    "`{}` was not expected here; the file is damaged: export it again",
                    show(word)
                )));
            }
        }
    }
    if in_solid || open.is_some() {
        return Err(words.bad(
            "the file ends without `endsolid`; it was cut: export it again (or add the line, if \
             the mesh is known to be complete)",
        ));
    }
    Ok(raw)
}

fn close_loop(words: &Words, raw: &mut RawMesh, start: usize) -> Result<(), MeshError> {
    let end = vertex_number(raw, raw.positions.len())?;
    if raw.positions.len() - start < 3 {
        return Err(words.bad("a facet needs three vertices; the file is damaged: export it again"));
    }
    let corners: Vec<u32> = (start as u32..end).collect();
    raw.faces.push(&corners);
    Ok(())
}
