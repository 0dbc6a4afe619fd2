//! Whether the reference is right: the exact distance, checked by winding numbers alone (Jacobson, Kavan and
//! Sorkine-Hornung 2013, "Robust inside-outside segmentation using generalized winding numbers"), which know nothing of
//! which faces of the mesh count as its surface.
//!
//! Where the distance at a point is d, the closest point must not lie inside the solid, and no point closer than d may
//! lie on the other side.

use super::model::Solid;
use glam::DVec3;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use volmap_bake::random::Random;
use volmap_bake::watch::{Cancelled, Watch};

/// Points around each that are asked for their side.
const AROUND: usize = 16;
/// How far from the surface both sides are asked, as a part of the distance.
const BESIDE: f64 = 1e-3;
/// Points nearer to the surface than this part of the mesh's size aren't asked: rounding.
const NEAREST: f64 = 1e-6;

/// What the check found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct ReferenceCheck {
    /// Points that were checked.
    pub points: usize,
    /// Points whose distance winding numbers contradict.
    pub contradictions: usize,
    /// The one farthest from the surface, metres.
    pub worst: Option<[f64; 3]>,
}

/// Checks the exact distance at points. Only of meshes whose winding numbers are integers: others leave room for doubt.
///
/// # Errors
/// [`Cancelled`].
pub fn check_reference(solid: &Solid, points: &[DVec3], watch: &Watch) -> Result<ReferenceCheck, Cancelled> {
    if !solid.phi.mesh.has_integer_winding() {
        return Ok(ReferenceCheck::default());
    }
    let work = watch.begin("checking the exact distance", points.len() as u64)?;
    let mesh = &solid.phi.mesh;
    let [low, high] = volmap_bake::input::bounds(&solid.mesh);
    let claim = Claim {
        closest: |p| mesh.closest(p).point,
        inside: |p| mesh.inside_by_winding(p),
        nearest: NEAREST * (high - low).max_element(),
    };
    let check = |(number, point): (usize, &DVec3)| {
        work.check()?;
        work.add(1);
        Ok(claim.check(*point, number as u64))
    };
    let found: Vec<Option<Checked>> =
        points.par_iter().enumerate().map(check).collect::<Result<_, Cancelled>>()?;
    Ok(summed(points, &found))
}

/// What is claimed of a solid: its closest points, and what lies inside.
struct Claim<C, I> {
    closest: C,
    inside: I,
    /// Points closer to the surface aren't checked, metres.
    nearest: f64,
}

/// One point.
#[derive(Clone, Copy)]
struct Checked {
    distance: f64,
    is_wrong: bool,
}

impl<C: Fn(DVec3) -> DVec3, I: Fn(DVec3) -> bool> Claim<C, I> {
    fn check(&self, point: DVec3, seed: u64) -> Option<Checked> {
        let closest = (self.closest)(point);
        let distance = closest.distance(point);
        if distance <= self.nearest {
            return None;
        }
        let side = (self.inside)(point);
        let out = (point - closest) * BESIDE;
        let is_within = (self.inside)(closest + out) && (self.inside)(closest - out);
        let mut random = Random::new(seed);
        let mut crosses = || {
            let near = point + in_ball(&mut random) * (distance * (1.0 - BESIDE));
            (self.inside)(near) != side
        };
        Some(Checked { distance, is_wrong: is_within || (0..AROUND).any(|_| crosses()) })
    }
}

fn summed(points: &[DVec3], found: &[Option<Checked>]) -> ReferenceCheck {
    let checked = || points.iter().zip(found).filter_map(|(point, found)| Some((point, (*found)?)));
    let wrong = || checked().filter(|(_, checked)| checked.is_wrong);
    let worst = wrong().max_by(|a, b| a.1.distance.total_cmp(&b.1.distance));
    ReferenceCheck {
        points: checked().count(),
        contradictions: wrong().count(),
        worst: worst.map(|(point, _)| point.to_array()),
    }
}

/// A random point of the unit ball, more of them near its surface.
fn in_ball(random: &mut Random) -> DVec3 {
    loop {
        let point = DVec3::from([(); 3].map(|()| 2.0 * random.unit() - 1.0));
        if (0.04..=1.0).contains(&point.length_squared()) {
            return point;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Boxes from 0 to 1 and from 0.5 to 2 along x, both from 0 to 1 along y and z.
    fn inside(p: DVec3) -> bool {
        p.cmpgt(DVec3::ZERO).all() && p.cmplt(DVec3::new(2.0, 1.0, 1.0)).all()
    }

    /// The closest point of a box's surface to a point inside of it.
    fn on_box(p: DVec3, low: DVec3, high: DVec3) -> DVec3 {
        let faces = (0..3).flat_map(|axis| [(axis, low[axis]), (axis, high[axis])]);
        let points = faces.map(|(axis, at)| {
            let mut q = p.clamp(low, high);
            q[axis] = at;
            q
        });
        points.min_by(|a, b| a.distance(p).total_cmp(&b.distance(p))).unwrap()
    }

    fn check(closest: impl Fn(DVec3) -> DVec3) -> ReferenceCheck {
        let claim = Claim { closest, inside, nearest: 1e-6 };
        let mut random = Random::new(3);
        let points: Vec<DVec3> =
            (0..400).map(|_| DVec3::new(2.0 * random.unit(), random.unit(), random.unit())).collect();
        let found: Vec<_> = points.iter().zip(0..).map(|(point, seed)| claim.check(*point, seed)).collect();
        summed(&points, &found)
    }

    #[test]
    fn the_union_holds_and_hidden_faces_and_missing_ones_are_found() {
        let union = |p: DVec3| on_box(p, DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
        let right = check(union);
        assert!(right.points > 390 && right.contradictions == 0, "{right:?}");
        // The distance to all faces of both boxes, those inside the other too.
        let all_faces = |p: DVec3| {
            let first = on_box(p, DVec3::ZERO, DVec3::ONE);
            let second = on_box(p, DVec3::new(0.5, 0.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
            if first.distance(p) < second.distance(p) { first } else { second }
        };
        assert!(check(all_faces).contradictions > 40);
        // A surface without the face at y = 0.
        let open = |p: DVec3| on_box(p, DVec3::new(0.0, -9.0, 0.0), DVec3::new(2.0, 1.0, 1.0));
        assert!(check(open).contradictions > 20);
    }
}
