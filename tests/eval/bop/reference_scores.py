"""Scores of a BOP results file, written anew in numpy from the published definitions.

An independent reference for `pickbed score`: it shares no code with it. Definitions: Hodan et al.
2018 (VSD) and 2020 (MSSD, MSPD, AR), the rules of BOP 2024 and 2025 for AP. Prints JSON.

usage: reference_scores.py DATASET SPLIT RESULTS.csv [--no-vsd]
"""

import csv
import json
import math
import pathlib
import struct
import sys
import zlib

import numpy as np

STEPS = np.arange(0.05, 0.51, 0.05)
MILLIMETRES = range(2, 21, 2)
DELTA_MM = 15.0
MIN_VISIBLE = 0.1
MAX_ESTIMATES = 100
SYMMETRY_STEP = 0.01


def read_ply(path):
    """Returns vertices (n, 3) and triangles (m, 3)."""
    data = path.read_bytes()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    header = data[:end].decode().split("\n")
    binary = any("binary_little_endian" in line for line in header)
    sizes = {"float": ("<f4", 4), "float32": ("<f4", 4), "uchar": ("u1", 1), "uint8": ("u1", 1),
             "double": ("<f8", 8), "int": ("<i4", 4)}
    counts, fields, element = {}, [], ""
    for line in header:
        words = line.split()
        if words[:1] == ["element"]:
            element = words[1]
            counts[element] = int(words[2])
        if words[:1] == ["property"] and element == "vertex":
            fields.append((words[2], sizes[words[1]][0]))
    if not binary:
        lines = data[end:].decode().split("\n")
        n = counts["vertex"]
        columns = [name for name, _ in fields]
        rows = np.array([[float(x) for x in line.split()] for line in lines[:n]])
        vertices = rows[:, [columns.index(axis) for axis in "xyz"]]
        faces = [[int(x) for x in line.split()[1:4]] for line in lines[n:n + counts["face"]]]
        return vertices, np.array(faces)
    table = np.frombuffer(data, dtype=fields, count=counts["vertex"], offset=end)
    vertices = np.stack([table[axis].astype(float) for axis in "xyz"], axis=1)
    offset = end + table.nbytes
    faces = np.frombuffer(data, dtype=[("n", "u1"), ("v", "<i4", 3)], count=counts["face"],
                          offset=offset)
    return vertices, faces["v"]


def read_png16(path):
    """Returns a gray PNG of 16 bits."""
    data = path.read_bytes()
    position, pixels = 8, b""
    while position < len(data):
        length, kind = struct.unpack(">I4s", data[position:position + 8])
        chunk = data[position + 8:position + 8 + length]
        if kind == b"IHDR":
            width, height, bits = struct.unpack(">IIB", chunk[:9])
        if kind == b"IDAT":
            pixels += chunk
        position += 12 + length
    assert bits == 16
    raw = zlib.decompress(pixels)
    stride, before, rows = 2 * width, bytearray(2 * width), []
    for y in range(height):
        line = bytearray(raw[y * (stride + 1) + 1:(y + 1) * (stride + 1)])
        kind = raw[y * (stride + 1)]
        for i in range(stride):
            left = line[i - 2] if i >= 2 else 0
            up, corner = before[i], before[i - 2] if i >= 2 else 0
            if kind == 1:
                add = left
            elif kind == 2:
                add = up
            elif kind == 3:
                add = (left + up) // 2
            elif kind == 4:
                guess = left + up - corner
                add = min((left, up, corner), key=lambda value: abs(guess - value))
            else:
                add = 0
            line[i] = (line[i] + add) & 255
        rows.append(bytes(line))
        before = line
    return np.frombuffer(b"".join(rows), dtype=">u2").reshape(height, width).astype(float)


def symmetries(info):
    """Returns rotations and translations of all symmetries, the identity first."""
    discrete = [(np.eye(3), np.zeros(3))]
    for matrix in info.get("symmetries_discrete", []):
        matrix = np.array(matrix).reshape(4, 4)
        discrete.append((matrix[:3, :3], matrix[:3, 3]))
    continuous = []
    for axis in info.get("symmetries_continuous", []):
        a, offset = np.array(axis["axis"], float), np.array(axis["offset"], float)
        a /= np.linalg.norm(a)
        cross = np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])
        count = math.ceil(math.pi / SYMMETRY_STEP)
        for i in range(count):
            angle = i * 2 * math.pi / count
            rotation = np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
            continuous.append((rotation, offset - rotation @ offset))
    if not continuous:
        return discrete
    return [(Rc @ R, Rc @ t + tc) for R, t in discrete for Rc, tc in continuous]


def mssd_mspd(model, K, estimate, truth):
    vertices = model["vertices"]
    at_estimate = vertices @ estimate[0].T + estimate[1]
    pixels = project(K, at_estimate)
    surface, projection = [], []
    for R, t in model["symmetries"]:
        at_truth = vertices @ (truth[0] @ R).T + truth[0] @ t + truth[1]
        surface.append(np.linalg.norm(at_estimate - at_truth, axis=1).max())
        projection.append(np.linalg.norm(pixels - project(K, at_truth), axis=1).max())
    # The BOP toolkit computes no MSSD if the origins are a diameter apart.
    is_apart = np.linalg.norm(estimate[1] - truth[1]) >= model["diameter"]
    return np.inf if is_apart else min(surface), min(projection)


def project(K, points):
    homogeneous = points @ K.T
    return homogeneous[:, :2] / homogeneous[:, 2:]


def render(model, K, pose, shape):
    """Returns the distance from the camera center at each pixel; 0 = background."""
    height, width = shape
    corners = (model["vertices"] @ pose[0].T + pose[1])[model["triangles"]]
    depth = np.full(shape, np.inf)
    for triangle in corners:
        if (triangle[:, 2] <= 0).any():
            continue
        p = project(K, triangle) - 0.5  # the toolkit's renderer samples the centers of pixels at (i + 0.5, j + 0.5)
        low = np.maximum(np.ceil(p.min(axis=0)), 0).astype(int)
        high = np.minimum(np.floor(p.max(axis=0)), [width - 1, height - 1]).astype(int)
        if (high < low).any():
            continue
        u, v = np.meshgrid(np.arange(low[0], high[0] + 1), np.arange(low[1], high[1] + 1))
        (ax, ay), (bx, by), (cx, cy) = p
        area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
        if area == 0:
            continue
        wa = ((bx - u) * (cy - v) - (by - v) * (cx - u)) / area
        wb = ((cx - u) * (ay - v) - (cy - v) * (ax - u)) / area
        wc = 1 - wa - wb
        z = 1 / (wa / triangle[0, 2] + wb / triangle[1, 2] + wc / triangle[2, 2])
        inside = (wa >= 0) & (wb >= 0) & (wc >= 0)
        window = depth[low[1]:high[1] + 1, low[0]:high[0] + 1]
        window[inside & (z < window)] = z[inside & (z < window)]
    depth[np.isinf(depth)] = 0
    return distances(K, depth)


def distances(K, depth):
    u, v = np.meshgrid(np.arange(depth.shape[1]), np.arange(depth.shape[0]))
    x, y = (u - K[0, 2]) * depth / K[0, 0], (v - K[1, 2]) * depth / K[1, 1]
    return np.sqrt(x * x + y * y + depth * depth)


def vsd(model, estimated, true, measured):
    """Returns the error for each tolerance."""
    def visible(rendered):
        return (rendered > 0) & ((measured == 0) | (rendered - measured <= DELTA_MM))

    true_visible = visible(true)
    estimate_visible = visible(estimated) | (true_visible & (estimated > 0))
    both = true_visible & estimate_visible
    union = (true_visible | estimate_visible).sum()
    if union == 0:
        return np.ones(len(STEPS))
    apart = np.abs(true[both] - estimated[both]) / model["diameter"]
    only_one = union - both.sum()
    return np.array([((apart >= tau).sum() + only_one) / union for tau in STEPS])


def match(errors, scores, allowed, threshold):
    """Returns the instance of each estimate, -1 = none. errors: (estimates, instances)."""
    matched, taken = np.full(len(scores), -1), set()
    for e in sorted(range(len(scores)), key=lambda e: -scores[e]):
        best = threshold
        for t in range(errors.shape[1]):
            if allowed[t] and t not in taken and errors[e, t] < best:
                best, matched[e] = errors[e, t], t
        if matched[e] >= 0:
            taken.add(matched[e])
    return matched


def average_precision(detections, wanted):
    right = np.array([d[1] for d in sorted(detections, key=lambda d: -d[0])], dtype=bool)
    recall, precision = np.cumsum(right) / wanted, np.cumsum(right) / np.arange(1, len(right) + 1)
    levels = [precision[recall >= level].max() if (recall >= level).any() else 0
              for level in np.linspace(0, 1, 101)]
    return float(np.mean(levels))


def errors_of(models, K, width, estimates, truths, measured):
    """Returns the error tables of one object in one image."""
    shape = (len(estimates), len(truths))
    model = models[(estimates or truths)[0]["obj_id"]]
    tables = {"mssd": np.zeros(shape), "mspd": np.zeros(shape),
              "vsd": np.zeros((len(STEPS),) + shape)}
    drawn = [render(model, K, t["pose"], measured.shape) for t in truths] if measured is not None else []
    for e, estimate in enumerate(estimates):
        seen = render(model, K, estimate["pose"], measured.shape) if drawn else None
        for t, truth in enumerate(truths):
            surface, projection = mssd_mspd(model, K, estimate["pose"], truth["pose"])
            tables["mssd"][e, t] = surface
            tables["mspd"][e, t] = projection * 640 / width
            if drawn:
                tables["vsd"][:, e, t] = vsd(model, seen, drawn[t], measured)
    return tables


def highest(values, count):
    return sorted(range(len(values)), key=lambda i: -values[i])[:count]


class Totals:
    def __init__(self):
        self.wanted = 0
        self.found = {"mssd": np.zeros(10), "mspd": np.zeros(10), "vsd": np.zeros((10, 10))}
        self.detections = {}  # (kind, threshold, object) -> [(score, right)]
        self.detect_wanted = {}

    def localise(self, model, count, estimates, truths, tables):
        kept = highest([e["score"] for e in estimates], count)
        scores = [estimates[i]["score"] for i in kept]
        best = highest([t["visible"] for t in truths], count)
        allowed = [i in best for i in range(len(truths))]
        self.wanted += sum(allowed)
        for i in range(10):
            mssd = tables["mssd"][kept] / model["diameter"]
            self.found["mssd"][i] += (match(mssd, scores, allowed, STEPS[i]) >= 0).sum()
            self.found["mspd"][i] += (
                match(tables["mspd"][kept], scores, allowed, 5.0 * (i + 1)) >= 0).sum()
            for tau in range(10):
                found = match(tables["vsd"][tau][kept], scores, allowed, STEPS[i])
                self.found["vsd"][tau, i] += (found >= 0).sum()

    def detect(self, object_id, model, estimates, truths, tables):
        self.detect_wanted.setdefault(object_id, 0)
        self.detect_wanted[object_id] += sum(t["visible"] >= MIN_VISIBLE for t in truths)
        scores = [e["score"] for e in estimates]
        kinds = [("mssd", i, tables["mssd"] / model["diameter"], STEPS[i]) for i in range(10)]
        kinds += [("mm", i, tables["mssd"], mm) for i, mm in enumerate(MILLIMETRES)]
        kinds += [("mspd", i, tables["mspd"], 5.0 * (i + 1)) for i in range(10)]
        for kind, i, errors, threshold in kinds:
            entry = self.detections.setdefault((kind, i, object_id), [])
            matched = match(errors, scores, [True] * len(truths), threshold)
            for score, t in zip(scores, matched):
                if t < 0 or truths[t]["visible"] >= MIN_VISIBLE:
                    entry.append((score, t >= 0))

    def mean_precision(self, kind):
        objects = [o for o, count in self.detect_wanted.items() if count > 0]
        return float(np.mean([[average_precision(self.detections[kind, i, o],
                                                 self.detect_wanted[o])
                               if self.detections[kind, i, o] else 0.0 for i in range(10)]
                              for o in objects]))


def main():
    root, split = pathlib.Path(sys.argv[1]), sys.argv[2]
    with_vsd = "--no-vsd" not in sys.argv
    folder = root / ("models_eval" if (root / "models_eval").is_dir() else "models")
    models = {}
    for key, info in json.loads((folder / "models_info.json").read_text()).items():
        vertices, triangles = read_ply(folder / f"obj_{int(key):06}.ply")
        models[int(key)] = {"vertices": vertices, "triangles": triangles,
                            "diameter": info["diameter"], "symmetries": symmetries(info)}
    estimates = {}
    with open(sys.argv[3]) as file:
        for row in csv.DictReader(file):
            R = np.array([float(x) for x in row["R"].split()]).reshape(3, 3)
            t = np.array([float(x) for x in row["t"].split()])
            entry = {"obj_id": int(row["obj_id"]), "score": float(row["score"]), "pose": (R, t)}
            estimates.setdefault((int(row["scene_id"]), int(row["im_id"])), []).append(entry)
    counts, detected = {}, None
    for target in json.loads((root / f"{split}_targets_bop19.json").read_text()):
        image = (target["scene_id"], target["im_id"])
        counts.setdefault(image, {})[target["obj_id"]] = target["inst_count"]
    file24 = root / f"{split}_targets_bop24.json"
    if file24.exists():
        detected = {(t["scene_id"], t["im_id"]) for t in json.loads(file24.read_text())}
    totals = Totals()
    for scene in sorted((root / split).iterdir()):
        if not scene.name.isdigit():
            continue
        cameras = json.loads((scene / "scene_camera.json").read_text())
        gt = json.loads((scene / "scene_gt.json").read_text())
        gt_info = json.loads((scene / "scene_gt_info.json").read_text())
        for key, camera in cameras.items():
            image = (int(scene.name), int(key))
            K = np.array(camera["cam_K"], float).reshape(3, 3)
            depth = read_png16(scene / "depth" / f"{int(key):06}.png") * camera["depth_scale"]
            measured = distances(K, depth) if with_vsd else None
            truths = [{"obj_id": entry["obj_id"], "visible": info["visib_fract"],
                       "pose": (np.array(entry["cam_R_m2c"], float).reshape(3, 3),
                                np.array(entry["cam_t_m2c"], float))}
                      for entry, info in zip(gt[key], gt_info[key])]
            here = estimates.get(image, [])
            best = [here[i] for i in highest([e["score"] for e in here], MAX_ESTIMATES)]
            is_detected = detected is None or image in detected
            # The BOP toolkit leaves out estimates of objects that the image does not have.
            for object_id in sorted({t["obj_id"] for t in truths}):
                of_object = [e for e in best if e["obj_id"] == object_id]
                true = [t for t in truths if t["obj_id"] == object_id]
                tables = errors_of(models, K, depth.shape[1], of_object, true, measured)
                count = counts.get(image, {}).get(object_id, 0)
                if count:
                    totals.localise(models[object_id], count, of_object, true, tables)
                if is_detected:
                    totals.detect(object_id, models[object_id], of_object, true, tables)
    recall = {kind: float(found.mean() / totals.wanted) for kind, found in totals.found.items()}
    mssd, mspd = totals.mean_precision("mssd"), totals.mean_precision("mspd")
    print(json.dumps({
        "bop19_average_recall_vsd": recall["vsd"], "bop19_average_recall_mssd": recall["mssd"],
        "bop19_average_recall_mspd": recall["mspd"],
        "bop19_average_recall": float(np.mean(list(recall.values()))),
        "bop24_mAP_mssd": mssd, "bop24_mAP_mspd": mspd, "bop24_mAP": (mssd + mspd) / 2,
        "bop25_mAP": mssd, "bop25_mAP_mm": totals.mean_precision("mm")}))


if __name__ == "__main__":
    main()
