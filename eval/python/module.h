#pragma once

// The Python module `pickbed`, one function per group of classes. They are called in this order,
// because a signature shows the Python name of a class only if the class was added before.

#include <pybind11/pybind11.h>

#include "eval/layer.h"

namespace pickbed::eval {

void AddScenarios(pybind11::module_& module);   // Scenario, ObjectModel, CameraIntrinsics, tables
void AddMetrics(pybind11::module_& module);     // MetricModel and the pose errors
void AddIntervals(pybind11::module_& module);   // rates and medians with intervals
void AddRecords(pybind11::module_& module);     // Grasp, PoseHypothesis, AttemptRecord, ...
void AddCell(pybind11::module_& module);        // Cell
void AddPickingEnv(pybind11::module_& module);  // BinPickingEnv

}  // namespace pickbed::eval
