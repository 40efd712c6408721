"""tree_format_test.py MESHMSER SOURCE [NODE]: the commands tree, cut and reconstruct, and the snippets of docs/tree.md."""

import json
import math
import os
import re
import subprocess
import sys
import tempfile

import numpy as np

meshmser, source = sys.argv[1:3]
node = sys.argv[3] if len(sys.argv) > 3 and sys.argv[3] else None
config = os.path.join(source, "configs", "mesh.yaml")
with open(os.path.join(source, "docs", "tree.md"), encoding="utf-8") as file:
    snippets = dict(re.findall(r"```(python|r|js)\n(.*?)```", file.read(), re.S))
assert set(snippets) == {"python", "r", "js"}, snippets.keys()


def expect(what, found, expected):
    if found != expected:
        sys.exit(f"{what}: found {found!r}, expected {expected!r}")


with tempfile.TemporaryDirectory() as folder:
    environment = dict(os.environ, MESHMSER_CACHE=os.path.join(folder, "cache"))

    def run(*command, code=0):
        done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        expect(f"exit code of {command}\n{done.stderr}", done.returncode, code)
        return done.stdout if code == 0 else done.stderr

    def tree_of(*options):
        run(meshmser, "tree", config, "tree.json", *options)
        with open(os.path.join(folder, "tree.json"), encoding="utf-8") as file:
            return json.load(file)

    def faces(name):
        """The last value of each face, of a binary PLY of double or int properties."""
        with open(os.path.join(folder, name), "rb") as file:
            data = file.read()
        head, body = data.split(b"end_header\n", 1)
        head = head.decode()
        vertices = int(re.search(r"element vertex (\d+)", head)[1])
        count = int(re.search(r"element face (\d+)", head)[1])
        vertex = np.dtype([(n, "<f8") for n in re.findall(r"property double (\w+)", head.split("element face")[0])])
        kind = "<i4" if "component" in head else "<f8"
        face = np.dtype([("n", "u1"), ("v", "<i4", 3), ("value", kind)])
        of_faces = np.frombuffer(body, face, count, vertices * vertex.itemsize)
        expect("bytes of " + name, len(body), vertices * vertex.itemsize + count * face.itemsize)
        expect("corners of " + name, set(of_faces["n"]), {3})
        return of_faces["value"]

    tree = tree_of()
    expect("format", (tree["format"], tree["version"], tree["polarity"]), ("meshmser tree", 1, "upper"))
    parent, level, area = tree["parent"], tree["level"], tree["area"]
    expect("order", all(p == -1 or p > n for n, p in enumerate(parent)), True)
    expect("levels above the parent's", all(p == -1 or level[n] > level[p] for n, p in enumerate(parent)), True)
    expect("the lowest level", tree["levels"][0], None)
    expect("ascending", tree["levels"][1:], sorted(tree["levels"][1:]))

    # By hand, walking up from each triangle.
    triangles = [0] * len(parent)
    for of in tree["node_of_triangle"]:
        while of >= 0:
            triangles[of] += 1
            of = parent[of]
    high = sum(level[of] >= 10 for of in tree["node_of_triangle"] if of >= 0)
    expected = f"{len(parent)} {max(triangles)} {high}\n"
    with open(os.path.join(folder, "snippet.py"), "w", encoding="utf-8") as file:
        file.write(snippets["python"])
    expect("the Python snippet", run(sys.executable, "snippet.py", "tree.json"), expected)
    with open(os.path.join(folder, "snippet.cjs"), "w", encoding="utf-8") as file:
        file.write(snippets["js"])
    if node:
        expect("the JavaScript snippet", run(node, "snippet.cjs", "tree.json"), expected)

    # Simplified: what is small is gone, the rest is as it was.
    median = sorted(area)[len(area) // 2]
    opened = tree_of("--min-area", repr(median))
    expect("areas that stay", sorted(opened["area"]), sorted(a for a, p in zip(area, parent) if a >= median or p < 0))
    flat = tree_of("--min-persistence", "0.7")
    leaves = set(range(len(flat["parent"]))) - set(flat["parent"])
    assert 0 < len(leaves) < len(set(range(len(parent))) - set(parent)), "no maximum was removed, or all"

    # Cut: components and their areas, as the tree has them at that level.
    at = 20
    printed = run(meshmser, "cut", config, "cut.ply", "--at", repr(tree["levels"][at - 1]))
    components = [n for n, p in enumerate(parent) if (level[p] if p >= 0 else 0) < at <= level[n]]
    numbers = faces("cut.ply")
    expect("components", sorted(set(numbers)), list(range(len(components) + 1)))
    expect("triangles above", int((numbers > 0).sum()), sum(level[of] >= at for of in tree["node_of_triangle"]))
    printed_areas = [float(line.split()[1]) for line in printed.splitlines()[1:]]
    for found, expected_area in zip(printed_areas, sorted((area[n] for n in components), reverse=True), strict=True):
        assert math.isclose(found, expected_area, rel_tol=1e-5), (found, expected_area)

    run(meshmser, "reconstruct", config, "scalar.ply")
    values = faces("scalar.ply")
    for value, of in zip(values, tree["node_of_triangle"], strict=True):
        if level[of] > 1:
            expect("a reconstructed value", value, tree["levels"][level[of] - 1])

    # Shapes, here of pits: levels count lines; each node has a side and a value.
    shapes = tree_of("--set", "tree.polarity=shapes", "--set", "tree.transform=negate")
    expect("polarity", (shapes["polarity"], shapes["version"]), ("shapes", 1))
    expect("lists", {len(shapes[key]) for key in ("parent", "level", "area", "value", "sign")}, {len(shapes["parent"])})
    expect("signs", set(shapes["sign"]), {-1, 1})
    for n, p in enumerate(shapes["parent"]):
        expect("a value of a root alone is none", shapes["value"][n] is None, p < 0)
        assert p < 0 or shapes["value"][n] in shapes["levels"], shapes["value"][n]
        if p >= 0 and shapes["parent"][p] >= 0 and shapes["sign"][n] == shapes["sign"][p]:
            assert shapes["sign"][n] * (shapes["value"][n] - shapes["value"][p]) > 0, n

    for wrong, message in (
        (["tree", config, "tree.txt"], "must end in .json"),
        (["tree", config, "tree.json", "--polarity", "lower"], "makes no lower tree"),
        (["cut", config, "cut.ply", "--at", "high"], "expected a number"),
        (["tree", config, "tree.json", "--min-area", "-1"], "at least 0"),
    ):
        told = run(meshmser, *wrong, code=2)
        assert message in told, told
print("passed" if node else "passed, but for JavaScript: no Node here")
