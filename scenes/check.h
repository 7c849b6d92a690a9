#pragma once

// Errors that a user can cause, and how they are worded.
//
// Bad input throws InputError with one line that names the file, line, key and value and says what
// to do; the command line prints that line and exits 1. Anything else that is thrown is our fault
// and exits 2. Libraries never print.

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace pickbed {

// Bad input: what() is one finished sentence for the user.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws InputError(message) unless `ok`.
void CheckInput(bool ok, const std::string& message);

// The candidate with the smallest edit distance to `word`; empty when nothing is near enough to be
// a likely slip (more than a third of the letters differ).
std::string NearestName(std::string_view word, const std::vector<std::string>& candidates);

// "unknown <kind> 'word'; did you mean 'x'? known: a, b, c" as one line.
std::string UnknownNameMessage(std::string_view kind, std::string_view word,
                               const std::vector<std::string>& candidates);

}  // namespace pickbed
