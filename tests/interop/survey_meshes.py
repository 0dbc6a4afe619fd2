"""Bakes every mesh of a collection of real ones and checks what comes of it against independent programs.

    python survey_meshes.py --volmap target/release/volmap [--report report.json] FOLDER...

Without folders: /usr/share/assimp/models, of Debian's package assimp-testmodels. The data of libcgal-demo
(/usr/share/doc/libcgal-dev/data.tar.gz) come in an archive: unpack it and name its folder.

Each mesh is baked twice. With --keep-orientation the map has to be that of the file's own triangles: its nodes
are compared with distances and exact winding numbers by libigl, on the geometry as trimesh, meshio or VTK read
it. As baked by default, signs may differ only where triangles were turned, and are then compared with the
winding numbers of the turned mesh, made by trimesh, and with the parity of ray crossings.

Exit status 1 if anything panics, hangs, fails without a clear message or has a wrong sign or distance.
"""

import argparse
import base64
import collections
import concurrent.futures
import hashlib
import json
import pathlib
import subprocess
import sys
import tempfile

import h5py
import hdf5plugin  # noqa: F401 (registers Zstandard)
import igl
import igl.copyleft.cgal
import mapbox_earcut
import meshio
import numpy as np
import trimesh
import vtk
from vtk.util.numpy_support import vtk_to_numpy

EXTENSIONS = {".obj", ".stl", ".ply", ".off", ".gltf", ".glb", ".3mf", ".vtk", ".vtu", ".vtp"}
ASSIMP = "/usr/share/assimp/models"
TIME_LIMIT = 120
POINTS = 500
# Beyond the single precision of the stored fields, of the mesh's size: readers that keep coordinates in f32.
DISTANCE_TOLERANCE = 1e-5
# Nodes this close to the surface, in its size, may lie on either side by rounding.
TOO_CLOSE = 1e-4
# Winding numbers this close to one half are anyone's guess: baked ones are approximations near holes.
UNDECIDED = 0.02
# Both sides of a piece are asked this far off it, in the mesh's size.
SIDE = 1e-8
FINE_EVERY = 10
KINDS = [
    ("point cloud", "a point cloud"),
    ("no faces", "the mesh has no faces"),
    ("only degenerate faces", "collapse to points or lines"),
    ("unsupported feature", "is not supported;"),
    ("not a mesh format", "not a mesh"),
    ("too large", "--max-memory"),
    ("missing buffer file", "No such file"),
]


def main():
    arguments = parse_arguments()
    folders = arguments.folders or [ASSIMP]
    files = [f for folder in folders for f in sorted(pathlib.Path(folder).rglob("*")) if is_mesh(f)]
    with concurrent.futures.ProcessPoolExecutor(2) as pool:
        resolutions = [40 if k % FINE_EVERY == 0 else 20 for k in range(len(files))]
        records = list(pool.map(survey, files, [arguments.volmap] * len(files), resolutions))
    if arguments.report:
        pathlib.Path(arguments.report).write_text(json.dumps(records, indent=1))
    print_table(records)
    suspicious = [r for r in records if r["suspicious"]]
    for record in suspicious:
        print(f"SUSPICIOUS {record['file']}: {record['outcome']}: {record['note']}")
    sys.exit(1 if suspicious or not records else 0)


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--volmap", default="target/release/volmap")
    parser.add_argument("--report", help="JSON file with a record of each mesh")
    parser.add_argument("folders", nargs="*")
    return parser.parse_args()


def is_mesh(path):
    return path.is_file() and path.suffix.lower() in EXTENSIONS


def print_table(records):
    digests = {r["digest"] for r in records}
    print(f"{len(records)} meshes, {len(digests)} different ones")
    for what in ("outcome", "check"):
        counts = collections.Counter(r[what] for r in records if r.get(what))
        for name, count in sorted(counts.items(), key=lambda item: -item[1]):
            print(f"{what:8} {count:4}  {name}")


def survey(path, volmap, resolution):
    """One record: what came of a mesh."""
    record = {"file": str(path), "digest": hashlib.sha256(path.read_bytes()).hexdigest(), "resolution": resolution}
    with tempfile.TemporaryDirectory() as folder:
        kept, repaired = pathlib.Path(folder, "kept.h5"), pathlib.Path(folder, "repaired.h5")
        record |= bake(volmap, path, repaired, resolution)
        if record["outcome"] == "asset":
            try:
                again = bake(volmap, path, kept, resolution, "--keep-orientation")
                if again["outcome"] != "asset":
                    return record | again | {"suspicious": True}
                record |= check(volmap, path, kept, repaired)
            except Exception as error:  # what can't be checked has to show, not to end the survey
                record |= {"suspicious": True, "note": f"check failed: {type(error).__name__}: {error}"}
    return record


def bake(volmap, path, output, resolution, *options):
    command = [volmap, "bake", path, "-o", output, "--resolution", str(resolution), *options]
    command += ["--max-memory", "2GiB", "--quiet"]
    try:
        done = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT)
    except subprocess.TimeoutExpired:
        return {"outcome": "hang", "suspicious": True, "note": f"more than {TIME_LIMIT} s"}
    message = done.stderr.decode(errors="replace").strip()
    if done.returncode == 0:
        made = output.is_file()
        return {"outcome": "asset" if made else "no asset", "suspicious": not made, "note": message}
    if "panicked" in message or done.returncode != 1:
        return {"outcome": "panic", "suspicious": True, "note": f"{done.returncode}: {message}"}
    clear = message.startswith("error: ") and path.name in message and "report it" not in message
    kind = next((name for name, sign in KINDS if sign in message), "malformed file")
    outcome = f"error: {kind}" if clear else "error: UNCLEAR"
    return {"outcome": outcome, "suspicious": not clear or output.exists(), "note": message}


def check(volmap, path, kept, repaired):
    """What is wrong with the assets of a mesh, or how they were found right."""
    kept, map_file = Asset(kept), repaired
    repaired = Asset(repaired)
    if not (kept.finite and repaired.finite):
        return wrong("values that are not finite")
    state = "closed" if kept.diagnosis["closed"] else "open or not manifold"
    if repaired.diagnosis["flipped_triangles"]:
        state += ", turned"
    reader, mesh, notes = reference(path, kept)
    if mesh is None:
        return {"check": "NOT CHECKED: no reader agrees on the geometry", "suspicious": True, "note": notes}
    rng = np.random.default_rng(1)
    chosen = rng.permutation(len(kept.phi))[:POINTS]
    points, phi = kept.positions()[chosen], kept.phi[chosen]
    bad = compare(points, phi, mesh, kept)
    if bad:
        return wrong(f"{bad} (geometry by {reader})")
    bad = check_query(volmap, map_file, repaired, rng)
    if bad:
        return wrong(bad)
    if len(kept.phi) == len(repaired.phi) and np.array_equal(kept.phi, repaired.phi):
        return {"check": f"right ({state})", "reader": reader, "note": notes}
    return check_turned(repaired, mesh, state, reader)


def wrong(note):
    return {"check": "WRONG", "suspicious": True, "note": note}


class Asset:
    """An asset, read with h5py alone; nodes as `formats/SPEC.md` numbers them."""

    def __init__(self, path):
        with h5py.File(path) as file:
            groups = ("grid", "bake", "source", "diagnosis")
            self.grid, self.bake, self.source, self.diagnosis = (dict(file[g].attrs) for g in groups)
            self.runs = file["cells/band"][:].astype(np.int64)
            self.phi = file["fields/signed_distance"][:].astype(float)
            self.finite = np.isfinite(self.phi).all() and np.isfinite(file["fields/volume"][:]).all()
        self.size = np.linalg.norm(self.source["bounds_max"] - self.source["bounds_min"])

    def positions(self):
        n = self.grid["resolution"].astype(int)
        cells = np.zeros(n[::-1], bool)
        for i, j, k, length in self.runs:
            cells[k, j, i : i + length] = True
        points = [np.empty((0, 3))]
        for axis in (None, 0, 1, 2):
            found = touched_lattice(cells, axis)
            lattice = np.argwhere(found)[:, ::-1].astype(float)
            if axis is None:
                points.append(lattice)
                continue
            pair = np.repeat(lattice, 2, axis=0)
            pair[0::2, axis] += 1 / 3
            pair[1::2, axis] += 2 / 3
            points.append(pair)
        return self.grid["origin"] + np.concatenate(points) * self.grid["cell_size"]


def touched_lattice(cells, along):
    """Corners (along None) or edges along an axis that belong to a stored cell."""
    found = cells
    for axis in (0, 1, 2):
        if axis == along:
            continue
        dimension = 2 - axis
        before = [(0, 1) if d == dimension else (0, 0) for d in range(3)]
        after = [(1, 0) if d == dimension else (0, 0) for d in range(3)]
        found = np.pad(found, before) | np.pad(found, after)
    return found


def reference(path, asset):
    """The geometry of the first reader that agrees on box and area; or none, and what they say."""
    box = np.array([asset.source["bounds_min"], asset.source["bounds_max"]])
    area = asset.source["area"]
    said = []
    for name, read in READERS:
        try:
            vertices, faces = read(path)
            vertices, faces = unique_triangles(np.asarray(vertices, float) * asset.bake["unit"], np.asarray(faces))
            mesh = vertices[faces]
            found_box = np.array([mesh.min((0, 1)), mesh.max((0, 1))])
            found_area = 0.5 * np.linalg.norm(np.cross(mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]), axis=1).sum()
        except (Exception, SystemExit) as error:  # meshio exits where no format fits
            said.append(f"{name}: {type(error).__name__} {str(error)[:80]}")
            continue
        if np.abs(found_box - box).max() > 2e-6 * np.abs(box).max():
            said.append(f"{name}: box {found_box.round(6).tolist()}, not {box.round(6).tolist()}")
        elif abs(found_area - area) > 1e-5 * area:
            said.append(f"{name}: area {found_area:.8g}, not {area:.8g}; {len(faces)} triangles")
        else:
            return name, (vertices, faces), "; ".join(said)
    return None, None, "; ".join(said)


def unique_triangles(vertices, faces):
    """Equal vertices made one; triangles with fewer than three, or the same as another, left out."""
    vertices, index = np.unique(vertices, axis=0, return_inverse=True)
    faces = index.reshape(-1)[faces]
    first = faces.argmin(axis=1)
    faces = np.stack([faces[np.arange(len(faces)), (first + c) % 3] for c in range(3)], axis=1)
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return vertices, np.unique(faces[proper], axis=0)


def with_trimesh(path):
    mesh = trimesh.load(path, force="mesh", process=False)
    return mesh.vertices, mesh.faces


def with_meshio(path):
    mesh = meshio.read(path)
    return mesh.points, fans([face for block in mesh.cells if block.dim == 2 for face in block.data])


def with_vtk(path):
    readers = {
        ".ply": vtk.vtkPLYReader,
        ".obj": vtk.vtkOBJReader,
        ".stl": vtk.vtkSTLReader,
        ".vtp": vtk.vtkXMLPolyDataReader,
        ".vtk": vtk.vtkDataSetReader,
        ".vtu": vtk.vtkXMLUnstructuredGridReader,
    }
    reader, surface, triangles = readers[path.suffix.lower()](), vtk.vtkDataSetSurfaceFilter(), vtk.vtkTriangleFilter()
    reader.SetFileName(str(path))
    surface.SetInputConnection(reader.GetOutputPort())
    triangles.SetInputConnection(surface.GetOutputPort())
    triangles.Update()
    data = triangles.GetOutput()
    return vtk_to_numpy(data.GetPoints().GetData()), vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)


def with_plain_text(path):
    """OFF and OBJ by hand, whatever else a line holds ignored; polygons cut by earcut."""
    lines = [line.split("#")[0].split() for line in path.read_text(errors="replace").splitlines()]
    lines = [line for line in lines if line]
    if path.suffix.lower() == ".obj":
        vertices = [list(map(float, line[1:4])) for line in lines if line[0] == "v"]
        polygons = [[int(c.split("/")[0]) for c in line[1:]] for line in lines if line[0] == "f"]
        return ear_clipped(vertices, [[c - 1 if c > 0 else len(vertices) + c for c in face] for face in polygons])
    if path.suffix.lower() != ".off":
        raise ValueError("neither OFF nor OBJ")
    body = lines[1:] if len(lines[0]) == 1 else [lines[0][1:], *lines[1:]]
    count, faces = int(body[0][0]), int(body[0][1])
    vertices = [list(map(float, line[:3])) for line in body[1 : 1 + count]]
    rows = body[1 + count : 1 + count + faces]
    return ear_clipped(vertices, [list(map(int, row[1 : 1 + int(row[0])])) for row in rows])


def with_plain_gltf(path):
    """glTF of one file by hand: all modes that have triangles, no sparse accessors."""
    gltf = json.loads(path.read_text())
    folder = path.parent
    buffers = [gltf_buffer(folder, buffer["uri"]) for buffer in gltf["buffers"]]

    def array(k):
        accessor = gltf["accessors"][k]
        view = gltf["bufferViews"][accessor["bufferView"]]
        kind = np.dtype({5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}[accessor["componentType"]])
        width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = (view.get("byteStride") or kind.itemsize * width, kind.itemsize)
        return np.ndarray((accessor["count"], width), kind, buffers[view["buffer"]], start, stride)

    vertices, faces = [], []

    def visit(node, above):
        local = np.array(node.get("matrix", np.eye(4).ravel()), float).reshape(4, 4).T
        if set(node) & {"rotation", "scale"}:
            raise ValueError("rotation or scale")
        local[:3, 3] += node.get("translation", [0, 0, 0])
        here = above @ local
        for primitive in gltf["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
            points = array(primitive["attributes"]["POSITION"]).astype(float)
            order = array(primitive["indices"]).ravel() if "indices" in primitive else np.arange(len(points))
            faces.extend(sum(map(len, vertices)) + order[t] for t in triples(primitive.get("mode", 4), len(order)))
            vertices.append(points @ here[:3, :3].T + here[:3, 3])
        for child in node.get("children", []):
            visit(gltf["nodes"][child], here)

    for root in gltf["scenes"][gltf.get("scene", 0)]["nodes"]:
        visit(gltf["nodes"][root], np.eye(4))
    return np.concatenate(vertices), np.array(faces, dtype=np.int64)


def gltf_buffer(folder, uri):
    return base64.b64decode(uri.split(",", 1)[1]) if uri.startswith("data:") else (folder / uri).read_bytes()


def triples(mode, count):
    """Corners of the triangles of a glTF primitive: separate ones, a strip or a fan."""
    if mode == 4:
        return [[3 * k, 3 * k + 1, 3 * k + 2] for k in range(count // 3)]
    if mode == 5:
        return [[k, k + 1 + k % 2, k + 2 - k % 2] for k in range(count - 2)]
    return [[0, k + 1, k + 2] for k in range(count - 2)] if mode == 6 else []


def ear_clipped(vertices, polygons):
    """Triangles of polygons that may be concave. (VTK's own cutting loses some.)"""
    vertices, triangles = np.asarray(vertices, float), []
    for polygon in polygons:
        corners = vertices[polygon]
        normal = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0)
        if len(polygon) < 3 or not normal.any():
            continue
        u = np.cross(normal, np.eye(3)[np.abs(normal).argmin()])
        v = np.cross(normal, u)
        flat = np.stack([corners @ (u / np.linalg.norm(u)), corners @ (v / np.linalg.norm(v))], axis=1)
        cut = mapbox_earcut.triangulate_float64(flat, np.array([len(polygon)], np.uint32))
        triangles.extend(np.asarray(polygon)[cut.reshape(-1, 3)])
    return vertices, np.array(triangles, np.int64)


def fans(polygons):
    return [[face[0], face[c], face[c + 1]] for face in polygons for c in range(1, len(face) - 1)]


READERS = [
    ("trimesh", with_trimesh),
    ("meshio", with_meshio),
    ("VTK", with_vtk),
    ("plain text", with_plain_text),
    ("plain glTF", with_plain_gltf),
]


def distances(points, mesh):
    squared, *_ = igl.point_mesh_squared_distance(np.ascontiguousarray(points), *mesh)
    return np.sqrt(squared)


def union_surface(mesh):
    """The faces, cut where they cross (CGAL), without the pieces that have the solid on both sides."""
    vertices, faces, pairs, *_ = igl.copyleft.cgal.remesh_self_intersections(*mesh)
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1)
    offset = normals / np.maximum(length, 1e-300)[:, None] * SIDE * np.linalg.norm(np.ptp(mesh[0], axis=0))
    middle = corners.mean(axis=1)
    hidden = (winding(middle + offset, mesh) > 0.5) & (winding(middle - offset, mesh) > 0.5) & (length > 0)
    return (mesh if hidden.all() else (vertices, faces[~hidden]))


def winding(points, mesh):
    return np.atleast_1d(igl.winding_number(*mesh, np.ascontiguousarray(points)))


def compare(points, phi, mesh, asset):
    """What is wrong with values at nodes, if anything."""
    scale = asset.size + np.abs(points).max()
    # Of a mesh with holes some of what lies inside may still count.
    least, most = distances(points, mesh), distances(points, union_surface(mesh))
    if asset.diagnosis["closed"]:
        least = most
    difference = np.maximum(least - np.abs(phi), np.abs(phi) - most)
    worst = difference.argmax()
    if difference[worst] > DISTANCE_TOLERANCE * scale:
        return f"distance {phi[worst]:.6g} at {points[worst]}, off by {difference[worst]:.3g}"
    number = winding(points, mesh)
    decided = (np.abs(phi) > TOO_CLOSE * scale) & (np.abs(number - 0.5) > UNDECIDED)
    differ = decided & ((phi < 0) != (number > 0.5))
    if differ.any():
        at = np.flatnonzero(differ)[np.abs(phi[differ]).argmax()]
        found = f"winding number {number[at]:.4f}, distance {phi[at]:.6g} at {points[at]}"
        return f"sign differs at {differ.sum()} of {len(phi)} nodes: {found}"
    return None


def check_query(volmap, path, asset, rng):
    """Whether the program answers nodes with the values that are stored for them."""
    chosen = rng.permutation(len(asset.phi))[:100]
    points = asset.positions()[chosen]
    table = "x,y,z\n" + "\n".join(",".join(repr(float(c)) for c in p) for p in points)
    command = [volmap, "query", path, "--points", "-"]
    done = subprocess.run(command, input=table, capture_output=True, text=True, timeout=TIME_LIMIT)
    if done.returncode != 0:
        return f"query: {done.stderr}"
    rows = [line.split(",") for line in done.stdout.splitlines()[1:]]
    # Nodes on the domain's skin may fall out of it by rounding.
    near = [(float(row[3]), phi) for row, phi in zip(rows, asset.phi[chosen]) if row[11] == "band"]
    off = max((abs(a - b) for a, b in near), default=0.0)
    largest = np.abs(asset.phi).max()
    if off > 1e-5 * largest:
        return f"query is off by {off:.3g} at a node"
    return None if 2 * len(near) >= len(chosen) else f"query: only {len(near)} of {len(chosen)} nodes in the band"


def check_turned(asset, mesh, state, reader):
    """The default bake of a mesh whose triangles were turned."""
    rng = np.random.default_rng(2)
    chosen = rng.permutation(len(asset.phi))[:POINTS]
    points, phi = asset.positions()[chosen], asset.phi[chosen]
    decided = np.abs(phi) > TOO_CLOSE * (asset.size + np.abs(points).max())
    signs = {"as turned by trimesh": winding(points, turned(mesh)) > 0.5, "by parity": parity(points, mesh)}
    for how, inside in signs.items():
        if not (decided & ((phi < 0) != inside)).any():
            return {"check": f"right, {how} ({state})", "reader": reader}
    differ = {how: int((decided & ((phi < 0) != inside)).sum()) for how, inside in signs.items()}
    closed = bool(asset.diagnosis["closed"])
    return {"check": f"turned, signs differ ({state})", "suspicious": closed, "reader": reader, "note": str(differ)}


def turned(mesh):
    made = trimesh.Trimesh(*mesh, process=False)
    trimesh.repair.fix_normals(made, multibody=True)
    return np.asarray(made.vertices), np.asarray(made.faces, dtype=np.int64)


def parity(points, mesh):
    """Odd numbers of crossings, by VTK."""
    cells = vtk.vtkCellArray()
    for face in mesh[1]:
        cells.InsertNextCell(3, [int(v) for v in face])
    corners, asked = vtk.vtkPoints(), vtk.vtkPoints()
    for store, coordinates in ((corners, mesh[0]), (asked, points)):
        store.SetDataTypeToDouble()
        for p in coordinates:
            store.InsertNextPoint(*p)
    surface, cloud = vtk.vtkPolyData(), vtk.vtkPolyData()
    surface.SetPoints(corners)
    surface.SetPolys(cells)
    cloud.SetPoints(asked)
    select = vtk.vtkSelectEnclosedPoints()
    select.SetInputData(cloud)
    select.SetSurfaceData(surface)
    select.CheckSurfaceOff()
    select.SetTolerance(1e-9)
    select.Update()
    return vtk_to_numpy(select.GetOutput().GetPointData().GetArray("SelectedPoints")).astype(bool)


if __name__ == "__main__":
    main()
