#pragma once

// Grasps and hypotheses from Python.

#include <pybind11/pybind11.h>

#include <string>

#include "eval/layer.h"
#include "grasp/grasp.h"
#include "perception/pose_hypothesis.h"

namespace pickbed::eval {

// Makes a grasp of checked values. Throws InputError for a pose that is none, a position further
// than 20 m away, a width outside 0 to 10 m, or a score that is not finite.
Grasp MakeGrasp(pybind11::handle X_WG, double width_m, double score, int hypothesis,
                const std::string& tool);

// Makes a hypothesis of checked values. Throws InputError for a pose that is none, or a score
// outside 0 to 1.
PoseHypothesis MakeHypothesis(int object, pybind11::handle X_CO, double score);

}  // namespace pickbed::eval
