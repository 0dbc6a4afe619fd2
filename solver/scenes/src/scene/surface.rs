//! The surface of a body's solid: the fluid meets it, mass fills it, bodies touch with it, pictures show it.

use std::sync::Arc;
use volmap_bake::primitive::PlacedPrimitive;
use volmap_fluid::bodies::Mass;
use volmap_formats::mesh::TriangleMesh;

/// A surface as it is known beside the map, in the map's frame. Where it isn't known so, the map's surface is the
/// body's.
#[derive(Clone, Debug, Default)]
pub struct Surface {
    /// A mesh of it: it encloses the mass, and bears boundary particles.
    pub mesh: Option<Arc<TriangleMesh>>,
    /// The shape that has it; its mass is a closed form.
    pub primitive: Option<PlacedPrimitive>,
}

impl Surface {
    /// That of a mesh, or of the shape that the mesh stands for, after `out` metres out of it. A mesh that is moved
    /// so is no mesh of the surface any more, as its edges are rounded; of most shapes it is known.
    pub fn new(mesh: Arc<TriangleMesh>, primitive: Option<PlacedPrimitive>, out: f64) -> Surface {
        if out == 0.0 {
            return Surface { mesh: Some(mesh), primitive };
        }
        let primitive = primitive.and_then(|primitive| primitive.offset(out));
        let mesh = primitive.as_ref().and_then(|primitive| primitive.mesh().ok()).map(Arc::new);
        Surface { mesh, primitive }
    }

    /// The mass that it encloses; density in kg/m^3. None of a surface that isn't closed.
    pub fn mass(&self, density: f64) -> Option<Mass> {
        match &self.primitive {
            Some(shape) => Mass::of_shape(shape, density),
            None => Mass::of_mesh(self.mesh.as_ref()?, density),
        }
    }
}
