#!/usr/bin/python3
"""Whether two .vtu files hold the same mesh, bit for bit: points and tets in their order, every array with its type.

  tools/web/same_mesh.py A.vtu B.vtu
"""
import hashlib
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "cli"))
from meshes import read_vtu


def parts(path):
    points, arrays, tets = read_vtu(path)
    digest = lambda array: f"{array.dtype}{array.shape} {hashlib.sha256(array.tobytes()).hexdigest()}"
    return {"points": digest(points), "tets": digest(tets.astype("int64")),
            **{f"array {name}": digest(values) for name, values in arrays.items()}}


one, other = parts(sys.argv[1]), parts(sys.argv[2])
for name in sorted(one.keys() | other.keys()):
    if one.get(name) != other.get(name):
        print(f"{name}: {one.get(name)} in {sys.argv[1]}, {other.get(name)} in {sys.argv[2]}")
if one != other or "int64(0, 4)" in one["tets"]:
    sys.exit(1)
