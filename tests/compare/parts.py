#!/usr/bin/env python3
"""Machined parts: meshmser beside what users would pick instead, on the same scans, as a Markdown table.

    parts.py [--build build/release] [--work FOLDER]

Needs MESHMSER_EVAL_DATA (the folder of evaluation data; its neighbour `eval` holds edge_score.py), a build with
-DMESHMSER_COMPARE=ON, and Debian's python3-numpy and python3-scipy. Scans: those of the evaluation data and three made here
by meshmser-scan. Every method gets the same mesh (meshmser's, through the raw points) and one setting for all scans: the
one of its grid below with the best mean F. CGAL region growing of planes (part_rivals cgal_region_growing) is
left out: it fits its plane to the whole region at every step and did not end in five minutes on the bracket. Scores: label borders against true edges of 30 degrees and more, at 2 spacings.
"""
import argparse
import itertools
import os
import pathlib
import re
import subprocess
import sys

SOURCE = pathlib.Path(__file__).resolve().parents[2]
GIVEN = ["bracket_0.1", "pump_0.3", "diamond_0.1"]
OWN = {"bracket_0.3 (own)": ["bracket", "--noise", "0.3"], "pump_0.1 (own)": ["pump", "--noise", "0.1"],
       "diamond_0.3 (own)": ["diamond", "--noise", "0.3"]}
LEVELS = {"fixed threshold of curvature, flooded": [
    ["--set", "tree.level_rule=noise", "--set", "mser.select=level", "--set", f"mser.level={value}"] for value in (0.2, 0.4)]}
GRIDS = {
    "PCL region growing": ("pcl_region_growing", {"--angle": [3, 5], "--distance": [0.05], "--smooth": [0]}),
    "CGAL sharp edges": ("cgal_sharp_edges", {"--angle": [10, 20, 40], "--smooth": [5, 20]}),
}


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stderr}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=pathlib.Path, default=SOURCE / "build/release")
    parser.add_argument("--work", type=pathlib.Path, default=pathlib.Path("comparison-out"))
    a = parser.parse_args()
    if "MESHMSER_EVAL_DATA" not in os.environ:
        sys.exit("parts.py: set MESHMSER_EVAL_DATA to the folder of evaluation data")
    data = pathlib.Path(os.environ["MESHMSER_EVAL_DATA"])
    a.work.mkdir(parents=True, exist_ok=True)

    scans = {name: (data / f"simulated/{name}.ply", data / f"simulated/{name}-edges.npy") for name in GIVEN}
    for name, options in OWN.items():
        path = a.work / (re.sub(r"\W+", "_", name) + ".ply")
        if not path.exists():
            run([a.build / "data/scanner/meshmser-scan", options[0], path, *options[1:], "--truth"])
        scans[name] = (path, path.with_name(path.stem + "-edges.npy"))

    spacing = {}

    def score(name, borders):
        text = run([sys.executable, data.parent / "eval/edge_score.py", scans[name][1], scans[name][0], borders])
        found = re.search(r"P ([\d.]+) R ([\d.]+) F ([\d.]+)\s+\(spacing ([\d.]+)", text)
        spacing[name] = found[4]
        return tuple(float(v) for v in found.groups()[:3])

    def ours(name, settings, out):
        run([a.build / "meshmser", "run", SOURCE / "configs/machined.yaml", "--set", f"load.path={scans[name][0].resolve()}",
             "--cache", a.work / "cache", "--out", out, "--until", "export", "--quiet", *settings])
        return score(name, out / "label_borders.csv")

    def best(method, settings, scored):
        """The one setting with the best mean F, and its row."""
        rows = {}
        for setting in settings:
            rows[tuple(setting)] = [scored(name, setting) for name in scans]
            print(method, *setting, *(f"{f:.3f}" for _, _, f in rows[tuple(setting)]), file=sys.stderr, flush=True)
        setting = max(rows, key=lambda s: sum(f for _, _, f in rows[s]))
        table.append((method, " ".join(str(s) for s in setting if s != "--set"), rows[setting]))

    table = []
    folder = {name: a.work / re.sub(r"\W+", "_", name) for name in scans}
    best("meshmser, `machined.yaml`", [[]], lambda name, s: ours(name, s, folder[name]))
    for method, settings in LEVELS.items():
        best(method, settings, lambda name, s: ours(name, s, a.work / "level"))
    for method, (program, grid) in GRIDS.items():
        def rival(name, setting):
            run([a.build / "tests/compare/part_rivals", program, folder[name] / "segments.ply", a.work / "rival.csv",
                 "--spacing", spacing[name], *setting])
            return score(name, a.work / "rival.csv")
        best(method, [[x for pair in zip(grid, values) for x in pair] for values in itertools.product(*grid.values())], rival)

    print("| method | its best setting | " + " | ".join(scans) + " | mean F |")
    print("|---|---|" + "---|" * (len(scans) + 1))
    for method, setting, row in table:
        cells = " | ".join(f"{p:.2f} / {r:.2f}" for p, r, _ in row)
        print(f"| {method} | {setting} | {cells} | {sum(f for _, _, f in row) / len(row):.3f} |")


if __name__ == "__main__":
    main()
