#!/usr/bin/python3
"""Scenarios, objects and tables of the Python module."""

import numpy as np
import pickbed

import support


class Scenarios(support.TestCase):
    def test_a_preset_has_its_objects_and_settings(self):
        scenario = pickbed.Scenario("clutter")
        self.assertEqual(scenario.name, "clutter")
        self.assertEqual([o.name for o in scenario.objects], ["bracket", "rod", "pipe_tee", "elbow", "gear"])
        self.assertEqual(scenario.settings["bin"]["inner_size_m"], [0.3, 0.3, 0.05])
        self.assertEqual(scenario.settings["objects"][1]["name"], "rod")
        self.assertEqual(scenario.trials, 100)

    def test_overrides_are_equal_as_dict_and_as_list(self):
        as_dict = self.scenario({"objects.0.count": 4, "estimator.name": "ppf", "camera.eye_m": np.array([0, -0.1, 0.9])})
        as_list = self.scenario(["objects.0.count=4", "estimator.name=ppf", "camera.eye_m=[0, -0.1, 0.9]"])
        self.assertEqual(as_dict.settings, as_list.settings)
        self.assertEqual(as_dict.settings["objects"][0]["count"], 4)
        self.assertEqual(as_dict.settings["camera"]["eye_m"], [0, -0.1, 0.9])
        self.assertEqual(self.scenario(trials=9).trials, 9)
        self.assertEqual(self.scenario({"gripper": ["jaw_8cm", "cup_30mm"]}).settings["gripper"], ["jaw_8cm", "cup_30mm"])

    def test_the_text_is_equal_to_the_one_of_a_run(self):
        self.program("run", self.scenario_file, "--out", "run", "--pictures", 0, "--trials", 1, "--set",
                     "policy.max_attempts=1")
        scenario = self.scenario(["policy.max_attempts=1"], trials=1)
        self.assertEqual(scenario.text(), (self.folder / "run/scenario.yaml").read_text())

    def test_the_camera_projects_its_target_to_the_image_center(self):
        scenario = self.scenario()
        target_W = np.append(scenario.settings["camera"]["target_m"], 1)
        target_C = np.linalg.inv(scenario.X_WC) @ target_W
        u, v, w = scenario.camera.K @ target_C[:3]
        np.testing.assert_allclose([u / w, v / w], [scenario.camera.cx, scenario.camera.cy], atol=1e-9)

    def test_arrays_share_the_memory_of_the_mesh(self):
        ring = pickbed.load_object("ring")
        vertices = ring.vertices_O_m
        self.assertEqual(vertices.__array_interface__["data"], ring.vertices_O_m.__array_interface__["data"])
        self.assertFalse(vertices.flags.writeable)
        self.assertEqual(vertices.dtype, np.float64)
        del ring  # the array keeps the object
        spread_m = np.linalg.norm(vertices - vertices.mean(axis=0), axis=1).max()
        self.assertAlmostEqual(2 * spread_m, pickbed.load_object("ring").diameter_m, delta=0.1 * spread_m)

    def test_symmetry_transforms_map_the_ring_onto_itself(self):
        ring = pickbed.load_object("ring")
        transforms = ring.symmetry_transforms(steps=8)
        np.testing.assert_array_equal(transforms[0], np.eye(4))
        vertices = ring.vertices_O_m
        for X in transforms[1:4]:
            moved = vertices @ X[:3, :3].T + X[:3, 3]
            gap_m = np.linalg.norm(moved[:20, None] - vertices[None], axis=2).min(axis=1).max()
            self.assertLess(gap_m, 0.05 * ring.diameter_m)

    def test_tables_name_the_rows_of_the_program(self):
        for names, kind in [(pickbed.estimator_names(), "estimators"), (pickbed.planner_names(), "planners"),
                            (pickbed.gripper_names(), "grippers"), (pickbed.sensor_names(), "sensors"),
                            (pickbed.object_names(), "objects"), (pickbed.preset_names(), "presets")]:
            listed = self.program("list", kind)
            for name in names:
                self.assertRegex(listed, rf"(?m)^\s*{name} ")
            self.assertTrue(names, kind)


class BadScenarios(support.TestCase):
    def test_each_fault_is_one_line(self):
        self.refused("did you mean 'clutter'", lambda: pickbed.Scenario("cluter"))
        self.refused("the scenario drops nothing", lambda: self.scenario({"objects": []}))
        self.refused("trials", lambda: self.scenario({"trials": "many"}))
        self.refused("frictoin", lambda: self.scenario({"bin.frictoin": 0.5}))
        self.refused("a setting has a value of type object", lambda: self.scenario({"seed": object()}))
        self.refused("settings must be a dict", lambda: self.scenario("seed=3"))
        self.refused("settings must be a dict", lambda: self.scenario([3]))
        self.refused("gone.obj", lambda: pickbed.load_mesh_object("gone.obj"))
        self.refused("unknown object 'rign'", lambda: pickbed.load_object("rign"))

    def test_a_camera_matrix_is_checked(self):
        K = [[600, 0, 320], [0, 600, 240], [0, 0, 1]]
        self.assertEqual(pickbed.CameraIntrinsics.from_matrix(K, 640, 480).fx, 600)
        make = pickbed.CameraIntrinsics.from_matrix
        self.refused("K must be 3 x 3, not 2 x 3", lambda: make(K[:2], 640, 480))
        self.refused("fx", lambda: make([[np.nan, 0, 320], [0, 600, 240], [0, 0, 1]], 640, 480))
        self.refused("K must be [[fx, 0, cx]", lambda: make([[600, 1, 320], [0, 600, 240], [0, 0, 1]], 640, 480))
        self.refused("K must be a camera matrix of 3 x 3 numbers, not an array of <U1", lambda: make("K", 640, 480))
        self.refused("width", lambda: pickbed.CameraIntrinsics(0, 480, 600, 600, 320, 240))


class WrongArguments(support.TestCase):
    """Arguments of wrong types. The text of pybind11 has several lines and names no argument."""

    def wrong(self, words, call):
        self.refused(words, call, TypeError)

    def test_the_argument_the_type_and_the_value_are_in_one_line(self):
        X, camera = np.eye(4), pickbed.CameraIntrinsics(64, 48, 60, 60, 32, 24)
        ring = pickbed.load_object("ring")
        model = pickbed.MetricModel(ring)
        self.wrong("Grasp(): width_m must be a number, not 'wide' of type str", lambda: pickbed.Grasp(X, "wide"))
        self.wrong("hypothesis must be a whole number, not 0.5 of type float", lambda: pickbed.Grasp(X, 0.1, hypothesis=0.5))
        self.wrong("tool must be a text, not 3 of type int", lambda: pickbed.Grasp(X, 0.1, tool=3))
        self.wrong("PoseHypothesis(): object must be a whole number, not 'ring'", lambda: pickbed.PoseHypothesis("ring", X))
        self.wrong("mssd_m(): model must be a MetricModel, not a value of type ObjectModel", lambda: pickbed.mssd_m(ring, X, X))
        self.wrong("camera must be a CameraIntrinsics, not a value of type ndarray",
                   lambda: pickbed.vsd(model, camera.K, X, X, np.zeros((48, 64), np.float32), [0.1]))
        self.wrong("Cell(): scenario must be a Scenario, not 'bin_ring'", lambda: pickbed.Cell("bin_ring"))
        self.wrong("scenario must be a Scenario, not None", lambda: pickbed.BinPickingEnv(None))
        self.wrong("from_matrix(): width must be a whole number, not 64.5",
                   lambda: pickbed.CameraIntrinsics.from_matrix(camera.K, 64.5, 48))
        self.wrong("width = 1099511627776 of type int is out of range", lambda: pickbed.CameraIntrinsics(1 << 40, 48, 60, 60, 32, 24))

    def test_items_of_lists_are_named(self):
        self.wrong("before[1] must be a list of 2 values, not 3 of type int",
                   lambda: pickbed.paired_interval([(1, 2), 3], [(1, 2), (1, 2)]))
        self.wrong("clusters[0][1] must be a whole number, not 'x'", lambda: pickbed.cluster_interval([(1, "x")]))
        self.wrong("values[0][1] must be a number, not None", lambda: pickbed.median_interval([[1, None]]))

    def test_missing_and_unknown_arguments_are_named(self):
        self.wrong("Grasp(): width_m is missing; it takes (X_WG, width_m, score=1.0", lambda: pickbed.Grasp(np.eye(4)))
        self.wrong("there is no argument widht_m", lambda: pickbed.Grasp(np.eye(4), 0.1, widht_m=0.1))
        self.wrong("X_WG is given twice", lambda: pickbed.Grasp(np.eye(4), 0.1, X_WG=np.eye(4)))
        self.wrong("4 arguments are given; it takes (successes, attempts, confidence=0.95)",
                   lambda: pickbed.wilson_interval(1, 2, 0.9, 4))

    def test_right_arguments_keywords_and_subclasses_work(self):
        class Mine(pickbed.Grasp):
            def __init__(self):
                super().__init__(width_m=np.float32(0.25), X_WG=np.eye(4), hypothesis=np.int64(3))

        self.assertEqual((Mine().width_m, Mine().hypothesis), (0.25, 3))
        self.assertTrue(pickbed.mssd_m.__doc__.startswith("mssd_m(model: pickbed.MetricModel"))

    def test_a_broken_condition_is_a_value_error(self):
        ring = pickbed.load_object("ring")
        self.refused("at least one step", lambda: ring.symmetry_transforms(0), ValueError)
        self.assertIn("ValueError for steps < 1", ring.symmetry_transforms.__doc__)
        self.assertIn("ValueError if the numbers of units differ", pickbed.paired_interval.__doc__)
        self.refused("the same units", lambda: pickbed.paired_interval([(1, 2)], []), ValueError)


if __name__ == "__main__":
    support.main()
