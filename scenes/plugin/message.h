#pragma once

// Messages of the plug-in protocol: MessagePack values (msgpack.org, specification of 2013). An
// array of numbers is a map {dtype, shape, data}: `dtype` is a NumPy name such as "float32", and
// `data` holds the elements row by row, little-endian.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace pickbed::scenes {

// A message that breaks the format, or a value of another kind than the reader expects. The text is
// a part of a sentence without the name of the sender.
class MessageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Writes one message. The bytes of large arrays are referenced, not copied. They must stay valid
// until the message is sent.
class MessageWriter {
 public:
  // The next `entries` pairs of Text() and a value are the entries of a map.
  void BeginMap(size_t entries);
  // The next `items` values are the items of a list.
  void BeginList(size_t items);
  void Nil();
  void Bool(bool value);
  void Integer(int64_t value);
  void Unsigned(uint64_t value);
  void Real(double value);
  void Text(std::string_view text);
  // Writes {dtype, shape, data}; refers to `data`.
  void Array(std::string_view dtype, std::span<const size_t> shape,
             std::span<const std::byte> data);
  // Same with a copy of few numbers.
  void Numbers(std::span<const double> values, std::span<const size_t> shape);

  // Returns the bytes of the message in order.
  std::vector<std::span<const std::byte>> Chunks() const;
  size_t size() const { return bytes_.size() + spliced_size_; }

 private:
  // Array bytes that follow the first `position` bytes of `bytes_`.
  struct Splice {
    size_t position;
    std::span<const std::byte> data;
  };
  void Byte(unsigned value) { bytes_.push_back(static_cast<char>(value)); }
  void BigEndian(uint64_t value, int bytes);
  void Head(size_t count, unsigned fix, size_t max_fix, unsigned wide);
  void ArrayHead(std::string_view dtype, std::span<const size_t> shape, size_t data_bytes);

  std::string bytes_;
  std::vector<Splice> spliced_;
  size_t spliced_size_ = 0;
};

// A value of a received message.
class MessageValue {
 public:
  struct Binary {
    std::string bytes;
  };
  using List = std::vector<MessageValue>;
  using Map = std::vector<std::pair<std::string, MessageValue>>;
  using Variant =
      std::variant<std::monostate, bool, int64_t, double, std::string, Binary, List, Map>;

  MessageValue() = default;
  explicit MessageValue(Variant value) : value_(std::move(value)) {}

  bool is_nil() const { return std::holds_alternative<std::monostate>(value_); }
  const List* list() const { return std::get_if<List>(&value_); }
  const Map* map() const { return std::get_if<Map>(&value_); }
  const Binary* binary() const { return std::get_if<Binary>(&value_); }
  // Returns what the value is, in words such as "a text".
  const char* kind() const;

  // Returns the value of a key; null if this is no map, the key is missing or its value is nil.
  const MessageValue* Find(std::string_view key) const;
  // Returns the value of a key. Throws MessageError if Find() returns null.
  const MessageValue& At(std::string_view key) const;

  // The next functions throw MessageError, which begins with `name`, for a value of another kind.
  const std::string& Text(std::string_view name) const;
  const List& Items(std::string_view name) const;
  int64_t Integer(std::string_view name) const;
  double Real(std::string_view name) const;  // also of an integer
  // Returns all numbers of a list, of nested lists or of an array {dtype, shape, data}, row by row.
  // NaN and infinity are allowed.
  std::vector<double> Numbers(std::string_view name) const;

 private:
  Variant value_;
};

// Maximum number of values in a received message, and of levels of nested lists and maps.
inline constexpr size_t kMaxMessageValues = 2000000;
inline constexpr int kMaxMessageDepth = 32;

// Reads a message. Throws MessageError for other bytes than one MessagePack value, for keys that
// are no texts, for keys and texts that are not UTF-8, for extension types, and beyond the limits
// above.
MessageValue ReadMessageValue(std::span<const std::byte> bytes);

}  // namespace pickbed::scenes
