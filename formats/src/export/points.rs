//! Particles with values, for programs that show them or make a surface of them.
//!
//! - [`write_vtu`]: VTK's XML, for ParaView, VTK, meshio and splashsurf;
//! - [`write_ply`]: binary PLY, for most mesh programs and splashsurf;
//! - [`write_bgeo`]: Houdini's classic geometry, for partio, SPlisHSPlasH's tools and splashsurf.

mod bgeo;
mod ply;
mod vtu;

pub use bgeo::write as write_bgeo;
pub use ply::write as write_ply;
pub use vtu::write as write_vtu;

/// Points with values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points<'a> {
    /// Places, metres.
    pub positions: Positions<'a>,
    /// Values, as many as points, each with its name: plain ASCII letters, digits and underscores.
    pub arrays: Vec<(&'static str, Values<'a>)>,
    /// Numbers that all points share, each with its name, as `TimeValue` (seconds) or `particle_radius [m]`. VTU has
    /// them as field data, PLY as comments, BGEO not at all.
    pub facts: Vec<(&'static str, Vec<f64>)>,
}

/// Places of points, in one precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Positions<'a> {
    /// Single.
    F32(&'a [[f32; 3]]),
    /// Double, for what lies far from the origin. BGEO has single precision only; splashsurf reads it in VTU, not in
    /// PLY.
    F64(&'a [[f64; 3]]),
}

impl Default for Positions<'_> {
    fn default() -> Self {
        Positions::F32(&[])
    }
}

impl Positions<'_> {
    /// How many points there are.
    pub fn len(self) -> usize {
        match self {
            Positions::F32(places) => places.len(),
            Positions::F64(places) => places.len(),
        }
    }

    /// Whether there is no point.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// A point's place in single precision.
    fn rounded(self, point: usize) -> [f32; 3] {
        match self {
            Positions::F32(places) => places[point],
            Positions::F64(places) => places[point].map(|x| x as f32),
        }
    }

    /// Bytes of a point.
    fn bytes(self) -> usize {
        match self {
            Positions::F32(_) => 3 * size_of::<f32>(),
            Positions::F64(_) => 3 * size_of::<f64>(),
        }
    }

    /// Adds a point's place, little-endian.
    fn add(self, point: usize, out: &mut Vec<u8>) {
        match self {
            Positions::F32(places) => out.extend(places[point].iter().flat_map(|x| x.to_le_bytes())),
            Positions::F64(places) => out.extend(places[point].iter().flat_map(|x| x.to_le_bytes())),
        }
    }
}

/// Values of one type, one a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Values<'a> {
    /// Numbers.
    F32(&'a [f32]),
    /// Vectors.
    Vector(&'a [[f32; 3]]),
    /// Numbers of things.
    U32(&'a [u32]),
}

/// Room in memory for a file is made for so many bytes a value at most.
const WORD: usize = 4;

impl Values<'_> {
    fn components(self) -> usize {
        match self {
            Values::Vector(_) => 3,
            Values::F32(_) | Values::U32(_) => 1,
        }
    }

    fn count(self) -> usize {
        match self {
            Values::F32(v) => v.len(),
            Values::Vector(v) => v.len(),
            Values::U32(v) => v.len(),
        }
    }

    /// The bits of point `index`, one word a component.
    fn words(self, index: usize) -> impl Iterator<Item = u32> {
        let words = match self {
            Values::F32(v) => [v[index].to_bits(), 0, 0],
            Values::Vector(v) => v[index].map(f32::to_bits),
            Values::U32(v) => [v[index], 0, 0],
        };
        words.into_iter().take(self.components())
    }
}

impl Points<'_> {
    /// Bytes of a point with all its values.
    fn point_bytes(&self) -> usize {
        let words: usize = self.arrays.iter().map(|(_, values)| values.components()).sum();
        self.positions.bytes() + WORD * words
    }

    /// Whether there are as many values as points, and as many points as the format can count.
    fn check(&self, most: usize) -> std::io::Result<()> {
        let count = self.positions.len();
        let refuse = |reason: String| Err(std::io::Error::new(std::io::ErrorKind::InvalidInput, reason));
        if let Some((name, values)) = self.arrays.iter().find(|(_, values)| values.count() != count) {
            return refuse(format!("{count} points, but {} values of {name}", values.count()));
        }
        if count > most {
            return refuse(format!("{count} points, but the format has {most} at most"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cloud and what is in it.
    pub fn with_sample<R>(use_it: impl FnOnce(&Points) -> R) -> R {
        let positions: Vec<[f32; 3]> = (0..50).map(|n| [n as f32 * 0.1, -0.5, 1e-3 * n as f32]).collect();
        let velocity: Vec<[f32; 3]> = (0..50).map(|n| [1.0, n as f32, -2.5]).collect();
        let density: Vec<f32> = (0..50).map(|n| 1.0 + 1e-4 * n as f32).collect();
        let id: Vec<u32> = (0..50).rev().collect();
        use_it(&Points {
            positions: Positions::F32(&positions),
            arrays: vec![
                ("velocity", Values::Vector(&velocity)),
                ("density", Values::F32(&density)),
                ("id", Values::U32(&id)),
            ],
            facts: vec![("TimeValue", vec![0.25])],
        })
    }

    #[test]
    fn lists_of_different_lengths_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points");
        let density = Values::F32(&[1.0, 2.0]);
        let points = Points {
            positions: Positions::F32(&[[0.0; 3]; 3]),
            arrays: vec![("density", density)],
            ..Points::default()
        };
        for write in [write_vtu, write_ply, write_bgeo] {
            let error = write(&path, &points).unwrap_err().to_string();
            assert!(error.contains("3 points, but 2 values of density"), "{error}");
            assert!(error.starts_with(&path.display().to_string()), "{error}");
        }
        assert!(!path.exists());
    }
}
