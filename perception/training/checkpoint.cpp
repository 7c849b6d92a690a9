#include "perception/training/checkpoint.h"

#include <fmt/format.h>

#include <cstring>

#include "perception/networks/verifier_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/random.h"

namespace pickbed::perception {
namespace {

constexpr uint64_t kMagic = 0x345054504b434950;  // "PICKPTP4", little endian

void Put(std::string& bytes, const void* data, uint64_t size) {
  bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
  bytes.append(static_cast<const char*>(data), size);
}

// Reads length-prefixed blocks in order. Throws InputError if the bytes end too early.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}
  std::string_view Take() {
    uint64_t size = 0;
    CheckInput(rest_.size() >= sizeof size, "cut short");
    std::memcpy(&size, rest_.data(), sizeof size);
    rest_.remove_prefix(sizeof size);
    CheckInput(rest_.size() >= size, "cut short");
    const std::string_view piece = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return piece;
  }

 private:
  std::string_view rest_;
};

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

template <typename Value>
void PutAll(std::string& bytes, const std::vector<Value>& values) {
  Put(bytes, values.data(), values.size() * sizeof(Value));
}

template <typename Value>
std::vector<Value> TakeAll(Reader& reader) {
  const std::string_view bytes = reader.Take();
  std::vector<Value> values(bytes.size() / sizeof(Value));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Value));
  return values;
}

void PutVerifiers(std::string& bytes, const std::vector<TrainedVerifier>& trained) {
  std::vector<Verifier> verifiers;
  std::vector<double> auc;
  for (const TrainedVerifier& each : trained) {
    verifiers.push_back(each.verifier);
    auc.push_back(each.auc);
  }
  PutAll(bytes, auc);
  PutAll(bytes, verifiers.empty() ? std::vector<float>{} : VerifierValues(verifiers));
}

std::vector<TrainedVerifier> TakeVerifiers(Reader& reader) {
  const std::vector<double> auc = TakeAll<double>(reader);
  const std::vector<float> values = TakeAll<float>(reader);
  if (auc.empty()) return {};
  const std::vector<Verifier> verifiers = VerifiersFrom(values, auc.size());
  std::vector<TrainedVerifier> trained;
  for (size_t i = 0; i < auc.size(); ++i) trained.push_back({verifiers[i], auc[i]});
  return trained;
}

Checkpoint Parse(std::string_view bytes) {
  uint64_t head[2] = {};
  CheckInput(bytes.size() >= sizeof head, "cut short");
  std::memcpy(head, bytes.data(), sizeof head);
  bytes.remove_prefix(sizeof head);
  CheckInput(head[0] == kMagic, "no checkpoint of this version");
  CheckInput(head[1] == HashBytes(bytes.data(), bytes.size()), "damaged");
  Reader reader(bytes);
  Checkpoint checkpoint;
  checkpoint.key = reader.Take();
  const std::string_view iteration = reader.Take();
  CheckInput(iteration.size() == sizeof checkpoint.iteration, "damaged");
  std::memcpy(&checkpoint.iteration, iteration.data(), iteration.size());
  checkpoint.loss_history = TakeAll<double>(reader);
  checkpoint.recall_history = RecallsFrom(TakeAll<double>(reader));
  checkpoint.training_state = reader.Take();
  checkpoint.verifiers = TakeVerifiers(reader);
  return checkpoint;
}

}  // namespace

void WriteCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  std::string body;
  Put(body, checkpoint.key.data(), checkpoint.key.size());
  Put(body, &checkpoint.iteration, sizeof checkpoint.iteration);
  PutAll(body, checkpoint.loss_history);
  PutAll(body, RecallValues(checkpoint.recall_history));
  Put(body, checkpoint.training_state.data(), checkpoint.training_state.size());
  PutVerifiers(body, checkpoint.verifiers);
  const uint64_t head[2] = {kMagic, HashBytes(body.data(), body.size())};
  WriteFileAtomically(file, std::string(reinterpret_cast<const char*>(head), sizeof head) + body);
}

Checkpoint ReadCheckpoint(const std::filesystem::path& file, const std::string& key) {
  const std::string bytes = ReadFileBytes(file);
  Checkpoint checkpoint;
  try {
    checkpoint = Parse(bytes);
  } catch (const InputError& error) {
    throw InputError(
        fmt::format("{}: {}; delete it and start the training again", file.string(), error.what()));
  }
  CheckInput(checkpoint.key == key,
             fmt::format("{}: belongs to a training with other settings or objects; use the same "
                         "ones, write to another file, or delete it to start again",
                         file.string()));
  return checkpoint;
}

}  // namespace pickbed::perception
