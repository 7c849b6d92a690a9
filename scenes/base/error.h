#pragma once

// Errors that a user can cause, and their wording.
//
// Bad input throws InputError. Its message is one line with the file, line, key, value and a
// remedy. The command line prints that line and exits with status 1. Any other exception is a
// defect of the program and exits with status 2. Libraries never print.

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace pickbed::scenes {

// Bad input; what() is one complete sentence for the user.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Throws InputError(message) unless `ok`.
void CheckInput(bool ok, const std::string& message);

// Returns the candidate with the smallest edit distance to `word`. The result is empty when more
// than a third of the letters differ in every candidate, because a typing error is then unlikely.
std::string NearestName(std::string_view word, const std::vector<std::string>& candidates);

// Returns one line: "unknown <kind> 'word'; did you mean 'x'? known: a, b, c".
std::string UnknownNameMessage(std::string_view kind, std::string_view word,
                               const std::vector<std::string>& candidates);

}  // namespace pickbed::scenes
