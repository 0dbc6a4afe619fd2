//! A picture of a frame, so that one sees it without another program: the fluid as a surface in screen space (van der
//! Laan et al. 2009, *Screen Space Fluid Rendering with Curvature Flow*), bodies as meshes, containers open towards the
//! eye, shadows, a colour bar.
//!
//! ```text
//! particles -> balls -> depth, thickness -> smoothed depth -> normals ─┐
//! meshes -> triangles -> depth, normals ─────────────────────────────────> light -> legend -> PNG
//! light -> depth seen from it ─────────────────────────────────────────┘
//! ```
//! Guaranteed: the bytes depend on settings and frame alone, not on the number of threads.

pub mod camera;
mod model;
mod occlusion;
mod overlay;
mod shade;
mod shadow;
mod smooth;
mod splat;

pub use camera::{Bounds, Camera};
pub use model::Model;

use super::Frame;
use glam::Vec3;
use rayon::prelude::*;
use shade::{Light, Scenery};
use splat::{Fluid, Layer, Splat};
use volmap_figures::picture::ColourMap;
use volmap_figures::picture::canvas::Canvas;
use volmap_figures::raster::{self, BAND, Bands, Fragment, Sides, Triangle, View};
use volmap_formats::text::thousands;
use volmap_runtime::{DVec3, Pose};

/// How frames are drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureSettings {
    /// Pixels across, 64 to 8,192.
    pub width: u32,
    /// Pixels down, 64 to 8,192.
    pub height: u32,
    /// The eye; by default it sees the whole domain from the front, the left and above.
    pub camera: Option<Camera>,
    /// How the fluid looks.
    pub style: Style,
    /// What its colour stands for.
    pub colour: ColourBy,
    /// Numbers at the ends of the colour bar; by default they suit the domain.
    pub range: Option<[f64; 2]>,
}

/// How the fluid looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Style {
    /// A smooth surface.
    #[default]
    Surface,
    /// Balls of the particle radius.
    Particles,
}

/// What the fluid's colour stands for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourBy {
    /// Speed, m/s.
    #[default]
    Speed,
    /// Density in parts of the rest density.
    Density,
    /// Pressure, Pa.
    Pressure,
}

impl Default for PictureSettings {
    fn default() -> Self {
        let (style, colour) = (Style::Surface, ColourBy::Speed);
        PictureSettings { width: 1280, height: 720, camera: None, style, colour, range: None }
    }
}

/// A body to be drawn.
#[derive(Clone, Debug)]
pub struct Prop {
    /// Its name; a body of that name in the frame moves it.
    pub name: String,
    /// Its mesh, in its own frame.
    pub model: Model,
    /// Where it is, if no body moves it.
    pub pose: Pose,
    /// Its solid is around the mesh, which is drawn where one looks into it.
    pub container: bool,
    /// Red, green, blue; by default one of a palette.
    pub colour: Option<[u8; 3]>,
}

impl Prop {
    /// From its model's places to those of pictures, of its pose in the world.
    fn local(&self, pose: Pose, origin: DVec3) -> Pose {
        Pose { rotation: pose.rotation, translation: pose.to_world(self.model.origin) - origin }
    }
}

/// What is the same in all frames.
pub struct World {
    /// What places in pictures, the bounds too, are relative to, metres: where all lies far from zero, a point near it.
    pub origin: DVec3,
    /// All that may be seen: the fluid at the start, containers, bodies.
    pub bounds: Bounds,
    /// Acceleration, m/s^2.
    pub gravity: Vec3,
    /// Rest density, kg/m^3.
    pub rest_density: f64,
    /// Bodies.
    pub props: Vec<Prop>,
}

/// Draws frames.
pub struct Painter {
    settings: PictureSettings,
    world: World,
    view: View,
    up: Vec3,
    range: [f64; 2],
    colours: Vec<Vec3>,
    fluid: Vec<Fluid>,
    spare: Vec<Fluid>,
    behind: Vec<Behind>,
}

/// Bodies and ground at a pixel: four samples of colour and depth.
#[derive(Clone, Copy)]
struct Behind {
    colours: [Vec3; 4],
    depths: [f32; 4],
    /// Whether any is of a body.
    body: bool,
}

/// Samples along each side of a pixel.
const FINER: usize = 2;
const CONTAINER: [u8; 3] = [248, 250, 252];
/// Colours of bodies, none of them that of water.
const PALETTE: [[u8; 3]; 6] =
    [[246, 190, 50], [213, 94, 0], [0, 158, 115], [204, 121, 167], [160, 160, 165], [150, 105, 70]];
/// Radius of a ball in particle radii, so that neighbours make a surface.
const SURFACE_RADIUS: f32 = 1.5;

impl Painter {
    /// Prepares pictures of a world.
    pub fn new(settings: &PictureSettings, mut world: World) -> Painter {
        let mut settings = settings.clone();
        settings.width = settings.width.clamp(64, 8192);
        settings.height = settings.height.clamp(64, 8192);
        for prop in &world.props {
            let pose = prop.local(prop.pose, world.origin);
            for vertex in &prop.model.vertices {
                world.bounds.add(pose.to_world(vertex.as_dvec3()).as_vec3());
            }
        }
        for place in settings.camera.iter_mut().flat_map(|camera| [&mut camera.position, &mut camera.target])
        {
            *place = (DVec3::from(*place) - world.origin).to_array();
        }
        world.bounds = world.bounds.or_unit();
        let up = (-world.gravity).try_normalize().unwrap_or(Vec3::Y);
        let size = [settings.width, settings.height].map(|n| n as usize);
        let view = camera::view(settings.camera.as_ref(), world.bounds, up, size);
        let range = settings.range.unwrap_or_else(|| usual_range(settings.colour, &world));
        let mut palette = PALETTE.iter().cycle();
        let colours = world.props.iter().map(|prop| {
            let usual = || if prop.container { &CONTAINER } else { palette.next().unwrap_or(&CONTAINER) };
            let rgb = prop.colour.unwrap_or_else(|| *{ usual }());
            Vec3::from_array(rgb.map(|c| f32::from(c) / 255.0))
        });
        let colours = colours.collect();
        let (fluid, spare, behind) = (Vec::new(), Vec::new(), Vec::new());
        Painter { settings, world, view, up, range, colours, fluid, spare, behind }
    }

    /// The frame as a PNG file.
    pub fn draw(&mut self, frame: &Frame) -> Vec<u8> {
        let near: Vec<DVec3>;
        let mut frame = *frame;
        if self.world.origin != DVec3::ZERO {
            near = frame.positions.iter().map(|place| *place - self.world.origin).collect();
            frame.positions = &near;
        }
        let frame = &frame;
        let poses = self.poses(frame);
        self.rasterize(frame, &poses);
        let radius = self.ball_radius(frame);
        if self.settings.style == Style::Surface {
            let depth = self.view.local(self.world.bounds.centre()).z.max(self.view.near);
            let pixels = (radius * self.view.scale_at(depth)).clamp(1.5, 60.0);
            smooth::smooth(
                &mut self.fluid,
                &mut self.spare,
                self.view.size[0],
                1.6 * pixels,
                [4.0 * radius, 5.0 * radius],
            );
        }
        self.finish(frame, &poses)
    }

    fn ball_radius(&self, frame: &Frame) -> f32 {
        let factor = if self.settings.style == Style::Surface { SURFACE_RADIUS } else { 1.0 };
        factor * frame.particle_radius as f32
    }

    /// Where the props' models are.
    fn poses(&self, frame: &Frame) -> Vec<Pose> {
        let pose = |prop: &Prop| {
            let body = frame.bodies.iter().find(|body| body.name == prop.name);
            prop.local(body.map_or(prop.pose, |body| body.pose), self.world.origin)
        };
        self.world.props.iter().map(pose).collect()
    }

    fn value(&self, frame: &Frame, particle: usize) -> f32 {
        match self.settings.colour {
            ColourBy::Speed => frame.velocities.get(particle).map_or(0.0, |&v| Vec3::from(v).length()),
            ColourBy::Density => frame.density.get(particle).copied().unwrap_or(0.0),
            ColourBy::Pressure => frame.pressure.get(particle).copied().unwrap_or(0.0),
        }
    }

    /// The light, from above, the left and the eye's side.
    fn light(&self, view: View) -> Light {
        let back = -view.forward.reject_from_normalized(self.up).normalize_or_zero();
        let direction = (0.9 * self.up - 0.5 * view.right + 0.4 * back).normalize();
        Light { view, direction, up: self.up }
    }

    /// Bodies, ground and balls.
    fn rasterize(&mut self, frame: &Frame, poses: &[Pose]) {
        let (view, radius) = (self.view, self.ball_radius(frame));
        let fine = view.finer(FINER);
        let props = || self.world.props.iter().zip(poses);
        let project = |(n, (prop, pose)): (usize, (&Prop, &Pose))| {
            let sides = if prop.container { Sides::Back } else { Sides::Both };
            prop.model.project(&fine, pose, sides, n as u32)
        };
        let faces: Vec<Triangle> = props().enumerate().flat_map(project).collect();
        let balls = splat::project(&view, frame.positions, |n| self.value(frame, n), radius);
        let solid: Vec<_> =
            props().filter(|(p, _)| !p.container).map(|(p, &pose)| (&p.model, pose)).collect();
        let light = self.light(fine);
        let shadow = shadow::cast(light.direction, self.world.bounds, frame.positions, radius, &solid);
        let scenery = Scenery {
            light,
            ground: self.ground(),
            shown: (self.world.bounds.centre(), self.world.bounds.size()),
            shadow: &shadow,
            colours: &self.colours,
        };
        let [width, height] = view.size;
        let (fluid, behind) = (&mut self.fluid, &mut self.behind);
        fluid.resize(width * height, Fluid::NONE);
        behind.resize(
            width * height,
            Behind { colours: [Vec3::ONE; 4], depths: [f32::INFINITY; 4], body: false },
        );
        let layers = Layers { scenery: &scenery, width, faces: &faces, balls: &balls };
        let sorted = (raster::sorted(&faces, FINER * height), splat::sorted(&balls, height));
        let bands = fluid.par_chunks_mut(BAND * width).zip(behind.par_chunks_mut(BAND * width)).enumerate();
        bands.for_each(|(band, (fluid, behind))| {
            layers.draw_behind(band, &sorted.0, behind);
            let mut layer = Layer::new(behind.iter().map(Behind::farthest).collect());
            for ball in sorted.1.of(band) {
                layers.balls[ball].draw(band, [width, height], radius, &mut layer);
            }
            layer.store(fluid);
        });
    }

    /// Height of the ground.
    fn ground(&self) -> f32 {
        let Bounds { low, high } = self.world.bounds;
        // The lowest corner, for any direction of gravity; a little lower, as a tank's floor has its own picture.
        let lowest: f32 = (0..3).map(|a| (self.up[a] * low[a]).min(self.up[a] * high[a])).sum();
        lowest - 2e-3 * self.world.bounds.size()
    }

    /// Light on the fluid, over what is behind it, and the legend.
    fn finish(&self, frame: &Frame, poses: &[Pose]) -> Vec<u8> {
        let [width, height] = self.view.size;
        let size = self.world.bounds.size();
        let depth: Vec<f32> = self
            .fluid
            .iter()
            .zip(&self.behind)
            .map(|(fluid, behind)| fluid.depth.min(behind.nearest()))
            .collect();
        let far = self.view.local(self.world.bounds.centre()).z + size;
        let hidden = occlusion::occlusion(&depth, width, width / 60, [0.16 * size, far]);
        let table: Vec<Vec3> = (0..=255)
            .map(|n| {
                Vec3::from_array(self.colour_map().at(f64::from(n) / 255.0).map(|c| f32::from(c) / 255.0))
            })
            .collect();
        let light = self.light(self.view);
        let mut rgb = vec![[0u8; 3]; width * height];
        rgb.par_chunks_mut(width).enumerate().for_each(|(row, line)| {
            for (column, pixel) in line.iter_mut().enumerate() {
                let at = row * width + column;
                let colour = self.pixel(&light, [column, row], &table, frame.particle_radius as f32);
                // Not the ground: a dark rim around all that stands on it would be no shadow.
                let lies_on = self.behind[at].body || self.fluid[at].depth < f32::INFINITY;
                let colour = if lies_on { colour * (1.0 - 0.3 * hidden[at]) } else { colour };
                *pixel = colour.to_array().map(|c| (255.0 * c.clamp(0.0, 1.0) + 0.5) as u8);
            }
        });
        let mut canvas = Canvas::new([width as f64, height as f64]);
        canvas.image([0.0; 2], [width, height], |x, y| rgb[y * width + x]);
        for (prop, pose) in self.world.props.iter().zip(poses).filter(|(prop, _)| prop.container) {
            overlay::draw_edges(&mut canvas, &self.view, &prop.model, pose);
        }
        overlay::draw(&mut canvas, [width as f64, height as f64], &self.legend(frame));
        canvas.to_preview()
    }

    fn pixel(&self, light: &Light, [column, row]: [usize; 2], table: &[Vec3], particle_radius: f32) -> Vec3 {
        let at = row * self.view.size[0] + column;
        let (fluid, behind) = (self.fluid[at], &self.behind[at]);
        if fluid.depth == f32::INFINITY {
            return 0.25 * behind.colours.iter().sum::<Vec3>();
        }
        let [low, high] = self.range;
        let place = ((f64::from(fluid.value) - low) / (high - low)).clamp(0.0, 1.0);
        let colour = table[(255.0 * place) as usize];
        let normal = light.fluid_normal(&self.fluid, [column, row]);
        let surface = light.fluid([column as f32 + 0.5, row as f32 + 0.5], normal, colour);
        let through = match self.settings.style {
            Style::Surface => shade::transmittance(fluid.thickness / particle_radius),
            Style::Particles => (1.0 - fluid.thickness / (0.5 * particle_radius)).max(0.0),
        };
        let mixed = |n: usize| {
            let covered = fluid.depth < behind.depths[n];
            if covered {
                surface.lerp(behind.colours[n] * (0.55 + 0.45 * colour), through)
            } else {
                behind.colours[n]
            }
        };
        0.25 * (0..4).map(mixed).sum::<Vec3>()
    }

    fn colour_map(&self) -> ColourMap {
        match self.settings.colour {
            ColourBy::Speed => ColourMap::Water,
            ColourBy::Density | ColourBy::Pressure => ColourMap::Viridis,
        }
    }

    fn legend(&self, frame: &Frame) -> overlay::Legend<'static> {
        let quantity = match self.settings.colour {
            ColourBy::Speed => ("speed", "m/s"),
            ColourBy::Density => ("density / rest density", ""),
            ColourBy::Pressure => ("pressure", "Pa"),
        };
        overlay::Legend {
            map: self.colour_map(),
            range: self.range,
            quantity,
            backed: self.settings.camera.is_some(),
            title: format!("t = {:.3} s", frame.time),
            subtitle: format!(
                "{} particles, step {}",
                thousands(frame.positions.len() as u64),
                thousands(frame.step)
            ),
        }
    }
}

/// What is drawn into bands.
struct Layers<'a> {
    scenery: &'a Scenery<'a>,
    width: usize,
    faces: &'a [Triangle],
    balls: &'a [Splat],
}

impl Layers<'_> {
    /// Bodies and ground, with light, in samples.
    fn draw_behind(&self, band: usize, sorted: &Bands, out: &mut [Behind]) {
        let fine = &self.scenery.light.view;
        let mut solid = Vec::new();
        for part in 0..FINER {
            let fine_band = FINER * band + part;
            let first = fine_band * BAND;
            let rows = BAND.min(fine.size[1].saturating_sub(first));
            solid.clear();
            // Where nothing is drawn, nothing is looked up.
            if rows > 0 && sorted.of(fine_band).next().is_some() {
                solid.resize(rows * fine.size[0], Fragment::NONE);
                sorted.of(fine_band).for_each(|face| self.faces[face].draw(fine_band, fine, &mut solid));
            }
            let above = (fine_band * BAND / FINER - band * BAND) * self.width;
            for (n, pixel) in out.iter_mut().skip(above).take(rows / FINER * self.width).enumerate() {
                let (column, row) = (FINER * (n % self.width), FINER * (n / self.width));
                let places = [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| [column + x, row + y]);
                let sample = |[x, y]: [usize; 2]| solid.get(y * fine.size[0] + x).copied();
                let samples = places.map(|place| sample(place).unwrap_or(Fragment::NONE));
                *pixel = self.lit(places.map(|[x, y]| [x, first + y]), samples);
            }
        }
    }

    /// Light on the samples of a pixel: once, if they are alike.
    fn lit(&self, places: [[usize; 2]; 4], samples: [Fragment; 4]) -> Behind {
        let middle = |[x, y]: [usize; 2]| [x as f32 + 0.5, y as f32 + 0.5];
        let body = samples.iter().any(|sample| sample.depth < f32::INFINITY);
        if samples.iter().all(|sample| sample.material == samples[0].material) {
            let mean = Fragment {
                depth: 0.25 * samples.iter().map(|sample| sample.depth).sum::<f32>(),
                normal: samples.iter().map(|sample| sample.normal).sum(),
                ..samples[0]
            };
            let (colour, depth) = self.scenery.behind(places[3].map(|n| n as f32), mean, None);
            let depths = if body { samples.map(|sample| sample.depth) } else { [depth; 4] };
            return Behind { colours: [colour; 4], depths, body };
        }
        let lit = |n: usize| self.scenery.behind(middle(places[n]), samples[n], Some(n));
        let lit = [lit(0), lit(1), lit(2), lit(3)];
        Behind { colours: lit.map(|l| l.0), depths: lit.map(|l| l.1), body }
    }
}

impl Behind {
    fn farthest(&self) -> f32 {
        self.depths.iter().copied().fold(0.0, f32::max)
    }

    fn nearest(&self) -> f32 {
        self.depths.iter().copied().fold(f32::INFINITY, f32::min)
    }
}

/// Numbers that suit the world: three quarters of the speed of a fall from its top, its hydrostatic pressure.
fn usual_range(colour: ColourBy, world: &World) -> [f64; 2] {
    let up = (-world.gravity).try_normalize().unwrap_or(Vec3::Y);
    let height = f64::from(up.abs().dot(world.bounds.high - world.bounds.low));
    let gravity = f64::from(world.gravity.length()).max(0.1);
    match colour {
        ColourBy::Speed => [0.0, 0.75 * (2.0 * gravity * height).sqrt()],
        ColourBy::Density => [0.9, 1.1],
        ColourBy::Pressure => [0.0, world.rest_density * gravity * height],
    }
}
