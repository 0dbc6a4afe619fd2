//! VTK's cell types as faces. The corner orders are those of the VTK file formats, figure 2 of
//! "VTK File Formats", VTK User's Guide.
//!
//! Volume cells, polyhedra too, contribute their outer boundary: the faces that only one cell has, turned outward.

use glam::DVec3;

use crate::mesh::binary::{as_count, as_index};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;

const TETRA: &[&[usize]] = &[&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]];
const HEXAHEDRON: &[&[usize]] =
    &[&[0, 4, 7, 3], &[1, 2, 6, 5], &[0, 1, 5, 4], &[3, 7, 6, 2], &[0, 3, 2, 1], &[4, 5, 6, 7]];
const VOXEL: &[&[usize]] =
    &[&[0, 4, 6, 2], &[1, 3, 7, 5], &[0, 1, 5, 4], &[2, 6, 7, 3], &[0, 2, 3, 1], &[4, 5, 7, 6]];
const WEDGE: &[&[usize]] = &[&[0, 1, 2], &[3, 5, 4], &[0, 3, 4, 1], &[1, 4, 5, 2], &[2, 5, 3, 0]];
const PYRAMID: &[&[usize]] = &[&[0, 3, 2, 1], &[0, 1, 4], &[1, 2, 4], &[2, 3, 4], &[3, 0, 4]];

/// VTK's type number of polyhedra.
pub const POLYHEDRON: u8 = 42;

/// Cells of one grid, whose faces are added at its end.
#[derive(Default)]
pub struct Cells {
    surface: Vec<(u8, Vec<u32>)>,
    /// Faces of volume cells: sorted corners (the fourth is `u32::MAX` for triangles) and corners.
    volume: Vec<([u32; 4], [u32; 4])>,
    /// The same of faces with more corners, which polyhedra have.
    polygons: Vec<(Vec<u32>, Vec<u32>)>,
}

/// The faces of one polyhedron from its stream: the number of faces, then of each its number of corners and its
/// corners; `first` is the number of the piece's first point. Nothing may follow.
pub fn polyhedron(
    raw: &RawMesh,
    stream: &[f64],
    first: u32,
    at: &dyn Fn() -> String,
) -> Result<Vec<Vec<u32>>, MeshError> {
    let bad = || {
        raw.bad(at(), "the faces of this polyhedron don't fit its list; the file is damaged: export it again")
    };
    let (&count, mut rest) = stream.split_first().ok_or_else(bad)?;
    let count = as_count(count).filter(|&count| count <= rest.len()).ok_or_else(bad)?;
    let mut faces = Vec::with_capacity(count);
    for _ in 0..count {
        let (&length, more) = rest.split_first().ok_or_else(bad)?;
        let length = as_count(length).filter(|&length| length <= more.len()).ok_or_else(bad)?;
        let (face, more) = more.split_at(length);
        faces.push(corners(raw, face, first, at)?);
        rest = more;
    }
    if rest.is_empty() { Ok(faces) } else { Err(bad()) }
}

/// The corners from a list of numbers; `first` is the number of the piece's first point.
pub fn corners(
    raw: &RawMesh,
    values: &[f64],
    first: u32,
    at: &dyn Fn() -> String,
) -> Result<Vec<u32>, MeshError> {
    let index = |&value: &f64| {
        as_index(value).and_then(|index| index.checked_add(first)).filter(|&i| i < u32::MAX).ok_or_else(
            || raw.bad(at(), format!("{value} is not a point number; the file is damaged: export it again")),
        )
    };
    values.iter().map(index).collect()
}

impl Cells {
    /// Takes one cell. All points must be in `raw` already.
    pub fn add(&mut self, raw: &mut RawMesh, kind: u8, corners: &[u32]) -> Result<(), MeshError> {
        let (faces, count): (&[&[usize]], usize) = match kind {
            0 => return Ok(()),
            1 | 2 => {
                raw.skipped.points += 1;
                return Ok(());
            }
            3 | 4 => {
                raw.skipped.lines += 1;
                return Ok(());
            }
            5..=9 => return self.add_surface(raw, kind, corners),
            10 => (TETRA, 4),
            11 => (VOXEL, 8),
            12 => (HEXAHEDRON, 8),
            13 => (WEDGE, 6),
            14 => (PYRAMID, 5),
            _ => {
                return Err(MeshError::unsupported(
                    raw.format,
                    format!(
                        "cell type {kind} ({})",
                        if kind == 42 { "polyhedron without faces" } else { "curved" }
                    ),
                    "extract a linear surface (in ParaView: Extract Surface, save as .vtp)",
                ));
            }
        };
        self.check_corners(raw, kind, corners, count)?;
        self.add_volume(raw, faces, corners);
        Ok(())
    }

    fn check_corners(&self, raw: &RawMesh, kind: u8, corners: &[u32], count: usize) -> Result<(), MeshError> {
        let bad = |problem: String| {
            let number = self.surface.len() + self.volume.len() + self.polygons.len();
            Err(raw.bad(format!("a cell of type {kind} (after {number} faces)"), problem))
        };
        if corners.len() != count {
            return bad(format!("has {} corners instead of {count}", corners.len()));
        }
        match corners.iter().find(|&&c| c as usize >= raw.positions.len()) {
            Some(c) => bad(format!(
                "refers to point {c}, but there are only {}; the file is damaged: export it again",
                raw.positions.len()
            )),
            None => Ok(()),
        }
    }

    fn add_surface(&mut self, raw: &RawMesh, kind: u8, corners: &[u32]) -> Result<(), MeshError> {
        let mut corners = corners.to_vec();
        match kind {
            5 => self.check_corners(raw, kind, &corners, 3)?,
            8 | 9 => self.check_corners(raw, kind, &corners, 4)?,
            _ => self.check_corners(raw, kind, &corners, corners.len())?,
        }
        if kind == 8 {
            corners.swap(2, 3);
        }
        self.surface.push((kind, corners));
        Ok(())
    }

    fn add_volume(&mut self, raw: &RawMesh, faces: &[&[usize]], corners: &[u32]) {
        let faces: Vec<Vec<u32>> =
            faces.iter().map(|face| face.iter().map(|&k| corners[k]).collect()).collect();
        self.add_faces(raw, faces);
    }

    /// Takes a polyhedron by its faces. All points must be in `raw` already.
    pub fn add_polyhedron(&mut self, raw: &RawMesh, faces: Vec<Vec<u32>>) -> Result<(), MeshError> {
        for face in &faces {
            self.check_corners(raw, POLYHEDRON, face, face.len().max(3))?;
        }
        self.add_faces(raw, faces);
        Ok(())
    }

    /// Files disagree about the orientation of wedges, and some hold mirrored cells: the sign of
    /// the cell's volume decides which side of its faces is outward.
    fn add_faces(&mut self, raw: &RawMesh, faces: Vec<Vec<u32>>) {
        let Some(origin) = faces.first().and_then(|face| face.first()) else { return };
        let point = |corner: u32| DVec3::from(raw.positions[corner as usize]);
        let relative = |corner: u32| point(corner) - point(*origin);
        let mut volume = 0.0;
        for face in &faces {
            for pair in face[1..].windows(2) {
                volume += relative(face[0]).dot(relative(pair[0]).cross(relative(pair[1])));
            }
        }
        for mut face in faces {
            if volume < 0.0 {
                face.reverse();
            }
            let mut key = face.clone();
            key.sort_unstable();
            if face.len() > 4 {
                self.polygons.push((key, face));
            } else {
                self.volume.push((padded(&key), padded(&face)));
            }
        }
    }

    /// Adds the surface cells, and the outer faces of the volume cells.
    pub fn finish(mut self, raw: &mut RawMesh) {
        self.volume.sort_unstable();
        self.polygons.sort_unstable();
        for (kind, corners) in &self.surface {
            // A patch on the boundary of a volume mesh is there already, facing outward.
            if self.is_volume_face(corners) {
                continue;
            }
            if *kind == 6 {
                raw.add_strip(corners);
            } else {
                raw.add_face(corners);
            }
        }
        for same in self.volume.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, face)] = same {
                let corners = if face[3] == u32::MAX { &face[..3] } else { &face[..] };
                raw.faces.push(corners);
            }
        }
        for same in self.polygons.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, face)] = same {
                raw.faces.push(face);
            }
        }
    }

    fn is_volume_face(&self, corners: &[u32]) -> bool {
        let mut key = corners.to_vec();
        key.sort_unstable();
        match corners.len() {
            0..=4 => self.volume.binary_search_by_key(&padded(&key), |face| face.0).is_ok(),
            _ => self.polygons.binary_search_by(|face| face.0.cmp(&key)).is_ok(),
        }
    }
}

/// Up to four corners.
fn padded(corners: &[u32]) -> [u32; 4] {
    let mut out = [u32::MAX; 4];
    out[..corners.len()].copy_from_slice(corners);
    out
}
