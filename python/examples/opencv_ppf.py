"""Point pair features of OpenCV (Drost et al. 2010), from Python.

Needs the Debian package python3-opencv, whose module ppf_match_3d is OpenCV's surface matching.

    pickbed plugin check "python3 opencv_ppf.py"
"""

import cv2
import numpy as np
import pickbed_plugin as pb

ppf = cv2.ppf_match_3d

MODEL_POINTS = 3000
SCENE_POINTS = 4000
CANDIDATES = 40  # best poses of each object that ICP refines
STEP = 0.04  # distance of sampled points, in diameters
NEIGHBORS = 12  # points of a normal


def with_normals(points_C):
    """Returns points and normals that face the camera (N x 6, float32)."""
    _, cloud = ppf.computeNormalsPC3d(points_C.astype(np.float32), NEIGHBORS, True, (0, 0, 0))
    facing = np.einsum("ij,ij->i", cloud[:, :3], cloud[:, 3:]) > 0
    cloud[facing, 3:] *= -1
    return cloud[np.isfinite(cloud).all(axis=1)]


def support(model, X_CO, grid, cell_m):
    """Returns the share of model points facing the camera that have a measured point nearby."""
    points = model[:, :3] @ X_CO[:3, :3].T + X_CO[:3, 3]
    normals = model[:, 3:] @ X_CO[:3, :3].T
    seen = points[np.einsum("ij,ij->i", points, normals) < 0]
    if len(seen) == 0:
        return 0.0
    cells = np.round(seen / cell_m).astype(int)
    return float(np.mean([tuple(cell) in grid for cell in cells]))


class OpencvPpf(pb.Estimator):
    needs = ["bin"]

    def setup(self, setup):
        rng = np.random.default_rng(0)
        self.models = []
        for o in setup.objects:
            model = np.hstack(o.sample(MODEL_POINTS, rng)).astype(np.float32)
            detector = ppf.PPF3DDetector(STEP, STEP, 30)
            detector.trainModel(model)
            self.models.append((o, model, detector))

    def estimate(self, frame):
        points_C = frame.points_in_bin_C()
        if len(points_C) < 10 * NEIGHBORS:
            return []
        rng = frame.rng()
        if len(points_C) > SCENE_POINTS:
            points_C = points_C[rng.choice(len(points_C), SCENE_POINTS, replace=False)]
        scene = with_normals(points_C)
        found = []
        for o, model, detector in self.models:
            cell_m = 0.06 * o.diameter_m
            grid = {tuple(cell + shift) for cell in np.round(scene[:, :3] / cell_m).astype(int)
                    for shift in ((0, 0, 0), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0))}
            candidates = detector.match(scene, 0.2, 0.03)[:CANDIDATES]
            if len(candidates) == 0:
                continue
            _, refined = ppf.ICP(30).registerModelToScene(model, scene, candidates)
            for candidate in refined:
                X_CO = np.array(candidate.pose, float)
                if np.linalg.det(X_CO[:3, :3]) > 0.9:
                    found.append((support(model, X_CO, grid, cell_m), o, X_CO))
        return self.best(found)

    @staticmethod
    def best(found):
        """Returns the poses with most support, and leaves out poses at the same place."""
        poses, places = [], []
        for score, o, X_CO in sorted(found, key=lambda item: -item[0]):
            center_C = X_CO[:3, :3] @ o.vertices_m.mean(axis=0) + X_CO[:3, 3]
            if all(np.linalg.norm(center_C - place) > 0.3 * o.diameter_m for place in places):
                u, _, vt = np.linalg.svd(X_CO[:3, :3])
                poses.append(pb.Pose(o.name, u @ vt, X_CO[:3, 3], score))
                places.append(center_C)
        return poses


if __name__ == "__main__":
    pb.serve(OpencvPpf())
