#include "eval/replay/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "eval/replay/first_difference.h"
#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

const char* VerdictName(ReplayVerdict verdict) {
  switch (verdict) {
    case ReplayVerdict::kSame:
      return "same";
    case ReplayVerdict::kDiffers:
      return "differs";
    case ReplayVerdict::kNotRecorded:
      return "not recorded";
    case ReplayVerdict::kAltered:
      return "record altered";
    case ReplayVerdict::kOnlyRecorded:
      return "not replayed";
    case ReplayVerdict::kOnlyReplayed:
      return "not in record";
  }
  return "";
}

// Hash of the values in the record; 0 if it does not hold the values of this stage.
uint64_t HashOfRecord(TrialStage stage, const AttemptRecord& record) {
  switch (stage) {
    case TrialStage::kScene:
    case TrialStage::kImage:
      return 0;
    case TrialStage::kHypotheses:
      return HashOfHypotheses(record);
    case TrialStage::kGrasp:
      return HashOfGrasp(record);
    case TrialStage::kOutcome:
      return HashOfOutcome(record);
  }
  return 0;
}

StageReplay Compare(TrialStage stage, const AttemptRecord& recorded,
                    const AttemptRecord& replayed) {
  StageReplay row;
  row.attempt = recorded.attempt;
  row.stage = stage;
  row.recorded = recorded.hashes[stage];
  row.replayed = replayed.hashes[stage];
  const uint64_t held = HashOfRecord(stage, recorded);
  if (row.recorded == 0) row.recorded = held;  // stores of schema 4 have no hashes
  if (row.recorded == 0) {
    row.verdict = ReplayVerdict::kNotRecorded;
  } else if (held != 0 && held != row.recorded) {
    row.verdict = ReplayVerdict::kAltered;
  } else if (row.recorded != row.replayed) {
    row.verdict = ReplayVerdict::kDiffers;
  }
  if (row.verdict == ReplayVerdict::kAltered || row.verdict == ReplayVerdict::kDiffers) {
    row.what = WhatDiffers(stage, recorded, replayed);
  }
  return row;
}

std::string HashText(uint64_t hash) {
  return hash == 0 ? std::string("-") : fmt::format("{:016x}", hash);
}

bool IsDifference(const StageReplay& row) {
  return row.verdict != ReplayVerdict::kSame && row.verdict != ReplayVerdict::kNotRecorded;
}

std::string StageLine(const StageReplay& row) {
  return fmt::format("{:<9}{:<12}{:<18}{:<18}{}\n", row.attempt, StageName(row.stage),
                     HashText(row.recorded), HashText(row.replayed), VerdictName(row.verdict));
}

std::string StageLines(const std::vector<StageReplay>& stages) {
  std::string text =
      fmt::format("{:<9}{:<12}{:<18}{:<18}\n", "attempt", "stage", "recorded", "replayed");
  for (const StageReplay& row : stages) text += StageLine(row);
  return text;
}

// One line per attempt, followed by the stages that differ.
std::string AttemptLines(const std::vector<StageReplay>& stages) {
  std::string text;
  for (auto begin = stages.begin(); begin != stages.end();) {
    const auto end = std::find_if(
        begin, stages.end(), [&](const StageReplay& row) { return row.attempt != begin->attempt; });
    const auto same = std::count_if(
        begin, end, [](const StageReplay& row) { return row.verdict == ReplayVerdict::kSame; });
    text += fmt::format("attempt {}: {} of {} stages are the same\n", begin->attempt, same,
                        end - begin);
    for (; begin != end; ++begin) {
      if (IsDifference(*begin)) text += "  " + StageLine(*begin);
    }
  }
  return text;
}

}  // namespace

TrialAddress ParseTrialAddress(const std::string& text) {
  const size_t hash = text.rfind('#');
  CheckInput(hash != std::string::npos && hash > 0,
             fmt::format("{}: the trial number is missing; write RUN#TRIAL, for instance {}#0",
                         text, text));
  TrialAddress address;
  address.run = text.substr(0, hash);
  const char *begin = text.data() + hash + 1, *end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(begin, end, address.trial);
  CheckInput(error == std::errc() && stop == end && address.trial >= 0,
             fmt::format("{}: '{}' is no trial number; write a number from 0 after '#'", text,
                         text.substr(hash + 1)));
  return address;
}

std::vector<StageReplay> CompareStages(const std::vector<AttemptRecord>& recorded,
                                       const std::vector<AttemptRecord>& replayed) {
  std::vector<StageReplay> rows;
  for (size_t attempt = 0; attempt < std::max(recorded.size(), replayed.size()); ++attempt) {
    for (const TrialStage stage : kTrialStages) {
      if (attempt < std::min(recorded.size(), replayed.size())) {
        rows.push_back(Compare(stage, recorded[attempt], replayed[attempt]));
        continue;
      }
      StageReplay row;
      row.attempt = static_cast<int>(attempt);
      row.stage = stage;
      if (attempt < recorded.size()) {
        row.recorded = recorded[attempt].hashes[stage];
        row.verdict = ReplayVerdict::kOnlyRecorded;
      } else {
        row.replayed = replayed[attempt].hashes[stage];
        row.verdict = ReplayVerdict::kOnlyReplayed;
      }
      rows.push_back(row);
    }
  }
  return rows;
}

const StageReplay* ReplayReport::FirstDifference() const {
  const auto first = std::find_if(stages.begin(), stages.end(), IsDifference);
  return first == stages.end() ? nullptr : &*first;
}

ReplayReport ReplayTrial(
    const RecordedTrial& recorded, TrialObserver* observer,
    const std::function<void(std::string_view what, double share)>& on_progress) {
  TrialOptions options;
  options.truth = recorded.truth;
  TrialRunner runner(recorded.spec, recorded.objects, on_progress, options);
  ReplayReport report;
  report.replayed = runner.Run(recorded.result.bin_index, observer);
  if (recorded.crashed) {
    for (const AttemptRecord& attempt : report.replayed.attempts) {
      for (const TrialStage stage : kTrialStages) {
        report.stages.push_back(
            {attempt.attempt, stage, 0, attempt.hashes[stage], ReplayVerdict::kNotRecorded, ""});
      }
    }
  } else {
    report.stages = CompareStages(recorded.result.attempts, report.replayed.attempts);
  }
  return report;
}

std::string ReplayTable(const ReplayReport& report, bool verbose) {
  std::string text = verbose ? StageLines(report.stages) : AttemptLines(report.stages);
  const StageReplay* first = report.FirstDifference();
  if (first == nullptr) {
    const bool compared = std::any_of(report.stages.begin(), report.stages.end(), [](auto& row) {
      return row.verdict == ReplayVerdict::kSame;
    });
    return text + (compared ? "all recorded stages are the same\n"
                            : "no stage was recorded to compare with\n");
  }
  text += fmt::format("first difference: attempt {}, stage {} ({})\n", first->attempt,
                      StageName(first->stage), VerdictName(first->verdict));
  if (!first->what.empty()) text += fmt::format("  {}\n", first->what);
  return text;
}

ResultColumns ReplayColumns() {
  return {
      {"attempt", "number of the attempt"},
      {"stage", "stage of the attempt: scene, image, hypotheses, grasp or outcome"},
      {"recorded", "hash of the recorded stage, - = none"},
      {"replayed", "hash of the repeated stage, - = none"},
      {"verdict", "same, differs, not recorded, record altered, not replayed or not in record"},
  };
}

std::string ReplayCsv(const ReplayReport& report) {
  std::string text = HeaderLine(ReplayColumns());
  for (const StageReplay& row : report.stages) {
    text += fmt::format("{},{},{},{},{}\n", row.attempt, StageName(row.stage),
                        HashText(row.recorded), HashText(row.replayed), VerdictName(row.verdict));
  }
  return text;
}

}  // namespace pickbed::eval
