#!/usr/bin/python3
"""The docstrings of the Python module are the comments of the C++ headers."""

import importlib.util
import inspect
import re
import sys
from pathlib import Path

import pickbed

import support

ROOT = Path(__file__).resolve().parents[3]
sys.dont_write_bytecode = True  # no cache files in the source tree

HEADER = """#pragma once

// Comment of the file.

namespace pickbed::eval {

// A box
// of two lines.
//
// - first,
//   second line
struct Box {
  double side_m = 0.5;  // length of a side,
                        // in metres
  int above = -1, below = -1;  // counts
  // Returns the volume; null if unknown. Throws InputError.
  std::optional<double> Volume(std::function<int(int)> f) const { return side_m; }
  bool plain;
};

enum class Color { kRed, kBlue };

// Makes a box.
template <typename T>
std::map<int, Box> Make(const T& value,
                        int count = 3);

int Undocumented();

}  // namespace pickbed::eval
"""


class Docstrings(support.TestCase):
    def read(self, text):
        spec = importlib.util.spec_from_file_location("make_docstrings", ROOT / "eval/python/make_docstrings.py")
        script = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(script)
        header = self.folder / "box.h"
        header.write_text(text)
        reader = script.Reader()
        reader.read(header)
        return reader.docs

    def test_comments_before_and_behind_declarations_are_read(self):
        self.assertEqual(self.read(HEADER), {
            "Box": "A box of two lines.\n\n- first, second line",
            "Box::side_m": "length of a side, in metres",
            "Box::above": "counts",
            "Box::below": "counts",
            "Box::Volume": "Returns the volume; None if unknown. Raises InputError.",
            "Make": "Makes a box."})

    def test_the_module_shows_the_comments_of_today(self):
        def comment_of(header, declaration):
            text = (ROOT / header).read_text()
            match = re.search(r"((?:^ *//.*\n)+)^ *" + re.escape(declaration), text, re.M)
            return re.sub(r"\s*// ?", " ", match.group(1)).strip()

        for function, header, declaration in [
                (pickbed.mssd_m, "eval/metrics/pose_errors.h", "double Mssd("),
                (pickbed.wilson_interval, "eval/stats/statistics.h", "Interval WilsonInterval("),
                (pickbed.BinPickingEnv.choose_grasp, "eval/python/picking_env.h", "const std::optional<Grasp>& ChooseGrasp(")]:
            self.assertIn(comment_of(header, declaration), function.__doc__)

    def test_each_class_and_function_has_a_docstring(self):
        for name, value in vars(pickbed).items():
            if name.startswith("_") or not (inspect.isclass(value) or callable(value)):
                continue
            self.assertTrue(value.__doc__ and len(value.__doc__.strip()) > 10, name)
            if not inspect.isclass(value):
                continue
            for method, function in vars(value).items():
                if callable(function) and not method.startswith("_"):
                    self.assertIn(".", function.__doc__ or "", f"{name}.{method}")


if __name__ == "__main__":
    support.main()
