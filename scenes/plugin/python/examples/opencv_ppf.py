"""Point pair features of OpenCV (Drost et al. 2010), from Python.

Needs the Debian package python3-opencv, whose module ppf_match_3d is OpenCV's surface matching.

    pickbed plugin check "python3 opencv_ppf.py"
"""

import cv2
import numpy as np
import pickbed_plugin as pb

ppf = cv2.ppf_match_3d
cv2.setNumThreads(1)  # each worker of pickbed has its own program

# OpenCV merges poses that are nearer than its sampling step, but takes the step for a distance. So all
# points are in diameters of the object here.
STEP = 0.07
MODEL_POINTS = 2000
VOXEL = 0.06  # one measured point in each
NEIGHBORS = 12  # points of a normal
CANDIDATES = 30  # best poses that ICP refines


def one_per_voxel(points):
    """Returns the first point in each voxel."""
    _, first = np.unique(np.floor(points / VOXEL).astype(int), axis=0, return_index=True)
    return points[np.sort(first)]


def with_normals(points):
    """Returns points and normals that face the camera (N x 6, float32)."""
    _, cloud = ppf.computeNormalsPC3d(points.astype(np.float32), NEIGHBORS, True, (0, 0, 0))
    cloud = cloud[np.isfinite(cloud).all(axis=1)]
    away = np.einsum("ij,ij->i", cloud[:, :3], cloud[:, 3:]) > 0
    cloud[away, 3:] *= -1
    return np.ascontiguousarray(cloud)


def support(model, X, occupied):
    """Returns the share of model points facing the camera that have a measured point nearby."""
    points = model[:, :3] @ X[:3, :3].T + X[:3, 3]
    normals = model[:, 3:] @ X[:3, :3].T
    seen = points[np.einsum("ij,ij->i", points, normals) < 0]
    cells = np.floor(seen / VOXEL).astype(int)
    return float(np.mean([tuple(cell) in occupied for cell in cells])) if len(seen) else 0.0


class OpencvPpf(pb.Estimator):
    needs = ["bin"]

    def setup(self, setup):
        rng = np.random.default_rng(0)
        self.known = []
        for o in setup.objects:
            points, normals = o.sample(MODEL_POINTS, rng)
            model = np.hstack([points / o.diameter_m, normals]).astype(np.float32)
            detector = ppf.PPF3DDetector(STEP, STEP)
            detector.trainModel(model)
            self.known.append((o, model, detector))

    def estimate(self, frame):
        points_C = frame.points_in_bin_C()
        found = []
        for o, model, detector in self.known:
            scene = one_per_voxel(points_C / o.diameter_m)
            if len(scene) < 3 * NEIGHBORS:
                continue
            occupied = set(map(tuple, np.floor(points_C / o.diameter_m / VOXEL).astype(int)))
            scene = with_normals(scene)
            candidates = detector.match(scene, 0.2, 0.03)[:CANDIDATES]
            if len(candidates) == 0:
                continue
            _, refined = ppf.ICP(30).registerModelToScene(model, scene, candidates)
            for candidate in refined:
                X = np.array(candidate.pose, float)
                if np.isfinite(X).all() and np.linalg.det(X[:3, :3]) > 0.9:
                    u, _, vt = np.linalg.svd(X[:3, :3])
                    X[:3, :3] = u @ vt
                    found.append((support(model, X, occupied), o, X))
        return self.apart(found)

    @staticmethod
    def apart(found):
        """Returns the poses with most support, without a second one at the same place."""
        poses, places = [], []
        for score, o, X in sorted(found, key=lambda item: -item[0]):
            t_m = X[:3, 3] * o.diameter_m
            center_C = X[:3, :3] @ o.vertices_m.mean(axis=0) + t_m
            if all(np.linalg.norm(center_C - place) > 0.3 * o.diameter_m for place in places):
                poses.append(pb.Pose(o.name, X[:3, :3], t_m, score))
                places.append(center_C)
        return poses


if __name__ == "__main__":
    pb.serve(OpencvPpf())
