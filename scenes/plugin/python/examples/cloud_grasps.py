"""A grasp planner for a parallel jaw that works on the observed points, without poses.

It makes a height map of the bin and looks along many lines over it: where the surface falls off on both
sides, and the fingers have room there, is a grasp from straight above.

    pickbed plugin check "python3 cloud_grasps.py" --role planner
"""

import numpy as np
import pickbed_plugin as pb

CELL_M = 0.002  # of the height map
DEPTH_M = 0.015  # of the finger tips below the highest point between them
FINGER_M = 0.015  # thickness, with clearance
HALF_WIDTH_M = 0.012  # of a finger, across the closing direction, with clearance
LINES, ANGLES = 300, 12


class CloudGrasps(pb.Planner):
    needs = ["bin"]

    def height_map(self, frame):
        """Returns heights above the floor (x by y); 0 where nothing was measured."""
        points_C = frame.points_in_bin_C()
        X_BC = np.linalg.inv(frame.X_CB)
        points_B = points_C @ X_BC[:3, :3].T + X_BC[:3, 3]
        size_m = frame.setup.bin_size_m
        shape = np.ceil(size_m[:2] / CELL_M).astype(int)
        heights = np.zeros(shape)
        cells = np.floor((points_B[:, :2] + size_m[:2] / 2) / CELL_M).astype(int)
        cells = np.clip(cells, 0, shape - 1)
        np.maximum.at(heights, (cells[:, 0], cells[:, 1]), points_B[:, 2])
        return heights

    def profile(self, heights, center, direction, reach_m):
        """Returns the heights along a line as wide as a finger, from -reach to reach."""
        along = np.arange(-reach_m, reach_m + CELL_M / 2, CELL_M)
        across = np.arange(-HALF_WIDTH_M, HALF_WIDTH_M + CELL_M / 2, CELL_M)
        side = np.array([-direction[1], direction[0]])
        places = (center + along[:, None, None] * direction + across[None, :, None] * side)
        cells = np.floor(places / CELL_M).astype(int)
        outside = (cells < 0).any(axis=2) | (cells >= heights.shape).any(axis=2)
        cells = np.clip(cells, 0, np.array(heights.shape) - 1)
        found = np.where(outside, np.inf, heights[cells[..., 0], cells[..., 1]])
        return along, found.max(axis=1)

    def grasp(self, frame, heights, center, angle, opening_m):
        """Returns the grasp on a line through a cell, or None."""
        direction = np.array([np.cos(angle), np.sin(angle)])
        along, profile = self.profile(heights, center, direction, opening_m)
        middle = len(along) // 2
        tips_m = max(profile[middle] - DEPTH_M, 0.004)
        if not np.isfinite(profile[middle]) or profile[middle] < tips_m + 0.005:
            return None
        solid = profile > tips_m
        left = middle - np.argmin(solid[middle::-1])
        right = middle + np.argmin(solid[middle:])
        if solid[left] or solid[right]:
            return None
        fingers = int(np.ceil(FINGER_M / CELL_M))
        room = np.concatenate([solid[max(left - fingers, 0):left + 1], solid[right:right + fingers + 1]])
        width_m = (right - left) * CELL_M
        if room.any() or left < fingers or width_m > opening_m - 2 * CELL_M:
            return None
        shift = (along[left] + along[right]) / 2
        X_BG = np.eye(4)
        X_BG[:3, 0] = [*direction, 0]
        X_BG[:3, 2] = [0, 0, -1]
        X_BG[:3, 1] = np.cross(X_BG[:3, 2], X_BG[:3, 0])
        X_BG[:2, 3] = center - frame.setup.bin_size_m[:2] / 2 + shift * direction
        X_BG[2, 3] = tips_m
        hold = (profile[left:right].max() - tips_m) / DEPTH_M
        centered = 1 - abs(shift) / opening_m
        score = 0.5 * profile[middle] / heights.max() + 0.25 * min(hold, 1) + 0.25 * centered
        return pb.Grasp(frame.X_WC @ frame.X_CB @ X_BG, width_m, float(np.clip(score, 0, 1)))

    def plan_grasps(self, frame, poses):
        jaw = next(g for g in frame.setup.grippers if g.mechanism == "parallel_jaw")
        heights, rng = self.height_map(frame), frame.rng()
        if not heights.any():
            return []
        cells = np.argwhere(heights > max(0.5 * heights.max(), 0.006))
        grasps = []
        for cell in cells[rng.permutation(len(cells))[:LINES]]:
            for angle in np.pi * (np.arange(ANGLES) + rng.random()) / ANGLES:
                grasps.append(self.grasp(frame, heights, (cell + 0.5) * CELL_M, angle,
                                         jaw.max_opening_m))
        found = [grasp for grasp in grasps if grasp is not None]
        return sorted(found, key=lambda grasp: -grasp.score)[:50]


if __name__ == "__main__":
    pb.serve(CloudGrasps())
