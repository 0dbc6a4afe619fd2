"""Checks that the benches against SPlisHSPlasH end, and say why, where that program doesn't compute the same.

python check_bench.py

What is read from it is given here, as the version has it that the tables were made with and as others would.
"""

import json
import pathlib
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "solver/benches"))
import compare_splishsplash
import splishsplash

# Of version 2.19.0: f32.
FOUND = {
    "fluids": 1, "bodies": 1, "particles": 61250,
    "particle_mass": [0.125, 0.125], "particle_volume": [0.0001250000059371814, 0.0001250000059371814],
    "fluid_box": [[-1.4500000476837158, 1.4500000476837158], [0.05000000074505806, 2.450000047683716],
                  [-1.4500000476837158, 1.4500000476837158]],
    "tank": [[-1.5499999523162842, 1.5499999523162842], [-0.05000000074505806, 3.049999952316284],
             [-1.5499999523162842, 1.5499999523162842]],
    "rest_density": 1000.0, "viscosity": 0.009999999776482582, "particle_radius": 0.02500000037252903,
    "support_radius": 0.10000000149011612, "kernel": "cubic spline", "gravity": [0.0, -9.8100004196167, 0.0],
    "cfl_factor": 1.0, "largest_step": 0.004999999888241291, "least_step": 9.999999747378752e-05,
    "first_step": 0.0010000000474974513, "density_error": 0.0005000000074505806, "density_iterations": [2, 100],
    "divergence_solve": True, "divergence_error": 0.0010000000149011612, "divergence_iterations": 100,
}
DIFFERENT = {
    "particle_mass": [0.1, 0.1], "particle_volume": [0.0001, 0.0001], "particles": 61249,
    "tank": [[-1.55, 1.55], [-0.05, 3.0], [-1.55, 1.55]], "kernel": "another", "density_error": 1e-4,
    "density_iterations": [2, 1000], "divergence_iterations": 1000, "divergence_solve": False, "largest_step": 0.002,
}

dam = compare_splishsplash.DAM
assert FOUND.keys() == dam.expected().keys(), "a condition isn't checked here"
dam.check("SPlisHSPlasH", FOUND)
for name, value in DIFFERENT.items():
    try:
        dam.check("SPlisHSPlasH", {**FOUND, name: value})
    except SystemExit as error:
        assert f"  {name}: " in str(error) and " instead of " in str(error), error
        print(str(error).splitlines()[-1])
    else:
        raise AssertionError(f"{name} of {value} went by")

# Our side is given its conditions, whatever the defaults are.
with tempfile.TemporaryDirectory() as folder:
    ours = json.loads(dam.our_scene(pathlib.Path(folder), "mirror").read_text())
volume = ours["fluid"]["volume_factor"] * (2 * ours["particle_radius"]) ** 3
assert splishsplash.same(FOUND["particle_volume"], [volume] * 2), volume
