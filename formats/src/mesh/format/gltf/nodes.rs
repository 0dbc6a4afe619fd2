//! The scene graph: which meshes are drawn, and where (glTF 2.0, sections 3.5.2 and 3.5.3; KHR_node_visibility).

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};

use super::json::{Node, Root};
use crate::mesh::error::MeshError;
use crate::mesh::raw::RawMesh;
use crate::mesh::text::show;

/// A mesh where a node of the scene puts it.
pub struct Placed {
    /// `None`: the file has no nodes.
    pub node: Option<usize>,
    pub mesh: usize,
    /// The node's, with those of its ancestors.
    pub affine: DAffine3,
}

/// All meshes of the default scene, or of all root nodes if there is no scene; parents before children. What is hidden
/// or outside of the scene is noted.
pub fn placed_meshes(root: &Root, raw: &mut RawMesh) -> Result<Vec<Placed>, MeshError> {
    let mut found = Vec::new();
    if root.nodes.is_empty() && root.scenes.is_empty() {
        let identity = DAffine3::IDENTITY;
        return Ok((0..root.meshes.len())
            .map(|mesh| Placed { node: None, mesh, affine: identity })
            .collect());
    }
    let mut visited = vec![false; root.nodes.len()];
    let mut hidden = Vec::new();
    // Nodes, their parents' transforms, and whether those are shown.
    let mut stack: Vec<(usize, DAffine3, bool)> = Vec::new();
    let tops = top_nodes(root, raw)?;
    stack.extend(tops.into_iter().rev().map(|node| (node, DAffine3::IDENTITY, true)));
    while let Some((index, parent, parent_shown)) = stack.pop() {
        let place = || format!("node {index}");
        let Some(node) = root.nodes.get(index) else {
            return Err(raw.bad(place(), "there is no such node; export the file again"));
        };
        if std::mem::replace(&mut visited[index], true) {
            return Err(raw.bad(
                place(),
                "the node has two parents or is its own ancestor, which glTF forbids; export the \
                 file again",
            ));
        }
        let affine = parent * local(node, raw, &place)?;
        let shown = parent_shown && is_visible(node);
        match node.mesh {
            Some(mesh) if shown => found.push(Placed { node: Some(index), mesh, affine }),
            Some(_) => hidden.push(index),
            None => {}
        }
        stack.extend(node.children.iter().rev().map(|&child| (child, affine, shown)));
    }
    if !hidden.is_empty() {
        raw.notes.push(format!("hidden by KHR_node_visibility, left out: {}", names(root, &hidden)));
    }
    let outside: Vec<usize> =
        (0..root.nodes.len()).filter(|&k| !visited[k] && root.nodes[k].mesh.is_some()).collect();
    if !outside.is_empty() {
        raw.notes.push(format!("outside of the scene, left out: {}", names(root, &outside)));
    }
    Ok(found)
}

fn is_visible(node: &Node) -> bool {
    let visibility = node.extensions.get("KHR_node_visibility");
    visibility.and_then(|extension| extension.get("visible")?.as_bool()).unwrap_or(true)
}

/// `node 3 (chair)`, and so on.
fn names(root: &Root, nodes: &[usize]) -> String {
    const MOST: usize = 5;
    let name = |&node: &usize| match root.nodes[node].name.as_deref() {
        Some(name) if !name.is_empty() => format!("node {node} ({})", show(name.as_bytes())),
        _ => format!("node {node}"),
    };
    let text = nodes.iter().take(MOST).map(name).collect::<Vec<_>>().join(", ");
    match nodes.len().saturating_sub(MOST) {
        0 => text,
        more => format!("{text} and {more} more"),
    }
}

fn top_nodes(root: &Root, raw: &RawMesh) -> Result<Vec<usize>, MeshError> {
    if root.scenes.is_empty() {
        return Ok(without_parents(root));
    }
    let scene = root.scene.unwrap_or(0);
    let found = root.scenes.get(scene).map(|scene| scene.nodes.clone());
    found.ok_or_else(|| raw.bad(format!("scene {scene}"), "there is no such scene; export again"))
}

fn without_parents(root: &Root) -> Vec<usize> {
    let mut is_child = vec![false; root.nodes.len()];
    for &child in root.nodes.iter().flat_map(|node| &node.children) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    (0..root.nodes.len()).filter(|&node| !is_child[node]).collect()
}

/// The transform of every node with those of its ancestors, whether it is in the scene or not; `None` of nodes that are
/// their own ancestors.
pub fn global_transforms(root: &Root, raw: &RawMesh) -> Result<Vec<Option<DAffine3>>, MeshError> {
    let mut found = vec![None; root.nodes.len()];
    let mut stack: Vec<(usize, DAffine3)> =
        without_parents(root).into_iter().map(|node| (node, DAffine3::IDENTITY)).collect();
    while let Some((index, parent)) = stack.pop() {
        let Some(node) = root.nodes.get(index).filter(|_| found[index].is_none()) else { continue };
        let affine = parent * local(node, raw, &|| format!("node {index}"))?;
        found[index] = Some(affine);
        stack.extend(node.children.iter().map(|&child| (child, affine)));
    }
    Ok(found)
}

/// A matrix (column by column), or translation * rotation * scale.
fn local(node: &Node, raw: &RawMesh, place: &dyn Fn() -> String) -> Result<DAffine3, MeshError> {
    if let Some(m) = &node.matrix {
        return Ok(DAffine3::from_mat4(DMat4::from_cols_array(m)));
    }
    let translation = node.translation.unwrap_or([0.0; 3]);
    let rotation = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let scale = node.scale.unwrap_or([1.0; 3]);
    transform(translation, rotation, scale)
        .ok_or_else(|| raw.bad(place(), "the rotation is not a quaternion; export the file again"))
}

/// Translation * rotation * scale; `None` if the rotation is no quaternion.
pub fn transform(translation: [f64; 3], rotation: [f64; 4], scale: [f64; 3]) -> Option<DAffine3> {
    let quaternion = DVec4::from(rotation);
    let length = quaternion.length();
    let rotation = (length > 0.0 && length.is_finite()).then(|| DQuat::from_vec4(quaternion / length))?;
    Some(DAffine3::from_scale_rotation_translation(DVec3::from(scale), rotation, DVec3::from(translation)))
}
