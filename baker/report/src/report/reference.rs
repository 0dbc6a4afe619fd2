//! What a volume is compared with: Eq. 12 of Bender et al. 2020 by other rules and on other distances.

use super::model::{Model, Solid};
use super::shape::ClosedForm;
use glam::DVec3;
use schemars::JsonSchema;
use serde::Serialize;
use volmap_bake::sdf::{Neighbours, SignedDistance};
use volmap_bake::volume_map::anywhere::{Block, Integrator, LineRule};
use volmap_bake::volume_map::oracle;
use volmap_bake::volume_map::pixel_rows::{self, Pixels};
use volmap_bake::volume_map::quadrature::{Point, Rule, along_curve};
use volmap_bake::watch::{Cancelled, Work};

/// The paper's reference, section 6.1.
pub const PAPER_RULE: Rule = Rule::GaussLegendre(100);
/// A rule whose own error on a surface is below 0.02 % of the ball, and whose degree is far above that of the element.
pub const FINE_RULE: Rule = Rule::Chord(20);

/// A way to find the right volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Reference {
    /// Gauss-Legendre of order 100 on the asset's own distance: the paper's.
    Gl100Own,
    /// A converged rule of the ball on the asset's own distance.
    FineOwn,
    /// Gauss-Legendre of order 100 on the exact distance to the mesh.
    Gl100Mesh,
    /// A converged rule on the exact distance to the mesh.
    FineMesh,
    /// A closed form.
    Shape,
}

impl Reference {
    /// All of them.
    pub const ALL: [Reference; 5] = [
        Reference::Gl100Own,
        Reference::FineOwn,
        Reference::Gl100Mesh,
        Reference::FineMesh,
        Reference::Shape,
    ];

    /// In words.
    pub fn describe(self) -> String {
        match self {
            Reference::Gl100Own => {
                format!("{PAPER_RULE} on the asset's own distance, as the paper's")
            }
            Reference::FineOwn => format!("{FINE_RULE} (converged) on the asset's own distance"),
            Reference::Gl100Mesh => format!("{PAPER_RULE} on the exact distance to the mesh"),
            Reference::FineMesh => format!("{FINE_RULE} (converged) on the exact distance to the mesh"),
            Reference::Shape => "closed form of the shape".to_string(),
        }
    }
}

/// Integrals on the asset's own distance.
pub struct OwnIntegrals<'a> {
    integrator: Integrator<'a>,
    paper: LineRule,
    fine: LineRule,
    /// The asset's.
    own: Option<LineRule>,
    /// See [`Integrator::cut_sides`].
    cut: [[bool; 2]; 3],
}

impl<'a> OwnIntegrals<'a> {
    /// Of a model.
    pub fn new(model: &'a Model) -> OwnIntegrals<'a> {
        let integrator = Integrator::new(&model.field, model.radius);
        OwnIntegrals {
            cut: integrator.cut_sides(),
            integrator,
            paper: LineRule::new(PAPER_RULE.points()),
            fine: LineRule::new(FINE_RULE.points()),
            own: model.rule.map(|rule| LineRule::new(rule.points())),
        }
    }

    /// Whether a box sees nothing of what lies beyond a side of the domain that cuts the surface's surroundings.
    pub fn knows(&self, low: DVec3, high: DVec3) -> bool {
        let grid = &self.integrator.field().grid;
        let (from, to) = (grid.origin, grid.max_corner());
        (0..3).all(|axis| {
            let [lower, upper] = self.cut[axis];
            !(lower && low[axis] < from[axis] || upper && high[axis] > to[axis])
        })
    }

    /// By the paper's rule, at the pixels of a slice.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn paper_at_pixels(&self, pixels: &Pixels, work: &Work) -> Result<Vec<f64>, Cancelled> {
        pixel_rows::volumes(&self.integrator, &PAPER_RULE.points(), pixels, work)
    }

    /// By the paper's rule and the converged one.
    pub fn both(&self, x: DVec3, block: &mut Block) -> [f64; 2] {
        self.integrator.volumes([&self.paper, &self.fine], x, block)
    }

    /// By the asset's rule, if it is known.
    pub fn own(&self, x: DVec3, block: &mut Block) -> Option<f64> {
        let [volume] = self.integrator.volumes([self.own.as_ref()?], x, block);
        Some(volume)
    }
}

/// Integrals on the exact distance.
pub struct ExactIntegrals<'a> {
    phi: &'a Solid,
    radius: f64,
    paper: Vec<Point>,
    fine: Vec<Point>,
}

impl<'a> ExactIntegrals<'a> {
    /// Of a solid.
    pub fn new(solid: &'a Solid, radius: f64) -> ExactIntegrals<'a> {
        let [paper, fine] = [PAPER_RULE, FINE_RULE].map(|rule| along_curve(rule.points()));
        ExactIntegrals { phi: solid, radius, paper, fine }
    }

    /// By the converged rule.
    pub fn fine(&self, x: DVec3, near: &mut Neighbours) -> f64 {
        self.volume(&self.fine, x, near)
    }

    /// By the paper's rule.
    pub fn paper(&self, x: DVec3, near: &mut Neighbours) -> f64 {
        self.volume(&self.paper, x, near)
    }

    fn volume(&self, points: &[Point], x: DVec3, near: &mut Neighbours) -> f64 {
        // gamma* is 0 or 1 in the whole ball: the distance is 1-Lipschitz.
        let phi = self.phi.phi.at(x);
        let full: f64 = points.iter().map(|point| point.weight).sum();
        match phi {
            _ if phi >= 2.0 * self.radius => 0.0,
            _ if phi <= -self.radius && self.phi.diagnosis.closed => self.radius.powi(3) * full,
            _ => oracle::volume_on_exact_distance(&self.phi.phi, points, self.radius, x, near),
        }
    }
}

/// Of a closed form.
pub fn shape_volume(shape: &ClosedForm, radius: f64, x: DVec3) -> f64 {
    shape.volume(radius, x)
}
