#include "perception/networks/tensor_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>

#include "scenes/base/byte_blocks.h"
#include "scenes/base/error.h"
#include "scenes/base/message_text.h"
#include "scenes/base/settings.h"

namespace pickbed::perception {
namespace {

constexpr std::string_view kMagic = "PICKTENS";
constexpr uint64_t kFormatVersion = 1;
constexpr std::string_view kZipMagic = "PK\3\4";
constexpr const char *kText = "text", *kFloat32 = "float32", *kInt64 = "int64";
constexpr int64_t kMaxValues = int64_t{1} << 40;

int64_t BytesPerValue(const std::string& type) {
  return type == kText ? 1 : type == kFloat32 ? sizeof(float) : sizeof(int64_t);
}

struct EntryHead {
  std::string name, type, shape;
  void Visit(SettingsVisitor& v) {
    v.Text("name", name, {}, "name of the entry");
    v.Text("type", type, {kText, kFloat32, kInt64}, "type of its values");
    v.Text("shape", shape, {}, "sizes along its dimensions, joined by x");
  }
};

struct Header {
  std::string kind;
  int version = 0;
  std::vector<EntryHead> entries;
  void Visit(SettingsVisitor& v) {
    v.Text("kind", kind, {}, "what the file is");
    v.Integer("version", version, {0, 1e9}, "version of its content");
    v.List(
        "entries", entries.size(), [&](size_t size) { entries.resize(size); },
        [&](size_t i, SettingsVisitor& item) { entries[i].Visit(item); }, "entries of the file");
  }
};

std::string ShapeText(const TensorShape& shape) { return fmt::format("{}", fmt::join(shape, "x")); }

TensorShape ShapeFrom(const std::string& text) {
  TensorShape shape;
  const char *next = text.data(), *const end = next + text.size();
  while (next != end) {
    int64_t size = 0;
    const auto [after, error] = std::from_chars(next, end, size);
    const bool is_last = after == end;
    CheckInput(error == std::errc() && (is_last || *after == 'x'),
               fmt::format("'{}' is not a shape", text));
    shape.push_back(size);
    next = is_last ? end : after + 1;
  }
  return shape;
}

template <typename Value>
std::vector<Value> ValuesIn(const std::string& bytes) {
  std::vector<Value> values(bytes.size() / sizeof(Value));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), values.size() * sizeof(Value));
  return values;
}

template <typename Value>
std::string BytesOf(std::span<const Value> values) {
  return {reinterpret_cast<const char*>(values.data()), values.size_bytes()};
}

}  // namespace

int64_t ValueCount(const TensorShape& shape) {
  int64_t count = 1;
  for (const int64_t size : shape) {
    CheckInput(size >= 0 && (count == 0 || size <= kMaxValues / count),
               fmt::format("a tensor of shape {} is too large", ShapeText(shape)));
    count *= size;
  }
  return count;
}

TensorFile::TensorFile(std::string kind, int version) : kind_(std::move(kind)), version_(version) {}

TensorFile TensorFile::Parse(std::string_view bytes, const std::string& kind, int oldest,
                             int newest) {
  CheckInput(
      !bytes.starts_with(kZipMagic),
      "it is a PyTorch archive, which can run code when it is read; pickbed wrote such files "
      "in earlier versions: convert it with eval/python/convert_model.py");
  BlockReader reader(bytes, kMagic, kFormatVersion, "a " + kind);
  Header header;
  ReadSettingsText(std::string(reader.Take()), "header of the file",
                   [&](SettingsVisitor& v) { header.Visit(v); });
  CheckInput(header.kind == kind, fmt::format("it is not a {} but a {}", kind, header.kind));
  CheckInput(header.version <= newest,
             fmt::format("it is of version {}, newer than this program, which reads up to {}",
                         header.version, newest));
  CheckInput(header.version >= oldest,
             fmt::format("it is of version {}, older than {}", header.version, oldest));
  TensorFile file(kind, header.version);
  for (const EntryHead& head : header.entries) {
    file.Add(head.name, {head.type, ShapeFrom(head.shape), std::string(reader.Take())});
  }
  reader.RequireEnd();
  return file;
}

void TensorFile::Add(const std::string& name, Entry entry) {
  const int64_t size = ValueCount(entry.shape) * BytesPerValue(entry.type);
  CheckInput(size == static_cast<int64_t>(entry.bytes.size()),
             fmt::format("entry '{}' has {} bytes, its shape {} needs {}", name, entry.bytes.size(),
                         ShapeText(entry.shape), size));
  const bool is_new = entries_.emplace(name, std::move(entry)).second;
  CheckInput(is_new, fmt::format("entry '{}' occurs twice", name));
}

void TensorFile::PutText(const std::string& name, const std::string& text) {
  Add(name, {kText, {static_cast<int64_t>(text.size())}, text});
}

void TensorFile::Put(const std::string& name, std::span<const float> values,
                     const TensorShape& shape) {
  Add(name, {kFloat32, shape, BytesOf(values)});
}

void TensorFile::Put(const std::string& name, std::span<const int64_t> values,
                     const TensorShape& shape) {
  Add(name, {kInt64, shape, BytesOf(values)});
}

void TensorFile::Put(const std::string& name, const std::vector<float>& values) {
  Put(name, values, {static_cast<int64_t>(values.size())});
}

const TensorFile::Entry& TensorFile::Find(const std::string& name, const std::string& type) const {
  const auto found = entries_.find(name);
  CheckInput(found != entries_.end(), fmt::format("it has no entry '{}'", name));
  CheckInput(found->second.type == type,
             fmt::format("entry '{}' is {}, not {}", name, found->second.type, type));
  return found->second;
}

std::string TensorFile::Text(const std::string& name) const {
  const std::string& text = Find(name, kText).bytes;
  const auto is_plain = [](unsigned char c) { return c >= ' ' || c == '\n' || c == '\t'; };
  CheckInput(IsUtf8(text) && std::ranges::all_of(text, is_plain),
             fmt::format("'{}' has bytes that are no text", name));
  return text;
}

std::vector<float> TensorFile::Floats(const std::string& name) const {
  const std::vector<float> values = ValuesIn<float>(Find(name, kFloat32).bytes);
  // No network has values near this. One of them would outvote all others.
  constexpr float kLargest = 1e6f;
  const auto is_usual = [](float value) { return std::abs(value) <= kLargest; };
  CheckInput(std::ranges::all_of(values, is_usual),
             fmt::format("a value of '{}' is not finite, or over {:g}", name, kLargest));
  return values;
}

std::vector<int64_t> TensorFile::Integers(const std::string& name) const {
  return ValuesIn<int64_t>(Find(name, kInt64).bytes);
}

const TensorShape& TensorFile::Shape(const std::string& name) const {
  const auto found = entries_.find(name);
  CheckInput(found != entries_.end(), fmt::format("it has no entry '{}'", name));
  return found->second.shape;
}

std::string TensorFile::Bytes() const {
  Header header{kind_, version_, {}};
  for (const auto& [name, entry] : entries_) {
    header.entries.push_back({name, entry.type, ShapeText(entry.shape)});
  }
  BlockWriter writer;
  writer.Put(WriteSettings([&](SettingsVisitor& v) { header.Visit(v); }));
  for (const auto& [name, entry] : entries_) writer.Put(entry.bytes);
  return writer.Bytes(kMagic, kFormatVersion);
}

}  // namespace pickbed::perception
