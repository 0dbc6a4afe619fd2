//! Triangles that are there twice.

use super::super::TriangleMesh;

/// Keeps the first of equal triangles and returns how many were dropped. Equal: the same corners in
/// the same cyclic order. Each is compared with those of the same lowest corner: a counting sort.
pub fn drop_duplicates(mesh: &mut TriangleMesh) -> usize {
    let triangles = &mut mesh.triangles;
    let mut ends = vec![0u32; mesh.vertices.len() + 1];
    for triangle in triangles.iter() {
        ends[lowest(triangle) as usize + 1] += 1;
    }
    for k in 1..ends.len() {
        ends[k] += ends[k - 1];
    }
    let mut order = vec![0u32; triangles.len()];
    for (k, triangle) in triangles.iter().enumerate() {
        // From where the vertex' triangles start to where they end.
        let next = &mut ends[lowest(triangle) as usize];
        order[*next as usize] = k as u32;
        *next += 1;
    }
    let mut doubles: Vec<u32> = Vec::new();
    let mut rest: Vec<([u32; 2], u32)> = Vec::new();
    let mut start = 0;
    for &end in &ends[..mesh.vertices.len()] {
        let group = &order[start..end as usize];
        start = end as usize;
        if group.len() < 2 {
            continue;
        }
        rest.clear();
        rest.extend(group.iter().map(|&k| (after_lowest(&triangles[k as usize]), k)));
        rest.sort_unstable();
        doubles.extend(rest.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[1].1));
    }
    doubles.sort_unstable();
    let mut next = doubles.iter().peekable();
    let mut k = 0;
    triangles.retain(|_| {
        k += 1;
        next.next_if(|&&double| double == k - 1).is_none()
    });
    doubles.len()
}

fn lowest(&[a, b, c]: &[u32; 3]) -> u32 {
    a.min(b).min(c)
}

/// The two corners that follow the lowest one.
fn after_lowest(&[a, b, c]: &[u32; 3]) -> [u32; 2] {
    if a < b && a < c {
        [b, c]
    } else if b < c {
        [c, a]
    } else {
        [a, b]
    }
}
