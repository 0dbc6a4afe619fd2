//! A bath duck: the smooth union of ellipsoids, balls and tapered limbs.
//!
//! The size is that of Bender et al. 2020, Fig. 6 (1.3 m x 1.3 m x 1.5 m): x is its width, y its height (up),
//! z its length, with the beak towards +z. The origin is the middle of its bounding box.

use glam::DVec3;

use crate::improve::improve;
use crate::mesh::Mesh;
use crate::solids::{ball, ellipsoid, smooth_intersection, smooth_union, tapered, untilt};
use crate::surface::{self, Lattice};

/// Half of the duck's width, height and length, m.
pub const HALF_SIZE: DVec3 = DVec3::new(0.65, 0.65, 0.75);

/// The fine duck.
pub fn duck() -> Mesh {
    duck_of_cell(0.029)
}

/// The duck meshed with lattice cells of the given edge length, m.
pub fn duck_of_cell(cell: f64) -> Mesh {
    let lattice = Lattice { low: DVec3::new(-0.9, -0.2, -1.1), high: DVec3::new(0.9, 1.6, 1.1), cell };
    let mut mesh = surface::mesh(solid, lattice);
    improve(&mut mesh, solid, 20);
    mesh.fit(-HALF_SIZE, HALF_SIZE);
    mesh
}

/// The implicit duck, standing on about y = 0; symmetric in x.
fn solid(p: DVec3) -> f64 {
    let p = DVec3::new(p.x.abs(), p.y, p.z);
    let torso = smooth_union(body(p), wing(p), 0.06);
    let with_head = smooth_union(torso, head(p), 0.16);
    let with_beak = smooth_union(with_head, beak(p), 0.035);
    smooth_union(with_beak, eye(p), 0.02)
}

fn body(p: DVec3) -> f64 {
    let hull = ellipsoid(p, DVec3::new(0.0, 0.42, -0.06), DVec3::new(0.55, 0.41, 0.62));
    let chest = ball(p, DVec3::new(0.0, 0.46, 0.20), 0.41);
    // The tail narrows upwards and backwards; shrinking x makes it wide and flat.
    let flat = DVec3::new(p.x * 0.6, p.y, p.z);
    let tail = tapered(flat, [DVec3::new(0.0, 0.48, -0.42), DVec3::new(0.0, 0.80, -0.74)], [0.22, 0.05]);
    let whole = smooth_union(smooth_union(hull, chest, 0.2), tail, 0.18);
    smooth_intersection(whole, 0.055 - p.y, 0.08)
}

fn wing(p: DVec3) -> f64 {
    // Thin in x: a limb in stretched space, scaled back to about a distance.
    let thin = DVec3::new((p.x - 0.50) * 1.6 + (p.y - 0.5) * 0.3, p.y, p.z);
    let shoulder = DVec3::new(0.0, 0.46, 0.06);
    let elbow = DVec3::new(0.06, 0.50, -0.22);
    let tip = DVec3::new(0.10, 0.65, -0.46);
    let arm = tapered(thin, [shoulder, elbow], [0.20, 0.17]);
    let feathers = tapered(thin, [elbow, tip], [0.17, 0.075]);
    smooth_union(arm, feathers, 0.05) / 1.6
}

const HEAD: DVec3 = DVec3::new(0.0, 0.96, 0.24);

fn head(p: DVec3) -> f64 {
    let skull = ball(p, HEAD, 0.36);
    let cheek = ball(p, HEAD + DVec3::new(0.15, -0.07, 0.10), 0.24);
    let nape = HEAD + DVec3::new(0.0, 0.31, -0.10);
    let tuft = tapered(p, [nape, nape + DVec3::new(0.0, 0.08, -0.10)], [0.08, 0.04]);
    smooth_union(smooth_union(skull, cheek, 0.1), tuft, 0.07)
}

fn beak(p: DVec3) -> f64 {
    let upper_centre = HEAD + DVec3::new(0.0, -0.02, 0.41);
    let upper = ellipsoid(untilt(p, upper_centre, 0.25), upper_centre, DVec3::new(0.19, 0.07, 0.205));
    let lower_centre = HEAD + DVec3::new(0.0, -0.115, 0.36);
    let lower = ellipsoid(untilt(p, lower_centre, -0.08), lower_centre, DVec3::new(0.145, 0.055, 0.18));
    smooth_union(upper, lower, 0.035)
}

fn eye(p: DVec3) -> f64 {
    ellipsoid(p, HEAD + DVec3::new(0.175, 0.135, 0.275), DVec3::new(0.068, 0.09, 0.064))
}
