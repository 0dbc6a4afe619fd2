//! Patches: triangles that hang together without meeting another part, so that each side of a patch has one winding
//! number.

use super::contacts::Contacts;
use crate::mesh::topology::{DisjointSets, Topology};

/// The triangles of each patch. A triangle that meets another is one by itself.
pub fn patches(topology: &Topology, contacts: &Contacts) -> Vec<Vec<u32>> {
    let neighbours = topology.neighbours();
    let mut is_met = vec![false; neighbours.len()];
    contacts.met.iter().for_each(|&triangle| is_met[triangle as usize] = true);
    let mut sets = DisjointSets::new(neighbours.len());
    for (triangle, across) in neighbours.iter().enumerate().filter(|(triangle, _)| !is_met[*triangle]) {
        let smooth =
            across.iter().filter(|neighbour| !neighbour.same_way()).filter_map(|neighbour| neighbour.face());
        for other in smooth.filter(|&other| other > triangle && !is_met[other]) {
            sets.union(triangle as u32, other as u32);
        }
    }
    let (labels, count) = sets.numbered();
    let mut patches = vec![Vec::new(); count];
    labels.iter().enumerate().for_each(|(triangle, &label)| patches[label as usize].push(triangle as u32));
    patches
}
