#pragma once

// A child program that talks over its standard input and output. Its standard error goes to a log.

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace pickbed::scenes {

// The log of a child: a file FOLDER/NAME_1.log, or the first number that is free. A log without
// text is removed at the end. Without a folder, the log is only in memory.
class ChildLog {
 public:
  // Throws InputError if the file cannot be created.
  ChildLog(const std::filesystem::path& folder, const std::string& name);
  ~ChildLog();
  ChildLog(const ChildLog&) = delete;
  ChildLog& operator=(const ChildLog&) = delete;

  int descriptor() const { return descriptor_; }
  const std::filesystem::path& file() const { return file_; }  // empty without a folder

  // Begins the text of a new child. LastLines() does not return earlier text.
  void Mark();
  // Returns the last lines since Mark(), at most `max_lines`.
  std::vector<std::string> LastLines(size_t max_lines) const;

 private:
  int descriptor_ = -1;
  std::filesystem::path file_;
  off_t begin_ = 0;
};

// A running child. It is the leader of its own process group, so that Ctrl-C does not reach it and
// its own children end with it. It is killed when this process ends.
class ChildProcess {
 public:
  // Starts `command`: a program of PATH and its arguments. The child gets no descriptors besides
  // the standard ones. `environment` is added to the environment, as "NAME=value". Throws
  // InputError if it cannot be started.
  ChildProcess(const std::vector<std::string>& command, const std::vector<std::string>& environment,
               const ChildLog& log);
  // Kills the group and reaps the child.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  // Return the ends of the pipes and give them away; the caller closes them.
  int TakeInput() { return std::exchange(input_, -1); }    // the child reads it
  int TakeOutput() { return std::exchange(output_, -1); }  // the child writes it

  // Waits up to `grace` for the end of the child, then kills its group. Returns how the child
  // ended: "ended with status 1", "was ended by signal 11 (Segmentation fault)" or "was stopped".
  std::string End(std::chrono::milliseconds grace);

 private:
  bool HasEnded() const;

  pid_t pid_ = -1;
  int input_ = -1;
  int output_ = -1;
};

}  // namespace pickbed::scenes
