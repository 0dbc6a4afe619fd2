//! A software rasteriser: triangles into a buffer of depth, normal and material, in bands of rows that threads draw
//! side by side.
//!
//! ```text
//! mesh in the world -> View -> project (clip, faces of one side) -> Triangle -> sorted into Bands -> Fragment a pixel
//! ```
//! Guaranteed: the pixels depend on view and triangles alone, not on the number of threads; no panic on any number.

mod bands;
mod triangles;
mod view;

pub use bands::{BAND, Bands};
pub use triangles::{Faces, Fragment, Sides, Triangle, project, sorted};
pub use view::View;

use rayon::prelude::*;

/// The nearest triangle at each pixel, rows from the upper one down.
pub fn draw(view: &View, triangles: &[Triangle]) -> Vec<Fragment> {
    let [width, height] = view.size;
    let mut pixels = vec![Fragment::NONE; width * height];
    let bands = sorted(triangles, height);
    pixels.par_chunks_mut((BAND * width).max(1)).enumerate().for_each(|(band, pixels)| {
        bands.of(band).for_each(|number| triangles[number].draw(band, view, pixels));
    });
    pixels
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Quat, Vec3};

    /// Looks along -z at a square of 4 m in 40 x 30 pixels.
    fn view(parallel: bool) -> View {
        View {
            origin: 10.0 * Vec3::Z,
            right: Vec3::X,
            up: Vec3::Y,
            forward: Vec3::NEG_Z,
            size: [40, 30],
            scale: if parallel { 10.0 } else { 100.0 },
            parallel,
            near: 0.1,
        }
    }

    /// Triangles with their own faces' normals; the material is the number of the triangle.
    fn drawn(view: &View, corners: &[[Vec3; 3]], sides: Sides) -> Vec<Fragment> {
        let places: Vec<Vec3> = corners.iter().flatten().copied().collect();
        let triangles: Vec<[u32; 3]> =
            (0..corners.len() as u32).map(|n| [3 * n, 3 * n + 1, 3 * n + 2]).collect();
        let normals: Vec<[Vec3; 3]> = corners.iter().map(|[a, b, c]| [(*b - *a).cross(*c - *a); 3]).collect();
        let faces =
            Faces { places: &places, triangles: &triangles, normals: &normals, rotation: Quat::IDENTITY };
        draw(view, &project(view, &faces, sides, |n| n as u32))
    }

    fn square(z: f32, half: f32) -> [[Vec3; 3]; 2] {
        let corner = |x: f32, y: f32| Vec3::new(half * x, half * y, z);
        let [a, b, c, d] = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        [[a, b, c], [a, c, d]]
    }

    #[test]
    fn squares_cover_their_pixels_and_the_nearer_is_seen() {
        for parallel in [true, false] {
            let view = view(parallel);
            // In perspective the nearer one is as large on the picture as the farther one in parallel.
            let corners = [square(0.0, 1.0), square(5.0, 0.5)].concat();
            let pixels = drawn(&view, &corners, Sides::Both);
            let count =
                |found: &dyn Fn(&Fragment) -> bool| pixels.iter().filter(|&pixel| found(pixel)).count();
            let near = if parallel { 10 * 10 } else { 20 * 20 };
            assert_eq!(count(&|pixel| pixel.material >= 2 && pixel.material < 4), near, "{parallel}");
            assert_eq!(count(&|pixel| pixel.depth < f32::INFINITY), 20 * 20, "{parallel}");
            for pixel in pixels.iter().filter(|pixel| pixel.depth < f32::INFINITY) {
                let depth = if pixel.material < 2 { 10.0 } else { 5.0 };
                assert!((pixel.depth - depth).abs() < 1e-4 && pixel.normal.z > 0.0, "{pixel:?}");
            }
        }
    }

    #[test]
    fn faces_of_the_other_side_are_left_out() {
        let view = view(true);
        let front = square(0.0, 1.0);
        let back = front.map(|[a, b, c]| [a, c, b]);
        let seen = |corners: &[[Vec3; 3]]| {
            let pixels = drawn(&view, corners, Sides::Back);
            pixels.iter().filter(|pixel| pixel.depth < f32::INFINITY).count()
        };
        assert_eq!((seen(&front), seen(&back)), (0, 400));
    }

    #[test]
    fn any_numbers_are_drawn() {
        let odd = [f32::NAN, f32::INFINITY, -1e38, 0.0, 1e-30, 9.95];
        let corner = |n: usize| Vec3::new(odd[n % 6], odd[n / 6 % 6], odd[n / 36 % 6]);
        let corners: Vec<[Vec3; 3]> =
            (0..216).map(|n| [corner(n), corner(n + 7), corner(5 * n + 1)]).collect();
        for parallel in [true, false] {
            assert_eq!(drawn(&view(parallel), &corners, Sides::Both).len(), 1200);
        }
        assert!(draw(&View { size: [0, 0], ..view(true) }, &[]).is_empty());
    }

    #[test]
    fn pixels_do_not_depend_on_threads() {
        let view = view(false);
        let corners: Vec<[Vec3; 3]> =
            (0..200).flat_map(|n| square(0.02 * n as f32, 1.4 - 0.004 * n as f32)).collect();
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| drawn(&view, &corners, Sides::Both))
        };
        assert!(on(1) == on(3));
    }
}
