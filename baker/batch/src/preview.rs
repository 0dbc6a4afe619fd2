//! A small picture of the solid that a map stands for, traced through the map itself: sphere tracing (Hart 1996),
//! parallel projection, y up, seen from the front, the right and above.
//!
//! The solid of a container lies outside: its near walls are left out, and what is seen is the inside. The volume,
//! which the map holds anyway, shades: it is larger in corners than on a plane, and smaller on edges.

use glam::{BVec3, DVec3};
use volmap_figures::picture::colours::{Rgb, WHITE};
use volmap_figures::picture::png::{self, Effort};
use volmap_formats::asset::{Dimension, Exterior};
use volmap_runtime::{Sample, Values, VolumeMap};

/// Width and height, pixels.
pub const SIZE: [usize; 2] = [160, 120];
/// Of the first, coarse picture, which finds where the solid is.
const COARSE: [usize; 2] = [40, 30];
/// Colour of a solid in the fluid.
const SOLID: Rgb = [150, 186, 222];
/// Colour of a container's inside.
const CONTAINER: Rgb = [240, 192, 124];
/// Towards the eye.
const EYE: DVec3 = DVec3::new(0.55, 0.5, 0.9);
/// Steps of light from dark to bright.
const SHADES: f64 = 40.0;
/// Steps of a ray, at most.
const STEPS: usize = 4096;
/// A surface is hit so close to it, pixels.
const CLOSE: f64 = 0.1;
/// Volume of the solid on a plane, as a part of the ball: Eq. 12 of Bender et al. 2020 for Phi = 0.
const ON_PLANE: f64 = 0.7578;

/// The picture as a PNG file, [`SIZE`] large, on white; blank if there is nothing to see.
pub fn preview(map: &VolumeMap) -> Vec<u8> {
    let pixels = match map.dimension() {
        Dimension::Three => solid(map),
        Dimension::Two => plan_view(map),
    };
    let pixels = pixels.unwrap_or_else(|| vec![WHITE; SIZE[0] * SIZE[1]]);
    png::encode(SIZE.map(|n| n as u32), &pixels.concat(), Effort::Small)
}

fn colour(map: &VolumeMap) -> Rgb {
    match map.exterior() {
        Exterior::Fluid => SOLID,
        Exterior::Solid => CONTAINER,
    }
}

/// `part` of a colour in front of white, `light` times as bright.
fn painted(colour: Rgb, light: f64, part: f64) -> Rgb {
    colour.map(|c| {
        let lit = (f64::from(c) * light).clamp(0.0, 255.0);
        (255.0 + part.clamp(0.0, 1.0) * (lit - 255.0)).round() as u8
    })
}

/// Rows of pixels from the upper one down, each the foot of a ray.
#[derive(Clone, Copy, Debug)]
struct View {
    size: [usize; 2],
    /// Across the picture, up in it, and away from the eye.
    axes: [DVec3; 3],
    /// Places along the first two axes, metres.
    centre: [f64; 2],
    /// Edge of a pixel, metres.
    pixel: f64,
}

impl View {
    /// With a rectangle of the first two axes filling the picture; none if it is empty or endless.
    fn of(axes: [DVec3; 3], low: [f64; 2], high: [f64; 2], size: [usize; 2]) -> Option<View> {
        let pixel = [0, 1].map(|side| (high[side] - low[side]) / (size[side] as f64 - 2.0));
        let pixel = pixel[0].max(pixel[1]);
        let centre = [0, 1].map(|side| 0.5 * (low[side] + high[side]));
        (pixel > 0.0 && pixel.is_finite()).then_some(View { size, axes, centre, pixel })
    }

    /// Place of a pixel's centre along the first two axes, metres.
    fn place(&self, index: usize) -> [f64; 2] {
        let (column, row) = ((index % self.size[0]) as f64, (index / self.size[0]) as f64);
        let [width, height] = self.size.map(|n| n as f64);
        [
            self.centre[0] + (column + 0.5 - 0.5 * width) * self.pixel,
            self.centre[1] - (row + 0.5 - 0.5 * height) * self.pixel,
        ]
    }

    /// Point at the depth 0 of a pixel's ray.
    fn foot(&self, index: usize) -> DVec3 {
        let [across, up] = self.place(index);
        across * self.axes[0] + up * self.axes[1]
    }
}

/// What a pixel shows: a point, and how much of the pixel it covers.
#[derive(Clone, Copy, Debug)]
struct Seen {
    pixel: usize,
    point: DVec3,
    part: f64,
}

fn solid(map: &VolumeMap) -> Option<Vec<Rgb>> {
    let view = view_of(map, SIZE)?;
    let seen = trace(map, &view);
    Some(shaded(map, &view, &seen))
}

/// The view that the solid fills.
fn view_of(map: &VolumeMap, size: [usize; 2]) -> Option<View> {
    let eye = EYE.normalize();
    let across = DVec3::Y.cross(eye).normalize();
    let axes = [across, eye.cross(across), -eye];
    let (low, high) = (map.grid().origin, map.grid().max_corner());
    let corners = (0..8).map(|n| DVec3::select(BVec3::new(n & 1 > 0, n & 2 > 0, n & 4 > 0), high, low));
    let places: Vec<[f64; 2]> = corners.map(|corner| [corner.dot(axes[0]), corner.dot(axes[1])]).collect();
    let [low, high] = bounds(&places)?;
    let whole = View::of(axes, low, high, COARSE)?;
    // The domain is larger than the solid: a coarse picture shows where that is.
    let found: Vec<[f64; 2]> = trace(map, &whole).iter().map(|seen| whole.place(seen.pixel)).collect();
    let [low, high] = bounds(&found)?;
    let margin = 0.5 * whole.pixel;
    View::of(axes, low.map(|x| x - margin), high.map(|x| x + margin), size)
}

fn bounds(places: &[[f64; 2]]) -> Option<[[f64; 2]; 2]> {
    let along = |pick: fn(f64, f64) -> f64| {
        places.iter().copied().reduce(|a, b| [pick(a[0], b[0]), pick(a[1], b[1])])
    };
    Some([along(f64::min)?, along(f64::max)?])
}

fn shaded(map: &VolumeMap, view: &View, seen: &[Seen]) -> Vec<Rgb> {
    let [across, up, away] = view.axes;
    let light = (0.6 * up - 0.5 * across - away).normalize();
    let points: Vec<DVec3> = seen.iter().map(|seen| seen.point).collect();
    let mut samples = Vec::<Sample>::new();
    map.sample_batch(&points, &mut samples);
    let mut pixels = vec![WHITE; view.size[0] * view.size[1]];
    for (seen, sample) in seen.iter().zip(&samples) {
        let (mut normal, mut part) = (-away, ON_PLANE);
        if let Sample::Near(boundary) = sample {
            normal = boundary.normal;
            part = boundary.volume / map.quadrature().ball_volume;
            part = if part.is_finite() { part } else { ON_PLANE };
        }
        // Behind the surface, or beside it, the normal may point away.
        let facing = if normal.dot(away) > 0.0 { -normal } else { normal };
        let corner = 1.0 - 1.2 * (part - ON_PLANE).clamp(-0.25, 0.25);
        let lit = (0.1 + 0.95 * (0.5 + 0.5 * facing.dot(light))) * corner;
        // A silhouette's normal is anywhere; dark ones would look like dirt.
        let lit = if seen.part < 1.0 { lit.max(0.8) } else { lit };
        // Steps of light that the eye doesn't see halve the file.
        let lit = (lit * SHADES).round() / SHADES;
        pixels[seen.pixel] = painted(colour(map), lit, seen.part);
    }
    pixels
}

/// A ray on its way.
struct Ray {
    pixel: usize,
    foot: DVec3,
    /// Depth now, at the step before, and where the domain ends.
    depth: f64,
    before: f64,
    end: f64,
    /// Distance at the step before, metres.
    distance: f64,
    /// It is in the fluid or was in it.
    in_fluid: bool,
    /// The least that it missed the surface by, metres, and at which depth.
    miss: (f64, f64),
}

/// What the rays of all pixels meet.
fn trace(map: &VolumeMap, view: &View) -> Vec<Seen> {
    let away = view.axes[2];
    let mut rays: Vec<Ray> = (0..view.size[0] * view.size[1]).filter_map(|n| ray(map, view, n)).collect();
    let (mut points, mut values, mut seen) = (Vec::new(), Vec::<Values>::new(), Vec::new());
    for _ in 0..STEPS {
        if rays.is_empty() {
            break;
        }
        points.clear();
        points.extend(rays.iter().map(|ray| ray.foot + ray.depth * away));
        map.sample_batch(&points, &mut values);
        let mut at = values.iter();
        rays.retain_mut(|ray| {
            let distance = at.next().map_or(f64::INFINITY, |values| values.distance);
            let end = ray.advance(map, distance, view.pixel);
            seen.extend(end.and_then(|(depth, part)| {
                (part > 0.0).then(|| Seen { pixel: ray.pixel, point: ray.foot + depth * away, part })
            }));
            end.is_none()
        });
    }
    seen
}

/// The ray of a pixel where it enters the domain, if it does.
fn ray(map: &VolumeMap, view: &View, pixel: usize) -> Option<Ray> {
    let (foot, away) = (view.foot(pixel), view.axes[2]);
    let [a, b] = [map.grid().origin, map.grid().max_corner()].map(|corner| (corner - foot) / away);
    let (start, end) = (a.min(b).max_element(), a.max(b).min_element());
    let in_fluid = map.exterior() == Exterior::Fluid;
    let miss = (f64::INFINITY, start);
    let ray = Ray { pixel, foot, depth: start, before: start, end, distance: f64::INFINITY, in_fluid, miss };
    (start < end).then_some(ray)
}

impl Ray {
    /// Goes on, knowing the distance where it is. At its end: the depth of what it shows and the covered part of the
    /// pixel, which is 0 if it shows nothing.
    fn advance(&mut self, map: &VolumeMap, distance: f64, pixel: f64) -> Option<(f64, f64)> {
        let close = CLOSE * pixel;
        if self.in_fluid && distance < close {
            let crossed = (self.depth - self.before) * self.distance / (self.distance - distance);
            let exact = distance < 0.0 && crossed.is_finite();
            return Some((if exact { self.before + crossed } else { self.depth }, 1.0));
        }
        // Out of a near wall of a container.
        self.in_fluid |= distance > 2.0 * close;
        let is_container = map.exterior() == Exterior::Solid;
        if self.in_fluid != is_container && distance.abs() < self.miss.0 {
            self.miss = (distance.abs(), self.depth);
        }
        // Where there is no distance, it is more than two radii.
        let safe = if distance.is_finite() { distance.abs() } else { 2.0 * map.support_radius() };
        (self.before, self.distance) = (self.depth, distance);
        self.depth += (0.9 * safe).max(close);
        // A silhouette covers pixels in part; a container's is done once the ray is in its fluid.
        let part = if self.in_fluid && is_container { 0.0 } else { 1.0 - self.miss.0 / pixel };
        (self.depth > self.end).then_some((self.miss.1, part.max(0.0)))
    }
}

/// A map in two dimensions, seen along z.
fn plan_view(map: &VolumeMap) -> Option<Vec<Rgb>> {
    let [low, high] = [map.grid().origin, map.grid().max_corner()].map(|corner| [corner.x, corner.y]);
    let view = View::of([DVec3::X, DVec3::Y, DVec3::NEG_Z], low, high, SIZE)?;
    let points: Vec<DVec3> = (0..SIZE[0] * SIZE[1]).map(|n| view.foot(n)).collect();
    let mut values = Vec::<Values>::new();
    map.sample_batch(&points, &mut values);
    let part = |distance: f64| 0.5 - distance / view.pixel;
    Some(values.iter().map(|values| painted(colour(map), 0.85, part(values.distance))).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec2;
    use std::f64::consts::PI;
    use std::path::Path;
    use volmap_bake::area_map::{self, AreaSettings};
    use volmap_bake::bake::{BakeSettings, bake};
    use volmap_bake::input::{InputSettings, from_bytes};
    use volmap_bake::plan::{GridChoice, MapSettings};
    use volmap_bake::volume_map::quadrature::Rule;
    use volmap_bake::watch::Watch;
    use volmap_formats::asset::{Array, Asset};

    const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                        f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\nf 2 3 7 6\nf 1 5 8 4\n";

    fn cube(invert: bool) -> VolumeMap {
        VolumeMap::from_asset(&cube_asset(invert)).unwrap()
    }

    fn cube_asset(invert: bool) -> Asset {
        let input = from_bytes(Path::new("cube.obj"), CUBE, &InputSettings::default()).unwrap();
        let map = MapSettings {
            support_radius: Some(0.1),
            grid: GridChoice::CellSize(0.05),
            rule: Rule::Chord(8),
            invert,
            ..MapSettings::default()
        };
        let settings = BakeSettings { map, ..BakeSettings::default() };
        bake(input, &settings, &Watch::default()).unwrap().asset
    }

    /// A disc's map in two dimensions.
    fn disc(radius: f64) -> Asset {
        let corner = DVec2::splat(radius);
        let settings = AreaSettings { support_radius: Some(0.2), ..AreaSettings::default() };
        area_map::bake([-corner, corner], &|x: DVec2| x.length() - radius, &settings, &Watch::default())
            .unwrap()
    }

    /// Area that is covered, m^2, if white is nothing and the deepest colour is all.
    fn covered(pixels: &[Rgb], pixel: f64) -> f64 {
        let deepest = pixels.iter().map(|rgb| rgb[0]).min().unwrap();
        let part = |rgb: &Rgb| f64::from(255 - rgb[0]) / f64::from(255 - deepest);
        pixels.iter().map(part).sum::<f64>() * pixel * pixel
    }

    /// The shadow of the unit cube along a direction is as large as the sum of its components.
    #[test]
    fn a_cube_covers_its_shadow() {
        let expected = EYE.normalize().element_sum();
        for invert in [false, true] {
            let map = cube(invert);
            let view = view_of(&map, SIZE).unwrap();
            let seen = trace(&map, &view);
            let area = seen.iter().map(|seen| seen.part).sum::<f64>() * view.pixel * view.pixel;
            // Silhouettes are half a pixel wide.
            assert!((area / expected - 1.0).abs() < 0.02, "{invert}: {area}, {expected}");
            let pixels = seen.len() as f64 / (SIZE[0] * SIZE[1]) as f64;
            assert!(pixels > 0.4, "the cube fills the picture: {pixels}");
        }
    }

    /// Of a solid the near faces are seen, of a container the far ones.
    #[test]
    fn containers_are_seen_from_inside() {
        for (invert, at) in [(false, 1.0), (true, 0.0)] {
            let map = cube(invert);
            let seen = trace(&map, &view_of(&map, SIZE).unwrap());
            let whole = seen.iter().filter(|seen| seen.part == 1.0);
            let off = whole.map(|seen| (seen.point - at).abs().min_element()).fold(0.0, f64::max);
            assert!(off < 0.02, "{invert}: {off} m from the faces");
        }
    }

    #[test]
    fn files_are_small_pictures_on_white() {
        let file = preview(&cube(false));
        let (size, rgb) = png::decode(&file).unwrap();
        assert_eq!(size.map(|n| n as usize), SIZE);
        assert_eq!(rgb[..3], WHITE);
        assert!(file.len() < 12_000, "{} bytes", file.len());
        let colours: std::collections::BTreeSet<&[u8]> = rgb.chunks(3).collect();
        assert!(colours.len() > 10, "faces are shaded");
        assert_eq!(file, preview(&cube(false)));
    }

    #[test]
    fn maps_in_two_dimensions_are_seen_from_above() {
        let map = VolumeMap::from_asset(&disc(0.7)).unwrap();
        let [low, high] = [map.grid().origin, map.grid().max_corner()].map(|corner| [corner.x, corner.y]);
        let view = View::of([DVec3::X, DVec3::Y, DVec3::NEG_Z], low, high, SIZE).unwrap();
        let area = covered(&plan_view(&map).unwrap(), view.pixel);
        assert!((area / (PI * 0.49) - 1.0).abs() < 0.01, "{area}");
    }

    #[test]
    fn odd_maps_have_a_picture() {
        let blank = png::encode(SIZE.map(|n| n as u32), &[255; 3 * SIZE[0] * SIZE[1]], Effort::Small);
        let empty = Asset {
            band_cells: Vec::new(),
            solid_cells: Vec::new(),
            signed_distance: Array::F32(Vec::new()),
            volume: Array::F32(Vec::new()),
            ..disc(0.7)
        };
        for dimension in [Dimension::Two, Dimension::Three] {
            let asset = Asset { dimension, ..empty.clone() };
            assert_eq!(preview(&VolumeMap::from_asset(&asset).unwrap()), blank);
        }
        // Nothing but solid, and a distance that is nonsense.
        let solid = Asset { exterior: Exterior::Solid, ..empty };
        assert!(png::size(&preview(&VolumeMap::from_asset(&solid).unwrap())).is_some());
        for mut wild in [disc(0.7), cube_asset(false), cube_asset(true)] {
            let count = wild.signed_distance.len();
            wild.signed_distance = Array::F64((0..count).map(|n| ((n * 7919) % 13) as f64 - 6.0).collect());
            wild.volume = Array::F64(vec![f64::MAX; count]);
            assert!(png::size(&preview(&VolumeMap::from_asset(&wild).unwrap())).is_some());
        }
    }
}
