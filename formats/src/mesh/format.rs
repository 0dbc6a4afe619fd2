//! The table of mesh formats. A new one is a reader beside the others, and here its `mod`, its variant and its row:
//! detection, the lists in messages and help texts, and the tests follow from the table.

use std::fmt;
use std::path::{Path, PathBuf};

use super::error::{MeshError, RECONSTRUCT};
use super::raw::RawMesh;
use super::text::{parse, without_bom, words};

mod gltf;
pub(super) mod obj;
mod off;
mod ply;
mod raw_triangles;
mod stl;
mod strangers;
mod threemf;
mod vtk;
mod vtk_cells;
mod vtk_ghosts;
mod vtk_xml;
mod xml;

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
    /// Raw triangles: text with nine numbers a line.
    RawTriangles,
}

/// All that is known of a format outside its reader.
struct Entry {
    format: MeshFormat,
    name: &'static str,
    /// Lower case, without the dot; the usual one first.
    extensions: &'static [&'static str],
    description: &'static str,
    /// How surely a file's bytes show the format.
    sign: fn(&[u8]) -> Sign,
    /// From the file's bytes and, if the file has one, the folder that it lies in.
    read: fn(&[u8], Option<&Path>) -> Result<RawMesh, MeshError>,
    /// Other files that the geometry is in, relative to the file's folder.
    references: fn(&[u8]) -> Vec<PathBuf>,
}

/// How surely bytes show a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Sign {
    /// They don't.
    None,
    /// The first lines look so.
    Looks,
    /// An outer structure that other formats don't have.
    Structure,
    /// A magic number.
    Magic,
}

/// A row for each variant, in the same order.
static TABLE: [Entry; 11] = [
    Entry {
        format: MeshFormat::Obj,
        name: obj::NAME,
        extensions: &["obj"],
        description: "Wavefront OBJ",
        sign: |bytes| sign_if(obj::looks_so(bytes), Sign::Looks),
        read: |bytes, _| obj::read(bytes),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Stl,
        name: stl::NAME,
        extensions: &["stl"],
        description: "STL, ASCII or binary",
        sign: |bytes| match stl::has_binary_size(bytes) {
            true => Sign::Structure,
            false => sign_if(stl::looks_ascii(bytes), Sign::Looks),
        },
        read: |bytes, _| stl::read(bytes),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Ply,
        name: ply::NAME,
        extensions: &["ply"],
        description: "Stanford PLY, ASCII or binary",
        sign: |bytes| {
            let starts = |start: &&[u8]| without_bom(bytes).starts_with(start);
            sign_if([&b"ply\n"[..], b"ply\r", b"ply "].iter().any(starts), Sign::Magic)
        },
        read: |bytes, _| ply::read(bytes),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Off,
        name: off::NAME,
        extensions: &["off"],
        description: "Geomview OFF, ASCII",
        sign: |bytes| sign_if(lines(bytes).next().is_some_and(off::starts_with_keyword), Sign::Structure),
        read: |bytes, _| off::read(bytes),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Gltf,
        name: gltf::NAME,
        extensions: &["gltf"],
        description: "glTF 2.0, JSON",
        sign: |bytes| sign_if(start(bytes).starts_with(b"{"), Sign::Structure),
        read: gltf::read,
        references: gltf::buffer_files,
    },
    Entry {
        format: MeshFormat::Glb,
        name: gltf::BINARY_NAME,
        extensions: &["glb"],
        description: "glTF 2.0, binary",
        sign: |bytes| sign_if(bytes.starts_with(b"glTF"), Sign::Magic),
        read: gltf::read,
        references: gltf::buffer_files,
    },
    Entry {
        format: MeshFormat::ThreeMf,
        name: threemf::NAME,
        extensions: &["3mf"],
        description: "3D Manufacturing Format",
        sign: |bytes| sign_if(bytes.starts_with(b"PK\x03\x04"), Sign::Magic),
        read: |bytes, _| threemf::read(bytes),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Vtk,
        name: vtk::NAME,
        extensions: &["vtk"],
        description: "VTK legacy, ASCII or binary",
        sign: |bytes| sign_if(without_bom(bytes).starts_with(b"# vtk DataFile"), Sign::Magic),
        read: |bytes, _| vtk::read(bytes),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Vtu,
        name: vtk_xml::GRID_NAME,
        extensions: &["vtu"],
        description: "VTK XML, unstructured grid",
        sign: |bytes| sign_if(vtk_xml::holds_polygons(start(bytes)) == Some(false), Sign::Structure),
        read: |bytes, _| vtk_xml::read(bytes, vtk_xml::GRID_NAME),
        references: no_references,
    },
    Entry {
        format: MeshFormat::Vtp,
        name: vtk_xml::POLYGONS_NAME,
        extensions: &["vtp"],
        description: "VTK XML, polygons",
        sign: |bytes| sign_if(vtk_xml::holds_polygons(start(bytes)) == Some(true), Sign::Structure),
        read: |bytes, _| vtk_xml::read(bytes, vtk_xml::POLYGONS_NAME),
        references: no_references,
    },
    Entry {
        format: MeshFormat::RawTriangles,
        name: raw_triangles::NAME,
        extensions: &["raw", "tri"],
        description: "raw triangles, nine numbers a line",
        // Points with colours and normals are nine numbers a line too: only the name tells.
        sign: |_| Sign::None,
        read: |bytes, _| raw_triangles::read(bytes),
        references: no_references,
    },
];

const _: () = {
    let mut row = 0;
    while row < TABLE.len() {
        assert!(TABLE[row].format as usize == row, "the rows are in the order of the variants");
        row += 1;
    }
};

fn sign_if(condition: bool, sign: Sign) -> Sign {
    if condition { sign } else { Sign::None }
}

fn no_references(_: &[u8]) -> Vec<PathBuf> {
    Vec::new()
}

/// A text without a byte order mark and blanks in front.
fn start(bytes: &[u8]) -> &[u8] {
    without_bom(bytes).trim_ascii_start()
}

/// The first lines, without empty ones and comments.
fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let text = without_bom(bytes);
    text[..text.len().min(65536)]
        .split(|b| matches!(b, b'\n' | b'\r'))
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty() && !line.starts_with(b"#"))
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl MeshFormat {
    /// All formats.
    pub const ALL: [MeshFormat; TABLE.len()] = {
        let mut all = [MeshFormat::Obj; TABLE.len()];
        let mut row = 0;
        while row < TABLE.len() {
            all[row] = TABLE[row].format;
            row += 1;
        }
        all
    };

    fn entry(self) -> &'static Entry {
        &TABLE[self as usize]
    }

    /// The short name, as messages have it: `OBJ`.
    pub fn name(self) -> &'static str {
        self.entry().name
    }

    /// A few words: `Wavefront OBJ`.
    pub fn description(self) -> &'static str {
        self.entry().description
    }

    /// The file name extensions, lower case, without the dot; the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        self.entry().extensions
    }

    /// The names of all formats, for messages and help texts: `OBJ, STL, PLY, ...`.
    pub fn list() -> String {
        MeshFormat::ALL.map(MeshFormat::name).join(", ")
    }

    /// The format that a file's name promises.
    pub fn from_extension(path: &Path) -> Option<MeshFormat> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        MeshFormat::ALL.into_iter().find(|format| format.extensions().contains(&extension.as_str()))
    }

    /// The format of a file: what its content shows, or else what its name promises.
    ///
    /// # Errors
    /// [`MeshError::UnknownFormat`], with what the content seems to be.
    pub fn detect(path: &Path, bytes: &[u8]) -> Result<MeshFormat, MeshError> {
        // The first 80 bytes of a binary STL are free.
        if !stl::has_binary_size(bytes)
            && let Some(problem) = strangers::known(bytes)
        {
            return Err(MeshError::UnknownFormat { problem: problem.into() });
        }
        let surest = MeshFormat::ALL.into_iter().rev().max_by_key(|format| (format.entry().sign)(bytes));
        if let Some(shown) = surest.filter(|format| (format.entry().sign)(bytes) > Sign::None) {
            return Ok(shown);
        }
        MeshFormat::from_extension(path)
            .ok_or_else(|| MeshError::UnknownFormat { problem: unknown(lines(bytes).next()) })
    }

    pub(super) fn read(self, bytes: &[u8], folder: Option<&Path>) -> Result<RawMesh, MeshError> {
        (self.entry().read)(bytes, folder)
    }

    pub(super) fn references(self, bytes: &[u8]) -> Vec<PathBuf> {
        (self.entry().references)(bytes)
    }
}

fn unknown(first_line: Option<&[u8]>) -> String {
    let numbers = first_line.map(|line| words(line).map(parse::<f64>).collect::<Option<Vec<_>>>());
    match numbers.flatten().map(|numbers| numbers.len()) {
        Some(9) => format!(
            "lines of nine numbers; if each line is the three corners of a triangle, name the file `.tri`; if each is \
             a point with its colour and normal, {RECONSTRUCT}"
        ),
        Some(3..) => format!("lines of numbers, it seems a point cloud; {RECONSTRUCT}"),
        _ => format!(
            "neither the name nor the content is that of a known mesh format; export the mesh as one of {}",
            MeshFormat::list()
        ),
    }
}
