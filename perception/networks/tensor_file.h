#pragma once

// File of named texts and tensors. It holds data only, so reading it runs no code of the file.
// Layout: magic, version, check sum, then a header (kind, and name, type and shape of each entry)
// and the raw little-endian values of each entry.

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "perception/layer.h"

namespace pickbed::perception {

// Sizes of a tensor along each dimension.
using TensorShape = std::vector<int64_t>;

// Returns the number of values. Throws InputError for a negative size or more than 2^40 values.
int64_t ValueCount(const TensorShape& shape);

class TensorFile {
 public:
  // `kind` says what the file is, such as "descriptor model". `version` is the version of its
  // content.
  TensorFile(std::string kind, int version);

  // Reads a file of this kind. `bytes` are its content. Throws InputError if it is damaged, of
  // another kind, a PyTorch archive, or of a version outside of [oldest, newest].
  static TensorFile Parse(std::string_view bytes, const std::string& kind, int oldest, int newest);

  const std::string& kind() const { return kind_; }
  int version() const { return version_; }

  // Adds an entry. The shape has as many values as are given.
  void PutText(const std::string& name, const std::string& text);
  void Put(const std::string& name, std::span<const float> values, const TensorShape& shape);
  void Put(const std::string& name, std::span<const int64_t> values, const TensorShape& shape);
  // Adds a tensor of one dimension.
  void Put(const std::string& name, const std::vector<float>& values);

  // Read an entry. They throw InputError if it is missing or of another type, Text() also if it has
  // bytes that are no text, and Floats() also if a value is not finite.
  std::string Text(const std::string& name) const;
  std::vector<float> Floats(const std::string& name) const;
  std::vector<int64_t> Integers(const std::string& name) const;
  const TensorShape& Shape(const std::string& name) const;
  bool Has(const std::string& name) const { return entries_.contains(name); }

  // Returns the content of the file. Equal entries give equal bytes.
  std::string Bytes() const;

 private:
  struct Entry {
    std::string type;
    TensorShape shape;
    std::string bytes;
  };
  void Add(const std::string& name, Entry entry);
  const Entry& Find(const std::string& name, const std::string& type) const;

  std::string kind_;
  int version_ = 0;
  std::map<std::string, Entry> entries_;
};

}  // namespace pickbed::perception
