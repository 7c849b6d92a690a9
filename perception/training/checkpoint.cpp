#include "perception/training/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "perception/networks/verifier_file.h"
#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"

namespace pickbed::perception {
namespace {

constexpr std::string_view kMagic = "PICKCKPT";
constexpr uint64_t kVersion = 1;

// Number of objects, then per measurement: iteration, at_1, at_8, object_at_1, object_at_8.
std::vector<double> RecallValues(const std::vector<HeldOutRecall>& history) {
  std::vector<double> values;
  values.push_back(history.empty() ? 0 : static_cast<double>(history.front().object_at_1.size()));
  for (const HeldOutRecall& recall : history) {
    values.insert(values.end(), {1.0 * recall.iteration, recall.at_1, recall.at_8});
    values.insert(values.end(), recall.object_at_1.begin(), recall.object_at_1.end());
    values.insert(values.end(), recall.object_at_8.begin(), recall.object_at_8.end());
  }
  return values;
}

std::vector<HeldOutRecall> RecallsFrom(const std::vector<double>& values) {
  CheckInput(!values.empty() && values[0] >= 0 && values[0] <= values.size(), "damaged");
  const size_t object_count = static_cast<size_t>(values[0]), row = 3 + 2 * object_count;
  CheckInput((values.size() - 1) % row == 0, "damaged");
  std::vector<HeldOutRecall> history;
  for (size_t first = 1; first < values.size(); first += row) {
    const double* next = values.data() + first;
    HeldOutRecall& recall = history.emplace_back();
    recall.iteration = static_cast<int>(next[0]);
    recall.at_1 = next[1];
    recall.at_8 = next[2];
    recall.object_at_1.assign(next + 3, next + 3 + object_count);
    recall.object_at_8.assign(next + 3 + object_count, next + row);
  }
  return history;
}

void PutVerifiers(BlockWriter& writer, const std::vector<TrainedVerifier>& trained) {
  std::vector<Verifier> verifiers;
  std::vector<double> auc;
  for (const TrainedVerifier& each : trained) {
    verifiers.push_back(each.verifier);
    auc.push_back(each.auc);
  }
  writer.Put(auc);
  writer.Put(verifiers.empty() ? std::vector<float>{} : VerifierValues(verifiers));
}

std::vector<TrainedVerifier> TakeVerifiers(BlockReader& reader) {
  const std::vector<double> auc = reader.TakeAll<double>();
  const std::vector<float> values = reader.TakeAll<float>();
  if (auc.empty()) return {};
  constexpr float kLargest = 1e6f;
  CheckInput(std::ranges::all_of(values, [](float v) { return std::abs(v) <= kLargest; }),
             "a value of a verifier is not finite, or too large");
  const std::vector<Verifier> verifiers = VerifiersFrom(values, auc.size());
  std::vector<TrainedVerifier> trained;
  for (size_t i = 0; i < auc.size(); ++i) trained.push_back({verifiers[i], auc[i]});
  return trained;
}

Checkpoint Parse(std::string_view bytes) {
  BlockReader reader(bytes, kMagic, kVersion, "a checkpoint");
  Checkpoint checkpoint;
  checkpoint.key = reader.Take();
  const std::string_view iteration = reader.Take();
  CheckInput(iteration.size() == sizeof checkpoint.iteration, "damaged");
  std::memcpy(&checkpoint.iteration, iteration.data(), iteration.size());
  checkpoint.loss_history = reader.TakeAll<double>();
  checkpoint.recall_history = RecallsFrom(reader.TakeAll<double>());
  checkpoint.training_state = reader.Take();
  checkpoint.verifiers = TakeVerifiers(reader);
  reader.RequireEnd();
  return checkpoint;
}

}  // namespace

void WriteCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  BlockWriter writer;
  writer.Put(checkpoint.key);
  writer.Put(&checkpoint.iteration, sizeof checkpoint.iteration);
  writer.Put(checkpoint.loss_history);
  writer.Put(RecallValues(checkpoint.recall_history));
  writer.Put(checkpoint.training_state);
  PutVerifiers(writer, checkpoint.verifiers);
  WriteFileAtomically(file, writer.Bytes(kMagic, kVersion));
}

Checkpoint ReadCheckpoint(const std::filesystem::path& file, const std::string& key) {
  const std::string bytes = ReadFileBytes(file);
  Checkpoint checkpoint;
  try {
    checkpoint = Parse(bytes);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}; restore the file from a copy, or train to another file",
                                 file.string(), error.what()));
  }
  CheckInput(checkpoint.key == key,
             fmt::format("{}: belongs to a training with other settings or objects; use the same "
                         "ones, write to another file, or delete it to start again",
                         file.string()));
  return checkpoint;
}

}  // namespace pickbed::perception
