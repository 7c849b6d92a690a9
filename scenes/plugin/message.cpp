#include "scenes/plugin/message.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cstring>
#include <numeric>

#include "scenes/base/message_text.h"

namespace pickbed::scenes {
namespace {

// First bytes of the types.
constexpr unsigned kNil = 0xc0, kFalse = 0xc2, kTrue = 0xc3;
constexpr unsigned kBin8 = 0xc4, kBin16 = 0xc5, kBin32 = 0xc6;
constexpr unsigned kFloat32 = 0xca, kFloat64 = 0xcb;
constexpr unsigned kUint8 = 0xcc, kUint64 = 0xcf, kInt8 = 0xd0, kInt64 = 0xd3;
constexpr unsigned kStr8 = 0xd9, kStr16 = 0xda, kStr32 = 0xdb;
constexpr unsigned kArray16 = 0xdc, kArray32 = 0xdd, kMap16 = 0xde, kMap32 = 0xdf;
constexpr unsigned kFixMap = 0x80, kFixArray = 0x90, kFixStr = 0xa0, kNegativeFix = 0xe0;

static_assert(std::endian::native == std::endian::little, "arrays are sent as they are in memory");

// Reads one message from a buffer.
class ValueReader {
 public:
  explicit ValueReader(std::span<const std::byte> bytes) : bytes_(bytes) {}

  MessageValue ReadAll() {
    MessageValue value = Read(0);
    if (position_ < bytes_.size()) {
      throw MessageError(fmt::format("has {} bytes after its value", bytes_.size() - position_));
    }
    return value;
  }

 private:
  MessageValue Read(int depth) {
    if (depth > kMaxMessageDepth) throw MessageError("has too many nested lists or maps");
    if (++values_ > kMaxMessageValues) {
      throw MessageError(fmt::format("has more than {} values", kMaxMessageValues));
    }
    const auto head = static_cast<unsigned>(BigEndian(1));
    if (head < kFixMap) return Integer(head);
    if (head < kFixArray) return ReadMap(head & 0x0f, depth);
    if (head < kFixStr) return ReadList(head & 0x0f, depth);
    if (head < kNil) return Value(Utf8Text(head & 0x1f));
    if (head >= kNegativeFix) return Integer(static_cast<int8_t>(head));
    if (head >= kUint8 && head <= kUint64) return Unsigned(BigEndian(1 << (head - kUint8)));
    if (head >= kInt8 && head <= kInt64) return Signed(1 << (head - kInt8));
    switch (head) {
      case kNil:
        return MessageValue();
      case kFalse:
      case kTrue:
        return Value(head == kTrue);
      case kFloat32:
        return Value(double{std::bit_cast<float>(static_cast<uint32_t>(BigEndian(4)))});
      case kFloat64:
        return Value(std::bit_cast<double>(BigEndian(8)));
      case kBin8:
      case kBin16:
      case kBin32:
        return Value(MessageValue::Binary{Bytes(BigEndian(1 << (head - kBin8)))});
      case kStr8:
      case kStr16:
      case kStr32:
        return Value(Utf8Text(BigEndian(1 << (head - kStr8))));
      case kArray16:
      case kArray32:
        return ReadList(BigEndian(head == kArray16 ? 2 : 4), depth);
      case kMap16:
      case kMap32:
        return ReadMap(BigEndian(head == kMap16 ? 2 : 4), depth);
      default:
        throw MessageError(fmt::format("has a value of an unknown type, 0x{:02x}", head));
    }
  }

  template <typename T>
  static MessageValue Value(T value) {
    return MessageValue(MessageValue::Variant(std::move(value)));
  }
  static MessageValue Integer(int64_t value) { return Value(value); }
  static MessageValue Unsigned(uint64_t value) {
    if (value > INT64_MAX) return Value(static_cast<double>(value));
    return Integer(static_cast<int64_t>(value));
  }
  MessageValue Signed(int bytes) {
    const int shift = 64 - 8 * bytes;
    return Integer(static_cast<int64_t>(BigEndian(bytes) << shift) >> shift);
  }

  // Every item has at least one byte, so a larger count is wrong. This bounds the memory.
  void RequireItems(uint64_t count) const {
    if (count > bytes_.size() - position_) throw MessageError("ends within a value");
  }

  MessageValue ReadList(uint64_t count, int depth) {
    RequireItems(count);
    MessageValue::List list;
    for (uint64_t i = 0; i < count; ++i) list.push_back(Read(depth + 1));
    return Value(std::move(list));
  }

  MessageValue ReadMap(uint64_t count, int depth) {
    RequireItems(count);
    MessageValue::Map map;
    for (uint64_t i = 0; i < count; ++i) {
      std::string key = Read(depth + 1).Text("a key");
      map.emplace_back(std::move(key), Read(depth + 1));
    }
    return Value(std::move(map));
  }

  std::string Utf8Text(uint64_t size) {
    std::string text = Bytes(size);
    if (!IsUtf8(text)) {
      throw MessageError(
          fmt::format("has a key or text that is not UTF-8: '{}'", Printable(OneLine(text))));
    }
    return text;
  }

  std::string Bytes(uint64_t size) {
    RequireItems(size);
    std::string text(reinterpret_cast<const char*>(bytes_.data()) + position_, size);
    position_ += size;
    return text;
  }

  uint64_t BigEndian(int bytes) {
    RequireItems(bytes);
    uint64_t value = 0;
    for (int i = 0; i < bytes; ++i) {
      value = value << 8 | std::to_integer<uint64_t>(bytes_[position_++]);
    }
    return value;
  }

  std::span<const std::byte> bytes_;
  size_t position_ = 0;
  size_t values_ = 0;
};

template <typename T>
void AppendElements(const std::string& data, std::vector<double>& numbers) {
  for (size_t i = 0; i + sizeof(T) <= data.size(); i += sizeof(T)) {
    T element;
    std::memcpy(&element, data.data() + i, sizeof(T));
    numbers.push_back(static_cast<double>(element));
  }
}

struct ElementType {
  const char* dtype;
  size_t bytes;
  void (*append)(const std::string& data, std::vector<double>& numbers);
};
constexpr ElementType kElementTypes[] = {
    {"float64", 8, AppendElements<double>}, {"float32", 4, AppendElements<float>},
    {"int64", 8, AppendElements<int64_t>},  {"int32", 4, AppendElements<int32_t>},
    {"uint8", 1, AppendElements<uint8_t>},
};

std::vector<double> ArrayNumbers(const MessageValue& array, std::string_view name) {
  const std::string& dtype = array.At("dtype").Text("dtype");
  const MessageValue::Binary* data = array.At("data").binary();
  if (data == nullptr) throw MessageError(fmt::format("{}: data must be binary", name));
  uint64_t elements = 1;
  for (const MessageValue& side : array.At("shape").Items("shape")) {
    const int64_t length = side.Integer("shape");
    const bool fits = length >= 0 && (length == 0 || elements <= data->bytes.size() / length);
    if (!fits) throw MessageError(fmt::format("{}: shape does not fit its data", name));
    elements *= length;
  }
  for (const ElementType& type : kElementTypes) {
    if (dtype != type.dtype) continue;
    if (elements * type.bytes != data->bytes.size()) {
      throw MessageError(fmt::format("{}: shape does not fit its data", name));
    }
    std::vector<double> numbers;
    numbers.reserve(elements);
    type.append(data->bytes, numbers);
    return numbers;
  }
  throw MessageError(fmt::format("{}: unknown dtype '{}'", name, dtype));
}

void AppendNumbers(const MessageValue& value, std::string_view name, std::vector<double>& numbers) {
  if (const MessageValue::List* list = value.list()) {
    for (const MessageValue& item : *list) AppendNumbers(item, name, numbers);
  } else {
    numbers.push_back(value.Real(name));
  }
}

[[noreturn]] void ThrowKind(std::string_view name, const char* wanted, const MessageValue& value) {
  throw MessageError(fmt::format("{} must be {}, but is {}", name, wanted, value.kind()));
}

}  // namespace

void MessageWriter::BigEndian(uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) Byte(value >> (8 * i) & 0xff);
}

// Types with a count: a short form, and forms with 16 and 32 bits.
void MessageWriter::Head(size_t count, unsigned fix, size_t max_fix, unsigned wide) {
  if (count <= max_fix) return Byte(fix | static_cast<unsigned>(count));
  const bool is_short = count <= 0xffff;
  Byte(is_short ? wide : wide + 1);
  BigEndian(count, is_short ? 2 : 4);
}

void MessageWriter::BeginMap(size_t entries) { Head(entries, kFixMap, 15, kMap16); }
void MessageWriter::BeginList(size_t items) { Head(items, kFixArray, 15, kArray16); }
void MessageWriter::Nil() { Byte(kNil); }
void MessageWriter::Bool(bool value) { Byte(value ? kTrue : kFalse); }

void MessageWriter::Integer(int64_t value) {
  if (value >= 0) return Unsigned(static_cast<uint64_t>(value));
  Byte(kInt64);
  BigEndian(static_cast<uint64_t>(value), 8);
}

void MessageWriter::Unsigned(uint64_t value) {
  if (value < kFixMap) return Byte(static_cast<unsigned>(value));
  Byte(kUint64);
  BigEndian(value, 8);
}

void MessageWriter::Real(double value) {
  Byte(kFloat64);
  BigEndian(std::bit_cast<uint64_t>(value), 8);
}

void MessageWriter::Text(std::string_view text) {
  Head(text.size(), kFixStr, 31, kStr16);
  bytes_ += text;
}

void MessageWriter::ArrayHead(std::string_view dtype, std::span<const size_t> shape,
                              size_t data_bytes) {
  BeginMap(3);
  Text("dtype");
  Text(dtype);
  Text("shape");
  BeginList(shape.size());
  for (const size_t length : shape) Unsigned(length);
  Text("data");
  Byte(kBin32);
  BigEndian(data_bytes, 4);
}

void MessageWriter::Array(std::string_view dtype, std::span<const size_t> shape,
                          std::span<const std::byte> data) {
  ArrayHead(dtype, shape, data.size());
  if (data.empty()) return;
  spliced_.push_back({bytes_.size(), data});
  spliced_size_ += data.size();
}

void MessageWriter::Numbers(std::span<const double> values, std::span<const size_t> shape) {
  const auto data = std::as_bytes(values);
  ArrayHead("float64", shape, data.size());
  bytes_.append(reinterpret_cast<const char*>(data.data()), data.size());
}

std::vector<std::span<const std::byte>> MessageWriter::Chunks() const {
  const auto own = std::as_bytes(std::span(bytes_.data(), bytes_.size()));
  std::vector<std::span<const std::byte>> chunks;
  size_t done = 0;
  for (const Splice& splice : spliced_) {
    chunks.push_back(own.subspan(done, splice.position - done));
    chunks.push_back(splice.data);
    done = splice.position;
  }
  if (done < own.size()) chunks.push_back(own.subspan(done));
  return chunks;
}

const char* MessageValue::kind() const {
  constexpr std::array kKinds{"nil",    "a truth value", "a whole number", "a number",
                              "a text", "binary data",   "a list",         "a map"};
  return kKinds.at(value_.index());
}

const MessageValue* MessageValue::Find(std::string_view key) const {
  if (map() == nullptr) return nullptr;
  for (const auto& [name, value] : *map()) {
    if (name == key) return value.is_nil() ? nullptr : &value;
  }
  return nullptr;
}

const MessageValue& MessageValue::At(std::string_view key) const {
  if (map() == nullptr) throw MessageError(fmt::format("is {} and no map with '{}'", kind(), key));
  const MessageValue* value = Find(key);
  if (value == nullptr) throw MessageError(fmt::format("has no '{}'", key));
  return *value;
}

const std::string& MessageValue::Text(std::string_view name) const {
  if (const auto* text = std::get_if<std::string>(&value_)) return *text;
  ThrowKind(name, "a text", *this);
}

const MessageValue::List& MessageValue::Items(std::string_view name) const {
  if (list() != nullptr) return *list();
  ThrowKind(name, "a list", *this);
}

int64_t MessageValue::Integer(std::string_view name) const {
  if (const auto* integer = std::get_if<int64_t>(&value_)) return *integer;
  ThrowKind(name, "a whole number", *this);
}

double MessageValue::Real(std::string_view name) const {
  if (const auto* integer = std::get_if<int64_t>(&value_)) return static_cast<double>(*integer);
  if (const auto* real = std::get_if<double>(&value_)) return *real;
  ThrowKind(name, "a number", *this);
}

std::vector<double> MessageValue::Numbers(std::string_view name) const {
  if (map() != nullptr) return ArrayNumbers(*this, name);
  std::vector<double> numbers;
  AppendNumbers(*this, name, numbers);
  return numbers;
}

MessageValue ReadMessageValue(std::span<const std::byte> bytes) {
  return ValueReader(bytes).ReadAll();
}

}  // namespace pickbed::scenes
