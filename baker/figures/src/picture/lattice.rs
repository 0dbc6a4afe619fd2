//! The lattice of a slice's pixels: where each one lies in space.

use glam::DVec3;
use std::fmt;
use std::str::FromStr;

/// An axis of space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// x.
    X,
    /// y, upwards.
    Y,
    /// z.
    Z,
}

impl Axis {
    /// All, in the order of coordinates.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// Its place in a vector.
    pub fn index(self) -> usize {
        self as usize
    }

    /// `x`, `y` or `z`.
    pub fn name(self) -> &'static str {
        ["x", "y", "z"][self.index()]
    }
}

/// A plane across an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Axis that it is across.
    pub axis: Axis,
    /// Where on the axis, metres.
    pub at: f64,
}

impl FromStr for Plane {
    type Err = String;

    fn from_str(text: &str) -> Result<Plane, String> {
        let parse = || {
            let (name, number) = text.split_once('=')?;
            let axis = Axis::ALL.into_iter().find(|axis| axis.name().eq_ignore_ascii_case(name.trim()))?;
            let at = number.trim().parse().ok().filter(|at: &f64| at.is_finite())?;
            Some(Plane { axis, at })
        };
        parse().ok_or_else(|| "give x=, y= or z= and a number of metres, as z=0.2".into())
    }
}

impl fmt::Display for Plane {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} m", self.axis.name(), self.at)
    }
}

/// Square pixels on a plane. Pixel (i, j) is i steps to the right and j up; pictures and arrays start at the
/// lowest row, i fastest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelLattice {
    /// The plane.
    pub plane: Plane,
    /// Axes to the right and up in the picture.
    pub axes: [Axis; 2],
    /// Lower left corner of the picture along `axes`, metres.
    pub low: [f64; 2],
    /// Edge of a pixel, metres.
    pub pixel: f64,
    /// Pixels to the right and up.
    pub size: [usize; 2],
}

impl PixelLattice {
    /// The lattice that covers a box (metres) with `pixels` pixels along the picture's longer side. y points
    /// up; on planes across y the longer side lies across.
    pub fn over(plane: Plane, low: DVec3, high: DVec3, pixels: usize) -> PixelLattice {
        let edges = high - low;
        let axes = match plane.axis {
            Axis::X => [Axis::Z, Axis::Y],
            Axis::Y if edges.z > edges.x => [Axis::Z, Axis::X],
            Axis::Y => [Axis::X, Axis::Z],
            Axis::Z => [Axis::X, Axis::Y],
        };
        let lengths = axes.map(|axis| edges[axis.index()]);
        let pixel = lengths[0].max(lengths[1]) / pixels.max(1) as f64;
        let count = |length: f64| ((length / pixel).round() as usize).max(1);
        PixelLattice { plane, axes, low: axes.map(|axis| low[axis.index()]), pixel, size: lengths.map(count) }
    }

    /// Pixels in all.
    pub fn len(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Upper right corner along the axes, metres.
    pub fn high(&self) -> [f64; 2] {
        [0, 1].map(|a| self.low[a] + self.size[a] as f64 * self.pixel)
    }

    /// Centre of a pixel.
    pub fn point(&self, i: usize, j: usize) -> DVec3 {
        let mut point = DVec3::ZERO;
        point[self.plane.axis.index()] = self.plane.at;
        for (a, step) in [i, j].into_iter().enumerate() {
            point[self.axes[a].index()] = self.low[a] + (step as f64 + 0.5) * self.pixel;
        }
        point
    }

    /// Centres of all pixels, i fastest.
    pub fn points(&self) -> Vec<DVec3> {
        (0..self.len()).map(|at| self.point(at % self.size[0], at / self.size[0])).collect()
    }

    /// A point of space along the picture's axes, metres.
    pub fn project(&self, point: DVec3) -> [f64; 2] {
        self.axes.map(|axis| point[axis.index()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_are_read() {
        assert_eq!("z=0.2".parse(), Ok(Plane { axis: Axis::Z, at: 0.2 }));
        assert_eq!(" X = -1e-3".parse(), Ok(Plane { axis: Axis::X, at: -1e-3 }));
        for wrong in ["", "z", "z=", "w=1", "z=nan", "z=inf", "z=1m", "0.2"] {
            assert!(wrong.parse::<Plane>().is_err(), "{wrong}");
        }
        assert_eq!("y=0.25".parse::<Plane>().unwrap().to_string(), "y = 0.25 m");
    }

    #[test]
    fn pixels_lie_in_the_box_and_project_back() {
        let (low, high) = (DVec3::new(-1.0, 0.0, 2.0), DVec3::new(2.0, 1.0, 9.3));
        for axis in Axis::ALL {
            let plane = Plane { axis, at: low[axis.index()] };
            let lattice = PixelLattice::over(plane, low, high, 100);
            assert_eq!(lattice.size[0].max(lattice.size[1]), 100);
            assert_eq!(lattice.points().len(), lattice.len());
            for (at, point) in lattice.points().into_iter().enumerate() {
                assert!(point.cmpge(low).all() && point.cmple(high).all(), "{point}");
                let [x, y] = lattice.project(point);
                let place = [(x - lattice.low[0]) / lattice.pixel, (y - lattice.low[1]) / lattice.pixel];
                assert_eq!(
                    [place[0] as usize, place[1] as usize],
                    [at % lattice.size[0], at / lattice.size[0]]
                );
            }
        }
        let thin =
            PixelLattice::over(Plane { axis: Axis::Z, at: 0.0 }, DVec3::ZERO, DVec3::new(9.0, 1e-6, 1.0), 50);
        assert_eq!(thin.size, [50, 1]);
    }
}
