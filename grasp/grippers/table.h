#pragma once

// Table of gripper mechanisms, and the reader of gripper files.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "grasp/gripper.h"

namespace pickbed::grasp {

// A mechanism. A new one is a class in grasp/grippers/ and a row in table.cpp.
struct GripperRow {
  const char* name;  // value of the key `mechanism`, equal to Gripper::mechanism()
  const char* help;
  std::unique_ptr<Gripper> (*make)();  // with default numbers
};

// All mechanisms that come with the program.
std::span<const GripperRow> GripperTable();

// Names of the mechanisms, in the order of the rows.
std::vector<std::string> MechanismNames(std::span<const GripperRow> rows = GripperTable());

// Reads a gripper. `name_or_path`: NAME of assets/grippers or a path that ends in .yaml. `rows`:
// the known mechanisms; a caller with its own mechanisms passes its own table. A file without the
// key `mechanism` describes the first row. Throws InputError for an unknown name or mechanism (with
// the nearest one), a key of another mechanism, a value out of range and contradicting values.
std::shared_ptr<const Gripper> LoadGripper(const std::string& name_or_path,
                                           std::span<const GripperRow> rows = GripperTable());

// Names of the files in assets/grippers.
std::vector<std::string> GripperNames();

}  // namespace pickbed::grasp
