"""Helpers of the tests of the Python module.

ctest sets PYTHONPATH to the folder of the module, PICKBED to the program and PICKBED_TEST_DATA to the
folder of real data.
"""

import os
import subprocess
import tempfile
import unittest
from pathlib import Path

import pickbed

# Ground truth poses with noise, so that some picks fail. No network.
SMALL = """seed: 7
trials: 3
objects:
  - {name: rod, count: 3}
  - {name: flange, count: 2}
estimator: {name: oracle, noise_mm: 5}
policy: {max_failures_in_row: 3}
"""


class TestCase(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="pickbed_python_")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        self.scenario_file = self.folder / "small.yaml"
        self.scenario_file.write_text(SMALL)

    def scenario(self, settings=None, **arguments):
        return pickbed.Scenario(self.scenario_file, settings, **arguments)

    def program(self, *arguments):
        """Runs pickbed and returns its standard output."""
        done = subprocess.run([os.environ["PICKBED"], *map(str, arguments)], cwd=self.folder,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        self.assertEqual(done.returncode, 0, done.stderr.decode())
        return done.stdout.decode()

    def refused(self, words, call, error=pickbed.InputError):
        """Expects one line with the words from the call."""
        with self.assertRaises(error) as caught:
            call()
        text = str(caught.exception)
        self.assertIn(words, text)
        self.assertNotIn("\n", text)


def main():
    unittest.main(verbosity=2)
