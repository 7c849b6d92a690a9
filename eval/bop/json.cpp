#include "eval/bop/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"

namespace pickbed::eval {
namespace {

// Message of an nlohmann exception without the library's error number.
std::string Reason(const std::exception& error) {
  const std::string text = error.what();
  const size_t end = text.find("] ");
  std::string reason = end == std::string::npos ? text : text.substr(end + 2);
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  return reason;
}

// The library's reader and writer call themselves for each level of nesting, so that a deeply
// nested text would exhaust the stack.
void CheckNesting(const std::string& text) {
  constexpr int kMaxDepth = 64;
  int depth = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string && c == '\\') {
      ++i;
    } else if (c == '"') {
      in_string = !in_string;
    } else if (!in_string) {
      depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    }
    CheckInput(depth <= kMaxDepth, fmt::format("is nested more than {} levels deep", kMaxDepth));
  }
}

// Throws InputError for an object that has a key twice: the library would keep the last value.
ParsedJson ParseUniqueKeys(const std::string& text) {
  using Event = ParsedJson::parse_event_t;
  std::vector<std::set<std::string>> keys;  // of the open objects
  return ParsedJson::parse(text, [&keys](int, Event event, const ParsedJson& parsed) {
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key) {
      const std::string key = parsed.get<std::string>();
      CheckInput(keys.back().insert(key).second,
                 fmt::format("has the key '{}' twice in one object", OneLine(key)));
    }
    return true;
  });
}

bool IsUsable(const ParsedJson& value) {
  return value.is_number() && std::abs(value.get<double>()) <= kLargestNumber;  // no NaN either
}

std::string Shown(const ParsedJson& value) {
  return OneLine(value.dump(-1, ' ', false, ParsedJson::error_handler_t::replace));
}

const ParsedJson* Find(const ParsedJson& object, const char* key, const JsonPlace& place) {
  if (object.is_object()) {
    if (const auto found = object.find(key); found != object.end()) return &*found;
  }
  place.Fault(fmt::format("has no '{}'", key));
  return nullptr;
}

}  // namespace

void ThrowFault(const std::string& line) { throw InputError(line); }

std::optional<ParsedJson> ReadJson(const std::filesystem::path& file, const OnFault& fault) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    fault(file.string() + ": is missing");
    return std::nullopt;
  }
  try {
    const std::string text = ReadFileBytes(file);
    CheckNesting(text);
    return ParseUniqueKeys(text);
  } catch (const ParsedJson::exception& exception) {
    fault(fmt::format("{}: is no JSON: {}", file.string(), Reason(exception)));
  } catch (const InputError& exception) {
    fault(fmt::format("{}: {}", file.string(), exception.what()));
  }
  return std::nullopt;
}

std::optional<double> JsonReal(const ParsedJson& object, const char* key, const JsonPlace& place) {
  const ParsedJson* value = Find(object, key, place);
  if (!value) return std::nullopt;
  if (IsUsable(*value)) return value->get<double>();
  place.Fault(value->is_number()
                  ? fmt::format("'{}' is {}, beyond {:g}", key, Shown(*value), kLargestNumber)
                  : fmt::format("'{}' is {}, not a number", key, Shown(*value)));
  return std::nullopt;
}

std::optional<int> JsonInteger(const ParsedJson& object, const char* key, const JsonPlace& place) {
  const ParsedJson* value = Find(object, key, place);
  if (!value) return std::nullopt;
  constexpr int64_t kMax = std::numeric_limits<int>::max();
  if (value->is_number_unsigned()) {
    const auto number = value->get<uint64_t>();
    if (number <= static_cast<uint64_t>(kMax)) return static_cast<int>(number);
  } else if (value->is_number_integer()) {
    const auto number = value->get<int64_t>();
    if (number >= -kMax && number <= kMax) return static_cast<int>(number);
  }
  place.Fault(fmt::format("'{}' is {}, not a whole number", key, Shown(*value)));
  return std::nullopt;
}

std::optional<std::vector<double>> ToReals(const ParsedJson& array, size_t count,
                                           const JsonPlace& place) {
  // Some files nest the rows of a matrix, most have a flat list of numbers.
  std::vector<double> numbers;
  const std::function<bool(const ParsedJson&)> take = [&](const ParsedJson& value) {
    if (value.is_array()) return std::all_of(value.begin(), value.end(), take);
    if (!IsUsable(value)) return false;
    numbers.push_back(value.get<double>());
    return true;
  };
  if (array.is_array() && take(array) && numbers.size() == count) return numbers;
  place.Fault(fmt::format("is not {} numbers of at most {:g}", count, kLargestNumber));
  return std::nullopt;
}

std::optional<std::vector<double>> JsonReals(const ParsedJson& object, const char* key,
                                             size_t count, const JsonPlace& place) {
  const ParsedJson* value = Find(object, key, place);
  if (!value) return std::nullopt;
  return ToReals(*value, count, place / fmt::format("'{}'", key));
}

Eigen::Matrix3d ToMatrix3(const std::vector<double>& numbers) {
  Eigen::Matrix3d matrix;
  for (int i = 0; i < 9; ++i) matrix(i / 3, i % 3) = numbers[i];
  return matrix;
}

}  // namespace pickbed::eval
