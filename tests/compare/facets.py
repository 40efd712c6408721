#!/usr/bin/env python3
"""Facets by plain MSER, by plain persistence and by configs/machined.yaml, on virtual scans of every kind of part.

    tests/compare/facets.py BUILD WORK [--only NAME ...] [--seeds 1 2] [--columns machined]

BUILD is a build folder (build/release), WORK a folder for scans, caches and results; scans that are there are not made
again. Prints a table in Markdown: precision / recall of label borders (level edges) against the scan's true edges of at
least the row's angle, within 2 spacings, and the number of labels. Only true edges whose two faces were both measured
within 3 spacings count for recall. Needs Debian's python3-numpy and python3-scipy; some minutes.
"""
import argparse
import csv
import json
import os
import subprocess
import sys

import numpy as np
from scipy.spatial import cKDTree

# name, shape, options of meshmser-scan, least angle of a true edge in degrees (None: nothing may be found)
SCANS = [
    ("diamond .1, 4 holes", "diamond", "--noise 0.1 --holes 4", 30),
    ("diamond .1, outliers", "diamond", "--noise 0.1 --outliers 0.005", 30),
    ("diamond .3, 4 holes", "diamond", "--noise 0.3 --holes 4", 30),
    ("diamond .3, outliers", "diamond", "--noise 0.3 --outliers 0.005", 30),
    ("diamond .3 of 14 passes, 4 holes", "diamond", "--noise 0.3 --holes 4 --views 14 --points 115000", 30),
    ("diamond .3 of 19 passes, 4 holes", "diamond", "--noise 0.3 --holes 4 --views 19 --points 115000", 30),
    ("bracket .1, 4 holes", "bracket", "--noise 0.1 --holes 4", 30),
    ("bracket .1, outliers", "bracket", "--noise 0.1 --outliers 0.005", 30),
    ("bracket .3, 4 holes", "bracket", "--noise 0.3 --holes 4", 30),
    ("bracket .3, outliers", "bracket", "--noise 0.3 --outliers 0.005", 30),
    ("pump .1, 4 holes", "pump", "--noise 0.1 --holes 4", 30),
    ("pump .1, outliers", "pump", "--noise 0.1 --outliers 0.005", 30),
    ("pump .3, 4 holes", "pump", "--noise 0.3 --holes 4", 30),
    ("pump .3, outliers", "pump", "--noise 0.3 --outliers 0.005", 30),
    ("cylinder .3", "cylinder", "--noise 0.3", 30),
    ("turned part .3", "turned", "--noise 0.3", 30),
    ("thin ribs .3", "ribs", "--noise 0.3", 30),
    ("edges of 8 to 24 degrees .1", "shallow", "--noise 0.1", 7),
    ("edges of 8 to 24 degrees .3", "shallow", "--noise 0.3", 7),
    ("edges of 16 to 24 degrees .3", "shallow", "--noise 0.3 --set angle=16 --set count=3", 7),
    ("fillets of 1 to 4 mm .3", "fillets", "--noise 0.3", 30),
    ("bracket .1, passes off by .5", "bracket", "--noise 0.1 --registration 0.5", 30),
    ("bracket .1, passes off by 1", "bracket", "--noise 0.1 --registration 1", 30),
    ("plane .3", "plane", "--noise 0.3 --set thickness=0", None),
    ("plane .5", "plane", "--noise 0.5 --set thickness=0", None),
    ("sphere .3", "sphere", "--noise 0.3", None),
    ("sphere .5", "sphere", "--noise 0.5", None),
    ("torus .3", "torus", "--noise 0.3", None),
]

# Maximally stable regions of |H|, the innermost of each chain, flooded; then maxima of |H| that last 6 times its noise, flooded and
# joined where the border is no more curved than its sides.
PLAIN_MSER = ["tree.scalar=mean_curvature", "tree.transform=abs", "tree.level_rule=linear", "tree.levels=128",
              "mser.select=mser", "mser.min_persistence=auto", "mser.nested=innermost", "mser.flood_by=strength",
              "mser.border=flood", "mser.merge=none"]
PERSISTENCE = ["tree.scalar=mean_curvature", "tree.transform=abs", "mser.select=persistence",
               "mser.min_persistence=6 noise", "mser.flood_by=strength", "mser.border=flood", "mser.merge=saliency"]
COLUMNS = {"mser": PLAIN_MSER, "persistence": PERSISTENCE, "machined": []}


def read_points(path):
    """Positions (#P, 3) of the binary PLY that meshmser-scan writes: x, y, z first, as floats or doubles."""
    data = open(path, "rb").read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode().split("\n")
    count = int(next(line for line in header if line.startswith("element vertex")).split()[2])
    sizes = {"float": ("<f4", 4), "double": ("<f8", 8)}
    kinds = [sizes[line.split()[1]][0] for line in header if line.startswith("property")]
    rows = np.frombuffer(data, np.dtype([("p%d" % i, kind) for i, kind in enumerate(kinds)]), count, end)
    return np.stack([rows["p%d" % i].astype(float) for i in range(3)], axis=1)


def read_border(path, step):
    """Points at most `step` apart along the level edges of a border table (#S, 3)."""
    with open(path, newline="") as table:
        edges = [[[float(row[axis + end]) for axis in "xyz"] for end in "01"]
                 for row in csv.DictReader(table) if row["kind"] == "level"]
    points = []
    for start, end in np.array(edges).reshape(-1, 2, 3):
        pieces = max(1, int(np.ceil(np.linalg.norm(end - start) / step)))
        places = (np.arange(pieces) + 0.5) / pieces
        points.append(start + places[:, None] * (end - start))
    return np.concatenate(points) if points else np.zeros((0, 3))


def share_within(points, others, distance):
    if len(points) == 0 or len(others) == 0:
        return float("nan")
    return float(np.isfinite(cKDTree(others).query(points, distance_upper_bound=distance)[0]).mean())


def score(scan, out, angle):
    points = read_points(scan)
    tree = cKDTree(points)
    sample = points[:: max(1, len(points) // 20000)]
    spacing = float(np.median(tree.query(sample, k=17)[0][:, 16]) * np.sqrt(np.pi / 16.5))
    edges = np.load(scan.replace(".ply", "-edges.npy")).astype(float)
    edges = edges[edges[:, 3] >= angle, :3]
    edges = edges[np.isfinite(tree.query(edges, distance_upper_bound=2 * spacing)[0])]
    faces = np.append(np.load(scan.replace(".ply", "-labels.npy")).astype(int), 0)
    around = faces[np.minimum(tree.query(edges, k=32, distance_upper_bound=3 * spacing)[1], len(points))]
    both = [sum(np.count_nonzero(row == face) >= 3 for face in set(row) - {0}) >= 2 for row in around]
    found = read_border(os.path.join(out, "label_borders.csv"), spacing / 2)
    return share_within(found, edges, 2 * spacing), share_within(edges[np.array(both, bool)], found, 2 * spacing)


def number_of_labels(out):
    for stage in json.load(open(os.path.join(out, "run.json")))["stages"]:
        if stage["name"] == "mser":
            return next(entry["value"] for entry in stage["report"] if entry["name"] == "num_labels")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build"), parser.add_argument("work")
    parser.add_argument("--only", nargs="*", default=[], help="rows whose names begin with one of these")
    parser.add_argument("--seeds", nargs="*", type=int, default=[1])
    parser.add_argument("--columns", nargs="*", choices=COLUMNS, default=list(COLUMNS))
    parser.add_argument("--set", nargs="*", default=[], help="further settings for every run, as mser.turning='5 deg'")
    arguments = parser.parse_args()
    work = os.path.abspath(arguments.work)
    os.makedirs(work, exist_ok=True)
    config = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "configs", "machined.yaml")
    print("| scan | " + " | ".join(arguments.columns) + " |\n|---|" + "---|" * len(arguments.columns))
    for name, shape, options, angle in SCANS:
        if arguments.only and not name.startswith(tuple(arguments.only)):
            continue
        for seed in arguments.seeds:
            scan = os.path.join(work, name.replace(" ", "_").replace(",", "") + "-%d.ply" % seed)
            if not os.path.exists(scan.replace(".ply", "-labels.npy")):
                subprocess.run([os.path.join(arguments.build, "data/scanner/meshmser-scan"), shape, scan, "--edges",
                                "--labels", "--seed", str(seed), *options.split()], check=True,
                               stdout=subprocess.DEVNULL)
            cells = []
            for column in arguments.columns:
                out = scan[:-4] + "-" + column
                sets = ["load.path=" + scan, "export.points=false", "export.tree=false", "export.pictures=false"]
                run = [os.path.join(arguments.build, "meshmser"), "run", config, "--until", "export", "--quiet", "--out",
                       out, "--cache", os.path.join(work, "cache")]
                for setting in sets + COLUMNS[column] + arguments.set:
                    run += ["--set", setting]
                subprocess.run(run, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                labels = number_of_labels(out)
                if angle is None:
                    cells.append("%d" % labels)
                else:
                    cells.append("%.3f / %.3f (%d)" % (*score(scan, out, angle), labels))
            which = name if len(arguments.seeds) == 1 else "%s, seed %d" % (name, seed)
            print("| %s | %s |" % (which, " | ".join(cells)), flush=True)


if __name__ == "__main__":
    sys.exit(main())
