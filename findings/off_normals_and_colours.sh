#!/usr/bin/env bash
# pymeshlab doesn't read its own OFF files: normals come back as colours and colours as normals.
#
# Package: pymeshlab 2025.7.post1, with numpy 2.2.6. It needs the system's libGL, as VTK does.
#
# Behaviour: `save_current_mesh("x.off")` of a mesh or of points made from arrays writes colours that nobody gave it
# (white) as well as normals, under the header `NCOFF`, each vertex as "x y z  r g b a  nx ny nz". Geomview's manual,
# which is what OFF has for a specification, puts the normal first. So does pymeshlab's own reader: all normals of the
# file that it has just written come back as (255, 255, 255), and white as other colours. Places and faces are right,
# and neither side warns. With `save_vertex_color=False` the header is `NOFF`, and all comes back right.
#
# Seen (points of the unit sphere with their normals; then screened Poisson reconstruction, as one makes a closed mesh
# of a scan):
#
#     without.off: NOFF, first vertex: 0.0162 -0.04167 0.999 0.0162 -0.04167 0.999
#       normals read: [ 0.016 -0.042  0.999], [ 0.007  0.044 -0.999]
#       Poisson: 0 boundary edges, area 12.55 (12.57), volume 4.18 (4.19)
#     with.off: NCOFF, first vertex: 0.0162 -0.04167 0.999 255 255 255 255 0.0162 -0.04167 0.999
#       normals read: [255. 255. 255.], [255. 255. 255.]
#       Poisson: 192 boundary edges, area 17.96 (12.57), no volume
#
# Why it matters: who bakes a distance to a scan goes over exactly this way, points and normals, Poisson, closed mesh.
# pymeshlab's PLY drops these normals unless told otherwise, and its OFF seems to keep them. What comes out is an open
# sheet instead of a sphere: it has no inside, so the sign of a distance to it means nothing.
#
# In this project: `NCOFF` is read with places and faces alone, whatever stands after them (the row OFF of the table of
# formats in formats/README.md; the test of OFF's variants in formats/tests/mesh.rs has pymeshlab's order). Signs never
# come from normals of a file.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --no-cache-dir --disable-pip-version-check pymeshlab==2025.7.post1 numpy==2.2.6

cat >look.py <<'PYTHON'
import os

import numpy as np
import pymeshlab



def sphere(count):
    """Points of the unit sphere, evenly spread on a spiral; each is its own normal."""
    n = np.arange(count) + 0.5
    z, angle = 1 - 2 * n / count, np.pi * (1 + 5**0.5) * n
    return np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], axis=1)


points = sphere(1000)
folder = os.getcwd()
written = pymeshlab.MeshSet()
written.add_mesh(pymeshlab.Mesh(points, v_normals_matrix=points))
written.save_current_mesh(f"{folder}/with.off")
written.save_current_mesh(f"{folder}/without.off", save_vertex_color=False)
seen = {}
for name in "without.off", "with.off":
    lines = open(f"{folder}/{name}").read().splitlines()
    vertex = " ".join(f"{float(number):.4g}" for number in lines[2].split())
    print(f"{name}: {lines[0]}, first vertex: {vertex}")
    meshes = pymeshlab.MeshSet()
    meshes.load_new_mesh(f"{folder}/{name}")
    back = meshes.current_mesh()
    assert np.allclose(back.vertex_matrix(), points, atol=1e-5), "places have changed"
    normals = back.vertex_normal_matrix()
    print(f"  normals read: {np.round(normals[0], 3)}, {np.round(normals[-1], 3)}")
    meshes.generate_surface_reconstruction_screened_poisson(depth=6)
    measures = meshes.get_geometric_measures()
    edges = meshes.get_topological_measures()["boundary_edges"]
    volume = f"volume {measures['mesh_volume']:.2f} (4.19)" if not edges else "no volume"
    print(f"  Poisson: {edges} boundary edges, area {measures['surface_area']:.2f} (12.57), {volume}")
    seen[name] = normals, edges, measures["surface_area"]

normals, edges, area = seen["without.off"]
assert np.allclose(normals, points, atol=1e-5) and edges == 0 and abs(area - 12.57) < 0.1, "NOFF isn't read as before"
normals, edges, _ = seen["with.off"]
assert (normals == 255).all() and edges > 0, "NCOFF has changed"
PYTHON
venv/bin/python look.py
