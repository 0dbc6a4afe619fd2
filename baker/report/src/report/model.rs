//! An asset as the report sees it: its fields in double precision, and the solid that it stands for.

use super::shape::ClosedForm;
use crate::error::Error;
use std::f64::consts::PI;
use volmap_bake::adaptive::DEPTH;
use volmap_bake::adaptive::uniform;
use volmap_bake::input::Input;
use volmap_bake::mesh::{Diagnosis, prepare};
use volmap_bake::provenance;
use volmap_bake::sdf::band::BandCells;
use volmap_bake::sdf::boundary_distance::BoundaryDistance;
use volmap_bake::sdf::field::DistanceField;
use volmap_bake::sdf::{MeshDistance, SignMethod};
use volmap_bake::volume_map::quadrature::Rule;
use volmap_formats::asset::{Asset, Value};
use volmap_formats::mesh::TriangleMesh;
use volmap_runtime::layout::Nodes;
use volmap_runtime::{DVec3, Grid, VolumeMap};

/// Equal cells that stand for an adaptive map's, at most.
const MOST_CELLS: u64 = 2_000_000;

/// An asset, opened in every way that is needed.
pub struct Model {
    /// As users see it.
    pub map: VolumeMap,
    /// Whether its cells have several sizes.
    pub is_adaptive: bool,
    /// The distance that it stores; of an adaptive map on equal cells, the smallest unless they are too many.
    pub field: DistanceField,
    /// Which cells that has.
    pub cells: BandCells,
    /// The rule of its volume, if it is one that we know.
    pub rule: Option<Rule>,
    /// Support radius, metres.
    pub radius: f64,
    /// Volume of the full ball, m^3.
    pub ball: f64,
}

/// The mesh that an asset was baked from, or another to compare it with.
pub struct Solid {
    /// Oriented as for the bake, metres.
    pub mesh: TriangleMesh,
    /// What is wrong with it.
    pub diagnosis: Diagnosis,
    /// Its signed distance.
    pub phi: BoundaryDistance,
    /// Name of its file.
    pub name: String,
    /// If it is not the file that was baked.
    pub warning: Option<String>,
}

impl Model {
    /// Opens an asset.
    ///
    /// # Errors
    /// An asset that the runtime refuses.
    pub fn new(asset: &Asset) -> Result<Model, Error> {
        let map = VolumeMap::from_asset(asset).map_err(|error| Error::setting("asset", error.to_string()))?;
        let is_adaptive = asset.is_adaptive();
        let asset = &uniform(asset, MOST_CELLS)?;
        let cells = BandCells { band: asset.band_cells.clone(), solid: asset.solid_cells.clone() };
        let grid = Grid::from(asset.grid);
        let nodes = Nodes::new(grid.resolution, &cells.band)
            .ok_or_else(|| Error::setting("asset", "has more than 2^32 nodes"))?;
        let values = asset.signed_distance.to_f64();
        let radius = asset.support_radius;
        Ok(Model {
            field: DistanceField::new(grid, &cells, &nodes, asset.exterior, values),
            map,
            is_adaptive,
            cells,
            rule: asset.quadrature.name.parse().ok(),
            radius,
            ball: 4.0 / 3.0 * PI * radius.powi(3),
        })
    }
}

impl Model {
    /// Whether a point counts where errors are measured. Adaptive cells are as exact as asked for in the fluid and where
    /// particles get into the solid.
    pub fn counts(&self, point: DVec3) -> bool {
        !self.is_adaptive || self.map.values(point).distance >= -DEPTH * self.radius
    }
}

impl Solid {
    /// The closed form of its volume, if it is a shape that has one and its surface wasn't moved.
    pub fn closed_form(&self) -> Option<ClosedForm> {
        let shape = self.phi.shape.filter(|_| self.phi.thickness == 0.0)?;
        ClosedForm::of(&shape, self.phi.invert)
    }

    /// The solid of a mesh, made as the asset says that it was baked.
    ///
    /// # Errors
    /// Parameters that no bake writes.
    pub fn new(asset: &Asset, mut input: Input) -> Result<Solid, Error> {
        let keep_orientation = provenance::flag(asset, "keep_orientation")?;
        let diagnosis = prepare(&mut input.mesh, keep_orientation).diagnosis;
        let sign = match asset.bake.get("sign") {
            Some(Value::Text(name)) if name == "pseudonormal" => SignMethod::Pseudonormal,
            _ => SignMethod::Auto,
        };
        let phi = BoundaryDistance {
            mesh: MeshDistance::new(&input.mesh, sign, &diagnosis),
            shape: input.placed_shape,
            invert: provenance::flag(asset, "invert")?,
            thickness: provenance::real(asset, "thickness", 0.0)?,
        };
        let warning = provenance::other_mesh(asset, &input.source);
        Ok(Solid { mesh: input.mesh, diagnosis, phi, name: input.source.file, warning })
    }
}
