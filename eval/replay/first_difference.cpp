#include "eval/replay/first_difference.h"

#include <fmt/format.h>

#include <functional>
#include <vector>

#include "eval/store/schema.h"

namespace pickbed::eval {
namespace {

struct Cell {
  std::string column, value;
};

template <typename T>
std::string ValueText(const T& value) {
  if constexpr (std::is_same_v<T, FailureReason>) {
    return std::string(FailureName(value));
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

// Returns the wanted columns of a row, as the store holds them.
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

std::string HypothesesDiffer(const AttemptRecord& recorded, const AttemptRecord& replayed) {
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

// `rest` names the content of the hash besides the visible instances.
std::string InstancesDiffer(const AttemptRecord& recorded, const AttemptRecord& replayed,
                            const char* rest) {
  const auto& a = recorded.instances;
  const auto& b = replayed.instances;
  const auto wanted = [](const std::string& column) {
    return column == "instance" || column == "object" || column == "visible_fraction";
  };
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    const std::string found =
        FirstUnequal(fmt::format("instances[{}].", i), CellsOf(InstanceRow{0, 0, a[i]}, wanted),
                     CellsOf(InstanceRow{0, 0, b[i]}, wanted));
    if (!found.empty()) return found;
  }
  if (a.size() != b.size()) {
    return fmt::format("instances: {} recorded, {} replayed", a.size(), b.size());
  }
  return fmt::format("only the hash: the record has no number of {}", rest);
}

std::string AttemptDiffers(const AttemptRecord& recorded, const AttemptRecord& replayed,
                           const std::function<bool(const std::string&)>& wanted) {
  const auto cells_of = [&](const AttemptRecord& record) {
    return CellsOf(AttemptRow{0, record, record.grasp.has_value(), record.grasp.value_or(Grasp())},
                   wanted);
  };
  return FirstUnequal("", cells_of(recorded), cells_of(replayed));
}

bool IsOfGrasp(const std::string& column) {
  return column == "executed" || column.starts_with("grasp_");
}

std::string RejectionsDiffer(const AttemptRecord& recorded, const AttemptRecord& replayed) {
  const auto text_of = [](const AttemptRecord& record) {
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

std::string WhatDiffers(TrialStage stage, const AttemptRecord& recorded,
                        const AttemptRecord& replayed) {
  switch (stage) {
    case TrialStage::kScene:
      return InstancesDiffer(recorded, replayed, "the bin and of the poses of the instances");
    case TrialStage::kImage:
      return InstancesDiffer(recorded, replayed, "pixels");
    case TrialStage::kHypotheses:
      return HypothesesDiffer(recorded, replayed);
    case TrialStage::kGrasp: {
      const std::string grasp = AttemptDiffers(recorded, replayed, IsOfGrasp);
      return grasp.empty() ? RejectionsDiffer(recorded, replayed) : grasp;
    }
    case TrialStage::kOutcome:
      return AttemptDiffers(recorded, replayed, [](const std::string& column) {
        return !IsOfGrasp(column) && !column.starts_with("hash_");
      });
  }
  return "";
}

}  // namespace pickbed::eval
