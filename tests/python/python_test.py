"""The Python module: results by hand, memory, errors, interruption, stubs."""

import ast
import gc
import inspect
import os
import re
import runpy
import signal
import tempfile
import threading
import time
import unittest

import meshmser
import numpy as np

SOURCE = os.environ["MESHMSER_SOURCE"]


def grid(side):
    y, x = np.mgrid[0 : side + 1, 0 : side + 1].astype(float)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    triangles = np.stack([corner, corner + 1, corner + side + 2, corner, corner + side + 2, corner + side + 1], axis=1)
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), triangles.reshape(-1, 3).astype(np.int32)


def terraces():
    """A terrace of 0.5 with a step of 1 on it, and a terrace of 1 at the rim: 10 x 10, 4 x 4, 6 x 8 squares."""
    positions, triangles = grid(24)
    x, y = positions[:, 0], positions[:, 1]
    values = np.where((x >= 3) & (x <= 13) & (y >= 3) & (y <= 13), 0.5, 0.0)
    values[((x >= 6) & (x <= 10) & (y >= 6) & (y <= 10)) | ((x >= 18) & (y >= 4) & (y <= 12))] = 1
    return positions, triangles, values


def parts(vertices, neighbours):
    """The connected parts of a set of vertices."""
    left, found = set(vertices), []
    while left:
        front = {left.pop()}
        part = set(front)
        while front:
            front = {w for v in front for w in neighbours[v]} & left
            left -= front
            part |= front
        found.append(part)
    return found


def lines_by_saturation(triangles, values, levels, rim, root=None):
    """1 + the number of shapes of all levels that hold each triangle, by the words of the definition. The rim is closed
    by one vertex more, the root unless another is given."""
    closing = len(values)
    values = np.append(values, sorted(values[list(rim)])[(len(rim) - 1) // 2])
    neighbours = {v: set() for v in range(closing + 1)}
    for t in triangles.tolist() + [[v, v, closing] for v in rim]:
        for v in t:
            neighbours[v] |= set(t) - {v}
    root, everything, lines = closing if root is None else root, set(neighbours), np.ones(len(triangles), int)
    for h in levels:
        high = {v for v in everything if values[v] >= h}
        for part in parts(high, neighbours) + parts(everything - high, neighbours):
            if root in part:
                continue
            shape = part.union(*(rest for rest in parts(everything - part, neighbours) if root not in rest))
            lines += [shape.issuperset(t) for t in triangles.tolist()]
    return lines


LEVELS = np.concatenate([[-np.inf], np.arange(1, 33) / 32])


class Arrays(unittest.TestCase):
    def test_terraces(self):
        positions, triangles, values = terraces()
        surface = meshmser.Surface(positions, triangles)
        tree = meshmser.build_component_tree(surface, values, levels=LEVELS)
        self.assertEqual(tree.num_nodes, 4)
        self.assertEqual(sorted(tree.area), [16, 48, 100, 576])
        self.assertEqual(list(tree.levels), list(LEVELS))
        expected = [sum(LEVELS <= values[t].min()) for t in triangles]
        np.testing.assert_array_equal(tree.level_of_triangle, expected)
        nodes = meshmser.select_mser(surface, tree, delta=3)
        np.testing.assert_array_equal(meshmser.stability(tree, 3)[nodes], 0)
        regions = meshmser.label_triangles([tree], [nodes])
        self.assertEqual(list(np.bincount(regions.label_of_triangle)), [856, 168, 96, 32])
        borders = meshmser.extract_borders(surface, regions)
        self.assertEqual(list(borders.owner_of_loop), [1, 2, 3])
        self.assertEqual(list(borders.level_length_of_loop), [40, 20, 16])
        self.assertEqual(list(borders.hole_length_of_loop), [0, 8, 0])
        self.assertEqual(borders.is_hole.sum(), 8)
        self.assertEqual(set(borders.neighbours[borders.is_hole]), {-1})
        loop = positions[borders.vertices(surface, 2)]
        self.assertEqual(len(loop), 16)
        self.assertTrue((np.abs(loop[:, :2] - 8).max(axis=1) == 2).all())
        with self.assertRaises(IndexError):
            borders.vertices(surface, 3)
        of_labels = meshmser.extract_label_borders(surface, regions.label_of_triangle)
        self.assertEqual(len(of_labels), 4)  # the first has an inner loop, too
        table = meshmser.describe_regions(surface, regions, values)
        self.assertEqual(list(table["area"]), [100, 48, 16])
        self.assertEqual(table["polarity"], ["upper"] * 3)
        self.assertEqual(table["centroid"].shape, (3, 3))
        np.testing.assert_allclose(table["centroid"][:, :2], [[8, 8], [21, 8], [8, 8]])
        self.assertEqual(list(table["scalar_min"]), [0.5, 1, 1])

    def test_trees_are_edited(self):
        positions, triangles, values = terraces()
        tree = meshmser.build_component_tree(meshmser.Surface(positions, triangles), values, levels=LEVELS)
        lowest = values[triangles].min(axis=1)
        np.testing.assert_array_equal(tree.reconstruct()[lowest > 0], lowest[lowest > 0])
        self.assertEqual(list(np.bincount(tree.cut(0.5))), [856, 200, 96])
        self.assertEqual(list(np.bincount(tree.cut(0.75))), [1024, 96, 32])
        self.assertEqual(sorted(tree.simplify(min_area=17).area), [48, 100, 576])
        self.assertEqual(tree.simplify(min_persistence=1).num_nodes, 4)
        self.assertEqual(list(tree.simplify(min_persistence=1.5).area), [576])
        self.assertEqual(tree.simplify().num_nodes, 4)

    def test_polarities_mirror(self):
        positions, triangles, values = terraces()
        surface = meshmser.Surface(positions, triangles)
        upper = meshmser.build_component_tree(surface, values, levels=40)
        lower = meshmser.build_component_tree(surface, -values, levels=40, polarity="lower")
        self.assertEqual(lower.polarity, "lower")
        for name in ("parent", "low_level", "high_level", "area", "node_of_triangle", "levels"):
            np.testing.assert_array_equal(getattr(upper, name), getattr(lower, name))
        both = meshmser.label_triangles([upper, lower], [[0], []])
        self.assertEqual((list(both.tree), list(both.node), len(both)), ([0], [0], 1))

    def test_shapes(self):
        positions, triangles = grid(12)
        far = np.abs(positions[:, :2] - 6).max(axis=1)
        values = np.where(far > 4, 5.0, np.where(far > 2, 9, 1))  # a bright ring on a grey ground, dark within
        surface = meshmser.Surface(positions, triangles)
        tree = meshmser.build_tree_of_shapes(surface, values, [0, 2, 4, 6, 8])
        self.assertEqual((tree.polarity, tree.num_nodes), ("shapes", 3))
        self.assertEqual(list(tree.parent), [1, 2, -1])
        self.assertEqual(list(tree.area), [16, 64, 144])
        self.assertEqual(list(tree.sign), [-1, 1, 1])
        self.assertEqual(list(tree.value), [8, 6, -np.inf])
        self.assertEqual(list(tree.high_level), [7, 3, 1])
        self.assertEqual(list(np.bincount(tree.cut(8))), [160, 96, 32])
        self.assertEqual(list(np.bincount(tree.cut(2))), [256, 32])
        self.assertEqual(sorted(set(tree.reconstruct())), [0, 4, 8])
        fine = meshmser.build_tree_of_shapes(surface, values, np.arange(0.5, 9.5))
        nodes = meshmser.select_mser(surface, fine, delta=1)
        self.assertEqual(list(nodes), [0, 1])
        regions = meshmser.label_triangles([fine], [nodes])
        table = meshmser.describe_regions(surface, regions, values, delta=1)
        self.assertEqual((table["polarity"], list(table["value"])), (["upper", "lower"], [5.5, 8.5]))
        self.assertEqual(list(meshmser.extract_borders(surface, regions).level_length_of_loop), [32, 16])
        # From the middle, all around it is a shape; two corners of its square belong to it.
        turned = meshmser.build_tree_of_shapes(surface, far, [3.0], root=6 * 13 + 6)
        self.assertEqual((list(turned.sign), sorted(turned.area)), ([1, 1], [109, 144]))
        with self.assertRaisesRegex(ValueError, "from 0 to 169"):
            meshmser.build_tree_of_shapes(surface, far, root=169)
        i, j = np.divmod(np.arange(36), 6)
        right, above = 6 * i + (j + 1) % 6, 6 * ((i + 1) % 6) + j
        both = 6 * ((i + 1) % 6) + (j + 1) % 6
        torus = np.concatenate([np.stack([6 * i + j, right, both], 1), np.stack([6 * i + j, both, above], 1)])
        with self.assertRaisesRegex(meshmser.StageError, "without handles"):
            meshmser.build_tree_of_shapes(meshmser.Surface(np.random.rand(36, 3), torus), np.arange(36.0))

    def test_shapes_are_saturation(self):
        random = np.random.default_rng(7)
        positions, triangles = grid(6)
        x, y = positions[:, 0], positions[:, 1]
        rim = np.flatnonzero((x == 0) | (y == 0) | (x == 6) | (y == 6))
        surface = meshmser.Surface(positions, triangles)
        for trial in range(40):
            values, root = random.integers(0, 4, len(positions)).astype(float), None if trial % 2 else trial
            tree = meshmser.build_tree_of_shapes(surface, values, [0, 1, 2, 3], root=root)
            expected = lines_by_saturation(triangles, values, [0, 1, 2, 3], rim, root)
            np.testing.assert_array_equal(tree.level_of_triangle, expected)

    def test_excluded_triangles_are_in_no_node(self):
        positions, triangles, values = terraces()
        values[0] = np.nan
        touching = (triangles == 0).any(axis=1)
        surface = meshmser.Surface(positions, triangles, exclude=touching)
        tree = meshmser.build_component_tree(surface, values)
        np.testing.assert_array_equal(tree.node_of_triangle < 0, touching)
        with self.assertRaisesRegex(meshmser.StageError, "vertex 0 is not finite"):
            meshmser.build_component_tree(meshmser.Surface(positions, triangles), values)

    def test_arrays_are_not_copied(self):
        positions, triangles, values = terraces()
        surface = meshmser.Surface(positions, triangles)
        self.assertTrue(np.shares_memory(surface.positions, positions))
        self.assertTrue(np.shares_memory(surface.triangles, triangles))
        tree = meshmser.build_component_tree(surface, values, levels=LEVELS)
        self.assertTrue(np.shares_memory(tree.parent, tree.parent))
        with self.assertRaises(ValueError):
            tree.parent[0] = 7
        # What is handed out keeps alive what it points into.
        parent, twins = tree.parent, surface.twins
        before = parent.copy(), twins.copy()
        del tree, surface
        gc.collect()
        np.testing.assert_array_equal(parent, before[0])
        np.testing.assert_array_equal(twins, before[1])
        # Other types and orders are converted.
        converted = meshmser.Surface(np.asfortranarray(positions, np.float32), triangles.tolist())
        np.testing.assert_array_equal(converted.twins, before[1])

    def test_empty(self):
        surface = meshmser.Surface(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
        tree = meshmser.build_component_tree(surface, [])
        regions = meshmser.label_triangles([tree], [meshmser.select_mser(surface, tree)])
        self.assertEqual((tree.num_nodes, len(regions)), (0, 0))
        self.assertEqual(len(meshmser.extract_borders(surface, regions)), 0)
        self.assertEqual(meshmser.describe_regions(surface, regions, [])["centroid"].shape, (0, 3))

    def test_numbers_are_not_cut(self):
        positions, triangles, values = terraces()
        for wrong in (triangles + 2**33, triangles.astype(np.uint64) + 2**63):
            with self.assertRaisesRegex(ValueError, "32 bits"):
                meshmser.Surface(positions, wrong)
        with self.assertRaisesRegex(TypeError, "whole numbers, got float64"):
            meshmser.Surface(positions, triangles + 0.5)
        surface = meshmser.Surface(positions, triangles.astype(np.int64))
        tree = meshmser.build_component_tree(surface, values, levels=LEVELS)
        with self.assertRaisesRegex(TypeError, "whole numbers, got float64"):
            meshmser.label_triangles([tree], [[0.7]])
        with self.assertRaisesRegex(TypeError, "flatnonzero"):
            meshmser.label_triangles([tree], [tree.area > 20])
        self.assertEqual(len(meshmser.label_triangles([tree], [np.flatnonzero(tree.area > 20)])), 3)
        with self.assertRaisesRegex(meshmser.StageError, "label 2147483647"):
            meshmser.extract_label_borders(surface, [2**31 - 1] + [1] * (len(triangles) - 1))
        for wrong in ({"min_area": -1}, {"min_persistence": np.nan}):
            with self.assertRaises(ValueError):
                tree.simplify(**wrong)
        with self.assertRaises(ValueError):
            tree.cut(np.nan)

    def test_contrast(self):
        positions, triangles, values = terraces()
        surface = meshmser.Surface(positions, triangles)
        tree = meshmser.build_component_tree(surface, values, levels=LEVELS)
        regions = meshmser.label_triangles([tree], [meshmser.select_mser(surface, tree)])
        self.assertNotIn("contrast", meshmser.describe_regions(surface, regions, values))
        contrast = meshmser.describe_regions(surface, regions, values, band=0.1)["contrast"]
        # The step between the two rows of triangles at the border, area-weighted.
        means = values[triangles].mean(axis=1)
        for region, node in enumerate(regions.node):
            inside = (tree.node_of_triangle <= node) & (tree.node_of_triangle >= tree.first_node_of_subtree[node])
            rows = [set(), set()]
            for h in np.flatnonzero(np.repeat(inside, 3)):
                twin = surface.twins[h]
                if twin >= 0 and not inside[twin // 3]:
                    rows[0].add(h // 3)
                    rows[1].add(twin // 3)
            step = [np.average(means[list(r)], weights=surface.areas[list(r)]) for r in rows]
            self.assertAlmostEqual(contrast[region], step[0] - step[1], places=6)

    def test_errors(self):
        positions, triangles, values = terraces()
        for error in ("UsageError", "ConfigError", "InputError", "StageError", "CacheError", "Cancelled"):
            self.assertTrue(issubclass(getattr(meshmser, error), meshmser.Error))
        with self.assertRaisesRegex(meshmser.StageError, "vertices 0 and 1"):
            meshmser.Surface(np.eye(5, 3), [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
        with self.assertRaises(meshmser.StageError):
            meshmser.Surface(positions, triangles + 600)
        with self.assertRaisesRegex(ValueError, "rows of 3"):
            meshmser.Surface(positions[:, :2], triangles)
        surface = meshmser.Surface(positions, triangles)
        with self.assertRaisesRegex(ValueError, "624 entries; the mesh has 625 vertices"):
            meshmser.build_component_tree(surface, values[1:])
        for wrong in ({"polarity": "up"}, {"levels": 1}, {"levels": 10**9}, {"levels": 2**40}, {"levels": 64.0},
                      {"range": (0.5, 0.5)}):
            with self.assertRaises(ValueError):
                meshmser.build_component_tree(surface, values, **wrong)
        tree = meshmser.build_component_tree(surface, values)
        with self.assertRaises(meshmser.StageError):
            meshmser.stability(tree, 0)
        with self.assertRaises(ValueError):
            meshmser.label_triangles([tree], [[tree.num_nodes]])


class Configurations(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def test_run(self):
        positions, triangles, values = terraces()
        path = os.path.join(self.folder, "mesh.ply")
        with open(path, "w", encoding="ascii") as file:
            file.write("ply\nformat ascii 1.0\n")
            file.write(f"element vertex {len(positions)}\nproperty double x\nproperty double y\nproperty double z\n")
            file.write(f"property double height\nelement face {len(triangles)}\n")
            file.write("property list uchar int vertex_indices\nend_header\n")
            for p, v in zip(positions.tolist(), values.tolist()):
                file.write(f"{p[0]} {p[1]} {p[2]} {v}\n")
            for t in triangles.tolist():
                file.write(f"3 {t[0]} {t[1]} {t[2]}\n")
        config = {
            "version": 1,
            "units": "mm",
            "stages": [
                {"load": {"path": path}},
                {"tree": {"scalar": "height", "levels": 33, "value_range": [0, 1], "polarity": "upper"}},
                {"mser": {"min_area": "1 mm2", "min_persistence": 0, "grow": "none"}},
                {"borders": {}},
            ],
        }
        folders = {"out": os.path.join(self.folder, "out"), "cache": os.path.join(self.folder, "cache")}
        result = meshmser.run(config, **folders)
        self.assertEqual([stage.name for stage in result.stages], ["load", "tree", "mser", "borders"])
        self.assertEqual({stage.outcome for stage in result.stages}, {"ran"})
        self.assertEqual(result.stage("mser").report["num_regions"], 3)
        segmentation = result.stage("mser").artifact()
        self.assertEqual(list(segmentation["regions"]["area"]), [100, 48, 16])
        self.assertIsInstance(segmentation["label_of_triangle"], np.memmap)
        self.assertEqual(list(result.stage("borders").artifact()["regions"]["level_length_of_loop"]), [40, 20, 16])
        with self.assertRaisesRegex(ValueError, "name one"):
            result.stage("load").artifact()
        mesh = result.stage("load").artifact("mesh")
        # The same from the stored arrays, without the pipeline.
        surface = meshmser.Surface(mesh["positions"], mesh["triangles"])
        self.assertTrue(np.shares_memory(surface.positions, mesh["positions"]))
        tree = meshmser.build_component_tree(surface, mesh["properties"][0]["values"], levels=LEVELS)
        stored = result.stage("tree").artifact()["trees"][0]
        np.testing.assert_array_equal(tree.parent, stored["parent_of_node"])
        np.testing.assert_array_equal(tree.node_of_triangle, stored["node_of_triangle"])

        again = meshmser.run(config, set={"mser.min_area": "50 mm2"}, **folders)
        self.assertEqual([stage.outcome for stage in again.stages], ["cached", "cached", "ran", "ran"])
        self.assertEqual(len(again.stage("mser").artifact()["regions"]["area"]), 1)
        self.assertEqual(len(meshmser.run(config, until="tree", **folders).stages), 2)

    def test_errors(self):
        with self.assertRaisesRegex(meshmser.ConfigError, "did you mean.*mser"):
            meshmser.run({"version": 1, "stages": [{"msr": {}}]})
        odd = {"path": "a: [odd] name's.ply"}
        with self.assertRaisesRegex(meshmser.Error, re.escape("a: [odd] name's.ply")):
            meshmser.run({"version": 1, "stages": [{"load": odd}]}, out=self.folder, cache=self.folder)
        with self.assertRaises(meshmser.Error):
            meshmser.run(os.path.join(self.folder, "none.yaml"))
        with self.assertRaisesRegex(meshmser.UsageError, "nosuch"):
            demo = os.path.join(SOURCE, "configs", "demo.yaml")
            meshmser.run(demo, until="nosuch", cache=self.folder, out=self.folder)

    def test_interruption(self):
        random = np.random.default_rng(1)
        path = os.path.join(self.folder, "scan.xyz")
        np.savetxt(path, random.random((150_000, 3)) * [400, 400, 0.1], fmt="%.4f")
        config = {"version": 1, "stages": [{"load": {"path": path}}, {"orient": {}}, {"curvature": {"steps": 60}}]}
        folders = {"out": os.path.join(self.folder, "out"), "cache": os.path.join(self.folder, "cache")}
        meshmser.run(config, until="load", **folders)
        began = time.monotonic()
        # The timer's thread runs only because the computation leaves Python's lock to it.
        timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            meshmser.run(config, **folders)
        timer.join()
        self.assertLess(time.monotonic() - began, 20)
        # Nothing is left behind that would be in the way.
        self.assertEqual(meshmser.run(config, until="load", **folders).stage("load").outcome, "cached")


class Stubs(unittest.TestCase):
    def test_stubs_name_what_there_is(self):
        with open(os.path.join(os.path.dirname(meshmser.__file__), "__init__.pyi"), encoding="utf-8") as file:
            stubs = {node.name: node for node in ast.parse(file.read()).body if hasattr(node, "name")}
        self.assertEqual(sorted(stubs), sorted(meshmser.__all__))
        for name, stub in stubs.items():
            real = getattr(meshmser, name)
            if isinstance(stub, ast.FunctionDef):
                self.assertEqual(self.stub_arguments(stub), self.real_arguments(real), name)
                continue
            members = {node.name: node for node in stub.body if isinstance(node, ast.FunctionDef)}
            own = {m for m in vars(real) if not m.startswith("_")}
            self.assertEqual({m for m in members if not m.startswith("_")}, own, name)
            for member, function in members.items():
                if not function.decorator_list and not member.startswith("__len"):
                    self.assertEqual(self.stub_arguments(function), self.real_arguments(getattr(real, member)), member)

    @staticmethod
    def stub_arguments(function):
        arguments = function.args
        return [a.arg for a in arguments.args + arguments.kwonlyargs if a.arg != "self"]

    @staticmethod
    def real_arguments(function):
        if inspect.isfunction(function):
            return [p for p in inspect.signature(function).parameters if p != "self"]
        # A compiled function tells its arguments in the first line of its docstring: name: type = default, ...
        signature = function.__doc__.splitlines()[0]
        signature = signature[signature.index("(") + 1 : signature.rindex(") ->")]
        while re.search(r"\[[^\[\]]*\]|\([^()]*\)|<[^<>]*>", signature):
            signature = re.sub(r"\[[^\[\]]*\]|\([^()]*\)|<[^<>]*>", "", signature)
        names = [argument.split(":")[0].split("=")[0].strip() for argument in signature.split(",")]
        return [name for name in names if name and name != "self"]


class Example(unittest.TestCase):
    def test_example(self):
        example = runpy.run_path(os.path.join(SOURCE, "docs", "example", "regions_of_mesas.py"))
        example["regions_of_arrays"]()


if __name__ == "__main__":
    unittest.main()
