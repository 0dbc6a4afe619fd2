//! How exact an asset is, in one figure: the largest error of its volume at random points of the fluid, against a
//! converged rule on the exact distance to the mesh. `volmap report` tells the causes.

use crate::error::Error;
use glam::DVec3;
use rayon::prelude::*;
use volmap_bake::describe;
use volmap_bake::input::Input;
use volmap_bake::sdf::Neighbours;
use volmap_bake::tolerance::MeasuredError;
use volmap_bake::watch::{Cancelled, Watch};
use volmap_formats::asset::Asset;
use volmap_report::report::model::{Model, Solid};
use volmap_report::report::reference::{ExactIntegrals, FINE_RULE};
use volmap_report::report::samples::band_points;

/// Points of the band that are drawn for each that is wanted in the fluid.
const TRIES: usize = 4;
const SEED: u64 = 1;

/// Measures an asset at up to so many points and notes the error in it, unless a tolerance's error stands there.
///
/// # Errors
/// An asset that the runtime refuses; cancelled.
pub fn note_error(asset: &mut Asset, input: &Input, points: u32, watch: &Watch) -> Result<(), Error> {
    if points == 0 || asset.bake.contains_key(describe::VOLUME_ERROR_MAX) || asset.band_count() == 0 {
        return Ok(());
    }
    let error = measure(asset, input.clone(), points as usize, watch)?;
    // Without a point in the fluid nothing is known.
    if error.points > 0 {
        asset.bake.extend(describe::measured_error(&error, FINE_RULE));
    }
    Ok(())
}

fn measure(asset: &Asset, input: Input, points: usize, watch: &Watch) -> Result<MeasuredError, Error> {
    watch.step("measuring the error")?;
    let model = Model::new(asset)?;
    let solid = Solid::new(asset, input)?;
    let drawn = band_points(&model.field.grid, &model.cells.band, TRIES * points, SEED);
    let in_fluid = |x: &&DVec3| (0.0..2.0 * model.radius).contains(&model.map.values(**x).distance);
    let fluid: Vec<DVec3> = drawn.iter().filter(in_fluid).take(points).copied().collect();
    let exact = ExactIntegrals::new(&solid, model.radius);
    let error = |near: &mut Neighbours, x: &DVec3| {
        watch.check()?;
        Ok((model.map.values(*x).volume - exact.fine(*x, near)).abs() / model.ball)
    };
    let errors: Result<Vec<f64>, Cancelled> = fluid.par_iter().map_init(Neighbours::default, error).collect();
    let errors = errors?;
    let squares: f64 = errors.iter().map(|error| error * error).sum();
    Ok(MeasuredError {
        max: errors
            .iter()
            .map(|error| if error.is_nan() { f64::INFINITY } else { *error })
            .fold(0.0, f64::max),
        rms: (squares / errors.len().max(1) as f64).sqrt(),
        points: errors.len(),
    })
}
