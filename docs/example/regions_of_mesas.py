"""Regions of a scalar on a mesh from Python: python3 regions_of_mesas.py [CONFIG.yaml]

Without an argument, on arrays: mesas and a basin on a square sheet with a hole in it. With one: runs the configuration,
then measures the borders of its regions."""

import sys

import meshmser
import numpy as np


def sheet_with_mesas(side=80):
    """Positions, triangles, heights: two mesas and a basin, one mesa cut by the hole."""
    y, x = np.mgrid[0 : side + 1, 0 : side + 1].astype(float)
    height = np.zeros_like(x)
    for center_x, center_y, radius, top in [(20, 20, 9, 1), (55, 25, 12, 0.6), (40, 60, 10, -0.8)]:
        height += top / (1 + (np.hypot(x - center_x, y - center_y) / radius) ** 20)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    lower = np.stack([corner, corner + 1, corner + side + 2], axis=1)
    upper = np.stack([corner, corner + side + 2, corner + side + 1], axis=1)
    triangles = np.concatenate([lower, upper]).astype(np.int32)
    center = np.stack([x.ravel(), y.ravel()], axis=1)[triangles].mean(axis=1)
    triangles = triangles[np.hypot(*(center - (62, 25)).T) > 4]
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1), triangles, height.ravel()


def regions_of_arrays():
    positions, triangles, height = sheet_with_mesas()
    surface = meshmser.Surface(positions, triangles)
    trees = [meshmser.build_component_tree(surface, height, levels=64, polarity=side) for side in ("upper", "lower")]
    selected = [meshmser.select_mser(surface, tree, delta=5) for tree in trees]
    # Filters are a line of NumPy each.
    selected = [nodes[(tree.area[nodes] > 50) & (tree.area[nodes] < 2000)] for nodes, tree in zip(selected, trees)]
    regions = meshmser.label_triangles(trees, selected)
    table = meshmser.describe_regions(surface, regions, height, delta=5)
    for i in range(len(regions)):
        polarity, area, mean = (table[name][i] for name in ("polarity", "area", "scalar_mean"))
        print(f"region {i + 1}: {polarity}, area {area:.0f}, mean {mean:.2f}")
    borders = meshmser.extract_borders(surface, regions)
    for loop, owner in enumerate(borders.owner_of_loop):
        along = positions[borders.vertices(surface, loop)]
        print(
            f"border of region {owner}: {len(along)} vertices, {borders.level_length_of_loop[loop]:.1f} along a level, "
            f"{borders.hole_length_of_loop[loop]:.1f} along the hole"
        )


def regions_of_configuration(path):
    result = meshmser.run(path)
    for stage in result.stages:
        print(f"{stage.name}: {stage.outcome}, {stage.wall_seconds:.2f} s")
    borders = result.stage("borders").artifact()["labels"]
    print(f"{len(borders['owner_of_loop'])} border loops, {borders['level_length_of_loop'].sum():.1f} long")


if __name__ == "__main__":
    regions_of_configuration(sys.argv[1]) if len(sys.argv) > 1 else regions_of_arrays()
