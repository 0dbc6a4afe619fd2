//! What moves a mesh's vertices before its node does: morph targets by their default weights (glTF 2.0, section
//! 3.7.2.2) and skins in the pose of the file's nodes (section 3.7.3).

use glam::{DAffine3, DMat4, DVec3};

use super::accessor::Buffers;
use super::json::{Primitive, Root};
use super::nodes::global_transforms;
use crate::mesh::budget::Budget;
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;

/// Adds the morph targets of a primitive to its positions.
pub fn add_targets(
    positions: &mut [[f64; 3]],
    primitive: &Primitive,
    weights: &[f64],
    buffers: &mut Buffers,
    budget: &mut Budget,
    place: &str,
) -> Result<(), MeshError> {
    for (target, &weight) in primitive.targets.iter().zip(weights) {
        let Some(&accessor) = target.get("POSITION").filter(|_| weight != 0.0) else { continue };
        let moves = buffers.positions(accessor, budget)?;
        if moves.len() != positions.len() {
            let problem =
                format!("a morph target moves {} vertices, and there are {}", moves.len(), positions.len());
            return Err(buffers.bad(place, problem + "; export the file again"));
        }
        for (p, d) in positions.iter_mut().zip(moves) {
            *p = (DVec3::from(*p) + weight * DVec3::from(d)).to_array();
        }
    }
    Ok(())
}

/// The transforms that a skin's joints give to what hangs on them.
pub struct Joints(Vec<DMat4>);

impl Joints {
    /// Of a skin: each joint's place in the scene, times its inverse bind matrix.
    pub fn of_skin(
        skin: usize,
        root: &Root,
        raw: &RawMesh,
        buffers: &mut Buffers,
        budget: &mut Budget,
    ) -> Result<Joints, MeshError> {
        let place = format!("skin {skin}");
        let Some(found) = root.skins.get(skin) else {
            return Err(raw.bad(place, "there is no such skin; export the file again"));
        };
        budget.take(root.nodes.len() + found.joints.len(), 256, "the scene")?;
        let places = global_transforms(root, raw)?;
        let bind = match found.inverse_bind_matrices {
            Some(accessor) => buffers.numbers(accessor, "MAT4", budget)?,
            None => Vec::new(),
        };
        let joint = |(k, &node): (usize, &usize)| {
            let place = places.get(node).copied().flatten()?;
            let inverse = match bind.get(16 * k..16 * (k + 1)) {
                Some(numbers) => DMat4::from_cols_slice(numbers),
                None if found.inverse_bind_matrices.is_none() => DMat4::IDENTITY,
                None => return None,
            };
            Some(DMat4::from(place) * inverse)
        };
        let joints: Option<Vec<DMat4>> = found.joints.iter().enumerate().map(joint).collect();
        let joints = joints.filter(|joints| !joints.is_empty()).ok_or_else(|| {
            raw.bad(place, "a joint has no node, or no inverse bind matrix; export the file again")
        })?;
        Ok(Joints(joints))
    }

    /// Moves the positions of a primitive; true if that mirrors it. `None`: it has no joints and weights.
    pub fn apply(
        &self,
        positions: &mut [[f64; 3]],
        primitive: &Primitive,
        buffers: &mut Buffers,
        budget: &mut Budget,
        place: &str,
    ) -> Result<Option<bool>, MeshError> {
        let sets = joint_sets(primitive);
        if sets.is_empty() {
            return Ok(None);
        }
        budget.take(positions.len(), 128, "the scene")?;
        let mut blended = vec![(DMat4::ZERO, 0.0); positions.len()];
        for [joints, weights] in sets {
            let joints = buffers.numbers(joints, "VEC4", budget)?;
            let weights = buffers.numbers(weights, "VEC4", budget)?;
            if joints.len() != 4 * positions.len() || weights.len() != joints.len() {
                return Err(
                    buffers.bad(place, "joints and weights don't fit the vertices; export the file again")
                );
            }
            for (k, (&joint, &weight)) in
                joints.iter().zip(&weights).enumerate().filter(|(_, (_, w))| **w != 0.0)
            {
                let Some(matrix) = self.0.get(joint as usize) else {
                    return Err(
                        buffers.bad(place, format!("there is no joint {joint} in the skin; export again"))
                    );
                };
                let (sum, total) = &mut blended[k / 4];
                *sum += *matrix * weight;
                *total += weight;
            }
        }
        let mut mirrored = false;
        for (k, (p, (matrix, total))) in positions.iter_mut().zip(blended).enumerate() {
            // A vertex without weights stays where it is.
            let affine =
                if total > 0.0 { DAffine3::from_mat4(matrix * (1.0 / total)) } else { DAffine3::IDENTITY };
            mirrored |= k == 0 && affine.matrix3.determinant() < 0.0;
            *p = affine.transform_point3(DVec3::from(*p)).to_array();
        }
        Ok(Some(mirrored))
    }
}

/// The accessors of joints and weights: `JOINTS_0` with `WEIGHTS_0`, and so on.
pub fn joint_sets(primitive: &Primitive) -> Vec<[usize; 2]> {
    let set = |n: usize| {
        let joints = primitive.attributes.get(&format!("JOINTS_{n}"))?;
        Some([*joints, *primitive.attributes.get(&format!("WEIGHTS_{n}"))?])
    };
    (0..).map_while(set).collect()
}
