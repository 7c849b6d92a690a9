#!/usr/bin/python3
"""The picking environment gives the same records as a run of the program."""

import os
import signal
import threading
import time

import numpy as np
import pickbed

import support

# The hand points down, 30 cm above the floor.
IN_THE_AIR = np.array([[1, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0.3], [0, 0, 0, 1]], float)
FILES = ["scenario.yaml", "summary.json", "trials.csv", "attempts.csv", "instances.csv", "instance_outcomes.csv"]


def play(env, seed, episodes, choose=None):
    """Steps with the grasps that pickbed chooses. Returns the records."""
    records = []
    for episode in range(episodes):
        env.reset(seed=seed if episode == 0 else None)
        done = False
        while not done:
            _, reward, terminated, truncated, info = env.step(choose(env) if choose else env.choose_grasp())
            records.append(info["record"])
            done = terminated or truncated
            assert reward == (info["record"].failure == "none")
    return records


class SameRecords(support.TestCase):
    def compare(self, settings, episodes):
        options = [word for setting in settings for word in ("--set", setting)]
        self.program("run", self.scenario_file, *options, "--trials", episodes, "--pictures", 0, "--failure-pictures", 0,
                     "--jobs", 1, "--out", "run")
        env = pickbed.BinPickingEnv(self.scenario(settings, trials=episodes))
        records = play(env, None, episodes)
        env.write(self.folder / "mine")
        for name in FILES:
            self.assertEqual((self.folder / "mine" / name).read_bytes(), (self.folder / "run" / name).read_bytes(), name)
        return records

    def test_files_are_equal_byte_by_byte(self):
        records = self.compare([], 3)
        self.assertGreater(len(records), 8)
        self.assertGreater(sum(r.failure != "none" for r in records), 0)

    def test_also_with_another_seed_and_cell_errors(self):
        self.compare(["seed=3", "cell.size_percent=1", "cell.hand_eye_mm=1", "policy.max_attempts=3"], 2)

    def test_also_with_several_picks_per_image(self):
        records = self.compare(["policy.picks_per_image=3", "estimator.noise_mm=0", "bin.inner_size_m=[0.5, 0.4, 0.1]"], 1)
        self.assertTrue(any(r.pick_of_image > 0 for r in records))

    def test_also_without_poses_and_with_stirs(self):
        self.compare(["planner.name=cloud_antipodal", "policy.stir.max=2", "policy.max_attempts=4"], 1)

    def test_records_are_equal_to_those_of_a_cell(self):
        scenario = self.scenario()
        env = pickbed.BinPickingEnv(scenario)
        records = play(env, 7, 1)
        trial = pickbed.Cell(scenario).run_trial(0)
        self.assertEqual([r.hashes for r in records], [r.hashes for r in trial.attempts])
        self.assertTrue(all(value != 0 for r in records for value in r.hashes.values()))
        self.assertEqual(env.trials[0].instances_cleared, trial.instances_cleared)

    def test_a_seed_gives_the_bins_of_the_scenario_with_this_seed(self):
        env = pickbed.BinPickingEnv(self.scenario())
        first, _ = env.reset(seed=7)
        other, _ = env.reset(seed=8)
        again, info = env.reset(seed=7)
        np.testing.assert_array_equal(first["depth_m"], again["depth_m"])
        self.assertFalse(np.array_equal(first["depth_m"], other["depth_m"]))
        self.assertEqual(info["bin_index"], 0)
        following, info = env.reset()
        self.assertEqual(info["bin_index"], 1)
        chosen, _ = env.reset(seed=7, options={"bin_index": 1})
        np.testing.assert_array_equal(following["depth_m"], chosen["depth_m"])


class OwnGrasps(support.TestCase):
    def setUp(self):
        super().setUp()
        self.env = pickbed.BinPickingEnv(self.scenario())

    def test_observation_has_the_types_that_the_documentation_names(self):
        observation, info = self.env.reset(seed=7)
        self.assertEqual(set(observation), {"color", "depth_m", "K", "X_WC"})
        self.assertEqual((observation["color"].dtype, observation["depth_m"].dtype), (np.uint8, np.float32))
        self.assertEqual(observation["color"].shape, observation["depth_m"].shape + (3,))
        self.assertEqual(info, {"bin_index": 0, "attempt": 0, "instances_left": 5})

    def test_a_grasp_on_a_true_pose_picks_without_an_estimate(self):
        # The same place as the grasp that pickbed chooses, given as a pose of the hand.
        self.env.reset(seed=7, options={"bin_index": 1})
        chosen = self.env.choose_grasp()
        self.env.reset(seed=7, options={"bin_index": 1})
        observation, reward, terminated, truncated, info = self.env.step(chosen.X_WG)
        record = info["record"]
        self.assertTrue(record.pose_free)
        self.assertEqual(record.hypotheses, [])
        self.assertEqual(reward, 1)
        self.assertEqual(info["instances_left"], 4)
        self.assertFalse(terminated or truncated)
        self.assertNotEqual(record.outcome.picked_instance, -1)

    def test_a_grasp_in_the_air_closes_on_nothing(self):
        self.env.reset(seed=7)
        _, reward, _, _, info = self.env.step(pickbed.Grasp(IN_THE_AIR, 0.03))
        self.assertEqual((reward, info["record"].failure), (0, "closed_on_nothing"))

    def test_no_grasp_ends_the_episode_and_the_bin_stays(self):
        before, _ = self.env.reset(seed=7)
        after, reward, terminated, truncated, info = self.env.step(None)
        self.assertEqual((reward, info["record"].failure), (0, "no_grasp"))
        self.assertEqual((terminated, truncated, info["instances_left"]), (True, False, 5))
        np.testing.assert_array_equal(before["color"], after["color"])
        self.assertEqual(self.env.trials[0].ended_by, "no_grasp")
        self.assertEqual(self.env.view.attempt, 1)

    def test_failures_in_a_row_terminate_and_the_limit_of_attempts_truncates(self):
        for limit, ends in ((0, [(False, False), (False, False), (True, False)]), (2, [(False, False), (False, True)])):
            env = pickbed.BinPickingEnv(self.scenario({"policy.max_attempts": limit}))
            env.reset(seed=7)
            self.assertEqual([env.step(pickbed.Grasp(IN_THE_AIR, 0.03))[2:4] for _ in ends], ends)

    def test_own_grasps_of_an_unfinished_episode_leave_no_trace(self):
        self.env.reset(seed=7)
        self.env.step(IN_THE_AIR)
        self.env.reset(options={"bin_index": 0})
        done = False
        while not done:
            _, _, terminated, truncated, _ = self.env.step(self.env.choose_grasp())
            done = terminated or truncated
        self.env.write(self.folder / "mine")
        self.program("run", self.scenario_file, "--trials", 2, "--set", "seed=7", "--pictures", 0, "--jobs", 1,
                     "--out", "mine", "--resume")

    def test_a_run_with_own_grasps_cannot_continue_a_run_of_the_program(self):
        play(self.env, 7, 1, choose=lambda env: None)
        self.env.write(self.folder / "mine")
        self.refused("already has", lambda: self.env.write(self.folder / "mine"))
        self.assertIn("no_grasp", (self.folder / "mine/attempts.csv").read_text())
        with self.assertRaises(AssertionError) as refused:
            self.program("run", self.scenario_file, "--out", "mine", "--resume")
        self.assertIn("other settings (the stored run has grasps of a caller, this one has none)", str(refused.exception))
        self.program("report", "mine")


class BadEnvInput(support.TestCase):
    def setUp(self):
        super().setUp()
        self.env = pickbed.BinPickingEnv(self.scenario())

    def test_each_fault_is_one_line(self):
        env = self.env
        self.refused("there is no episode", lambda: env.step(None))
        self.refused("there is no episode", lambda: env.view)
        self.refused("no finished trial", lambda: env.write(self.folder / "mine"))
        self.refused("seed = -1", lambda: env.reset(seed=-1))
        self.refused("seed = 'a'", lambda: env.reset(seed="a"))
        self.refused("unknown option 'bin'", lambda: env.reset(options={"bin": 3}))
        self.refused("bin_index = 0.5", lambda: env.reset(options={"bin_index": 0.5}))
        env.reset(seed=np.int64(7))
        self.refused("X_WG must be 4 x 4, not 2", lambda: env.step([1, 2]))
        self.refused("hypothesis 0, but the attempt has 0", lambda: env.step(pickbed.Grasp(np.eye(4), 0.02, hypothesis=0)))
        self.refused("width_m = 0.5: gripper jaw_8cm opens at most 0.08 m", lambda: env.step(pickbed.Grasp(np.eye(4), 0.5)))
        self.refused("unknown gripper", lambda: env.step(pickbed.Grasp(np.eye(4), 0.02, tool="claw")))
        self.assertEqual(env.step(env.choose_grasp())[1], 1)  # a refused step has not changed the episode
        self.refused("occlusion.enabled", lambda: pickbed.BinPickingEnv(self.scenario({"occlusion.enabled": True})))
        self.refused("unknown gripper", lambda: pickbed.BinPickingEnv(self.scenario({"gripper": "claw"})))
        play(env, 7, 1, choose=lambda env: None)
        self.refused("the episode has ended", lambda: env.step(None))
        env.reset(seed=7, options={"bin_index": 2})
        env.step(None)
        self.refused("finished episode 0 has bin 2", lambda: env.write(self.folder / "mine"))

    def is_interrupted(self):
        try:
            return self.env.view is None
        except pickbed.InputError:
            return True

    def test_ctrl_c_ends_a_step(self):
        # The first image of a seed is captured in reset(), so a step begins with the physics. On a fast machine, a
        # step can end before the signal.
        for delay_s in (0.04, 0.02, 0.01, 0.005):
            self.env.reset(seed=7)
            grasp = self.env.choose_grasp()
            timer = threading.Timer(delay_s, os.kill, (os.getpid(), signal.SIGINT))
            with self.assertRaises(KeyboardInterrupt):
                timer.start()
                self.env.step(grasp)
                timer.join()
                time.sleep(0.1)
            if self.is_interrupted():
                break
        self.assertTrue(self.is_interrupted(), "each step ended before its signal")
        self.refused("the last step was interrupted", lambda: self.env.step(grasp))
        self.refused("the last step was interrupted", lambda: self.env.view)
        self.env.reset(seed=7)
        self.assertEqual(self.env.step(self.env.choose_grasp())[1], 1)

    def test_other_threads_run_during_a_step(self):
        count, done = [0], threading.Event()

        def work():
            while not done.is_set():
                count[0] += 1
                time.sleep(0.0005)

        self.env.reset(seed=7)
        grasp = self.env.choose_grasp()
        thread = threading.Thread(target=work)
        thread.start()
        before = count[0]
        self.env.step(grasp)
        done.set()
        thread.join()
        self.assertGreater(count[0] - before, 5)


if __name__ == "__main__":
    support.main()
