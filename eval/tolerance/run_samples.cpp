// Executes a tolerance study over several processes and reads and writes the file of its outcomes.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "eval/tolerance/samples.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/math.h"

namespace pickbed::eval {
namespace {

constexpr int kChunk = 16;                               // samples per work item
constexpr const char* kFormerSamplesFile = "tries.csv";  // of earlier versions
constexpr const char* kVersion = "pickbed tolerance 1";

// Header line that identifies a study. Files with another line belong to another study.
std::string IdentityLine(const ToleranceStudy& study) {
  const ObjectModel& object = *study.table.objects[0];
  ToleranceOptions options = study.options;
  const Gripper& gripper = *study.table.gripper;
  std::string text =
      fmt::format("{:016x} {} {}\n", object.mesh_hash, object.mass.mass_kg, object.friction);
  text += gripper.SettingsText();
  text += WriteSettingsKey([&](SettingsVisitor& v) { options.Visit(v); });
  for (const PlannedSample& sample : study.samples) {
    const Pose X_WG = study.table.places[study.grasps[sample.grasp].place].scene.objects[0].X_WO *
                      sample.X_OE * study.grasps[sample.grasp].candidate.X_OG;
    text.append(reinterpret_cast<const char*>(X_WG.data()), 16 * sizeof(double));
  }
  return fmt::format("# {}: {} {} {:016x}\n", kVersion, object.name, gripper.name,
                     HashBytes(text.data(), text.size()));
}

std::string Row(const ToleranceStudy& study, int index, const SampleOutcome& outcome) {
  const PlannedSample& sample = study.samples[index];
  const auto axis = [&](int i) {
    return sample.axis[i] < 0 ? "" : ErrorAxisTable()[sample.axis[i]].name;
  };
  const PoseOffset e = ToPoseOffset(sample.X_OE);
  const double mm = 1e3, deg = kDegreesPerRadian;
  return fmt::format("{},{},{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{}\n",
                     index, SampleKindName(sample.kind), axis(0), sample.level[0], axis(1),
                     sample.level[1], study.grasps[sample.grasp].place, sample.grasp, mm * e[0],
                     mm * e[1], mm * e[2], deg * e[3], deg * e[4], deg * e[5],
                     outcome.success ? 1 : 0, FailureName(outcome.failure));
}

// Outcomes of all complete lines. A line that was cut off by a kill has no line end and is ignored.
std::vector<std::optional<SampleOutcome>> ReadOutcomes(const ToleranceStudy& study,
                                                       const std::filesystem::path& file) {
  std::vector<std::optional<SampleOutcome>> outcomes(study.samples.size());
  std::istringstream in(ReadFileBytes(file));
  std::string line;
  while (std::getline(in, line) && !in.eof()) {
    int index = -1;
    if (std::sscanf(line.c_str(), "%d,", &index) != 1) continue;
    const size_t last = line.rfind(',');
    if (last == std::string::npos || last < 2 || index < 0 ||
        index >= static_cast<int>(outcomes.size())) {
      continue;
    }
    const auto failure = FailureFromName(line.substr(last + 1));
    if (!failure) continue;
    outcomes[index] = SampleOutcome{line[last - 1] == '1', *failure};
  }
  return outcomes;
}

std::string WholeFile(const ToleranceStudy& study,
                      const std::vector<std::optional<SampleOutcome>>& outcomes) {
  std::string text = IdentityLine(study) + HeaderLine(SamplesColumns());
  for (size_t i = 0; i < outcomes.size(); ++i) {
    if (outcomes[i]) text += Row(study, static_cast<int>(i), *outcomes[i]);
  }
  return text;
}

std::vector<std::optional<SampleOutcome>> KeptOutcomes(const ToleranceStudy& study,
                                                       const std::filesystem::path& file,
                                                       bool resume) {
  if (!std::filesystem::exists(file))
    return std::vector<std::optional<SampleOutcome>>(study.samples.size());
  std::ifstream in(file);
  std::string first;
  std::getline(in, first);
  CheckInput(first + "\n" == IdentityLine(study),
             fmt::format("{}: has another tolerance map, or one with other settings; choose "
                         "another results folder",
                         file.string()));
  CheckInput(resume, fmt::format("{}: already has outcomes of this tolerance map; resume it, or "
                                 "choose another results folder",
                                 file.string()));
  return ReadOutcomes(study, file);
}

// Reply of a worker: one line "index success failure" per sample.
std::string ReplyOf(const ToleranceStudy& study, const std::vector<int>& samples) {
  std::string reply;
  for (const int index : samples) {
    const PlannedSample& sample = study.samples[index];
    const GraspOutcome outcome = ExecuteWithError(study.table, study.grasps[sample.grasp],
                                                  sample.X_OE, study.options.execute);
    reply +=
        fmt::format("{} {} {}\n", index, outcome.success ? 1 : 0, FailureName(outcome.failure));
  }
  return reply;
}

}  // namespace

ResultColumns SamplesColumns() {
  return {
      {"sample", "number of the sample"},
      {"kind", "purpose: axis (curve), pair (map of two axes), fit (of the model), test"},
      {"axis", "axis of the pose error; empty for a random error"},
      {"level", "error along the axis", "steps"},
      {"axis_2", "second axis of a pair"},
      {"level_2", "error along the second axis", "steps"},
      {"place", "number of the resting pose on the table"},
      {"grasp", "number of the grasp"},
      {"dx_mm", "position error in the object frame, x"},
      {"dy_mm", "position error in the object frame, y"},
      {"dz_mm", "position error in the object frame, z"},
      {"rx_deg", "rotation vector of the error in the object frame, x"},
      {"ry_deg", "rotation vector of the error in the object frame, y"},
      {"rz_deg", "rotation vector of the error in the object frame, z"},
      {"success", "1 if the grasp succeeded"},
      {"failure", "failure reason, see `pickbed list failures`"},
  };
}

StudyOutcomes ExecuteStudy(const ToleranceStudy& study, const std::filesystem::path& folder,
                           int jobs, bool resume, const StudyListener& listener) {
  const std::filesystem::path file = folder / kSamplesFile, former = folder / kFormerSamplesFile;
  std::vector<std::optional<SampleOutcome>> known =
      KeptOutcomes(study, std::filesystem::exists(file) ? file : former, resume);
  std::vector<std::vector<int>> chunks;
  for (size_t i = 0; i < known.size(); ++i) {
    if (known[i]) continue;
    if (chunks.empty() || chunks.back().size() == kChunk) chunks.emplace_back();
    chunks.back().push_back(static_cast<int>(i));
  }
  WriteFileAtomically(file, WholeFile(study, known));
  std::filesystem::remove(former);

  const int total = static_cast<int>(known.size());
  const int before = static_cast<int>(
      std::count_if(known.begin(), known.end(), [](const auto& o) { return o.has_value(); }));
  int done = before;
  WorkerPlan plan;
  plan.jobs = jobs;
  for (size_t i = 0; i < chunks.size(); ++i) plan.items.push_back(static_cast<int>(i));
  plan.start = [&](const WorkerPlan::Say&) {
    return [&](int chunk) { return ReplyOf(study, chunks[chunk]); };
  };
  plan.on_done = [&](int, const std::string& reply) {
    std::istringstream lines(reply);
    int index = 0, success = 0;
    std::string failure, rows;
    while (lines >> index >> success >> failure) {
      known[index] = SampleOutcome{
          success == 1, FailureFromName(failure).value_or(FailureReason::kPhysicsFailed)};
      rows += Row(study, index, *known[index]);
      ++done;
    }
    AppendToFile(file, rows);
    if (listener.on_progress) listener.on_progress(done, total, before);
  };
  plan.stop = listener.stop;
  WorkReport work = RunInWorkers(plan);

  StudyOutcomes result;
  result.interrupted = work.stopped;
  result.lost = std::move(work.lost);
  if (done == total) {
    WriteFileAtomically(file, WholeFile(study, known));
    for (const auto& outcome : known) result.outcomes.push_back(*outcome);
  }
  return result;
}

}  // namespace pickbed::eval
