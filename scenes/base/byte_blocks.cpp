#include "scenes/base/byte_blocks.h"

#include <fmt/format.h>

#include "scenes/base/error.h"
#include "scenes/base/random.h"

namespace pickbed::scenes {
namespace {

constexpr size_t kMagicSize = 8;

struct Head {
  char magic[kMagicSize];
  uint64_t version;
  uint64_t hash;  // of the blocks
};

}  // namespace

void BlockWriter::Put(const void* data, uint64_t size) {
  body_.append(reinterpret_cast<const char*>(&size), sizeof size);
  body_.append(static_cast<const char*>(data), size);
}

std::string BlockWriter::Bytes(std::string_view magic, uint64_t version) const {
  Head head{};
  std::memcpy(head.magic, magic.data(), kMagicSize);
  head.version = version;
  head.hash = HashBytes(body_.data(), body_.size());
  return std::string(reinterpret_cast<const char*>(&head), sizeof head) + body_;
}

BlockReader::BlockReader(std::string_view bytes, std::string_view magic, uint64_t version,
                         const std::string& kind, uint64_t oldest)
    : rest_(bytes) {
  Head head{};
  CheckInput(bytes.size() >= sizeof head, "the file is cut short");
  std::memcpy(&head, bytes.data(), sizeof head);
  rest_.remove_prefix(sizeof head);
  CheckInput(std::string_view(head.magic, kMagicSize) == magic, "it is not " + kind);
  CheckInput(head.version <= version,
             fmt::format("it is of version {}, newer than this program, which reads up to {}",
                         head.version, version));
  CheckInput(head.version >= oldest,
             fmt::format("it is of version {}, older than {}", head.version, oldest));
  CheckInput(head.hash == HashBytes(rest_.data(), rest_.size()),
             "the file is cut short or damaged: its check sum is wrong");
}

std::string_view BlockReader::Take() {
  uint64_t size = 0;
  CheckInput(rest_.size() >= sizeof size, "the file is cut short");
  std::memcpy(&size, rest_.data(), sizeof size);
  rest_.remove_prefix(sizeof size);
  CheckInput(rest_.size() >= size, "the file is cut short");
  const std::string_view block = rest_.substr(0, size);
  rest_.remove_prefix(size);
  return block;
}

}  // namespace pickbed::scenes
