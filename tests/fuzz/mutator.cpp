#include "tests/fuzz/mutator.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace pickbed::tests {
namespace {

constexpr auto kNumbers = std::to_array<std::string_view>({"0",
                                                           "-1",
                                                           "1",
                                                           "1e300",
                                                           "-1e300",
                                                           "1e-300",
                                                           "nan",
                                                           "inf",
                                                           "-inf",
                                                           "2147483648",
                                                           "-2147483649",
                                                           "18446744073709551615",
                                                           "9223372036854775808",
                                                           "99999999999999999999999",
                                                           "1e",
                                                           "0x10",
                                                           "1.5.2",
                                                           ".",
                                                           "-",
                                                           ""});

constexpr auto kTexts =
    std::to_array<std::string_view>({"[",    "]",        "{",        "}",        "\"",
                                     "'",    ":",        ": ",       ",",        "\n",
                                     "\r\n", "\t",       "&a",       "*a",       "<<: *a",
                                     "#",    "null",     "true",     "../",      "/dev/zero",
                                     "%s%n", "<script>", "[[[[[[[[", "\xff\xfe", "\xef\xbb\xbf",
                                     "- ",   "  ",       "!!binary", "|",        ">"});

size_t Place(const std::string& bytes, Rng& rng) {
  return bytes.empty() ? 0 : static_cast<size_t>(rng.Index(static_cast<int>(bytes.size())));
}

template <typename Texts>
std::string_view OneOf(const Texts& texts, Rng& rng) {
  return texts[static_cast<size_t>(rng.Index(static_cast<int>(texts.size())))];
}

// Replaces the number after a random place.
void ReplaceNumber(std::string& bytes, Rng& rng) {
  const auto is_number = [](char c) {
    return std::isdigit(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '-';
  };
  const auto from = std::find_if(bytes.begin() + static_cast<std::ptrdiff_t>(Place(bytes, rng)),
                                 bytes.end(), is_number);
  const auto to = std::find_if_not(from, bytes.end(), is_number);
  bytes.replace(from, to, OneOf(kNumbers, rng));
}

// Exchanges a line with the one at a random place.
void ExchangeLines(std::string& bytes, Rng& rng) {
  const auto line_at = [&](size_t place) {
    const size_t before = place == 0 ? std::string::npos : bytes.rfind('\n', place - 1);
    const size_t from = before == std::string::npos ? 0 : before + 1;
    const size_t end = bytes.find('\n', from);
    return std::pair(from, (end == std::string::npos ? bytes.size() : end) - from);
  };
  auto a = line_at(Place(bytes, rng)), b = line_at(Place(bytes, rng));
  if (a.first > b.first) std::swap(a, b);
  if (a.first + a.second > b.first) return;
  const std::string first = bytes.substr(a.first, a.second);
  const std::string second = bytes.substr(b.first, b.second);
  bytes.replace(b.first, b.second, first);
  bytes.replace(a.first, a.second, second);
}

void Change(std::span<const std::string> seeds, std::string& bytes, Rng& rng) {
  constexpr int kKinds = 10, kLongest = 64;
  const size_t at = Place(bytes, rng);
  const auto length = static_cast<size_t>(1 + rng.Index(kLongest));
  switch (rng.Index(kKinds)) {
    case 0:
    case 1:
      if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ 1 << rng.Index(8));
      break;
    case 2:
      if (!bytes.empty()) bytes[at] = static_cast<char>(rng.Index(256));
      break;
    case 3:
      bytes.resize(at);
      break;
    case 4:
      bytes.erase(at, length);
      break;
    case 5:
      bytes.insert(Place(bytes, rng), bytes.substr(at, length));
      break;
    case 6:
    case 7:
      ReplaceNumber(bytes, rng);
      break;
    case 8:
      if (rng.Index(2) == 0) {
        ExchangeLines(bytes, rng);
      } else {
        const std::string& other =
            seeds[static_cast<size_t>(rng.Index(static_cast<int>(seeds.size())))];
        bytes.replace(at, std::min(length, bytes.size() - at),
                      other.substr(Place(other, rng), length));
      }
      break;
    default:
      bytes.insert(at, OneOf(kTexts, rng));
  }
}

}  // namespace

std::string Mutated(std::span<const std::string> seeds, Rng& rng) {
  constexpr int kMaxChanges = 4;
  std::string bytes = seeds[static_cast<size_t>(rng.Index(static_cast<int>(seeds.size())))];
  for (int changes = 1 + rng.Index(kMaxChanges); changes > 0; --changes) Change(seeds, bytes, rng);
  return bytes;
}

}  // namespace pickbed::tests
