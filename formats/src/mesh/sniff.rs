//! Which format a file has: by what it holds first, by its name second.

use std::fmt;
use std::path::Path;

use super::MeshError;
use super::text::{parse, words};

/// The mesh formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// STL, ASCII or binary.
    Stl,
    /// Stanford PLY, ASCII or binary.
    Ply,
    /// Geomview OFF, with its variants COFF, NOFF, STOFF, 4OFF and nOFF of dimension 3.
    Off,
    /// glTF 2.0, JSON.
    Gltf,
    /// glTF 2.0, binary container.
    Glb,
    /// 3D Manufacturing Format.
    ThreeMf,
    /// VTK legacy, ASCII or binary.
    Vtk,
    /// VTK XML unstructured grid.
    Vtu,
    /// VTK XML polygons.
    Vtp,
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MeshFormat::Obj => "OBJ",
            MeshFormat::Stl => "STL",
            MeshFormat::Ply => "PLY",
            MeshFormat::Off => "OFF",
            MeshFormat::Gltf => "glTF",
            MeshFormat::Glb => "GLB",
            MeshFormat::ThreeMf => "3MF",
            MeshFormat::Vtk => "VTK",
            MeshFormat::Vtu => "VTU",
            MeshFormat::Vtp => "VTP",
        })
    }
}

impl MeshFormat {
    /// All formats.
    pub const ALL: [MeshFormat; 10] = [
        MeshFormat::Obj,
        MeshFormat::Stl,
        MeshFormat::Ply,
        MeshFormat::Off,
        MeshFormat::Gltf,
        MeshFormat::Glb,
        MeshFormat::ThreeMf,
        MeshFormat::Vtk,
        MeshFormat::Vtu,
        MeshFormat::Vtp,
    ];

    /// The usual file name extension, lower case, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            MeshFormat::Obj => "obj",
            MeshFormat::Stl => "stl",
            MeshFormat::Ply => "ply",
            MeshFormat::Off => "off",
            MeshFormat::Gltf => "gltf",
            MeshFormat::Glb => "glb",
            MeshFormat::ThreeMf => "3mf",
            MeshFormat::Vtk => "vtk",
            MeshFormat::Vtu => "vtu",
            MeshFormat::Vtp => "vtp",
        }
    }

    /// The format that a file's name promises.
    pub fn from_extension(path: &Path) -> Option<MeshFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        MeshFormat::ALL.into_iter().find(|f| f.extension() == extension)
    }

    /// The format of a file: what its content shows, or else what its name promises.
    ///
    /// # Errors
    /// [`MeshError::UnknownFormat`], with what the content seems to be.
    pub fn detect(path: &Path, bytes: &[u8]) -> Result<MeshFormat, MeshError> {
        let unknown = |problem: String| MeshError::UnknownFormat { problem };
        if let Some(problem) = known_stranger(bytes) {
            return Err(unknown(problem.into()));
        }
        let named = MeshFormat::from_extension(path);
        if let Some(shown) = signature(bytes) {
            return Ok(shown);
        }
        match (named, guess(bytes)) {
            // Without a signature these can't be what they are called.
            (Some(MeshFormat::Ply | MeshFormat::Glb | MeshFormat::ThreeMf), Some(guess)) => Ok(guess),
            (Some(MeshFormat::Stl | MeshFormat::Obj | MeshFormat::Off), Some(guess)) => Ok(guess),
            (Some(named), _) => Ok(named),
            (None, Some(guess)) => Ok(guess),
            (None, None) => Err(unknown(
                "neither the name nor the content is that of a known mesh format; export the mesh \
                 as OBJ, STL, PLY, OFF, glTF, GLB, 3MF, VTK, VTU or VTP"
                    .into(),
            )),
        }
    }
}

/// Formats that announce themselves.
fn signature(bytes: &[u8]) -> Option<MeshFormat> {
    let text = without_bom(bytes);
    if bytes.starts_with(b"glTF") {
        return Some(MeshFormat::Glb);
    }
    if bytes.starts_with(b"PK\x03\x04") {
        return Some(MeshFormat::ThreeMf);
    }
    if text.starts_with(b"ply\n") || text.starts_with(b"ply\r") || text.starts_with(b"ply ") {
        return Some(MeshFormat::Ply);
    }
    if text.starts_with(b"# vtk DataFile") {
        return Some(MeshFormat::Vtk);
    }
    if super::stl::has_binary_size(bytes) {
        return Some(MeshFormat::Stl);
    }
    let start = text.trim_ascii_start();
    if start.starts_with(b"{") {
        return Some(MeshFormat::Gltf);
    }
    let head = &start[..start.len().min(4096)];
    if head.starts_with(b"<") && find(head, b"<VTKFile").is_some() {
        let polygons = find(head, b"\"PolyData\"").or(find(head, b"'PolyData'"));
        return Some(if polygons.is_some() { MeshFormat::Vtp } else { MeshFormat::Vtu });
    }
    None
}

/// Formats that don't announce themselves, by the look of their first lines.
fn guess(bytes: &[u8]) -> Option<MeshFormat> {
    let text = without_bom(bytes);
    let head = &text[..text.len().min(65536)];
    let mut lines = head
        .split(|b| matches!(b, b'\n' | b'\r'))
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"));
    let first = lines.next()?;
    let word = words(first).next()?;
    if super::off::is_keyword(word) {
        return Some(MeshFormat::Off);
    }
    if super::stl::looks_ascii(bytes) {
        return Some(MeshFormat::Stl);
    }
    let is_obj = |line: &[u8]| {
        let mut words = words(line);
        matches!(words.next(), Some(b"v")) && words.take(3).all(|w| parse::<f64>(w).is_some())
    };
    (is_obj(first) || lines.any(is_obj)).then_some(MeshFormat::Obj)
}

/// What people try by mistake.
fn known_stranger(bytes: &[u8]) -> Option<&'static str> {
    let strangers: [(&[u8], &str); 11] = [
        (b"\x1f\x8b", "the file is compressed with gzip: unpack it first"),
        (b"BZh", "the file is compressed with bzip2: unpack it first"),
        (b"\xFD7zXZ", "the file is compressed with xz: unpack it first"),
        (b"\x28\xB5\x2F\xFD", "the file is compressed with zstd: unpack it first"),
        (b"\xFF\xFE", "the file is UTF-16 text: save it as UTF-8"),
        (b"\xFE\xFF", "the file is UTF-16 text: save it as UTF-8"),
        (b"version https://git-lfs", "the file is a Git LFS pointer, not a mesh: run `git lfs pull`"),
        (b"<!DOCTYPE", "the file is a web page, not a mesh: download it again"),
        (b"<html", "the file is a web page, not a mesh: download it again"),
        (b"Kaydara FBX", "the file is FBX: export it as glTF or OBJ"),
        (b"\x89HDF", "the file is HDF5: export its surface as VTP or PLY"),
    ];
    if bytes.is_empty() {
        return Some("the file is empty (0 bytes): export or download it again");
    }
    // 80 free bytes may come first in a binary STL.
    if super::stl::has_binary_size(bytes) {
        return None;
    }
    strangers.iter().find(|(start, _)| bytes.starts_with(start)).map(|(_, problem)| *problem)
}

fn without_bom(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes)
}

/// Where `needle` starts.
pub(super) fn find(bytes: &[u8], needle: &[u8]) -> Option<usize> {
    bytes.windows(needle.len()).position(|window| window == needle)
}
