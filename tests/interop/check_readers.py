#!/usr/bin/env python3
"""Who reads assets: the rows of SPEC.md's section 13 for the programs that are here.

    check_readers.py GZIP.h5 ZSTD.h5 SPEC.md

Each program reads /fields/volume in a process of its own, because plugins that one loads serve the others too. The sum
that h5py gives with hdf5plugin is the right one.
"""

import os
import subprocess
import sys
from pathlib import Path

gzip, zstd, spec = (Path(argument) for argument in sys.argv[1:])

H5PY = "import h5py; print(h5py.File({path!r})['fields/volume'][:].sum(dtype='f8'))"
TABLES = "import tables; print(tables.open_file({path!r}).root.fields.volume[:].sum(dtype='f8'))"
PROGRAMS = {
    "h5py": H5PY,
    "h5py, after `import hdf5plugin`": "import hdf5plugin; " + H5PY,
    "netCDF4": "import netCDF4; print(netCDF4.Dataset({path!r})['fields/volume'][:].sum(dtype='f8'))",
    "PyTables": TABLES,
    "PyTables, with `HDF5_PLUGIN_PATH`": TABLES,
    "pyfive": "import pyfive; print(pyfive.File({path!r})['fields/volume'][:].sum(dtype='f8'))",
}
MODULES = {"PyTables": "tables"}


def plugin_path():
    return subprocess.run(
        [sys.executable, "-c", "import hdf5plugin; print(hdf5plugin.PLUGIN_PATH)"], capture_output=True, text=True, check=True
    ).stdout.strip()


def answer(name, path):
    """What a program makes of a file: the sum of the volume, or None where it refuses."""
    environment = {key: value for key, value in os.environ.items() if key != "HDF5_PLUGIN_PATH"}
    if "HDF5_PLUGIN_PATH" in name:
        environment["HDF5_PLUGIN_PATH"] = plugin_path()
    code = PROGRAMS[name].format(path=str(path))
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    return float(run.stdout) if run.returncode == 0 else None


def version(name):
    module = name.split(",")[0]
    code = f"import importlib.metadata as m; print(m.version({MODULES.get(module, module)!r}))"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()


def word(found, right):
    return "no" if found is None else "yes" if abs(found - right) < 1e-9 * abs(right) else "WRONG NUMBERS"


right = answer("h5py, after `import hdf5plugin`", gzip)
rows = {}
for line in spec.read_text().splitlines():
    cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
    if len(cells) == 4:
        rows[cells[0]] = cells[1:]
wrong = []
for name in PROGRAMS:
    found = [word(answer(name, path), right) for path in (gzip, zstd)]
    print(f"| {name} | {version(name)} | {found[0]} | {found[1]} |")
    if rows.get(name, [None] * 3)[1:] != found:
        wrong.append(f"{name}: {found}, but SPEC.md has {rows.get(name)}")
assert not wrong, "\n".join(wrong)
