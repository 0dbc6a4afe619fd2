#!/usr/bin/env python3
"""Reads volmap assets (HDF5, format versions 1 to 5): load(path).sample(points).

Written from SPEC.md alone; it shares no code with the Rust reader. Section numbers are SPEC.md's.
Needs numpy, h5py, hdf5plugin and blake3. Command line:

    read_asset.py ASSET POINTS.csv OUT.csv

POINTS.csv has a header with the columns x, y, z; OUT.csv gets, for each point,
region,distance,nx,ny,nz,cx,cy,cz,volume with 17 digits, empty where unknown.
"""

import csv
import math
import os
import sys

import h5py
import hdf5plugin  # noqa: F401  (registers Zstandard)
import numpy as np
from blake3 import blake3
from h5py import h5t

BAND, OUTSIDE, DEEP_INSIDE = 0, 1, 2
REGIONS = "band", "outside", "deep_inside"
COLUMNS = "distance", "nx", "ny", "nz", "cx", "cy", "cz", "volume"

TABLES = "/cells/band", "/cells/solid"
FIELDS = "/fields/signed_distance", "/fields/volume"
DENSITY = "/fields/density"  # of versions 2 and 4
WEIGHT = "/fields/plane_weight"  # of version 5
DENSITY_COLUMNS = "density", "gx", "gy", "gz"
GROUPS = "/", "/bake", "/cells", "/diagnosis", "/fields", "/grid", "/quadrature", "/source"

NUMBERS = (h5t.STD_U64LE, "u"), (h5t.STD_U64BE, "u"), (h5t.IEEE_F64LE, "f"), (h5t.IEEE_F64BE, "f")
ELEMENTS = {
    "u32": (h5t.STD_U32LE, h5t.STD_U32BE),
    "f32": (h5t.IEEE_F32LE, h5t.IEEE_F32BE),
    "f64": (h5t.IEEE_F64LE, h5t.IEEE_F64BE),
    "i16": (h5t.STD_I16LE, h5t.STD_I16BE),
}


class Refused(ValueError):
    """The file is not an asset, is newer than this reader, or is damaged."""


def need(condition, why):
    if not condition:
        raise Refused(why)


# Bytes to values: sections 2, 3 and 10 ------------------------------------------------------------


def attribute(obj, name):
    """(tag of section 10, value): text as str, numbers as an array of one axis."""
    where = f"attribute {name} of {obj.name}"
    need(name in obj.attrs, f"{where} is missing")
    raw = obj.attrs.get_id(name)
    kind, space = raw.get_type(), raw.get_space()
    need(space.get_simple_extent_type() != h5py.h5s.NULL and len(raw.shape) <= 1, f"{where}: shape")
    if kind.get_class() == h5t.STRING:
        need(not kind.is_variable_str() and raw.shape == (), f"{where}: not a scalar text of fixed length")
        need((kind.get_cset(), kind.get_strpad()) == (h5t.CSET_UTF8, h5t.STR_NULLTERM), f"{where}: kind of text")
        value = bytes(obj.attrs[name])
        need(len(value) + 1 == kind.get_size() and b"\0" not in value, f"{where}: length of text")
        return "s", value.decode()
    tag = next((tag for known, tag in NUMBERS if kind.equal(known)), None)
    need(tag, f"{where}: neither u64 nor f64 nor text")
    return tag, np.atleast_1d(obj.attrs[name]).astype("<u8" if tag == "u" else "<f8")


def text(obj, name, *allowed):
    tag, value = attribute(obj, name)
    need(tag == "s" and (not allowed or value in allowed), f"{name} of {obj.name} is {value!r}")
    return value


def numbers(obj, name, tag, count=1):
    found, value = attribute(obj, name)
    need(found == tag and len(value) == count, f"{name} of {obj.name}: type or shape")
    return value if count > 1 else value[0].item()


def u64le(n):
    return int(n).to_bytes(8, "little")


def check_root(file, fields):
    """Compares the root's checksum with all attributes; so it also sees each one's type."""
    total = blake3()
    for path in sorted(GROUPS + TABLES + fields, key=str.encode):
        obj = file[path]
        for key, name in sorted((name.encode("utf-8", "surrogateescape"), name) for name in obj.attrs):
            tag, value = attribute(obj, name)
            if (path, name) == ("/", "blake3"):
                continue
            content = value.encode() if tag == "s" else value.tobytes()
            size = len(content) if tag == "s" else len(value)
            place = path.encode()
            total.update(u64le(len(place)) + place + u64le(len(key)) + key + tag.encode() + u64le(size) + content)
    need(text(file, "blake3") == total.hexdigest(), "checksum of the attributes doesn't match")


def dataset(file, path, kinds, axes, columns=4):
    """(name of the type, elements), with the checksum compared."""
    data = file[path]
    found = next((kind for kind in kinds if any(data.id.get_type().equal(t) for t in ELEMENTS[kind])), None)
    need(found, f"{path}: type")
    need(data.shape is not None and len(data.shape) == axes and data.shape[1:] == (columns,) * (axes - 1), f"{path}: shape")
    need(math.prod(data.chunks or ()) * data.dtype.itemsize <= 1 << 20, f"{path}: a chunk of more than 1 MiB")
    values = data[()].astype(data.dtype.newbyteorder("<"))
    extents = b"".join(map(u64le, data.shape))
    digest = blake3(found.encode() + extents + values.tobytes()).hexdigest()
    need(text(data, "blake3") == digest, f"{path}: checksum doesn't match")
    return found, values


def field(file, path):
    """(name of the type, values in f64, bound on what rounding to i16 changed)."""
    found, values = dataset(file, path, ["f32", "f64", "i16"], 1)
    step, bound = 1.0, 0.0
    if found == "i16":
        step, bound = (numbers(file[path], name, "f") for name in ("scale_factor", "max_error"))
        need(step > 0 and math.isfinite(32768 * step), f"{path}: scale_factor is out of range")
        need(bound >= 0 and math.isfinite(bound), f"{path}: max_error is out of range")
    values = values.astype(np.float64) * step
    need(np.isfinite(values).all(), f"{path}: not finite")
    return found, values, bound


# Cells and nodes: sections 4 to 6 -----------------------------------------------------------------

BITS = np.array([(n & 1, n >> 1 & 1, n >> 2 & 1) for n in range(8)])
OTHERS = (1, 2), (0, 2), (0, 1)  # the two axes across an edge along x, y, z


class Runs:
    """Finds cells, numbered (k ry + j) rx + i, in a table of runs."""

    def __init__(self, table, resolution):
        i, j, k, length = table.astype(np.int64).T
        rx, ry, rz = resolution
        need(((length >= 1) & (i + length <= rx) & (j < ry) & (k < rz)).all(), "a run leaves the grid or is empty")
        self.start, self.length = (k * ry + j) * rx + i, length
        need((self.start[1:] >= self.start[:-1] + length[:-1]).all(), "runs overlap or aren't sorted")
        self.before = np.cumsum(length) - length  # cells in the runs before each
        self.i, self.j, self.k, self.cells = i, j, k, int(length.sum())

    def find(self, cell):
        """Rank among the table's cells, -1 for those that aren't in it."""
        if not self.cells:
            return np.full(len(cell), -1)
        run = np.maximum(np.searchsorted(self.start, cell, "right") - 1, 0)
        along = cell - self.start[run]
        return np.where((along >= 0) & (along < self.length[run]), self.before[run] + along, -1)

    def indices(self):
        """(i, j, k) of every cell: [cells, 3]."""
        along = np.arange(self.cells) - np.repeat(self.before, self.length)
        i, j, k = (np.repeat(axis, self.length) for axis in (self.i, self.j, self.k))
        return np.stack([i + along, j, k], 1)


def number_nodes(cells, resolution):
    """The 32 nodes of each cell [cells, 32], and how many nodes each family has."""
    rx, ry, _ = resolution + 1
    columns, counts, first = [], [], 0
    for family in range(4):
        touched = BITS
        if family:
            touched = np.zeros((4, 3), np.int64)
            touched[:, OTHERS[family - 1]] = BITS[:4, :2]
        i, j, k = np.moveaxis(cells[:, None] + touched, 2, 0)
        points, rank = np.unique((k * ry + j) * rx + i, return_inverse=True)
        a_point = 2 if family else 1
        nodes = first + a_point * rank.reshape(i.shape)[..., None] + np.arange(a_point)
        columns.append(nodes.reshape(len(cells), 8))
        counts.append(a_point * len(points))
        first += counts[-1]
    return np.concatenate(columns, 1), counts


def spread(values, counts):
    """The values of all nodes of one layer of cells, from those of the nodes in the plane: section 12."""
    corners, x_edges, y_edges = np.split(values, np.cumsum(counts[:2]))
    return np.concatenate([corners, corners, x_edges, x_edges, y_edges, y_edges, np.repeat(corners, 2)])


def shape_functions(xi):
    """N [n, 32] and dN/dxi [n, 32, 3] at the reference coordinates [n, 3]."""
    n, dn = np.empty((len(xi), 32)), np.empty((len(xi), 32, 3))
    side = 2 * BITS - 1
    factor = 1 + side * xi[:, None]
    bracket = 9 * (xi**2).sum(1)[:, None] - 19
    n[:, :8] = factor.prod(2) * bracket / 64
    for axis, (b, c) in enumerate(OTHERS):
        across = factor[:, :, b] * factor[:, :, c] / 64
        x = xi[:, axis, None]
        dn[:, :8, axis] = across * (side[:, axis] * bracket + 18 * x * factor[:, :, axis])

        nodes = slice(8 + 8 * axis, 16 + 8 * axis)
        u, sb, sc = side.T  # t + 2 db + 4 dc
        fb, fc = 1 + sb * xi[:, b, None], 1 + sc * xi[:, c, None]
        along = 9 / 64 * (1 - x**2) * (1 + 3 * u * x)
        n[:, nodes] = along * fb * fc
        dn[:, nodes, axis] = 9 / 64 * (3 * u - 2 * x - 9 * u * x**2) * fb * fc
        dn[:, nodes, b] = along * sb * fc
        dn[:, nodes, c] = along * fb * sc
    return n, dn


# Adaptive maps: section 14 ------------------------------------------------------------------------

PLACES = np.array([*BITS] + [((t + 1) / 3, b, c) for c in (0, 1) for b in (0, 1) for t in (0, 1)]
                  + [(a, (t + 1) / 3, c) for c in (0, 1) for a in (0, 1) for t in (0, 1)]
                  + [(a, b, (t + 1) / 3) for b in (0, 1) for a in (0, 1) for t in (0, 1)])
SIXTHS = np.rint(6 * PLACES / 2).astype(np.int64)  # of a cell's nodes, in sixths of a cell twice as large


class Level:
    """The cells and nodes of one level; `coarse` is the level before."""

    def __init__(self, band, solid, resolution, first_node, first_cell, coarse):
        self.band, self.solid, self.resolution = Runs(band, resolution), Runs(solid, resolution), resolution
        self.first_cell, self.first_node = first_cell, first_node
        self.indices = self.band.indices()
        nodes, counts = number_nodes(self.indices, resolution)
        self.nodes = nodes + first_node
        self.count, corners = sum(counts), counts[0]
        self.end = first_node + self.count
        # Per node: the cell that constrains it, or -1, and its place there in sixths.
        self.owner = np.full(self.count, -1)
        self.sixths = np.zeros((self.count, 3), np.int64)
        if coarse and coarse.band.cells and self.count:
            place = np.zeros((self.count, 3), np.int64)
            place[self.nodes - first_node] = 3 * self.indices[:, None] + SIXTHS
            # First by (k, j, i): the lowest of up to eight cells counts, so it is written last.
            for lower in BITS:
                cell = place // 6 - lower
                touches = ((place >= 6 * cell) & (place <= 6 * cell + 6) & (cell >= 0)
                           & (cell < coarse.resolution)).all(1)
                found = np.where(touches, coarse.band.find(cell_number(cell, coarse.resolution)), -1)
                has = found >= 0
                self.owner[has], self.sixths[has] = found[has], (place - 6 * cell)[has]
        free = first_node + np.flatnonzero(self.owner < 0)
        self.free, self.free_corners = free, free[free < first_node + corners]


def cell_number(cell, resolution):
    return (cell[..., 2] * resolution[1] + cell[..., 1]) * resolution[0] + cell[..., 0]


def complete(levels, values, corners_only=False):
    """The values of all nodes from those of the free ones."""
    free = np.concatenate([level.free_corners if corners_only else level.free for level in levels])
    need(len(values) == len(free), "not as many values as free nodes")
    out = np.zeros(levels[-1].end)
    out[free] = values
    for coarse, level in zip(levels, levels[1:]):
        at = np.flatnonzero(level.owner >= 0)
        if not len(at):
            continue
        xi = level.sixths[at] / 3 - 1
        nodes = coarse.nodes[level.owner[at]]
        shape = trilinear(xi) if corners_only else shape_functions(xi)[0]
        out[level.first_node + at] = (shape * out[nodes[:, : shape.shape[1]]]).sum(1)
    return out


def trilinear(xi):
    return ((1 + (2 * BITS - 1) * xi[:, None]) / 2).prod(2)


def trilinear_slopes(xi):
    side = 2 * BITS - 1
    factor = (1 + side * xi[:, None]) / 2
    return np.stack([side[:, a] / 2 * factor[:, :, b] * factor[:, :, c] for a, (b, c) in enumerate(OTHERS)], 2)


def half_space(q):
    """U(q)."""
    q = np.maximum(q, -1)

    def above(x, power):
        return np.maximum(x, 0) ** power

    def f(t, sign):
        return above(t, 5) * (1 / 10 + sign * t / 60)

    t = np.maximum(1 - q, 0)
    return (2 * f(2 - q, -1) - 8 * f(1.5 - q, -1) + above(t, 4) * (1 + 2 * t / 5 - t**2 / 10)
            + 2 * f(-q, 1) - 8 * f(-0.5 - q, 1))


def make_levels(band, solid, resolution):
    """The levels of two tables, with partition and balance checked."""
    for table in band, solid:
        need((np.diff(table[:, 0].astype(np.int64)) >= 0).all(), "levels out of order")
    count = 1 + max((int(table[:, 0].max()) for table in (band, solid) if len(table)), default=0)
    need(count <= 16 and ((resolution << (count - 1)) <= 1 << 20).all(), "too many levels")
    levels, first_node, first_cell = [], 0, 0
    for number in range(count):
        tables = (table[table[:, 0] == number, 1:] for table in (band, solid))
        level = Level(*tables, resolution << number, first_node, first_cell, levels[-1] if levels else None)
        levels.append(level)
        first_node, first_cell = level.end, first_cell + level.band.cells
    for number, level in enumerate(levels):
        listed = np.concatenate([level.indices, level.solid.indices()])
        need(len(np.unique(cell_number(listed, level.resolution))) == len(listed), "a cell is both band and solid")
        for up in range(1, number + 1):
            coarse = levels[number - up]
            parents = cell_number(listed >> up, coarse.resolution)
            need((coarse.band.find(parents) < 0).all() and (coarse.solid.find(parents) < 0).all(), "cells in cells")
            if up >= 2:
                around = np.array(np.meshgrid(*[(-1, 0, 1)] * 3)).reshape(3, -1).T
                near = (level.indices[:, None] + around).reshape(-1, 3)
                near = near[((near >= 0) & (near < level.resolution)).all(1)]
                need((coarse.band.find(cell_number(near >> up, coarse.resolution)) < 0).all(), "not balanced")
    return levels


# The map: sections 7 and 9 ------------------------------------------------------------------------


class Map:
    def __init__(self, file):
        need("format" in file.attrs, "not an asset")
        try:
            text(file, "format", "volmap")
        except ValueError:
            raise Refused("not an asset") from None
        version = numbers(file, "format_version", "u")
        need(version >= 1, "format_version is 0")
        need(version <= 5, f"the file is newer than this reader: format version {version}")
        self.plane, self.adaptive = version in (3, 4), version == 5
        self.fields = FIELDS + (DENSITY,) * (version % 2 == 0) + (WEIGHT,) * self.adaptive
        for path in GROUPS + TABLES + self.fields:
            kind = h5py.Group if path in GROUPS else h5py.Dataset
            need(path in file and isinstance(file[path], kind), f"{path} is missing")
        check_root(file, self.fields)

        text(file, "length_unit", "m")
        text(file, "extension_function", "cubic_spline")
        text(file["fields"], "node_layout", "cubic_serendipity_12" if self.plane else "cubic_serendipity_32")
        grid, rule = file["grid"], file["quadrature"]
        for group in grid, rule:
            for name in group.attrs:
                tag, value = attribute(group, name)
                need(tag != "f" or np.isfinite(value).all(), f"{name} of {group.name} isn't finite")
        self.exterior = text(grid, "exterior", "fluid", "solid")
        self.origin = numbers(grid, "origin", "f", 3)
        self.cell_size = numbers(grid, "cell_size", "f", 3)
        self.support_radius = numbers(grid, "support_radius", "f")
        self.ball_volume = numbers(rule, "ball_volume", "f")
        resolution = numbers(grid, "resolution", "u", 3)
        need(((1 <= resolution) & (resolution <= 1 << 20)).all(), "resolution is out of range")
        self.resolution = resolution.astype(np.int64)
        if self.plane:
            need(numbers(grid, "dimension", "u") == 2 and resolution[2] == 1, "not a grid in the plane")
        need(self.resolution[1] * self.resolution[2] <= 1 << 24, "resolution: too many rows")
        need((self.cell_size > 0).all() and self.support_radius > 0 and self.ball_volume > 0, "a size that isn't > 0")
        text(rule, "name")
        numbers(rule, "points", "u")
        need(numbers(rule, "degree", "u") < 1 << 32, "degree is out of range")

        decoded = sum((file[path].size or 0) * file[path].dtype.itemsize for path in TABLES + self.fields)
        need(decoded <= 4096 * os.path.getsize(file.filename) + (16 << 20), "too large for the file's size")
        if self.adaptive:
            self.read_levels(file)
        else:
            self.read_cells(file)
        self.density = self.read_density(file) if version % 2 == 0 else None

    def read_levels(self, file):
        band, solid = (dataset(file, path, ["u32"], 2, 5)[1] for path in TABLES)
        (precision, phi, phi_error), (same, volume, volume_error) = (field(file, path) for path in FIELDS)
        need(precision == same, "the fields have two types")
        need(band[:, 4].sum(dtype=np.int64) <= len(phi) == len(volume), "length of the fields")
        self.levels = make_levels(band, solid, self.resolution)
        self.precision, self.max_error = precision, (phi_error, volume_error)
        self.phi, self.volume = complete(self.levels, phi), complete(self.levels, volume)
        weight = dataset(file, WEIGHT, ["u32"], 1)[1].astype(np.int64)
        need((weight <= 1).all(), "weights other than 0 and 1")
        self.weight = complete(self.levels, weight.astype(float), True) if len(weight) else np.zeros(len(self.phi))
        self.nodes = np.concatenate([level.nodes for level in self.levels])

    def read_cells(self, file):
        self.band, self.solid = (Runs(dataset(file, path, ["u32"], 2)[1], self.resolution) for path in TABLES)
        runs = np.concatenate([np.stack([t.start, t.start + t.length]) for t in (self.band, self.solid)], 1)
        start, end = runs[:, np.argsort(runs[0], kind="stable")]
        need((start[1:] >= end[:-1]).all(), "a cell is both band and solid")

        (precision, phi, phi_error), (same, volume, volume_error) = (field(file, path) for path in FIELDS)
        need(precision == same, "the fields have two types")
        # Every cell has a corner of its own, so this bounds what number_nodes allocates.
        need(self.band.cells <= len(phi) == len(volume), "length of the fields")
        self.nodes, counts = number_nodes(self.band.indices(), self.resolution)
        # Half of the nodes of each family lies below the layer of cells.
        self.counts = [count // 2 for count in counts[:3]] if self.plane else counts
        need(sum(self.counts) == len(phi), "length of the fields")
        self.precision, self.phi, self.volume = precision, self.all_nodes(phi), self.all_nodes(volume)
        self.max_error = phi_error, volume_error

    def find_in_levels(self, cell, f, per):
        """(number among all band cells or -1, whether solid, 2 / cell size of the band cells, place in the cell)."""
        stored, deep = np.full(len(cell), -1), np.zeros(len(cell), bool)
        scale, open_ = np.ones(len(cell)), np.ones(len(cell), bool)
        cell, f = cell.copy(), f.copy()
        for number, level in enumerate(self.levels):
            at = cell_number(cell, level.resolution)
            found = level.band.find(at)
            hit = open_ & (found >= 0)
            stored[hit] = level.first_cell + found[hit]
            scale[hit] = 2.0**number
            deep |= open_ & (level.solid.find(at) >= 0)
            # Where nothing is listed, no finer cell will be: to go on does no harm.
            open_ &= ~hit
            up = 2 * f >= 1
            cell[open_] = (2 * cell + up)[open_]
            f[open_] = (2 * f - up)[open_]
        return stored, deep, per * scale[stored >= 0, None], f

    def all_nodes(self, values):
        return spread(values, self.counts) if self.plane else values

    def read_density(self, file):
        data = file[DENSITY]
        text(data, "extension_function", "linear")
        for name in "kernel", "quadrature":
            text(data, name)
        for name in "extension_length", "kernel_integral":
            value = numbers(data, name, "f")
            need(math.isfinite(value) and value > 0, f"{name} of {DENSITY} is out of range")
        numbers(data, "points", "u")
        need(numbers(data, "degree", "u") < 1 << 32, f"degree of {DENSITY} is out of range")
        precision, values, _ = field(file, DENSITY)
        need(precision == self.precision and len(values) == sum(self.counts), f"{DENSITY}: type or length")
        return self.all_nodes(values)

    def sample(self, points):
        """Arrays region, distance, normal, closest, volume and density (with gradient: [n, 4]) at the points [n, 3]; NaN
        where unknown."""
        points = np.asarray(points, np.float64).reshape(-1, 3)
        with np.errstate(over="ignore", invalid="ignore"):
            p = (points - self.origin) / self.cell_size
        per = 2 / self.cell_size
        if self.plane:
            p[:, 2] = np.where(np.isfinite(points[:, 2]), 0, np.nan)
            per[2] = 0
        inside = ((0 <= p) & (p <= self.resolution)).all(1)
        outer = DEEP_INSIDE if self.exterior == "solid" else OUTSIDE
        region = np.where(np.isfinite(points).all(1), outer, OUTSIDE)

        p = p[inside]
        cell = np.minimum(np.floor(p).astype(np.int64), self.resolution - 1)
        f = p - cell
        if self.adaptive:
            stored, deep, per, f = self.find_in_levels(cell, f, per)
        else:
            number = cell_number(cell, self.resolution)
            stored, deep = self.band.find(number), self.solid.find(number) >= 0
        region[inside] = np.where(stored >= 0, BAND, np.where(deep, DEEP_INSIDE, OUTSIDE))

        band = region == BAND
        stored, xi = self.nodes[stored[stored >= 0]], (2 * f - 1)[stored >= 0]
        n, dn = shape_functions(xi)
        phi = self.phi[stored]
        distance = np.full(len(points), np.nan)
        normal, closest = np.full((2, len(points), 3), np.nan)
        slope = np.full(len(points), np.nan)
        volume = np.where(region == DEEP_INSIDE, self.ball_volume, 0.0)
        distance[band] = (n * phi).sum(1)
        volume[band] = (n * self.volume[stored]).sum(1)
        if self.adaptive:
            weight = (trilinear(xi) * self.weight[stored[:, :8]]).sum(1)
            volume[band] += weight * self.ball_volume * half_space(distance[band] / self.support_radius) / half_space(-1)
        density = np.where((region == DEEP_INSIDE)[:, None], np.nan, np.zeros((1, 4)))
        if self.density is not None:
            rho = self.density[stored]
            density[band, 0] = (n * rho).sum(1)
            density[band, 1:] = per * np.einsum("na,nad->nd", rho, dn)
        gradient = per * np.einsum("na,nad->nd", phi, dn)
        length = np.linalg.norm(gradient, axis=1, keepdims=True)
        slope[band] = length[:, 0]
        normal[band] = np.divide(gradient, length, out=np.zeros_like(gradient), where=length > 0)
        closest[band] = points[band] - distance[band, None] * normal[band]
        return {"region": region, "distance": distance, "normal": normal, "closest": closest, "volume": volume,
                "slope": slope, "density": density}


def load(path):
    """The map of an asset; Refused if it is damaged, newer than this reader, or something else."""
    try:
        with h5py.File(path) as file:
            return Map(file)
    except FileNotFoundError:
        raise
    except (OSError, KeyError, RuntimeError, TypeError, ValueError) as error:
        raise Refused(f"{path}: {error}") from error


def table(answer):
    """The numbers of an answer as [n, 8], in the order of COLUMNS."""
    return np.column_stack([answer[name] for name in ("distance", "normal", "closest", "volume")])


def main(asset, points, out):
    with open(points, newline="") as file:
        rows = [[float(row[axis]) for axis in "xyz"] for row in csv.DictReader(file)]
    answer = load(asset).sample(rows)
    with open(out, "w", newline="") as file:
        write = csv.writer(file, lineterminator="\n").writerow
        write(("region", *COLUMNS))
        for region, row in zip(answer["region"], table(answer).tolist()):
            write([REGIONS[region], *("" if math.isnan(value) else repr(value) for value in row)])


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    try:
        main(*sys.argv[1:])
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"error: {error}")
