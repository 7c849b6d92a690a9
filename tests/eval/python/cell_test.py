#!/usr/bin/python3
"""Drop, capture, estimate, plan and execute in Python give the same bytes as the program."""

import csv
import gc
import json
import threading

import numpy as np
import pickbed

import support


class CellStages(support.TestCase):
    def setUp(self):
        super().setUp()
        self.cell = pickbed.Cell(self.scenario())

    def test_images_are_equal_to_those_of_render(self):
        import cv2
        self.program("render", self.scenario_file, "--trial", 2, "--out", "render")
        view = self.cell.capture(self.cell.drop(2))
        read = lambda name: cv2.imread(str(self.folder / "render" / name), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(view.color, read("color.png")[:, :, ::-1])
        np.testing.assert_array_equal(view.ids, read("ids.png"))
        np.testing.assert_array_equal(np.rint(view.depth_m.astype(np.float64) * 1e4), read("depth.png"))
        self.assertEqual(view.depth_m.dtype, np.float32)
        self.assertGreater((view.depth_m > 0).mean(), 0.3)

    def test_true_poses_are_equal_to_those_of_drop(self):
        self.program("drop", self.scenario_file, "--trial", 1, "--out", "drop")
        scene = json.loads((self.folder / "drop/scene.json").read_text())
        content = self.cell.drop(1)
        self.assertEqual(len(content), 5)
        for posed, written in zip(content.instances, scene["objects"]):
            self.assertEqual(posed.instance, written["instance"])
            self.assertEqual(content.object_names[posed.object], written["name"])
            np.testing.assert_allclose(posed.X_WO[:3, 3], written["position_m"], atol=1e-6)

    def test_visible_fractions_and_masks_agree(self):
        self.program("render", self.scenario_file, "--out", "render")
        view = self.cell.capture(self.cell.drop())
        with open(self.folder / "render/visible.csv") as file:
            written = {int(row["instance"]): float(row["visible_fraction"]) for row in csv.DictReader(file)}
        for truth, fraction in zip(view.instances, view.visible_fractions):
            self.assertEqual(truth.visible_fraction, fraction)
            self.assertAlmostEqual(written[truth.instance], fraction, places=5)
            self.assertEqual(view.instance_mask(truth.instance).any(), fraction > 0)

    def test_true_poses_explain_the_depth_image(self):
        cell = pickbed.Cell(self.scenario({"sensor": "ideal"}))
        view = cell.capture(cell.drop())
        for truth in view.instances:
            pixels = np.argwhere(view.instance_mask(truth.instance))[::97]
            v, u = pixels.T
            z = view.depth_m[v, u].astype(np.float64)
            points_C = np.stack([(u - view.K[0, 2]) / view.K[0, 0] * z, (v - view.K[1, 2]) / view.K[1, 1] * z, z], axis=1)
            points_O = (points_C - truth.X_CO[:3, 3]) @ truth.X_CO[:3, :3]
            corners = cell.objects[truth.object].vertices_O_m
            self.assertTrue((points_O > corners.min(axis=0) - 1e-4).all())
            self.assertTrue((points_O < corners.max(axis=0) + 1e-4).all())

    def test_images_share_memory_and_outlive_their_view(self):
        view = self.cell.capture(self.cell.drop())
        depth_m = view.depth_m
        self.assertEqual(depth_m.__array_interface__["data"][0], view.depth_m.__array_interface__["data"][0])
        before = depth_m.copy()
        with self.assertRaises(ValueError):
            depth_m[0, 0] = 1
        del view
        self.cell.capture(self.cell.drop(1))
        gc.collect()
        np.testing.assert_array_equal(depth_m, before)

    def test_stages_give_the_first_attempt_of_the_trial(self):
        record = self.cell.run_trial(0).attempts[0]
        content = self.cell.drop(0)
        view = self.cell.capture(content)
        hypotheses = self.cell.estimate(view).hypotheses
        scored = self.cell.score(view, hypotheses)
        self.assertEqual(len(scored), len(record.hypotheses))
        for mine, recorded in zip(scored, record.hypotheses):
            np.testing.assert_array_equal(mine.X_WO, recorded.X_WO)
            self.assertEqual(mine.metrics, recorded.metrics)
            self.assertEqual(mine.instance, recorded.instance)
        plan = self.cell.plan(view, hypotheses)
        np.testing.assert_array_equal(plan.grasps[0].X_WG, record.grasp.X_WG)
        self.assertEqual(plan.rejected, record.grasps_rejected)
        outcome, after = self.cell.execute(content, plan.grasps[0], hypotheses)
        for name in ("success", "failure", "picked_instance", "slip_m", "place_error_m", "verdicts"):
            self.assertEqual(getattr(outcome, name), getattr(record.outcome, name), name)
        self.assertEqual(len(after), len(content) - outcome.success)

    def test_own_poses_and_the_estimate_of_a_frame(self):
        cell = pickbed.Cell(self.scenario({"estimator.name": "ppf", "objects": [{"name": "bracket", "count": 2}]}))
        view = cell.capture(cell.drop())
        found = cell.estimate_frame(view.camera, view.X_WC, view.depth_m, view.color).hypotheses
        self.assertTrue(any(scored.correct for scored in cell.score(view, found)))
        truth = [pickbed.PoseHypothesis(t.object, t.X_CO) for t in view.instances]
        for scored, true in zip(cell.score(view, truth), view.instances):
            self.assertEqual(scored.instance, true.instance)
            self.assertLess(scored.metrics["mssd_m"], 1e-9)

    def test_a_planner_without_poses_plans_on_the_image(self):
        cell = pickbed.Cell(self.scenario({"planner.name": "cloud_antipodal"}))
        content = cell.drop()
        view = cell.capture(content)
        grasp = cell.plan(view).grasps[0]
        self.assertEqual(grasp.hypothesis, pickbed.NO_HYPOTHESIS)
        outcome, _ = cell.execute(content, grasp)
        self.assertIn(outcome.failure, ("none", "slipped", "closed_on_nothing", "collision", "double_pick", "dropped"))
        self.refused("there is no estimator", lambda: cell.estimate(view))


class BadCellInput(support.TestCase):
    def setUp(self):
        super().setUp()
        self.cell = pickbed.Cell(self.scenario())
        self.content = self.cell.drop()

    def test_each_fault_is_one_line(self):
        cell, content = self.cell, self.content
        view = cell.capture(content)
        pose = np.eye(4)
        self.refused("bin_index = -1", lambda: cell.drop(-1))
        self.refused("attempt = -2", lambda: cell.capture(content, -2))
        self.refused("the image has no instance 99", lambda: view.instance_mask(99))
        self.refused("object 7, but the scenario has the objects 0 to 1",
                     lambda: cell.plan(view, [pickbed.PoseHypothesis(7, pose)]))
        self.refused("max_grasps = 0", lambda: cell.plan(view, [], 0))
        self.refused("hypothesis 3, but there are 0", lambda: cell.execute(content, pickbed.Grasp(pose, 0.02, hypothesis=3)))
        self.refused("unknown gripper", lambda: cell.execute(content, pickbed.Grasp(pose, 0.02, tool="claw")))
        self.refused("estimator.name", lambda: cell.estimate_frame(view.camera, pose, view.depth_m))
        other = pickbed.Cell(pickbed.Scenario("bin_ring", {"objects.0.count": 1}))
        self.refused("other objects", lambda: other.capture(content))

    def test_poses_are_checked(self):
        pose = np.eye(4)
        faults = {"X_WG must be 4 x 4, not 3 x 3": np.eye(3),
                  "X_WG must be a pose of 4 x 4 numbers, not an array of complex128": pose * 1j,
                  "X_WG must be a pose of 4 x 4 numbers, not an array of object": [[None] * 4] * 4,
                  "X_WG has a value that is not finite": pose * np.nan,
                  "X_WG is no rotation": pose * [[1.1], [1], [1], [1]],
                  "X_WG is a reflection": np.diag([1, 1, -1, 1]),
                  "X_WG has another last row": pose + np.eye(4)[3:] * 0.5,
                  "positions are in metres": pose + [[0, 0, 0, 350], [0] * 4, [0] * 4, [0] * 4]}
        for words, value in faults.items():
            self.refused(words, lambda value=value: pickbed.Grasp(value, 0.02))
        self.refused("width_m = 30", lambda: pickbed.Grasp(pose, 30))
        self.refused("width_m = nan", lambda: pickbed.Grasp(pose, float("nan")))
        self.refused("lift_aside_m is 2 m long", lambda: pickbed.Grasp(pose, 0.02, lift_aside_m=(0, 2)))
        self.refused("lift_aside_m is nan", lambda: pickbed.Grasp(pose, 0.02, lift_aside_m=(float("nan"), 0)))
        self.assertEqual(list(pickbed.Grasp(pose, 0.02, lift_aside_m=(0.02, -0.01)).lift_aside_m), [0.02, -0.01])
        self.refused("score = inf", lambda: pickbed.Grasp(pose, 0.02, float("inf")))
        self.refused("score = 2", lambda: pickbed.PoseHypothesis(0, pose, 2))
        nearly = pose.copy()
        nearly[0, 1] = 1e-4
        R = pickbed.Grasp(nearly, 0.02).X_WG[:3, :3]
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)

    def test_images_are_checked(self):
        cell = pickbed.Cell(self.scenario({"estimator.name": "ppf"}))
        camera = cell.camera
        size = (camera.height, camera.width)
        estimate = lambda depth_m, color=None: cell.estimate_frame(camera, cell.X_WC, depth_m, color)
        good = np.zeros(size, np.float32)
        self.refused("depth_m must be 480 x 640, not 640 x 480", lambda: estimate(good.T))
        self.refused("depth_m must be an image of float32 in metres, not an array of uint16",
                     lambda: estimate(np.zeros(size, np.uint16)))
        self.refused("depth_m has the value nan", lambda: estimate(good * np.nan))
        self.refused("depth_m has the value -1", lambda: estimate(good - 1))
        self.refused("color must be an image of uint8, not an array of float32", lambda: estimate(good, np.dstack([good] * 3)))
        self.refused("color must be 480 x 640 x 3", lambda: estimate(good, np.zeros(size, np.uint8)))
        self.refused("depth_m must be an image", lambda: estimate("depth.png"))

    def test_a_missing_object_is_no_crash(self):
        for call in (lambda: pickbed.Cell(None), lambda: pickbed.BinPickingEnv(None), lambda: pickbed.MetricModel(None),
                     lambda: self.cell.capture(None), lambda: self.cell.execute(self.content, None)):
            self.assertRaises(TypeError, call)

    def test_another_thread_is_refused(self):
        caught = []

        def capture():
            try:
                self.cell.capture(self.content)
            except RuntimeError as error:
                caught.append(str(error))

        thread = threading.Thread(target=capture)
        thread.start()
        thread.join()
        self.assertEqual(caught, ["Cell was made by another thread; make one in each thread"])


if __name__ == "__main__":
    support.main()
