#!/usr/bin/python3
"""Pose errors and intervals of the Python module against independent references."""

import csv
import math
import os
from pathlib import Path

import numpy as np
import pickbed

import support


def pose(rotation, translation):
    X = np.eye(4)
    X[:3, :3] = np.array(rotation.split(), float).reshape(3, 3)
    X[:3, 3] = np.array(translation.split(), float)
    return X


class PoseErrors(support.TestCase):
    def test_they_equal_the_bop_toolkit_on_real_estimates(self):
        folder = Path(os.environ["PICKBED_TEST_DATA"], "metrics_reference")
        if not folder.is_dir():
            self.skipTest(f"no reference data in {folder}")
        # The file is in millimetres. Read as metres, it gives errors in millimetres.
        model = pickbed.MetricModel(pickbed.load_mesh_object(folder / "ape_mm_centred.ply"), max_vertices=0)
        camera = pickbed.CameraIntrinsics(640, 480, 572.4114, 573.57043, 325.2611, 242.04899)
        with open(folder / "lmo_ape_pose_errors.csv") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 160)
        for row in rows[::4]:
            X_true, X_est = pose(row["gt_R"], row["gt_t_mm"]), pose(row["est_R"], row["est_t_mm"])
            errors = {"add_mm": pickbed.add_m(model, X_est, X_true), "adi_mm": pickbed.adi_m(model, X_est, X_true),
                      "mssd_mm": pickbed.mssd_m(model, X_est, X_true),
                      "mspd_px": pickbed.mspd_px(model, camera, X_est, X_true),
                      "re_deg": math.degrees(pickbed.rotation_error_rad(model, X_est, X_true)),
                      "te_mm": pickbed.translation_error_m(model, X_est, X_true)}
            for name, error in errors.items():
                self.assertAlmostEqual(error, float(row[name]), delta=max(1e-3, 1e-5 * float(row[name])), msg=name)

    def test_symmetric_poses_have_no_error(self):
        ring = pickbed.load_object("ring")
        model = pickbed.MetricModel(ring)
        X_true = np.eye(4)
        X_true[2, 3] = 0.6
        X_est = X_true @ ring.symmetry_transforms()[100]
        self.assertLess(pickbed.mssd_m(model, X_est, X_true), 1e-9)
        self.assertGreater(pickbed.add_m(model, X_est, X_true), 0.01)
        errors = pickbed.pose_errors(model, pickbed.CameraIntrinsics(640, 480, 600, 600, 320, 240), X_est, X_true)
        self.assertLess(errors["mspd_px"], 1e-6)
        self.assertEqual(errors["mssd_m"], pickbed.mssd_m(model, X_est, X_true))

    def test_vsd_is_the_share_of_pixels_that_contradict(self):
        cell = pickbed.Cell(pickbed.Scenario("bin_ring", {"objects.0.count": 1, "sensor": "ideal"}))
        view = cell.capture(cell.drop())
        truth = view.instances[0]
        model = pickbed.MetricModel(cell.objects[truth.object])
        vsd = lambda X_est, taus=(0.05, 0.5): pickbed.vsd(model, view.camera, X_est, truth.X_CO, view.depth_m, taus)
        self.assertEqual(vsd(truth.X_CO), [0, 0])
        near = truth.X_CO.copy()
        near[2, 3] -= 0.2 * model.diameter_m  # 20 % of the diameter towards the camera
        errors = vsd(near)
        self.assertGreater(errors[0], 0.99)
        self.assertLess(errors[1], 0.7)
        away = truth.X_CO.copy()
        away[0, 3] += 2 * model.diameter_m
        self.assertEqual(vsd(away), [1, 1])

    def test_each_fault_is_one_line(self):
        model = pickbed.MetricModel(pickbed.load_object("ring"))
        camera = pickbed.CameraIntrinsics(64, 48, 60, 60, 32, 24)
        X, depth_m = np.eye(4), np.zeros((48, 64), np.float32)
        self.refused("X_est must be 4 x 4", lambda: pickbed.mssd_m(model, X[:3], X))
        self.refused("X_true is a reflection", lambda: pickbed.add_m(model, X, np.diag([-1, 1, 1, 1])))
        self.refused("depth_m must be 48 x 64", lambda: pickbed.vsd(model, camera, X, X, depth_m[1:], [0.1]))
        self.refused("taus must be a list of numbers", lambda: pickbed.vsd(model, camera, X, X, depth_m, "all"))
        self.refused("taus has the value nan", lambda: pickbed.vsd(model, camera, X, X, depth_m, [np.nan]))
        self.refused("taus has the value -1", lambda: pickbed.vsd(model, camera, X, X, depth_m, [-1]))
        self.refused("delta_m = nan", lambda: pickbed.vsd(model, camera, X, X, depth_m, [0.1], np.nan))
        self.refused("max_vertices = -1", lambda: pickbed.MetricModel(pickbed.load_object("ring"), -1))


class Intervals(support.TestCase):
    def test_the_wilson_interval_solves_its_equation(self):
        low, high = pickbed.wilson_interval(45, 50)
        z = 1.959963984540054
        for end in (low, high):
            self.assertAlmostEqual(abs(45 / 50 - end), z * math.sqrt(end * (1 - end) / 50), places=9)

    def test_clusters_of_one_sample_give_the_wilson_interval(self):
        clusters = [(1, 1)] * 45 + [(0, 1)] * 5
        np.testing.assert_allclose(pickbed.cluster_interval(clusters), pickbed.wilson_interval(45, 50), atol=1e-9)

    def test_too_few_bins_give_none(self):
        self.assertIsNone(pickbed.cluster_interval([(3, 5)] * (pickbed.MIN_BINS_OF_INTERVAL - 1)))
        self.assertIsNotNone(pickbed.cluster_interval([(3, 5)] * pickbed.MIN_BINS_OF_INTERVAL))

    def test_equal_runs_differ_by_nothing(self):
        low, high = pickbed.paired_interval([(4, 5)] * 40, [(4, 5)] * 40)
        self.assertLess(low, 0)
        self.assertGreater(high, 0)
        low, high = pickbed.paired_interval([(1, 5)] * 40, [(4, 5)] * 40)
        self.assertTrue(low < 0.6 < high or low > 0)

    def test_the_median_is_within_its_interval(self):
        values = [[0.1 * i, 0.1 * i + 1] for i in range(30)]
        low, high = pickbed.median_interval(values)
        self.assertTrue(low <= np.median(values) <= high)

    def test_each_fault_is_one_line(self):
        self.refused("5 hits of 3 samples", lambda: pickbed.wilson_interval(5, 3))
        self.refused("-1 hits", lambda: pickbed.cluster_interval([(-1, 3)]))
        self.refused("confidence = 2", lambda: pickbed.wilson_interval(1, 3, 2))
        self.refused("the same units", lambda: pickbed.paired_interval([(1, 2)], []))
        self.refused("values has NaN", lambda: pickbed.median_interval([[float("nan")]]))


if __name__ == "__main__":
    support.main()
