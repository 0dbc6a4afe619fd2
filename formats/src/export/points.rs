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
    pub positions: &'a [[f32; 3]],
    /// Values, as many as points, each with its name: plain ASCII letters, digits and underscores.
    pub arrays: Vec<(&'static str, Values<'a>)>,
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

impl<'a> Points<'a> {
    /// Positions and values.
    fn all(&self) -> impl Iterator<Item = Values<'a>> {
        let positions = Values::Vector(self.positions);
        std::iter::once(positions).chain(self.arrays.iter().map(|&(_, values)| values))
    }

    /// Bytes of a point with all its values.
    fn point_bytes(&self) -> usize {
        WORD * self.all().map(Values::components).sum::<usize>()
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
            positions: &positions,
            arrays: vec![
                ("velocity", Values::Vector(&velocity)),
                ("density", Values::F32(&density)),
                ("id", Values::U32(&id)),
            ],
        })
    }

    #[test]
    fn lists_of_different_lengths_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("points");
        let density = Values::F32(&[1.0, 2.0]);
        let points = Points { positions: &[[0.0; 3]; 3], arrays: vec![("density", density)] };
        for write in [write_vtu, write_ply, write_bgeo] {
            let error = write(&path, &points).unwrap_err().to_string();
            assert!(error.contains("3 points, but 2 values of density"), "{error}");
            assert!(error.starts_with(&path.display().to_string()), "{error}");
        }
        assert!(!path.exists());
    }
}
