#!/usr/bin/env bash
# Two widely used mesh readers take the relative indices of OBJ for other corners, each in its own way, in silence.
#
# Packages: trimesh 5.2.0 and meshio 5.3.5, with numpy 2.2.6.
#
# Behaviour: in a face of a Wavefront OBJ, a negative index counts back from the last vertex BEFORE the face: -1 is that
# one. So parts with such indices can be joined by `cat`, and programs that write triangle by triangle need no counter.
# - trimesh counts from the end of the FILE. Of two joined boxes the first one disappears, and the second one is there
#   twice. (It is right where all vertices come before all faces.)
# - meshio subtracts 1 from negative indices as from positive ones, and leaves them negative: -1 becomes -2, by numpy's
#   rules the last but one of the file. Its faces join corners of both boxes.
# Neither raises or warns. The same boxes with positive indices are right in both. VTK 9.5.2 and pymeshlab 2025.7 read
# 9 m^3 from the file with relative ones. A report on trimesh's part is open (its issue 2364).
#
# Seen (file: boxes of 1 and 8 m^3, joined; the solid has 9 m^3 and goes from x = 0 to 7):
#
#     trimesh  positive.obj:  9.000 m^3, x = 0 to 7, lowest index 0
#     meshio   positive.obj:  9.000 m^3, x = 0 to 7, lowest index 0
#     trimesh  relative.obj: 16.000 m^3, x = 5 to 7, lowest index 0
#     meshio   relative.obj: 14.667 m^3, x = 0 to 7, lowest index -9
#
# Why it matters: a bake of such a mesh is exact for a solid that nobody drew. trimesh's has no box at the origin, so
# particles flow through it, and usual checks don't tell: a box that is there twice has no open edge, a positive volume
# and finite corners.
#
# In this project: relative indices are resolved where they stand (the row OBJ of the table of formats in
# formats/README.md); the test of OBJ's forms in formats/tests/mesh.rs has faces of negative indices.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --no-cache-dir --disable-pip-version-check trimesh==5.2.0 meshio==5.3.5 numpy==2.2.6

cat >look.py <<'PYTHON'
import warnings

import meshio
import numpy as np
import trimesh

CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
FACES = np.array(
    [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4],
     [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7]]
)


def part(corners, first):
    """An OBJ of one box. `first` is the index of its first corner: -8 is relative."""
    vertices = "".join("v {} {} {}\n".format(*corner) for corner in corners)
    return vertices + "".join("f {} {} {}\n".format(*face) for face in FACES + first)


def describe(points, faces):
    a, b, c = (points[faces[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    used = points[faces].reshape(-1, 3)
    return round(volume, 3), used.min(axis=0)[0], used.max(axis=0)[0], faces.min()


def with_trimesh(path):
    mesh = trimesh.load_mesh(path)
    return describe(np.asarray(mesh.vertices), np.asarray(mesh.faces))


def with_meshio(path):
    mesh = meshio.read(path)
    return describe(mesh.points, mesh.cells_dict["triangle"])


small, large = CORNERS, 2 * CORNERS + [5, 0, 0]
open("positive.obj", "w").write(part(small, 1) + part(large, 9))
open("relative.obj", "w").write(part(small, -8) + part(large, -8))
seen = {}
with warnings.catch_warnings():
    warnings.simplefilter("error")
    for path in "positive.obj", "relative.obj":
        for name, read in ("trimesh", with_trimesh), ("meshio", with_meshio):
            seen[name, path] = volume, low, high, index = read(path)
            print(f"{name:8} {path}: {volume:6.3f} m^3, x = {low:g} to {high:g}, lowest index {index}")

RIGHT = (9.0, 0.0, 7.0, 0)
assert seen["trimesh", "positive.obj"] == seen["meshio", "positive.obj"] == RIGHT, "the plain file isn't read as before"
assert seen["trimesh", "relative.obj"][:3] == (16.0, 5.0, 7.0), "trimesh has changed"
assert seen["meshio", "relative.obj"][0] == 14.667 and seen["meshio", "relative.obj"][3] == -9, "meshio has changed"
PYTHON
venv/bin/python look.py
