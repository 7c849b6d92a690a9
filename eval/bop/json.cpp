#include "eval/bop/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/base/error.h"
#include "scenes/base/files.h"

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
    return ParsedJson::parse(ReadFileBytes(file));
  } catch (const ParsedJson::exception& exception) {
    fault(fmt::format("{}: is no JSON: {}", file.string(), Reason(exception)));
  } catch (const InputError& exception) {
    fault(exception.what());
  }
  return std::nullopt;
}

std::optional<double> JsonReal(const ParsedJson& object, const char* key, const JsonPlace& place) {
  const ParsedJson* value = Find(object, key, place);
  if (!value) return std::nullopt;
  if (value->is_number() && std::isfinite(value->get<double>())) return value->get<double>();
  place.Fault(fmt::format("'{}' is {}, not a number", key, value->dump()));
  return std::nullopt;
}

std::optional<int> JsonInteger(const ParsedJson& object, const char* key, const JsonPlace& place) {
  const ParsedJson* value = Find(object, key, place);
  if (!value) return std::nullopt;
  if (value->is_number_integer()) {
    const auto number = value->get<int64_t>();
    if (std::abs(number) <= std::numeric_limits<int>::max()) return static_cast<int>(number);
  }
  place.Fault(fmt::format("'{}' is {}, not a whole number", key, value->dump()));
  return std::nullopt;
}

std::optional<std::vector<double>> ToReals(const ParsedJson& array, size_t count,
                                           const JsonPlace& place) {
  // Some files nest the rows of a matrix, most have a flat list of numbers.
  std::vector<double> numbers;
  const std::function<bool(const ParsedJson&)> take = [&](const ParsedJson& value) {
    if (value.is_array()) return std::all_of(value.begin(), value.end(), take);
    if (!value.is_number() || !std::isfinite(value.get<double>())) return false;
    numbers.push_back(value.get<double>());
    return true;
  };
  if (array.is_array() && take(array) && numbers.size() == count) return numbers;
  place.Fault(fmt::format("is not {} numbers", count));
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
