#pragma once

// Plug-ins for tests, written in Python with pickbed_plugin.

#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace pickbed::tests {

// Debian's Python, which has the packages of packages.txt. Another one may be first in PATH.
inline constexpr char kPython[] = "/usr/bin/python3";

// Writes a Python program and returns the command that runs it.
inline std::vector<std::string> PythonCommand(const TemporaryFolder& folder,
                                              const std::string& name, const std::string& code) {
  return {kPython, folder.Write(name, code).string()};
}

// An estimator whose function has this body, indented by four spaces. `frames` counts the images
// before this one; `pose(x, score, name, R)` makes a pose at (x, 0, 0.8) m.
inline std::string EstimatorCode(const std::string& body, const std::string& needs = "") {
  return "import os, sys, time\nimport numpy as np\nimport pickbed_plugin as pb\n"
         "frames = -1\n"
         "def pose(x=0, score=0.9, name=None, R=np.eye(3), z=0.8):\n"
         "    return pb.Pose(name or known.objects[0].name, R, [x, 0, z], score)\n"
         "@pb.estimator(needs=[" +
         needs +
         "])\n"
         "def tested(frame):\n"
         "    global frames, known\n"
         "    frames += 1\n"
         "    known = frame.setup\n" +
         body + "\npb.serve()\n";
}

}  // namespace pickbed::tests
