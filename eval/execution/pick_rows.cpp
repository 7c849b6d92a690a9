#include "eval/execution/pick_rows.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

namespace pickbed::eval {
namespace {

constexpr size_t kCells = 15;

std::string Cell(double value) { return std::isnan(value) ? "" : fmt::format("{}", value); }

std::vector<std::string> CellsOf(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else {
      cells.back() += c;
    }
  }
  return cells;
}

// Reads a number; sets `ok` to false if the cell is none.
double Number(const std::string& cell, bool& ok) {
  if (cell.empty()) return std::numeric_limits<double>::quiet_NaN();
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  ok = ok && error == std::errc() && end == cell.data() + cell.size();
  return value;
}

std::optional<ExecutedPick> ParsePickRow(const std::string& line) {
  const std::vector<std::string> cells = CellsOf(line);
  if (cells.size() != kCells) return std::nullopt;
  bool ok = true;
  const auto whole = [&](size_t i) {
    const double value = Number(cells[i], ok);
    ok = ok && std::isfinite(value);
    return ok ? static_cast<int>(value) : 0;
  };
  ExecutedPick pick;
  pick.method = cells[0];
  pick.scene_id = whole(1);
  pick.image_id = whole(2);
  pick.pick = whole(3);
  pick.object_id = whole(4);
  pick.score = Number(cells[5], ok);
  pick.instance = InstanceId(whole(6));
  pick.visible_fraction = Number(cells[7], ok);
  pick.errors = {Number(cells[8], ok), Number(cells[9], ok), Number(cells[10], ok),
                 Number(cells[11], ok), Number(cells[12], ok)};
  pick.success = cells[13] == "1";
  const auto failure = FailureFromName(cells[14]);
  if (!ok || !failure || (cells[13] != "0" && cells[13] != "1")) return std::nullopt;
  pick.failure = *failure;
  return pick;
}

}  // namespace

ResultColumns PicksColumns() {
  return {
      {"method", "name of the results file without its ending, or oracle"},
      {"scene_id", "number of the scene"},
      {"im_id", "number of the image in its scene"},
      {"pick", "number of the pick in its image, from 0"},
      {"obj_id", "object of the pose that was grasped; 0 = no grasp was found"},
      {"score", "score of this pose, as in the results file"},
      {"instance", "instance that the pose matches (MSSD under half a diameter), -1 = none"},
      {"visible_fraction", "visible fraction of this instance", "0..1"},
      {"vsd", "VSD to the nearest instance of the object, mean over BOP's ten tolerances", "0..1"},
      {"mssd_m", "MSSD to this instance"},
      {"mspd_px", "MSPD to this instance, in pixels of the image"},
      {"add_m", "ADD to this instance"},
      {"adi_m", "ADI to this instance"},
      {"success", "1 if the pick succeeded by the scenario's success rule"},
      {"failure", "failure reason; none after a success"},
  };
}

std::string PickRow(const ExecutedPick& pick) {
  const BopErrors& e = pick.errors;
  return fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", pick.method, pick.scene_id,
                     pick.image_id, pick.pick, pick.object_id, Cell(pick.score), int{pick.instance},
                     Cell(pick.visible_fraction), Cell(e.vsd), Cell(e.mssd_m), Cell(e.mspd_px),
                     Cell(e.add_m), Cell(e.adi_m), pick.success ? 1 : 0, FailureName(pick.failure));
}

std::vector<ExecutedPick> ReadPickRows(const std::string& text) {
  std::vector<ExecutedPick> picks;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line) && !lines.eof();) {
    const auto pick = ParsePickRow(line);
    if (!pick) break;
    picks.push_back(*pick);
  }
  return picks;
}

}  // namespace pickbed::eval
