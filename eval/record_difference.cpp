#include "eval/record_difference.h"

#include <fmt/format.h>

#include <functional>
#include <vector>

#include "eval/results_rows.h"

namespace pickbed {
namespace {

struct Cell {
  std::string column, value;
};

template <typename T>
std::string ValueText(const T& value) {
  if constexpr (std::is_same_v<T, Loss>) {
    return std::string(LossName(value));
  } else if constexpr (std::is_same_v<T, Pose>) {
    std::string numbers;
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 4; ++column) {
        numbers += fmt::format("{}{}", numbers.empty() ? "" : " ", value.matrix()(row, column));
      }
    }
    return "[" + numbers + "]";
  } else {
    return fmt::format("{}", value);
  }
}

// A row as the store would hold it.
template <typename Row>
std::vector<Cell> CellsOf(Row row, const std::function<bool(const std::string&)>& wanted) {
  std::vector<Cell> cells;
  row.Visit([&](const char* column, const auto& value) {
    if (wanted(column)) cells.push_back({column, ValueText(value)});
  });
  return cells;
}

std::string FirstUnequal(const std::string& what, const std::vector<Cell>& recorded,
                         const std::vector<Cell>& replayed) {
  for (size_t i = 0; i < recorded.size(); ++i) {
    if (recorded[i].value == replayed[i].value) continue;
    return fmt::format("{}{}: {} recorded, {} replayed", what, recorded[i].column,
                       recorded[i].value, replayed[i].value);
  }
  return "";
}

std::string HypothesesDiffer(const PickRecord& recorded, const PickRecord& replayed) {
  const auto& a = recorded.hypotheses;
  const auto& b = replayed.hypotheses;
  const auto wanted = [](const std::string& column) {
    return column == "object" || column == "score" || column == "x_wo";
  };
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const std::string found = FirstUnequal(fmt::format("hypotheses[{}].", i),
                                           CellsOf(HypothesisRow{0, 0, 0, a[i]}, wanted),
                                           CellsOf(HypothesisRow{0, 0, 0, b[i]}, wanted));
    if (!found.empty()) return found;
  }
  if (a.size() == b.size()) return "";
  return fmt::format("hypotheses: {} recorded, {} replayed", a.size(), b.size());
}

// `rest` is what the hash knows beyond the parts in view.
std::string PartsDiffer(const PickRecord& recorded, const PickRecord& replayed, const char* rest) {
  const auto& a = recorded.instances;
  const auto& b = replayed.instances;
  const auto wanted = [](const std::string& column) {
    return column == "instance" || column == "object" || column == "visible_fraction";
  };
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const std::string found =
        FirstUnequal(fmt::format("parts[{}].", i), CellsOf(InstanceRow{0, 0, a[i]}, wanted),
                     CellsOf(InstanceRow{0, 0, b[i]}, wanted));
    if (!found.empty()) return found;
  }
  if (a.size() != b.size()) {
    return fmt::format("parts: {} recorded, {} replayed", a.size(), b.size());
  }
  return fmt::format("the hash alone: the record holds no number of {}", rest);
}

std::string PickDiffers(const PickRecord& recorded, const PickRecord& replayed,
                        const std::function<bool(const std::string&)>& wanted) {
  const auto cells_of = [&](const PickRecord& record) {
    return CellsOf(PickRow{0, record, record.grasp.has_value(), record.grasp.value_or(Grasp())},
                   wanted);
  };
  return FirstUnequal("", cells_of(recorded), cells_of(replayed));
}

bool IsOfGrasp(const std::string& column) {
  return column == "executed" || column.starts_with("grasp_");
}

std::string RejectionsDiffer(const PickRecord& recorded, const PickRecord& replayed) {
  const auto text_of = [](const PickRecord& record) {
    std::string text;
    for (const auto& [cause, grasps] : record.grasps_rejected) {
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", cause, grasps);
    }
    return text.empty() ? std::string("none") : text;
  };
  const std::string a = text_of(recorded), b = text_of(replayed);
  return a == b ? "" : fmt::format("grasps rejected: {} recorded, {} replayed", a, b);
}

}  // namespace

std::string WhatDiffers(TrialStage stage, const PickRecord& recorded, const PickRecord& replayed) {
  switch (stage) {
    case TrialStage::kScene:
      return PartsDiffer(recorded, replayed, "the bin and of where the parts lie");
    case TrialStage::kImage:
      return PartsDiffer(recorded, replayed, "pixels");
    case TrialStage::kHypotheses:
      return HypothesesDiffer(recorded, replayed);
    case TrialStage::kGrasp: {
      const std::string grasp = PickDiffers(recorded, replayed, IsOfGrasp);
      return grasp.empty() ? RejectionsDiffer(recorded, replayed) : grasp;
    }
    case TrialStage::kOutcome:
      return PickDiffers(recorded, replayed, [](const std::string& column) {
        return !IsOfGrasp(column) && !column.starts_with("hash_");
      });
  }
  return "";
}

}  // namespace pickbed
