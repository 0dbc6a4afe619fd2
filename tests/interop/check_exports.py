#!/usr/bin/env python3
"""Holds what `volmap export` writes, as other programs read it, against `volmap query`.

    check_exports.py --against VOLMAP ASSET

VTKHDF by VTK's own probe; VTI by VTK's reader; PLY by trimesh and meshio; .cdm and .cdf by the few lines of numpy below,
which interpolate as Discregrid does. Prints the largest differences; exits 1 on failure.
"""

import argparse
import json
import pathlib
import subprocess
import tempfile

import meshio
import numpy as np
import trimesh
import vtk
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import read_asset
from compare_reader import query

REMOVED, UNSAMPLED = 0xFFFFFFFF, np.finfo(np.float64).max


def output(*command):
    return subprocess.run(list(map(str, command)), check=True, capture_output=True, text=True).stdout


class Case:
    def __init__(self, volmap, asset, folder):
        self.volmap, self.asset, self.folder = volmap, asset, folder
        self.info = json.loads(output(volmap, "info", asset, "--json"))
        grid = self.info["grid"]
        self.low, self.size = np.array(grid["origin"]), np.array(grid["cell_size"])
        self.high = self.low + self.size * np.array(grid["resolution"])
        self.radius = self.info["support_radius"]
        self.ball = self.info["quadrature"]["ball_volume"]

    def export(self, name, *options):
        path = self.folder / name
        output(self.volmap, "export", self.asset, "-o", path, *options)
        return path

    def query(self, points):
        """Regions, distances (nan where unknown), volumes."""
        regions, numbers = query(self.volmap, self.asset, points, self.folder, read_asset.COLUMNS)
        return np.array(regions), numbers[:, 0], numbers[:, 7]

    def check(self, what, difference, bound):
        worst = float(np.max(np.abs(difference)))
        print(f"{self.asset.name}: {what}: {worst:.1e}")
        assert worst <= bound, f"{what}: {worst} > {bound}"


def arrays(data):
    points = data.GetPointData()
    return {points.GetArrayName(i): vtk_to_numpy(points.GetArray(i)) for i in range(points.GetNumberOfArrays())}


def read(reader, path):
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def check_vtkhdf(case, points):
    grid = read(vtk.vtkHDFReader(), case.export("map.vtkhdf"))
    assert grid.GetNumberOfCells() == case.info["cells"]["band"]
    radius = vtk_to_numpy(grid.GetFieldData().GetArray("support_radius"))[0]
    assert radius == case.radius
    where = vtk.vtkPolyData()
    where.SetPoints(vtk.vtkPoints())
    where.GetPoints().SetData(numpy_to_vtk(points, deep=True))
    probe = vtk.vtkProbeFilter()
    probe.SetInputData(where)
    probe.SetSourceData(grid)
    # By default a point is moved into any cell that is closer than a millionth of the grid.
    probe.ComputeToleranceOff()
    probe.SetTolerance(0)
    probe.Update()
    found = arrays(probe.GetOutput())
    regions, distance, volume = case.query(points)
    band = regions == "band"
    # Beside the band, VTK's tolerance reaches a little into the next cell.
    assert (found["vtkValidPointMask"][band] == 1).all() and band.sum() > 500
    case.check("VTKHDF, distance, m", found["signed_distance"][band] - distance[band], 1e-12)
    case.check("VTKHDF, volume / ball", (found["volume"][band] - volume[band]) / case.ball, 1e-12)


def check_vti(case):
    image = read(vtk.vtkXMLImageDataReader(), case.export("map.vti", "--resolution", "19,23,17"))
    assert image.GetDimensions() == (20, 24, 18)
    found = arrays(image)
    # Not on the border, where rounding decides what is outside.
    inner = np.zeros((18, 24, 20), bool)
    inner[1:-1, 1:-1, 1:-1] = True
    points = np.array([image.GetPoint(i) for i in np.flatnonzero(inner.ravel())])
    regions, distance, volume = case.query(points)
    names = np.array(["outside", "band", "deep_inside"])[found["region"][inner.ravel()]]
    # Rounding may move a point that lies on a cell's face.
    same = names == regions
    assert same.mean() > 0.99
    limit = 2 * case.radius
    distance = np.where(regions == "outside", limit, np.where(regions == "deep_inside", -limit, distance))
    bound = 1e-12 if found["volume"].dtype == np.float64 else 1e-6
    difference = found["signed_distance"][inner.ravel()] - np.clip(distance, -limit, limit)
    case.check("VTI, distance, m", difference[same], bound)
    case.check("VTI, volume / ball", (found["volume"][inner.ravel()] - volume)[same] / case.ball, bound)
    one = arrays(read(vtk.vtkXMLImageDataReader(), case.export("one.vti", "--field", "distance")))
    assert sorted(one) == ["region", "signed_distance"]


def check_ply(case):
    for iso in (0.0, 0.05):
        path = case.export("surface.ply", "--iso", iso)
        mesh = trimesh.load(path)
        assert mesh.is_watertight and mesh.is_winding_consistent
        other = meshio.read(path)
        assert len(other.points) == len(mesh.vertices) and len(other.cells_dict["triangle"]) == len(mesh.faces)
        regions, distance, _ = case.query(np.array(other.points)[:: max(1, len(other.points) // 1000)])
        assert (regions == "band").all()
        case.check(f"PLY, distance of the vertices from {iso} m", distance - iso, 1e-12)
        if iso == 0 and not case.info["bake"]["thickness"]:
            # Normals point from the solid into the fluid: into a container.
            sign = -1 if case.info["exterior"] == "solid" else 1
            volume = case.info["diagnosis"]["volume"]
            case.check("PLY, relative error of the solid's volume", sign * mesh.volume / volume - 1, 0.01)


class Discregrid:
    """A map as SPlisHSPlasH loads it: CubicLagrangeDiscreteGrid::load and interpolate."""

    def __init__(self, path):
        data, at = path.read_bytes(), 0

        def take(kind, count):
            nonlocal at
            array = np.frombuffer(data, kind, count, at)
            at += array.nbytes
            return array

        def lists(kind, columns=1):
            return [take(kind, columns * int(take("<u8", 1)[0])) for _ in range(int(take("<u8", 1)[0]))]

        self.low, self.high = take("<f8", 3), take("<f8", 3)
        self.resolution = take("<u4", 3).astype(int)
        self.size, self.inverse = take("<f8", 3), take("<f8", 3)
        cells, fields = take("<u8", 2)
        self.nodes, self.cells, self.cell_map = lists("<f8"), lists("<u4", 32), lists("<u4")
        assert at == len(data) and cells == self.resolution.prod()
        assert fields == len(self.nodes) == len(self.cells) == len(self.cell_map)

    def shape(self, x):
        """The 32 shape functions, in Discregrid's order, at reference coordinates [n, 3]."""
        out = []
        side = (-1, 1)
        for z, y, sx in ((z, y, sx) for z in side for y in side for sx in side):
            corner = (1 + sx * x[:, 0]) * (1 + y * x[:, 1]) * (1 + z * x[:, 2])
            out.append(corner * (9 * (x**2).sum(1) - 19) / 64)
        # Along x: z runs first, then y. Along y: x, then z. Along z: y, then x.
        for axis, first, second in ((0, 2, 1), (1, 0, 2), (2, 1, 0)):
            for s2, s1, third in ((s2, s1, t) for s2 in side for s1 in side for t in side):
                along = 9 / 64 * (1 - x[:, axis] ** 2) * (1 + 3 * third * x[:, axis])
                out.append(along * (1 + s1 * x[:, first]) * (1 + s2 * x[:, second]))
        return np.stack(out, 1)

    def interpolate(self, field, points):
        """By the cells of field 0, as SPlisHSPlasH does; UNSAMPLED where there is no value."""
        cell = np.minimum(((points - self.low) * self.inverse).astype(int), self.resolution - 1)
        nx, ny, _ = self.resolution
        stored = self.cell_map[0][cell[:, 0] + nx * (cell[:, 1] + ny * cell[:, 2])]
        there = stored != REMOVED
        nodes = self.cells[0].reshape(-1, 32)[np.where(there, stored, 0)]
        values = self.nodes[field][nodes]
        there &= (values != UNSAMPLED).all(1)
        xi = 2 * (points - (self.low + cell * self.size)) / self.size - 1
        return np.where(there, (self.shape(xi) * np.where(values == UNSAMPLED, 0, values)).sum(1), UNSAMPLED)


def check_discregrid(case, points):
    grid = Discregrid(case.export("map.cdm"))
    assert (grid.high == case.high).all() and (grid.cells[0] == grid.cells[1]).all()
    regions, distance, volume = case.query(points)
    found = [grid.interpolate(field, points) for field in (0, 1)]
    band, deep = regions == "band", regions == "deep_inside"
    case.check("cdm, distance, m", found[0][band] - distance[band], 1e-13)
    case.check("cdm, volume / ball", (found[1][band] - volume[band]) / case.ball, 1e-12)
    assert (found[0][regions == "outside"] == UNSAMPLED).all()
    assert (found[0][deep] <= -2 * case.radius * 0.9).all()
    print(f"{case.asset.name}: cdm, {deep.sum()} points deep inside, down to {found[0].min():.3f} m")
    distances = Discregrid(case.export("map.cdf"))
    assert len(distances.nodes) == 1 and (distances.nodes[0] == grid.nodes[0]).all()
    back = case.folder / "back.h5"
    output(case.volmap, "import", case.folder / "map.cdm", "-o", back, "--support-radius", case.radius)
    again = Case(case.volmap, back, case.folder)
    _, there, _ = again.query(points)
    assert (there[band] == distance[band]).all()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("asset", type=pathlib.Path)
    parser.add_argument("--against", required=True, help="the program volmap")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        case = Case(arguments.against, arguments.asset, pathlib.Path(folder))
        points = np.random.default_rng(3).uniform(case.low, case.high, (3000, 3))
        check_vtkhdf(case, points)
        check_vti(case)
        check_ply(case)
        check_discregrid(case, points)


main()
