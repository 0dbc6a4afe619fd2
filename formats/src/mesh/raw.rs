//! A mesh as its file has it.

use super::error::MeshError;
use super::skipped::Skipped;

/// Larger coordinates are refused: their squares and cubes must not overflow.
pub const MAX_COORDINATE: f64 = 1e100;

/// A mesh as its file has it: polygons, duplicates, several objects in one list.
#[derive(Clone, Debug, PartialEq)]
pub struct RawMesh {
    /// Positions in the file's unit, with the transforms of the file's scene applied.
    pub positions: Vec<[f64; 3]>,
    /// Polygons with at least three corners each.
    pub faces: Faces,
    /// How many objects, pieces or instances were joined (0: the format doesn't say).
    pub objects: usize,
    /// The file's unit in metres, where the format defines it.
    pub unit: Option<f64>,
    /// What messages call it: the name of the format that it was read as.
    pub format: &'static str,
    /// What the file has besides faces.
    pub skipped: Skipped,
    /// What else was left out, or is taken otherwise than one may expect: a sentence each, for warnings.
    pub notes: Vec<String>,
}

/// Polygons as one list of corners. Corners are indices into the positions.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Faces {
    corners: Vec<u32>,
    /// Where each polygon ends; empty as long as all are triangles.
    ends: Vec<usize>,
}

impl Faces {
    /// Appends a polygon.
    #[inline]
    pub fn push(&mut self, corners: &[u32]) {
        if corners.len() != 3 && self.ends.is_empty() {
            self.ends.extend((1..=self.corners.len() / 3).map(|face| 3 * face));
        }
        let only_triangles = corners.len() == 3 && self.ends.is_empty();
        self.corners.extend_from_slice(corners);
        if !only_triangles {
            self.ends.push(self.corners.len());
        }
    }

    /// How many polygons.
    pub fn len(&self) -> usize {
        if self.ends.is_empty() { self.corners.len() / 3 } else { self.ends.len() }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The corners of each polygon.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut start = 0;
        (0..self.len()).map(move |face| {
            let end = self.ends.get(face).copied().unwrap_or(start + 3);
            &self.corners[std::mem::replace(&mut start, end)..end]
        })
    }

    /// The corners of all polygons.
    pub fn corners(&self) -> &[u32] {
        &self.corners
    }
}

impl RawMesh {
    /// A mesh with nothing in it; messages call it by the name of the format.
    pub fn new(format: &'static str) -> RawMesh {
        RawMesh {
            positions: Vec::new(),
            faces: Faces::default(),
            objects: 0,
            unit: None,
            format,
            skipped: Skipped::default(),
            notes: Vec::new(),
        }
    }

    /// Appends a polygon; one with fewer than three corners is counted as a point or a line.
    pub fn add_face(&mut self, corners: &[u32]) {
        match corners.len() {
            0 => self.skipped.other += 1,
            1 => self.skipped.points += 1,
            2 => self.skipped.lines += 1,
            _ => self.faces.push(corners),
        }
    }

    /// Appends the triangles of a strip; every other one is turned, so that all face one way.
    pub(super) fn add_strip(&mut self, strip: &[u32]) {
        if strip.len() < 3 {
            self.add_face(strip);
        }
        for (k, t) in strip.windows(3).enumerate() {
            // Repeated vertices join strips and make no triangle of their own.
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                continue;
            }
            let turned = [t[0], t[2], t[1]];
            self.faces.push(if k % 2 == 0 { t } else { &turned });
        }
    }

    pub(super) fn bad(&self, place: impl Into<String>, problem: impl Into<String>) -> MeshError {
        MeshError::malformed(self.format, place, problem)
    }

    pub(super) fn check(&self) -> Result<(), MeshError> {
        if self.positions.len() > u32::MAX as usize {
            return Err(MeshError::TooLarge {
                problem: format!(
                    "{} vertices: at most {} fit; split the mesh",
                    self.positions.len(),
                    u32::MAX
                ),
            });
        }
        let fits = |p: &[f64; 3]| p.iter().all(|c| c.abs() <= MAX_COORDINATE);
        if let Some(k) = self.positions.iter().position(|p| !fits(p)) {
            let [x, y, z] = self.positions[k];
            return Err(self.bad(
                format!("vertex {k} (counted from 0)"),
                format!(
                    "the position ({x}, {y}, {z}) is not finite or beyond 1e100; remove or repair \
                     this vertex"
                ),
            ));
        }
        let count = self.positions.len();
        if self.faces.corners.iter().all(|&corner| (corner as usize) < count) {
            return Ok(());
        }
        for (k, face) in self.faces.iter().enumerate() {
            if let Some(&corner) = face.iter().find(|&&c| c as usize >= count) {
                return Err(self.bad(
                    format!("face {k} (counted from 0)"),
                    format!(
                        "refers to vertex {corner} (counted from 0), but there are only {count}; \
                         the file is damaged or was cut: export it again"
                    ),
                ));
            }
        }
        Ok(())
    }

    pub(super) fn check_not_empty(&self) -> Result<(), MeshError> {
        if !self.faces.is_empty() {
            return Ok(());
        }
        if self.skipped.lines + self.skipped.other == 0 && !self.positions.is_empty() {
            return Err(MeshError::PointCloud { points: self.positions.len() });
        }
        let left_out = match (self.skipped.total(), self.notes.is_empty()) {
            (0, false) => self.notes.join("; "),
            (_, true) => format!("left out: {}", self.skipped),
            (_, false) => format!("left out: {}; {}", self.skipped, self.notes.join("; ")),
        };
        Err(MeshError::NoFaces { left_out })
    }
}
