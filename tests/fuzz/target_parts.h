#pragma once

// Parts that the targets of several formats have.

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "scenes/base/files.h"
#include "tests/fuzz/targets.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {

using Contents = std::vector<std::string>;

// Appends the bytes of a number.
template <typename Value>
void PutNumber(Value value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Returns the bytes of the file of this name that `write` makes.
template <typename Write>
std::string BytesOfFile(const std::string& name, Write write) {
  const TemporaryFolder temporary;
  write(temporary.path() / name);
  return ReadFileBytes(temporary.path() / name);
}

// A target whose code reads one file of this name.
template <typename Read>
FuzzTarget OneFile(const std::string& name, const std::string& file_name, Read read,
                   std::function<Contents()> seeds) {
  const auto run = [file_name, read](const std::filesystem::path& folder,
                                     const std::string& bytes) {
    const std::filesystem::path file = folder / file_name;
    WriteFileAtomically(file, bytes);
    read(file);
  };
  return {name, run, std::move(seeds)};
}

// A law that every accepted input keeps. An input that breaks it ends in another error than a
// refusal, which is a finding.
inline void RequireLaw(bool holds, const std::string& law) {
  if (!holds) throw std::logic_error("an accepted input breaks a law: " + law);
}

}  // namespace pickbed::tests
