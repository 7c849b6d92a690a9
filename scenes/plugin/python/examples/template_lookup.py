"""An estimator that looks up depth templates, in NumPy alone.

Templates are small depth images of each object from all sides. An observed blob of points is compared
with all of them; the best one gives the pose, and a few steps of ICP improve it. It suits objects that
do not touch each other.

    pickbed plugin check "python3 template_lookup.py" --scenario bin_bracket --set arrangement=packed
"""

import numpy as np
import pickbed_plugin as pb

CELLS = 16  # side of a template
DIRECTIONS, TURNS = 120, 16  # views on the sphere, rotations about each
SAMPLES = 800  # points on the surface of an object
ICP_POINTS = 250  # of them, and of a blob
CANDIDATES = 8  # templates that ICP refines
MIN_POINTS = 60  # smaller blobs are ignored


def rotations():
    """Returns rotations whose z axes cover the sphere (N x 3 x 3)."""
    index = np.arange(DIRECTIONS) + 0.5
    polar, azimuth = np.arccos(1 - 2 * index / DIRECTIONS), np.pi * (1 + 5**0.5) * index
    z = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth),
                  np.cos(polar)], axis=1)
    x = np.cross(z, np.where(np.abs(z[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]]))
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(z, x)
    turn = 2 * np.pi * np.arange(TURNS) / TURNS
    cos, sin = np.cos(turn)[None, :, None], np.sin(turn)[None, :, None]
    x, y = cos * x[:, None] + sin * y[:, None], cos * y[:, None] - sin * x[:, None]
    z = np.broadcast_to(z[:, None], x.shape)
    return np.stack([x, y, z], axis=2).reshape(-1, 3, 3)


def visible(points, size_m):
    """Returns the indices of points that no other point hides, for a view along z."""
    cells = np.floor(points[:, :2] / size_m * CELLS).astype(int)
    _, cell = np.unique(cells, axis=0, return_inverse=True)
    front = np.full(cell.max() + 1, np.inf)
    np.minimum.at(front, cell, points[:, 2])
    return np.flatnonzero(points[:, 2] < front[cell] + 0.1 * size_m)


def template(points, size_m):
    """Returns a depth image (in sizes, 0 = in front) of points around their center; 1 = nothing."""
    image = np.ones((CELLS, CELLS))
    cells = np.floor((points[:, :2] / size_m + 0.5) * CELLS).astype(int)
    inside = ((cells >= 0) & (cells < CELLS)).all(axis=1)
    depth = (points[inside, 2] - points[:, 2].min()) / size_m
    np.minimum.at(image, (cells[inside, 1], cells[inside, 0]), depth)
    return image.ravel()


def fit(source, target):
    """Returns the rotation and translation that move points to their partners (Kabsch 1976)."""
    a, b = source.mean(axis=0), target.mean(axis=0)
    u, _, vt = np.linalg.svd((source - a).T @ (target - b))
    R = vt.T @ np.diag([1, 1, np.linalg.det(vt.T @ u.T)]) @ u.T
    return R, b - R @ a


class TemplateLookup(pb.Estimator):
    needs = ["bin"]

    def setup(self, setup):
        rng = np.random.default_rng(0)
        self.known = []
        for o in setup.objects:
            points_O = o.sample(SAMPLES, rng)[0]
            R_all, images, seen = rotations(), [], []
            for R in R_all:
                turned = points_O @ R.T
                front = visible(turned, o.diameter_m)
                images.append(template(turned[front] - turned[front].mean(axis=0), o.diameter_m))
                seen.append(points_O[front][:ICP_POINTS])
            self.known.append((o, R_all, np.array(images), seen))

    def blobs(self, points_C, up_C, diameter_m):
        """Yields the points around the highest remaining point, from the highest blob on."""
        while len(points_C) >= MIN_POINTS:
            center = points_C[np.argmax(points_C @ up_C)]
            for _ in range(5):
                near = np.linalg.norm(points_C - center, axis=1) < 0.55 * diameter_m
                center = points_C[near].mean(axis=0) if near.any() else center
            if not near.any():
                return
            if near.sum() >= MIN_POINTS:
                yield points_C[near]
            points_C = points_C[np.linalg.norm(points_C - center, axis=1) > 0.6 * diameter_m]

    def pose_of(self, blob_C, known):
        """Returns rotation, translation and score of an object for a blob of points."""
        o, R_all, images, seen = known
        center_C = blob_C.mean(axis=0)
        # A view frame V whose z axis is the line of sight to the blob.
        z = center_C / np.linalg.norm(center_C)
        x = np.cross([0, 1.0, 0], z)
        x /= np.linalg.norm(x)
        R_CV = np.stack([x, np.cross(z, x), z], axis=1)
        image = template((blob_C - center_C) @ R_CV, o.diameter_m)
        blob_C = blob_C[:: max(1, len(blob_C) // ICP_POINTS)]
        best = None
        for index in np.argsort(np.abs(images - image).sum(axis=1))[:CANDIDATES]:
            R, points_O = R_CV @ R_all[index], seen[index]
            t = center_C - R @ points_O.mean(axis=0)
            for _ in range(20):
                moved = points_O @ R.T + t
                square = (moved**2).sum(axis=1)[:, None] + (blob_C**2).sum(axis=1) - 2 * moved @ blob_C.T
                distance = np.sqrt(np.maximum(square, 0))
                partner = blob_C[distance.argmin(axis=1)]
                close = distance.min(axis=1) < 0.15 * o.diameter_m
                if close.sum() < 10:
                    break
                R, t = fit(points_O[close], partner[close])
            score = np.mean(distance.min(axis=1) < 0.05 * o.diameter_m)
            score *= np.mean(distance.min(axis=0) < 0.06 * o.diameter_m)
            if best is None or score > best[2]:
                best = (R, t, score)
        return best

    def estimate(self, frame):
        points_C, up_C = frame.points_in_bin_C(), frame.X_CB[:3, 2]
        rng, poses = frame.rng(), []
        largest_m = max(o.diameter_m for o, _, _, _ in self.known)
        for blob_C in self.blobs(points_C, up_C, largest_m):
            if len(blob_C) > SAMPLES:
                blob_C = blob_C[rng.choice(len(blob_C), SAMPLES, replace=False)]
            found = [(known[0].name, *self.pose_of(blob_C, known)) for known in self.known]
            poses.append(pb.Pose(*max(found, key=lambda pose: pose[3])))
        return poses


if __name__ == "__main__":
    pb.serve(TemplateLookup())
