#include "scenes/plugin/child_process.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <sstream>
#include <thread>

#include "scenes/base/files.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> Shell(const std::string& script) { return {"sh", "-c", script}; }

std::string ReadAll(int descriptor) {
  std::string text;
  char letter = 0;
  while (read(descriptor, &letter, 1) == 1) text += letter;
  close(descriptor);
  return text;
}

TEST(ChildProcess, ReadsItsInputAndWritesItsOutput) {
  const ChildLog log("", "test");
  ChildProcess child({"cat"}, {}, log);
  const int input = child.TakeInput();
  ASSERT_EQ(write(input, "hello", 5), 5);
  close(input);
  EXPECT_EQ(ReadAll(child.TakeOutput()), "hello");
  EXPECT_EQ(child.End(milliseconds(5000)), "ended with status 0");
}

TEST(ChildProcess, ReportsHowItEnded) {
  const ChildLog log("", "test");
  EXPECT_EQ(ChildProcess(Shell("exit 3"), {}, log).End(milliseconds(5000)), "ended with status 3");
  EXPECT_THAT(ChildProcess(Shell("kill -SEGV $$"), {}, log).End(milliseconds(5000)),
              HasSubstr("was ended by signal 11 (Segmentation fault)"));
  EXPECT_EQ(ChildProcess(Shell("sleep 60"), {}, log).End(milliseconds(10)), "was stopped");
}

TEST(ChildProcess, AMissingProgramIsNamed) {
  const ChildLog log("", "test");
  EXPECT_THAT(ErrorOf([&] {
                ChildProcess({"no_such_program", "x"}, {}, log);
              }),
              HasSubstr("cannot start 'no_such_program': No such file or directory"));
  EXPECT_THAT(ErrorOf([&] { ChildProcess({}, {}, log); }), HasSubstr("command is empty"));
}

TEST(ChildProcess, ItsOwnChildrenEndWithIt) {
  const ChildLog log("", "test");
  ChildProcess child(Shell("sleep 60 & echo $!; wait"), {}, log);
  const int output = child.TakeOutput();
  std::string number;
  for (char letter = 0; read(output, &letter, 1) == 1 && letter != '\n';) number += letter;
  close(output);
  const pid_t grandchild = std::stoi(number);
  EXPECT_EQ(kill(grandchild, 0), 0);
  child.End(milliseconds(0));
  // The grandchild is reaped by another process, which takes a moment.
  const auto is_gone = [&] {
    const std::string status = "/proc/" + number + "/stat";
    if (!std::filesystem::exists(status)) return true;
    try {
      return ReadFileBytes(status).find(") Z ") != std::string::npos;
    } catch (const InputError&) {
      return true;
    }
  };
  for (int i = 0; i < 500 && !is_gone(); ++i) std::this_thread::sleep_for(milliseconds(10));
  EXPECT_TRUE(is_gone());
}

// A socket of a worker or the lock of a folder must not stay open in a child.
TEST(ChildProcess, GetsNoDescriptorsOfThisProcess) {
  const TemporaryFolder folder;
  const int open_file = open((folder.path() / "lock").c_str(), O_RDWR | O_CREAT, 0666);
  ASSERT_GE(open_file, 0);
  const ChildLog log("", "test");
  ChildProcess child(Shell("ls /proc/self/fd | tr '\\n' ' '"), {}, log);
  EXPECT_EQ(ReadAll(child.TakeOutput()), "0 1 2 3 ") << "3 is the folder that ls reads";
  close(open_file);
}

TEST(ChildProcess, GetsDefaultSignalsAndItsEnvironment) {
  const auto before = signal(SIGINT, SIG_IGN);  // as in a worker
  const ChildLog log("", "test");
  ChildProcess child(Shell("grep SigIgn /proc/self/status; echo $PICKBED_TEST"),
                     {"PICKBED_TEST=here"}, log);
  signal(SIGINT, before);
  std::istringstream output(ReadAll(child.TakeOutput()));
  std::string label, environment;
  uint64_t ignored = 0;  // a bit for each signal, from signal 1
  output >> label >> std::hex >> ignored >> environment;
  EXPECT_EQ(label, "SigIgn:");
  // What started this test may ignore others, such as the real-time signals.
  for (const int number : {SIGINT, SIGTERM, SIGPIPE}) EXPECT_FALSE(ignored >> (number - 1) & 1);
  EXPECT_EQ(environment, "here");
}

TEST(ChildLog, KeepsStandardErrorInTheFirstFreeFile) {
  const TemporaryFolder folder;
  {
    ChildLog first(folder.path() / "logs", "estimator"),
        second(folder.path() / "logs", "estimator");
    ChildProcess(Shell("echo one >&2; echo >&2; echo two >&2"), {}, first).End(milliseconds(5000));
    EXPECT_THAT(first.LastLines(9), ElementsAre("one", "two"));
    EXPECT_THAT(first.LastLines(1), ElementsAre("two"));
    first.Mark();
    EXPECT_THAT(first.LastLines(9), IsEmpty());
    ChildProcess(Shell("echo three >&2"), {}, first).End(milliseconds(5000));
    EXPECT_THAT(first.LastLines(9), ElementsAre("three"));
    EXPECT_NE(first.file(), second.file());
  }
  EXPECT_EQ(ReadFileBytes(folder.path() / "logs/estimator_1.log"), "one\n\ntwo\nthree\n");
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "logs/estimator_2.log"))
      << "an empty log is removed";
  const ChildLog third(folder.path() / "logs", "estimator");
  EXPECT_EQ(third.file().filename(), "estimator_2.log") << "an earlier log is never overwritten";
}

}  // namespace
}  // namespace pickbed::tests
