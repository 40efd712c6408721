#!/usr/bin/env python3
"""Lines of relief against what one would do without meshmser, on the same scans; a Markdown table to stdout.

    lines.py --data DIR [--eval DIR] [--program meshmser] [--scanner meshmser-scan] [--work DIR] [--only METHOD ...]

DIR (or the environment variable MESHMSER_EVAL_DATA): evaluation scans, with `sherds/NAME.xyz`, `NAME-outline.txt` and
`NAME-mask.png`, and `simulated/tablet_*.ply`; the folder `eval` beside it (or --eval) holds outline_score.py and
edge_score.py. Three nearly flat and three bent sherds of meshmser-scan with exact outlines are made and scored as well.
Every rival that needs an image sees the scan from its z axis, in pixels of 0.1 mm; it is given the best of the settings
listed here, by its score on these very scans. Needs NumPy, SciPy and OpenCV; takes minutes.
"""
import argparse
import os
import subprocess
import sys
import tempfile

import cv2
import numpy as np
from scipy.interpolate import LinearNDInterpolator
from scipy.ndimage import gaussian_filter
from scipy.spatial import Delaunay, cKDTree

PIXEL = 0.1  # mm
HERE = os.path.dirname(os.path.abspath(__file__))
RELIEF = os.path.join(HERE, "..", "..", "configs", "relief.yaml")
# Scans made for this table: name, parameters of the shape `sherd`.
MADE = [("flat-%d" % i, {"bend_radius": 0, **more}) for i, more in
        enumerate([{}, {"line_width": 1.8, "pitch": 4, "relief": 0.14}, {"line_width": 2.8, "pitch": 5.6}], 1)]
MADE += [("bent-%d" % i, {"bend_radius": r, **more}) for i, (r, more) in
         enumerate([(110, {}), (60, {"line_width": 1.8, "pitch": 4, "relief": 0.14}), (35, {"line_width": 2.8, "pitch": 5.6})], 1)]


class HeightMap:
    """Heights over x and y in pixels, first row at the greatest y; `seen`: pixels with points near."""

    def __init__(self, points):
        self.low = points[:, :2].min(0) - 0.5
        shape = np.ceil((points[:, :2].max(0) + 0.5 - self.low) / PIXEL).astype(int)
        x, y = np.meshgrid(*[self.low[k] + PIXEL * (np.arange(shape[k]) + 0.5) for k in (0, 1)])
        x, y = x[::-1], y[::-1]
        self.rows = len(y)
        # One height a place: steep walls bear several points above each other.
        where = np.round(points[:, :2] / 0.02).astype(np.int64)
        _, first = np.unique(where, axis=0, return_index=True)
        flat = points[first]
        self.height = LinearNDInterpolator(Delaunay(flat[:, :2]), flat[:, 2])(x, y)
        spacing = np.median(cKDTree(flat[:, :2]).query(flat[::50, :2], k=2)[0][:, 1])
        far = cKDTree(flat[:, :2]).query(np.c_[x.ravel(), y.ravel()])[0].reshape(x.shape) > 3 * spacing
        self.seen = np.isfinite(self.height) & ~far
        self.height[~self.seen] = 0

    def blurred(self, sigma):
        """Gaussian mean over what was seen; sigma in mm."""
        weight = gaussian_filter(self.seen.astype(float), sigma / PIXEL)
        return gaussian_filter(self.height, sigma / PIXEL) / np.maximum(weight, 1e-9)

    def place(self, pixels):
        """x, y of (column, row) positions."""
        return np.stack([self.low[0] + PIXEL * (pixels[..., 0] + 0.5),
                         self.low[1] + PIXEL * (self.rows - pixels[..., 1] - 0.5)], axis=-1)


def outlines(mask):
    """Edges (#E, 2, 2) in pixels around the parts of a mask."""
    edges = []
    for contour in cv2.findContours(mask.astype(np.uint8), cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]:
        ring = contour[:, 0].astype(float)
        edges.append(np.stack([ring, np.roll(ring, -1, axis=0)], axis=1))
    return np.concatenate(edges) if edges else np.zeros((0, 2, 2))


def without_specks(mask, least_area):
    count, label, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    keep = stats[:, cv2.CC_STAT_AREA] * PIXEL * PIXEL >= least_area
    keep[0] = False
    return keep[label]


def difference_of_gaussians(view, threshold):
    return outlines(without_specks((view.blurred(0.3) - view.blurred(1.2) > threshold) & view.seen, 2))


def as_bytes(values, seen):
    low, high = np.quantile(values[seen], [0.01, 0.99])
    image = np.clip((values - low) / (high - low) * 255, 0, 255)
    image[~seen] = 0
    return image.astype(np.uint8)


def depth_image(view):
    return as_bytes(view.blurred(0.15), view.seen)


def shaded_image(view):
    """Under a raking light from the upper left, 28 degrees above the picture's plane."""
    rows, columns = np.gradient(view.blurred(0.15), PIXEL)
    normal = np.stack([-columns, rows, np.ones_like(rows)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    light = np.array([-np.sqrt(0.5), np.sqrt(0.5), np.tan(np.radians(28))])
    return as_bytes(normal @ (light / np.linalg.norm(light)), view.seen)


def flattened_image(view):
    return as_bytes(view.blurred(0.15) - view.blurred(4), view.seen)


def image_mser(image, view, delta):
    """OpenCV's MSER, regions of 4 mm2 to 30 % of the picture; the outermost of each nested chain."""
    pixel2 = PIXEL * PIXEL
    mser = cv2.MSER_create(delta, int(4 / pixel2), max(int(0.3 * view.seen.sum()), int(4 / pixel2) + 1))
    regions = sorted(mser.detectRegions(image)[0], key=len, reverse=True)
    taken, edges = np.zeros(image.shape, bool), []
    for region in regions:
        if taken[region[:, 1], region[:, 0]].mean() > 0.5:
            continue
        mask = np.zeros(image.shape, bool)
        mask[region[:, 1], region[:, 0]] = True
        taken |= mask
        edges.append(outlines(mask))
    return np.concatenate(edges) if edges else np.zeros((0, 2, 2))


def image_canny(image, view, high):
    on = cv2.Canny(cv2.GaussianBlur(image, (0, 0), 3), high / 2, high) > 0
    edges = []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        rows, columns = np.nonzero(on)
        ok = (rows + dy < on.shape[0]) & (columns + dx >= 0) & (columns + dx < on.shape[1])
        rows, columns = rows[ok], columns[ok]
        ok = on[rows + dy, columns + dx]
        a = np.stack([columns[ok], rows[ok]], axis=1).astype(float)
        edges.append(np.stack([a, a + [dx, dy]], axis=1))
    return np.concatenate(edges)


def image_rivals():
    yield "difference of Gaussians 0.3, 1.2 mm", [
        ("%.3f mm" % t, lambda view, t=t: difference_of_gaussians(view, t)) for t in (0.01, 0.02, 0.03)]
    for name, image in (("depth image", depth_image), ("shaded rendering", shaded_image), ("depth less its 4 mm mean", flattened_image)):
        yield "MSER (OpenCV), " + name, [
            ("delta %d" % d, lambda view, d=d, image=image: image_mser(image(view), view, d)) for d in (2, 5, 10)]
        yield "Canny (OpenCV), " + name, [
            ("high %d" % h, lambda view, h=h, image=image: image_canny(image(view), view, h)) for h in (10, 20, 40)]


def program_rivals():
    ridge = ["tree.polarity=upper"]
    yield "meshmser, relief.yaml", [("as shipped", ridge)]
    yield "meshmser, relief.yaml, line_width auto", [("as shipped", ridge + ["curvature.line_width=auto"])]
    everything = ["mser.select=level", "mser.min_persistence=0", "mser.min_contrast=0"]
    yield "fixed threshold of mean curvature, less the ground", [
        ("%.2f / mm" % h, ridge + everything + ["mser.level=%g" % h]) for h in (0.02, 0.04, 0.06, 0.1)]


def write_borders(path, view, edges):
    with open(path, "w") as f:
        f.write("region,loop,edge,x0,y0,z0,x1,y1,z1,kind,neighbour\n")
        for (x0, y0), (x1, y1) in view.place(edges):
            f.write("1,1,0,%.4f,%.4f,0,%.4f,%.4f,0,level,0\n" % (x0, y0, x1, y1))


def ensure(path):
    os.makedirs(path, exist_ok=True)
    return path


def run_program(program, scan, settings, out, cache):
    command = [program, "run", RELIEF, "-q", "--out", out, "--cache", cache, "--until", "export"]
    for setting in ["load.path=" + scan, "export.pictures=false", "export.points=false", "export.tree=false"] + settings:
        command += ["--set", setting]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit("%s\n%s" % (" ".join(command), done.stderr))
    return os.path.join(out, "label_borders.csv")


class Scan:
    """A scan with its truth: outlines (x, y points) and the places in which they count."""

    def __init__(self, name, path, outline, counts, points):
        self.name, self.path, self.outline, self.counts, self.points = name, path, outline, counts, points
        centred = points[:: max(1, len(points) // 20000)] - points.mean(0)
        residual = centred @ np.linalg.svd(centred, full_matrices=False)[2][2]
        self.sag = float(np.quantile(residual, 0.95) - np.quantile(residual, 0.05))
        self.view = None

    def height_map(self):
        self.view = self.view or HeightMap(self.points)
        return self.view


def given_sherds(data, scoring):
    for file in sorted(os.listdir(os.path.join(data, "sherds"))):
        if not file.endswith(".xyz"):
            continue
        base = os.path.join(data, "sherds", file[:-4])
        with open(base + "-outline.txt") as f:
            low = [float(v) for v in f.readline().split("origin")[1].split()[:2]]
        mask = cv2.imread(base + "-mask.png", 0) > 0
        size = 2 * 15 + 1  # 1.5 mm of rim
        inner = cv2.erode(mask.astype(np.uint8), np.ones((size, size))) > 0
        counts = lambda p, inner=inner, low=low: scoring.inside(p, inner, *low)
        yield Scan(file[:-4], base + ".xyz", scoring.read_outline(base + "-outline.txt"), counts, np.loadtxt(base + ".xyz", usecols=(0, 1, 2)))


def made_sherds(scanner, work):
    for seed, (name, parameters) in enumerate(MADE, 1):
        path = os.path.join(work, name + ".xyz")
        command = [scanner, "sherd", path, "--truth", "--seed", str(seed)]
        for key, value in parameters.items():
            command += ["--set", "%s=%g" % (key, value)]
        subprocess.run(command, check=True, capture_output=True)
        points = np.loadtxt(path, usecols=(0, 1, 2))
        edges = np.load(path[:-4] + "-edges.npy")[:, :2].astype(float)
        rim = HeightMap(points)
        # What a flat view sees of the sherd, less the broken edge and half a millimetre.
        distance = cv2.distanceTransform(rim.seen.astype(np.uint8), cv2.DIST_L2, 5) * PIXEL

        def counts(p, rim=rim, distance=distance):
            column = np.round((p[:, 0] - rim.low[0]) / PIXEL - 0.5).astype(int)
            row = np.round(rim.rows - 0.5 - (p[:, 1] - rim.low[1]) / PIXEL).astype(int)
            ok = (row >= 0) & (row < distance.shape[0]) & (column >= 0) & (column < distance.shape[1])
            ok[ok] = distance[row[ok], column[ok]] > 2.5
            return ok

        yield Scan(name, path, edges, counts, points)


def score(scan, borders, scoring):
    found = scoring.sample(scoring.read_border_edges(borders), 0.1)[:, :2]
    found = found[scan.counts(found)] if len(found) else found
    truth = scan.outline[scan.counts(scan.outline)]
    return [scoring.f_score(scoring.share_near(found, truth, t), scoring.share_near(truth, found, t)) for t in (0.3, 0.5)]


def best_of(settings, scans, scoring, make):
    """The setting with the best mean F at 0.5 mm, with its scores (#scans, 2)."""
    results = []
    for label, setting in settings:
        results.append((label, np.array([score(s, make(s, setting), scoring) for s in scans])))
    return max(results, key=lambda r: r[1][:, 1].mean())


def table(title, scans, scoring, arguments, work):
    print("\n## %s\n" % title)
    print("| method | setting | F at 0.3 mm | F at 0.5 mm | " + " | ".join(s.name for s in scans) + " |")
    print("|---|---|" + "---|" * (2 + len(scans)))
    print("| *sag, mm* | | | | " + " | ".join("%.1f" % s.sag for s in scans) + " |")

    def by_program(scan, setting):
        return run_program(arguments.program, scan.path, setting, os.path.join(work, "out"), os.path.join(work, "cache"))

    def by_image(scan, find):
        path = os.path.join(work, "borders.csv")
        write_borders(path, scan.height_map(), find(scan.height_map()))
        return path

    for rivals, make in ((program_rivals(), by_program), (image_rivals(), by_image)):
        for name, settings in rivals:
            if arguments.only and not any(word in name for word in arguments.only):
                continue
            label, scores = best_of(settings, scans, scoring, make)
            print("| %s | %s | %.3f | %.3f | " % (name, label, *scores.mean(axis=0)) + " | ".join("%.3f" % f for f in scores[:, 1]) + " |", flush=True)


def tablet_table(data, eval_folder, arguments, work):
    print("\n## Engraved tablets, radius of 3 spacings, F within 2 spacings\n")
    print("| scan | meshmser, relief.yaml | best fixed threshold of mean curvature |")
    print("|---|---|---|")
    scans = [os.path.join(data, "simulated", f) for f in sorted(os.listdir(os.path.join(data, "simulated"))) if f.startswith("tablet") and f.endswith(".ply")]
    for seed, (name, more) in enumerate([("glyphs-4", ["--set", "glyphs=4", "--set", "glyph=5.5"]), ("shallow", ["--set", "groove_depth=0.12"]),
                                         ("holes", ["--holes", "4", "--noise", "0.2"])], 1):
        path = os.path.join(work, "tablet-%s.ply" % name)
        subprocess.run([arguments.scanner, "tablet", path, "--truth", "--seed", str(seed), "--noise", "0.3"] + more if "--noise" not in more else
                       [arguments.scanner, "tablet", path, "--truth", "--seed", str(seed)] + more, check=True, capture_output=True)
        scans.append(path)

    def edge_score(scan, settings):
        borders = run_program(arguments.program, scan, settings + ["curvature.radius=3 spacing"], os.path.join(work, "out"), os.path.join(work, "cache"))
        done = subprocess.run([sys.executable, os.path.join(eval_folder, "edge_score.py"), scan[:-4] + "-edges.npy", scan, borders, "--angle", "0"],
                              check=True, capture_output=True, text=True)
        return float(done.stdout.split(" F ")[1].split()[0])

    for scan in scans:
        fixed = {h: edge_score(scan, ["mser.select=level", "mser.min_persistence=0", "mser.min_contrast=0", "mser.level=%g" % -h])
                 for h in (0.05, 0.1, 0.2, 0.3)}
        best = max(fixed, key=fixed.get)
        print("| %s | %.3f | %.3f (%g / mm) |" % (os.path.basename(scan)[:-4], edge_score(scan, []), fixed[best], best), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--data", default=os.environ.get("MESHMSER_EVAL_DATA"))
    parser.add_argument("--eval")
    parser.add_argument("--program", default=os.path.join(HERE, "..", "..", "build", "release", "meshmser"))
    parser.add_argument("--scanner", default=os.path.join(HERE, "..", "..", "build", "release", "data", "scanner", "meshmser-scan"))
    parser.add_argument("--work")
    parser.add_argument("--only", nargs="*")
    arguments = parser.parse_args()
    if not arguments.data:
        sys.exit("lines.py: give --data or set MESHMSER_EVAL_DATA")
    eval_folder = arguments.eval or os.path.join(arguments.data, "..", "eval")
    sys.path.insert(0, eval_folder)
    import outline_score as scoring
    with tempfile.TemporaryDirectory() as fresh:
        work = ensure(arguments.work or fresh)
        table("Stamped sherds", list(given_sherds(arguments.data, scoring)), scoring, arguments, work)
        table("Made sherds, exact outlines", list(made_sherds(arguments.scanner, work)), scoring, arguments, work)
        tablet_table(arguments.data, eval_folder, arguments, work)


if __name__ == "__main__":
    main()
