#pragma once

// Files of length-prefixed blocks after a head with magic, version and check sum.

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/base/error.h"

namespace pickbed::scenes {

// Appends blocks.
class BlockWriter {
 public:
  void Put(const void* data, uint64_t size);
  void Put(std::string_view text) { Put(text.data(), text.size()); }
  template <typename Value>
  void Put(const std::vector<Value>& values) {
    Put(values.data(), values.size() * sizeof(Value));
  }
  // Returns head and blocks. `magic` has 8 characters.
  std::string Bytes(std::string_view magic, uint64_t version) const;
  // Returns the blocks without a head, for content of another file.
  const std::string& body() const { return body_; }

 private:
  std::string body_;
};

// Reads blocks in order. All functions throw InputError for a file that is cut short or damaged.
// The bytes must outlive it.
class BlockReader {
 public:
  // Checks the head. Versions from `oldest` to `version` are read. `kind` is what the file should
  // be, for the error: "a completion model".
  BlockReader(std::string_view bytes, std::string_view magic, uint64_t version,
              const std::string& kind, uint64_t oldest = 0);
  // Reads blocks without a head.
  explicit BlockReader(std::string_view body) : rest_(body) {}
  std::string_view Take();
  bool IsAtEnd() const { return rest_.empty(); }
  // Throws if bytes follow the last block that was taken.
  void RequireEnd() const {
    CheckInput(IsAtEnd(), "the file is damaged: it is longer than its blocks");
  }
  template <typename Value>
  std::vector<Value> TakeAll() {
    const std::string_view block = Take();
    CheckInput(block.size() % sizeof(Value) == 0, "the file is damaged: a list has another size");
    std::vector<Value> values(block.size() / sizeof(Value));
    if (!values.empty()) std::memcpy(values.data(), block.data(), values.size() * sizeof(Value));
    return values;
  }

 private:
  std::string_view rest_;
};

}  // namespace pickbed::scenes
