"""Adjacency, component tree, stability and borders on real scans against plain implementations: a dictionary of edges, a
sort and a union-find, sums by climbing. Exact but for areas, which are summed in another order.

Reads the evaluation scans of the folder MESHMSER_EVAL_DATA and is skipped without it. Arguments: parts of scans' names.
"""
import os
import pathlib
import sys
import tempfile

import numpy as np

import meshmser

SOURCE = pathlib.Path(os.environ["MESHMSER_SOURCE"])
DELTA = 3
SKIPPED = 77


def plain_twins(triangles):
    twins = [-1] * (3 * len(triangles))
    waiting = {}
    for t, corners in enumerate(triangles):
        for k in range(3):
            edge = (corners[k], corners[(k + 1) % 3])
            twin = waiting.pop((edge[1], edge[0]), None)
            if twin is None:
                waiting[edge] = 3 * t + k
            else:
                twins[3 * t + k], twins[twin] = twin, 3 * t + k
    return twins


class PlainTree:
    """Of each triangle its node's representative; of each representative the parent's, level and area."""

    def __init__(self, twins, level, areas):
        n = len(level)
        order = sorted((t for t in range(n) if level[t] > 0), key=lambda t: -level[t])
        joined, top = list(range(n)), list(range(n))
        parent, met = [-1] * n, bytearray(n)

        def find(t):
            while joined[t] != t:
                joined[t] = joined[joined[t]]
                t = joined[t]
            return t

        for t in order:
            met[t] = 1
            for h in range(3 * t, 3 * t + 3):
                other = twins[h] // 3
                if twins[h] < 0 or not met[other]:
                    continue
                root = find(other)
                if root != find(t):
                    parent[top[root]] = t
                    joined[root] = find(t)
                    top[find(t)] = t
        # The last triangle of a level stands for its node.
        self.node = [-1] * n
        for t in reversed(order):
            same = parent[t] >= 0 and level[parent[t]] == level[t]
            self.node[t] = self.node[parent[t]] if same else t
        self.parent = {t: (self.node[parent[t]] if parent[t] >= 0 else -1) for t in order if self.node[t] == t}
        self.level = level
        self.area = dict.fromkeys(self.parent, 0.0)
        for t in order:
            self.area[self.node[t]] += areas[t]
        for t in order:
            if t in self.parent and self.parent[t] >= 0:
                self.area[self.parent[t]] += self.area[t]

    def lo(self, node):
        return 1 if self.parent[node] < 0 else self.level[self.parent[node]] + 1

    def middle(self, node):
        return (self.lo(node) + self.level[node]) // 2

    def stability(self):
        down = dict.fromkeys(self.parent, 0.0)
        up = {}
        for node in self.parent:
            above = node
            while above >= 0:
                if self.lo(node) <= self.middle(above) + DELTA <= self.level[node]:
                    down[above] += self.area[node]
                above = self.parent[above]
            holder = node
            while self.lo(holder) > max(self.middle(node) - DELTA, 1):
                holder = self.parent[holder]
            up[node] = self.area[holder]
        return {node: (up[node] - down[node]) / self.area[node] for node in self.parent if self.area[node] > 0}

    def ancestors(self, node):
        while node >= 0:
            yield node
            node = self.parent[node]


def expect(holds, what):
    if not holds:
        raise AssertionError(what)


def check_tree(plain, tree):
    of_fast = tree.node_of_triangle
    fast_of_plain = {node: int(of_fast[node]) for node in plain.parent}
    expect(len(set(fast_of_plain.values())) == tree.num_nodes == len(fast_of_plain), "another number of nodes")
    expect(all((f < 0) == (p < 0) and (p < 0 or fast_of_plain[p] == f) for p, f in zip(plain.node, of_fast.tolist())),
           "triangles in other nodes")
    for node, fast in fast_of_plain.items():
        parent = plain.parent[node]
        expect(tree.parent[fast] == (fast_of_plain[parent] if parent >= 0 else -1), "another parent")
    nodes = list(fast_of_plain)
    expect(np.allclose(tree.area[[fast_of_plain[n] for n in nodes]], [plain.area[n] for n in nodes], rtol=1e-9), "areas")
    q = plain.stability()
    fast_q = meshmser.stability(tree, DELTA)
    expect(np.allclose([fast_q[fast_of_plain[n]] for n in q], list(q.values()), rtol=1e-6, atol=1e-6), "stability")
    return {fast: node for node, fast in fast_of_plain.items()}


def check_borders(plain, plain_of_fast, surface, twins, tree):
    nodes = meshmser.select_mser(surface, tree, DELTA)
    regions = meshmser.label_triangles([tree], [nodes])
    borders = meshmser.extract_borders(surface, regions)
    owner_of = {plain_of_fast[int(node)]: r + 1 for r, node in enumerate(regions.node)}
    expected = set()
    for h, twin in enumerate(twins):
        here = plain.node[h // 3]
        if twin < 0 or here < 0:
            continue
        there = set(plain.ancestors(plain.node[twin // 3]))
        for node in plain.ancestors(here):
            if node in there:
                break
            if node in owner_of:
                expected.add((owner_of[node], h))
    found = set()
    triangles = surface.triangles
    for loop, owner in enumerate(borders.owner_of_loop.tolist()):
        edges = borders.half_edges[borders.first_edge_of_loop[loop]:borders.first_edge_of_loop[loop + 1]]
        start, end = triangles[edges // 3, edges % 3], triangles[edges // 3, (edges + 1) % 3]
        expect((end == np.roll(start, -1)).all(), "a loop that does not close")
        found.update((owner, h) for h in edges.tolist() if twins[h] >= 0)
    expect(found == expected, "%d border edges instead of %d" % (len(found), len(expected)))
    return len(nodes), len(borders)


def check_scan(path, config, work):
    done = meshmser.run(SOURCE / "configs" / config, set={"load.path": str(path)}, until="tree", out=os.path.join(work, "out"),
                        cache=os.path.join(work, "cache"))
    mesh, trees = done.stage("mesh").artifact(), done.stage("tree").artifact()
    excluded = trees["excluded_of_triangle"]
    surface = meshmser.Surface(mesh["positions"], mesh["triangles"], exclude=excluded if len(excluded) else None)
    triangles = surface.triangles.tolist()
    twins = plain_twins(triangles)
    gone = np.asarray(excluded, bool) if len(excluded) else np.zeros(len(triangles), bool)
    twins = [-1 if twin < 0 or gone[h // 3] or gone[twin // 3] else twin for h, twin in enumerate(twins)]
    expect(twins == surface.twins.tolist(), "other twins")
    values = np.nan_to_num(trees["values"])
    tree = meshmser.build_component_tree(surface, values, levels=256)
    level = np.searchsorted(tree.levels, values, side="right")[surface.triangles].min(axis=1)
    level[gone] = 0
    plain = PlainTree(twins, level.tolist(), surface.areas.tolist())
    counts = check_borders(plain, check_tree(plain, tree), surface, twins, tree)
    print("%s: %d triangles, %d nodes, %d regions, %d loops: the same" % (path.name, len(triangles), tree.num_nodes, *counts),
          flush=True)


def main():
    folder = os.environ.get("MESHMSER_EVAL_DATA")
    if not folder:
        print("skipped: set MESHMSER_EVAL_DATA to the folder of evaluation scans to run this")
        return SKIPPED
    scans = [(p, "machined.yaml") for p in sorted(pathlib.Path(folder, "simulated").glob("*.ply"))]
    scans += [(p, "relief.yaml") for p in sorted(pathlib.Path(folder, "sherds").glob("*.xyz"))]
    scans += [(p, "machined.yaml") for p in sorted(pathlib.Path(folder, "bunny").glob("bun.conf"))]
    wanted = [s for s in scans if len(sys.argv) < 2 or any(word in s[0].name for word in sys.argv[1:])]
    with tempfile.TemporaryDirectory() as work:
        for path, config in wanted:
            check_scan(path, config, work)
    return 0


if __name__ == "__main__":
    sys.exit(main())
