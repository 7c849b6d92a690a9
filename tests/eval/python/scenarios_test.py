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


if __name__ == "__main__":
    support.main()
