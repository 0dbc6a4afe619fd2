#!/usr/bin/env bash
# splashsurf blends labels: where water touches oil, the surface gets the number of a third fluid.
#
# Packages: pysplashsurf 0.14.1.0 (the program splashsurf 0.14), meshio 5.3.5 for the files, numpy 2.2.6.
#
# Behaviour: `-a NAME` carries an attribute of the particles over to the mesh, as an SPH average in single precision.
# That is what one wants of a velocity. But it does so with integers too, whose type says that they are counts or
# labels, and says nothing: ids become fractions, and material 1 next to material 3 becomes 2, which no particle has.
# Of VTU's integer types it takes UInt32, a usual one of ids. Int32, Int64, UInt64 and UInt8 are an error that names the
# attribute; so who meets that error and converts to UInt32 walks into it.
#
# Seen (a block of 16 x 16 x 16 particles, the left half of material 1, the right half of material 3):
#
#     Int32:  exit code 1: Unsupported IOBuffer scalar data type
#     UInt32: exit code 0, warnings: 0, types on the mesh: float32, float32
#       id: 0.0% of 26,550 corners have a whole number
#       material, rounded: 12,873 corners 1, 804 corners 2, 12,873 corners 3
#
# Why it matters: ids, phases and bodies' numbers are what frames of SPH programs hold beside velocities, and a
# renderer that picks a colour or a shader by the rounded number shows a seam of another fluid. Nothing in the mesh file
# tells that the numbers were integers.
#
# In this project: "Surfaces of the fluid" in solver/README.md says which attributes of a frame make sense on a surface,
# and that ids don't.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install --quiet --no-cache-dir --disable-pip-version-check \
    pysplashsurf==0.14.1.0 meshio==5.3.5 numpy==2.2.6

cat >look.py <<'PYTHON'
import subprocess

import meshio
import numpy as np

RADIUS, SIDE = 0.025, 16
axis = 2 * RADIUS * (np.arange(SIDE) + 0.5)
places = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3).astype(np.float32)
labels = {"id": np.arange(len(places)), "material": np.where(places[:, 0] < SIDE * RADIUS, 1, 3)}


def surface(kind):
    """Exit code, messages and mesh of the program, with labels of the type `kind`."""
    cells = [("vertex", np.arange(len(places))[:, None])]
    data = {name: values.astype(kind) for name, values in labels.items()}
    meshio.write("particles.vtu", meshio.Mesh(places, cells, point_data=data))
    command = "venv/bin/pysplashsurf reconstruct particles.vtu -r 0.025 -l 2.0 -c 0.5 -t 0.6 -o surface.vtk"
    done = subprocess.run(command.split() + ["-a", "id", "-a", "material"], capture_output=True, text=True)
    text = done.stdout + done.stderr
    return done.returncode, text, meshio.read("surface.vtk") if done.returncode == 0 else None


code, text, mesh = surface(np.int32)
reason = next(line for line in text.splitlines() if "Unsupported" in line).split(": ")[-1]
print(f"Int32:  exit code {code}: {reason}")
assert code != 0, "Int32 is read now"

code, text, mesh = surface(np.uint32)
ids, material = (mesh.point_data[name].ravel() for name in ("id", "material"))
warned = [line for line in text.splitlines() if "WARN" in line or "ERROR" in line]
rounded = {number: int((np.round(material) == number).sum()) for number in (1, 2, 3)}
print(f"UInt32: exit code {code}, warnings: {len(warned)}, types on the mesh: {ids.dtype.name}, {material.dtype.name}")
print(f"  id: {(ids == np.round(ids)).mean():.1%} of {len(ids):,} corners have a whole number")
print("  material, rounded: " + ", ".join(f"{count:,} corners {number}" for number, count in rounded.items()))
assert code == 0 and not warned and ids.dtype.kind == material.dtype.kind == "f", "labels aren't floats any more"
assert (ids == np.round(ids)).mean() < 0.01 and rounded[2] > 100, "labels aren't averaged any more"
PYTHON
venv/bin/python look.py
