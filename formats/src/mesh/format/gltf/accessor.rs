//! Buffers and accessors (glTF 2.0, sections 3.6.1 and 3.6.2), every range checked.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;

use super::json::{Accessor, Root, SparsePart};
use crate::mesh::binary::{Endian, Scalar, as_index};
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::text::show;

/// The buffers, each read when first needed.
pub struct Buffers<'a> {
    root: &'a Root,
    format: &'static str,
    /// The binary chunk of a GLB.
    chunk: Option<&'a [u8]>,
    folder: Option<&'a Path>,
    read: Vec<Option<Vec<u8>>>,
}

/// Items of one type in a buffer view.
struct Run {
    view: usize,
    offset: usize,
    count: usize,
    kind: Scalar,
    /// Numbers of one item.
    width: usize,
    place: String,
}

impl<'a> Buffers<'a> {
    pub fn new(
        root: &'a Root,
        format: &'static str,
        chunk: Option<&'a [u8]>,
        folder: Option<&'a Path>,
    ) -> Buffers<'a> {
        let read = root.buffers.iter().map(|_| None).collect();
        Buffers { root, format, chunk, folder, read }
    }

    pub fn bad(&self, place: &str, problem: impl Into<String>) -> MeshError {
        MeshError::malformed(self.format, place, problem)
    }

    /// An accessor of type VEC3.
    pub fn positions(&mut self, accessor: usize, budget: &mut Budget) -> Result<Vec<[f64; 3]>, MeshError> {
        let values = self.values(accessor, "VEC3", budget)?;
        budget.take(values.len(), 8, "the scene")?;
        Ok(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect())
    }

    /// An accessor of type SCALAR with whole numbers.
    pub fn indices(&mut self, accessor: usize, budget: &mut Budget) -> Result<Vec<u32>, MeshError> {
        let values = self.values(accessor, "SCALAR", budget)?;
        let indices: Option<Vec<u32>> = values.into_iter().map(as_index).collect();
        indices.ok_or_else(|| {
            self.bad(&format!("accessor {accessor}"), "an index is not a whole number; export again")
        })
    }

    /// An accessor of such a type, number by number; integers that stand for fractions become those.
    pub fn numbers(
        &mut self,
        accessor: usize,
        shape: &str,
        budget: &mut Budget,
    ) -> Result<Vec<f64>, MeshError> {
        self.values(accessor, shape, budget)
    }

    fn values(&mut self, index: usize, shape: &str, budget: &mut Budget) -> Result<Vec<f64>, MeshError> {
        let place = format!("accessor {index}");
        let root = self.root;
        let Some(accessor) = root.accessors.get(index) else {
            return Err(self.bad(&place, "there is no such accessor; export the file again"));
        };
        if accessor.shape != shape {
            return Err(self.bad(
                &place,
                format!("the type {shape} was expected, not {}", show(accessor.shape.as_bytes())),
            ));
        }
        let width = match shape {
            "VEC3" => 3,
            "VEC4" => 4,
            "MAT4" => 16,
            _ => 1,
        };
        budget.take(accessor.count, 8 * width, "the scene")?;
        let kind = self.kind(&place, accessor.component_type)?;
        let mut values = match accessor.buffer_view {
            Some(view) => self.run(&Run {
                view,
                offset: accessor.byte_offset,
                count: accessor.count,
                kind,
                width,
                place: place.clone(),
            })?,
            None => vec![0.0; accessor.count * width],
        };
        self.replace_sparse(accessor, kind, &mut values, &place, budget)?;
        if accessor.normalized {
            let largest = largest(kind);
            values.iter_mut().for_each(|value| *value = (*value / largest).max(-1.0));
        }
        Ok(values)
    }

    /// Section 3.6.2.3: the values of some items are elsewhere.
    fn replace_sparse(
        &mut self,
        accessor: &Accessor,
        kind: Scalar,
        values: &mut [f64],
        place: &str,
        budget: &mut Budget,
    ) -> Result<(), MeshError> {
        let Some(sparse) = &accessor.sparse else {
            return Ok(());
        };
        let width = values.len().checked_div(accessor.count).unwrap_or(1).max(1);
        budget.take(sparse.count, 8 * (width + 1), "the scene")?;
        let index_kind = self.kind(place, sparse.indices.component_type.unwrap_or(5125))?;
        let run = |part: &SparsePart, kind, width| Run {
            view: part.buffer_view,
            offset: part.byte_offset,
            count: sparse.count,
            kind,
            width,
            place: format!("{place}, sparse"),
        };
        let indices = self.run(&run(&sparse.indices, index_kind, 1))?;
        let items = self.run(&run(&sparse.values, kind, width))?;
        for (index, item) in indices.iter().zip(items.chunks_exact(width)) {
            let at = as_index(*index).map(|index| index as usize * width);
            let target = at.and_then(|at| values.get_mut(at..at + width));
            match target {
                Some(target) => target.copy_from_slice(item),
                None => return Err(self.bad(place, "a sparse index is out of range; export again")),
            }
        }
        Ok(())
    }

    fn kind(&self, place: &str, code: u32) -> Result<Scalar, MeshError> {
        Ok(match code {
            5120 => Scalar::I8,
            5121 => Scalar::U8,
            5122 => Scalar::I16,
            5123 => Scalar::U16,
            5125 => Scalar::U32,
            5126 => Scalar::F32,
            _ => return Err(self.bad(place, format!("there is no component type {code}"))),
        })
    }

    fn run(&mut self, run: &Run) -> Result<Vec<f64>, MeshError> {
        let root = self.root;
        let Some(view) = root.buffer_views.get(run.view) else {
            return Err(self.bad(&run.place, format!("there is no buffer view {}", run.view)));
        };
        let item = run.kind.size() * run.width;
        let stride = view.byte_stride.filter(|&stride| stride > 0).unwrap_or(item);
        if run.count == 0 {
            return Ok(Vec::new());
        }
        if stride < item {
            return Err(self.bad(&run.place, format!("the stride {stride} is less than {item} bytes")));
        }
        let end =
            (run.count - 1).checked_mul(stride).and_then(|n| n.checked_add(item)?.checked_add(run.offset));
        if end.is_none_or(|end| end > view.byte_length) {
            return Err(self.bad(
                &run.place,
                format!(
                    "{} items don't fit the {} bytes of buffer view {}; export the file again",
                    run.count, view.byte_length, run.view
                ),
            ));
        }
        self.load(view.buffer, &run.place)?;
        let buffer = self.buffer(view.buffer);
        let start = view.byte_offset.checked_add(run.offset);
        let bytes = start.and_then(|start| buffer.get(start..)).unwrap_or_default();
        if (run.count - 1) * stride + item > bytes.len() {
            return Err(self.bad(
                &run.place,
                format!(
                    "buffer {} has only {} bytes; it was cut: export the file again",
                    view.buffer,
                    buffer.len()
                ),
            ));
        }
        let mut values = Vec::with_capacity(run.count * run.width);
        for item in (0..run.count).map(|k| &bytes[k * stride..]) {
            let number = |c: usize| run.kind.read(&item[c * run.kind.size()..], Endian::Little);
            values.extend((0..run.width).map(number));
        }
        Ok(values)
    }

    fn buffer(&self, index: usize) -> &[u8] {
        match &self.read[index] {
            Some(bytes) => bytes,
            None => self.chunk.unwrap_or_default(),
        }
    }

    /// After this the buffer is in memory: a chunk of the GLB, a data URI, or a file beside ours.
    fn load(&mut self, index: usize, place: &str) -> Result<(), MeshError> {
        let root = self.root;
        let Some(buffer) = root.buffers.get(index) else {
            return Err(self.bad(place, format!("there is no buffer {index}")));
        };
        let place = format!("buffer {index}");
        let Some(uri) = &buffer.uri else {
            return match self.chunk {
                Some(_) if index == 0 => Ok(()),
                _ => Err(self.bad(&place, "it has no URI and there is no binary chunk")),
            };
        };
        if self.read[index].is_some() {
            return Ok(());
        }
        let bytes = match uri.strip_prefix("data:") {
            Some(data) => self.data_uri(data, &place)?,
            None => self.file(uri, buffer.byte_length, &place)?,
        };
        self.read[index] = Some(bytes);
        Ok(())
    }

    fn data_uri(&self, data: &str, place: &str) -> Result<Vec<u8>, MeshError> {
        let Some((_, text)) = data.split_once(";base64,") else {
            return Err(self.bad(place, "the data URI is not base64; export the file again"));
        };
        let decoded = BASE64_STANDARD.decode(text);
        decoded.map_err(|error| self.bad(place, format!("invalid base64: {error}; export again")))
    }

    fn file(&self, uri: &str, length: usize, place: &str) -> Result<Vec<u8>, MeshError> {
        let Some(folder) = self.folder else {
            return Err(MeshError::unsupported(
                self.format,
                format!("the external buffer {}", show(uri.as_bytes())),
                "read the model from its file, or export it as GLB",
            ));
        };
        let name = local_path(uri).ok_or_else(|| {
            self.bad(
                place,
                format!(
                    "the URI {} leads out of the model's folder, which is refused; put the buffer \
                     beside the model",
                    show(uri.as_bytes())
                ),
            )
        })?;
        let io = |error| MeshError::Io { what: format!("cannot read {place}, {}", name.display()), error };
        let file = File::open(folder.join(&name)).map_err(io)?;
        if !file.metadata().map_err(io)?.is_file() {
            return Err(io(std::io::Error::other("not a regular file")));
        }
        let mut bytes = Vec::new();
        file.take(length as u64).read_to_end(&mut bytes).map_err(io)?;
        Ok(bytes)
    }
}

/// A relative path without `..`, percent-decoded. Symbolic links are the user's own business.
pub fn local_path(uri: &str) -> Option<PathBuf> {
    let mut bytes = Vec::new();
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digit = |b: u8| (b as char).to_digit(16).map(|d| d as u8);
        bytes.push(digit(rest.next()?)? << 4 | digit(rest.next()?)?);
    }
    let text = String::from_utf8(bytes).ok()?;
    let strange = text.contains(['\\', ':', '\0']) || text.starts_with('/');
    let parts: Vec<&str> = text.split('/').filter(|part| !matches!(*part, "" | ".")).collect();
    if strange || parts.is_empty() || parts.contains(&"..") {
        return None;
    }
    Some(parts.iter().collect())
}

/// Section 3.11: integers stand for -1 to 1, or 0 to 1.
fn largest(kind: Scalar) -> f64 {
    match kind {
        Scalar::I8 => 127.0,
        Scalar::U8 => 255.0,
        Scalar::I16 => 32767.0,
        Scalar::U16 => 65535.0,
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uris_stay_in_their_folder() {
        assert_eq!(local_path("a%20b/./c.bin"), Some(PathBuf::from("a b/c.bin")));
        for uri in [
            "../a.bin",
            "a/../../b.bin",
            "/etc/passwd",
            "%2e%2e/a.bin",
            "C:/a.bin",
            "file:///a.bin",
            "http://x/a.bin",
            "..\\a.bin",
            "%2Fetc/passwd",
            "",
            ".",
            "a%2",
            "a%zz",
        ] {
            assert_eq!(local_path(uri), None, "{uri}");
        }
    }
}
