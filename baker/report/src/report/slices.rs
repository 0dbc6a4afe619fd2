//! Slices of the volume and of its error against the paper's integral, at every pixel: Fig. 6 of Bender et al. 2020.

use super::model::Model;
use super::reference::OwnIntegrals;
use glam::DVec3;
use rayon::prelude::*;
use volmap_bake::volume_map::pixel_rows::Pixels;
use volmap_bake::watch::{Cancelled, Watch, Work};
use volmap_figures::picture::{Axis, Pixel, PixelLattice, Plane, Raster};
use volmap_runtime::{Sample, VolumeMap};

/// A slice.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorSlice {
    /// The asset's volume, m^3.
    pub volume: Raster,
    /// The asset's signed distance, metres; NaN outside the band.
    pub distance: Vec<f64>,
    /// Its difference to the integral of order 100 on the asset's own distance, as a part of the full ball.
    pub error: Raster,
    /// The worst pixel: where, and its error.
    pub worst: Option<(DVec3, f64)>,
    /// Whether it goes through the worst of the random points.
    pub through_worst: bool,
}

/// Around the worst point so many support radii are shown, at most.
const AROUND: f64 = 10.0;

/// Three slices through the middle of the domain, and one of the surroundings of the worst point, across the axis that
/// is closest to the surface there.
///
/// # Errors
/// [`Cancelled`].
pub fn slices(
    model: &Model,
    worst: Option<DVec3>,
    pixels: usize,
    watch: &Watch,
) -> Result<Vec<ErrorSlice>, Cancelled> {
    if pixels == 0 {
        return Ok(Vec::new());
    }
    let (low, high) = (model.map.grid().origin, model.map.grid().max_corner());
    let middle = 0.5 * (low + high);
    let plane = |axis: Axis, through: DVec3| Plane { axis, at: through[axis.index()] };
    let whole = |axis| (PixelLattice::over(plane(axis, middle), low, high, pixels), false);
    let mut lattices = Axis::ALL.map(whole).to_vec();
    if let Some(worst) = worst {
        let normal = match model.map.sample(worst) {
            Sample::Near(near) => near.normal.abs(),
            _ => DVec3::Z,
        };
        let axis = Axis::ALL[normal.min_position()];
        let (low, high) = (low.max(worst - AROUND * model.radius), high.min(worst + AROUND * model.radius));
        lattices.push((PixelLattice::over(plane(axis, worst), low, high, pixels), true));
    }
    let count = lattices.iter().map(|(lattice, _)| lattice.len() as u64).sum();
    let work = watch.begin("integrating at pixels", count)?;
    let own = OwnIntegrals::new(model);
    let slice = |(lattice, through_worst)| {
        let slice = slice(model, &own, lattice, &work)?;
        Ok(ErrorSlice { through_worst, ..slice })
    };
    lattices.into_iter().map(slice).collect()
}

fn slice(
    model: &Model,
    own: &OwnIntegrals,
    lattice: PixelLattice,
    work: &Work,
) -> Result<ErrorSlice, Cancelled> {
    let rows: Vec<Vec<PixelValues>> =
        (0..lattice.size[1]).into_par_iter().map(|j| row(&model.map, &lattice, j)).collect();
    let all = rows.concat();
    let wanted = all.iter().map(|pixel| matches!(pixel.known, Pixel::Value(_))).collect();
    let paper = own.paper_at_pixels(&pixels(&lattice, wanted), work)?;
    let raster = |values: &mut dyn Iterator<Item = f64>| Raster {
        lattice,
        pixels: all
            .iter()
            .zip(values)
            .map(|(pixel, value)| match pixel.known {
                Pixel::Value(_) => Pixel::Value(value),
                other => other,
            })
            .collect(),
    };
    let error = |(pixel, paper): (&PixelValues, &f64)| (pixel.volume - paper) / model.ball;
    let volume = raster(&mut all.iter().map(|pixel| pixel.volume));
    let error = raster(&mut all.iter().zip(&paper).map(error));
    let errors = error.pixels.iter().zip(lattice.points()).filter_map(|(pixel, point)| match pixel {
        Pixel::Value(error) => Some((point, *error)),
        _ => None,
    });
    Ok(ErrorSlice {
        worst: errors.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())),
        volume,
        error,
        distance: all.iter().map(|pixel| pixel.distance).collect(),
        through_worst: false,
    })
}

/// The lattice as places on the axes.
fn pixels(lattice: &PixelLattice, wanted: Vec<bool>) -> Pixels {
    let [right, up] = lattice.axes.map(Axis::index);
    let normal = lattice.plane.axis.index();
    Pixels {
        axes: [right, up, normal],
        along: (0..lattice.size[0]).map(|i| lattice.point(i, 0)[right]).collect(),
        across: (0..lattice.size[1]).map(|j| lattice.point(0, j)[up]).collect(),
        plane: lattice.plane.at,
        wanted,
    }
}

#[derive(Clone, Copy)]
struct PixelValues {
    /// In the band, or what it is else.
    known: Pixel,
    distance: f64,
    volume: f64,
}

fn row(map: &VolumeMap, lattice: &PixelLattice, j: usize) -> Vec<PixelValues> {
    let points: Vec<DVec3> = (0..lattice.size[0]).map(|i| lattice.point(i, j)).collect();
    let mut samples: Vec<Sample> = Vec::new();
    map.sample_batch(&points, &mut samples);
    let known = |known| PixelValues { known, distance: f64::NAN, volume: f64::NAN };
    let pixel = |sample: &Sample| match sample {
        Sample::Outside => known(Pixel::Fluid),
        Sample::DeepInside => known(Pixel::Solid),
        Sample::Near(near) => {
            PixelValues { known: Pixel::Value(0.0), distance: near.distance, volume: near.volume }
        }
    };
    samples.iter().map(pixel).collect()
}
