#include "perception/checkpoint.h"

#include <fmt/format.h>

#include <cstring>

#include "scenes/check.h"
#include "scenes/files.h"
#include "scenes/random.h"

namespace pickbed {
namespace {

constexpr uint64_t kMagic = 0x315054504b434950;  // "PICKPTP1", little endian

void Put(std::string& bytes, const void* data, uint64_t size) {
  bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
  bytes.append(static_cast<const char*>(data), size);
}

// Length-prefixed pieces one after the other; throws when the bytes end too early.
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

Checkpoint Parse(std::string_view bytes) {
  uint64_t head[2] = {};
  CheckInput(bytes.size() >= sizeof head, "cut short");
  std::memcpy(head, bytes.data(), sizeof head);
  bytes.remove_prefix(sizeof head);
  CheckInput(head[0] == kMagic, "no checkpoint");
  CheckInput(head[1] == HashBytes(bytes.data(), bytes.size()), "damaged");
  Reader reader(bytes);
  Checkpoint checkpoint;
  checkpoint.key = reader.Take();
  const std::string_view iteration = reader.Take();
  CheckInput(iteration.size() == sizeof checkpoint.iteration, "damaged");
  std::memcpy(&checkpoint.iteration, iteration.data(), iteration.size());
  const std::string_view losses = reader.Take();
  checkpoint.loss_history.resize(losses.size() / sizeof(double));
  if (!losses.empty()) std::memcpy(checkpoint.loss_history.data(), losses.data(), losses.size());
  checkpoint.training_state = reader.Take();
  return checkpoint;
}

}  // namespace

void WriteCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint) {
  std::string body;
  Put(body, checkpoint.key.data(), checkpoint.key.size());
  Put(body, &checkpoint.iteration, sizeof checkpoint.iteration);
  Put(body, checkpoint.loss_history.data(), checkpoint.loss_history.size() * sizeof(double));
  Put(body, checkpoint.training_state.data(), checkpoint.training_state.size());
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
        fmt::format("{}: {}; delete it and start the training anew", file.string(), error.what()));
  }
  CheckInput(checkpoint.key == key,
             fmt::format("{}: belongs to a training with other settings or parts; use those or "
                         "start anew without resuming",
                         file.string()));
  return checkpoint;
}

}  // namespace pickbed
