#include "eval/runtime/process_pool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>
#include <set>

#include "scenes/base/error.h"
#include "tests/support/error_of.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// A plan whose items reply with their square; `trouble` runs before each item.
WorkerPlan Squares(int items, int jobs, const std::function<void(int)>& trouble,
                   std::map<int, std::string>& replies) {
  WorkerPlan plan;
  for (int i = 0; i < items; ++i) plan.items.push_back(i);
  plan.jobs = jobs;
  plan.start = [trouble](const WorkerPlan::Say&) {
    return [trouble](int item) {
      trouble(item);
      return std::to_string(item * item);
    };
  };
  plan.on_done = [&replies](int item, const std::string& reply) {
    EXPECT_TRUE(replies.emplace(item, reply).second) << "item " << item << " done twice";
  };
  return plan;
}

void NoTrouble(int) {}

TEST(Workers, EveryItemIsDoneOnceForAnyJobCount) {
  for (int jobs : {1, 2, 5, 40}) {
    std::map<int, std::string> replies;
    const WorkReport report = RunInWorkers(Squares(23, jobs, NoTrouble, replies));
    EXPECT_TRUE(report.lost.empty());
    EXPECT_FALSE(report.stopped);
    ASSERT_EQ(replies.size(), 23u) << jobs << " jobs";
    for (const auto& [item, reply] : replies) EXPECT_EQ(reply, std::to_string(item * item));
  }
}

TEST(Workers, NoItemsStartNoWorker) {
  WorkerPlan plan;
  plan.start = [](const WorkerPlan::Say&) -> WorkerPlan::DoItem {
    throw std::runtime_error("was started");
  };
  EXPECT_TRUE(RunInWorkers(plan).lost.empty());
}

TEST(Workers, CrashLosesOneItem) {
  for (int jobs : {1, 3}) {
    std::map<int, std::string> replies;
    const auto crash = [](int item) {
      if (item == 4) raise(SIGKILL);
    };
    const WorkReport report = RunInWorkers(Squares(10, jobs, crash, replies));
    ASSERT_EQ(report.lost.size(), 1u);
    EXPECT_EQ(report.lost[0].item, 4);
    EXPECT_THAT(report.lost[0].why, HasSubstr("signal 9"));
    EXPECT_TRUE(LacksMemory(report.lost[0].why));
    EXPECT_EQ(replies.size(), 9u);
    EXPECT_FALSE(replies.contains(4));
  }
}

TEST(Workers, ExceptionLosesOneItemAndKeepsItsText) {
  std::map<int, std::string> replies;
  const auto fail = [](int item) {
    if (item % 4 == 1) throw std::logic_error("odd thing " + std::to_string(item));
  };
  const WorkReport report = RunInWorkers(Squares(10, 2, fail, replies));
  std::set<std::string> reasons;
  for (const LostItem& lost : report.lost) reasons.insert(lost.why);
  EXPECT_EQ(reasons, (std::set<std::string>{"odd thing 1", "odd thing 5", "odd thing 9"}));
  EXPECT_EQ(replies.size(), 7u);
}

TEST(Workers, LostItemsAreRetriedAsPlanned) {
  const TemporaryFolder temporary;
  const auto attempt_log = [&](int item) { return temporary.path() / std::to_string(item); };
  for (const bool crash : {true, false}) {
    std::map<int, std::string> replies;
    const auto fail = [&](int item) {
      std::ofstream(attempt_log(item), std::ios::app).put('x').flush();
      const bool fails =
          item == 4 || (item == 6 && std::filesystem::file_size(attempt_log(item)) == 1);
      if (!fails) return;
      if (crash) raise(SIGKILL);
      throw std::logic_error("odd");
    };
    WorkerPlan plan = Squares(10, 2, fail, replies);
    plan.retries = 1;
    std::vector<int> reported;
    plan.on_lost = [&](int item, const std::string&) { reported.push_back(item); };
    const WorkReport report = RunInWorkers(plan);
    ASSERT_EQ(report.lost.size(), 1u);
    EXPECT_EQ(report.lost[0].item, 4);
    EXPECT_EQ(reported, std::vector<int>{4});
    EXPECT_EQ(replies.size(), 9u);
    EXPECT_EQ(std::filesystem::file_size(attempt_log(4)), 2u);
    for (int item = 0; item < 10; ++item) std::filesystem::remove(attempt_log(item));
  }
}

TEST(Workers, WorkersKeepToTheirGroup) {
  std::map<int, std::string> replies;
  WorkerPlan plan = Squares(
      40, 2, [](int) { usleep(2000); }, replies);
  plan.group = [](int item) { return item % 4; };
  plan.start = [](const WorkerPlan::Say&) {
    return [last = -1, changes = 0](int item) mutable {
      usleep(2000);
      if (item % 4 != last) ++changes;
      last = item % 4;
      return std::to_string(getpid()) + " " + std::to_string(changes);
    };
  };
  RunInWorkers(plan);
  std::map<int, int> changes;  // by process
  for (const auto& [item, reply] : replies) {
    const size_t space = reply.find(' ');
    int& maximum = changes[std::stoi(reply)];
    maximum = std::max(maximum, std::stoi(reply.substr(space)));
  }
  int all = 0;
  for (const auto& [process, count] : changes) all += count;
  EXPECT_EQ(replies.size(), 40u);
  EXPECT_LE(all, 5) << "four groups, of which the last may be shared";
}

TEST(Workers, NeedlessItemsAreSkipped) {
  for (const int jobs : {1, 3}) {
    std::map<int, std::string> replies;
    WorkerPlan plan = Squares(40, jobs, NoTrouble, replies);
    plan.needless = [&](int item) { return item % 2 == 1 || replies.size() >= 10; };
    EXPECT_TRUE(RunInWorkers(plan).lost.empty());
    EXPECT_GE(replies.size(), 10u);
    EXPECT_LT(replies.size(), 10u + jobs) << "only items in progress are finished";
    for (const auto& [item, reply] : replies) EXPECT_EQ(item % 2, 0);
  }
}

TEST(Workers, InputErrorOfAWorkerIsRethrown) {
  std::map<int, std::string> replies;
  const auto refuse = [](int item) {
    if (item == 2) throw InputError("disk is full");
  };
  try {
    RunInWorkers(Squares(5, 2, refuse, replies));
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    EXPECT_STREQ(error.what(), "disk is full");
  }
}

// A shared folder that fails for a moment must not cost the items their results.
TEST(Workers, AFolderThatCannotBeReachedEndsTheRunAndLosesNoItem) {
  std::map<int, std::string> replies;
  const auto refuse = [](int item) {
    if (item == 2) {
      throw std::filesystem::filesystem_error("stat", "shared/pictures",
                                              std::make_error_code(std::errc::io_error));
    }
  };
  EXPECT_THAT(ErrorOf([&] { RunInWorkers(Squares(5, 1, refuse, replies)); }),
              AllOf(HasSubstr("'shared/pictures'"), HasSubstr("Input/output error"),
                    HasSubstr("repeat the command")));
  EXPECT_EQ(replies.size(), 2u);
}

TEST(Workers, StartFailureIsRethrownWithItsType) {
  WorkerPlan plan;
  plan.items = {0, 1};
  plan.jobs = 2;
  plan.start = [](const WorkerPlan::Say&) -> WorkerPlan::DoItem {
    throw InputError("model is broken");
  };
  EXPECT_THROW(RunInWorkers(plan), InputError);
  plan.start = [](const WorkerPlan::Say&) -> WorkerPlan::DoItem {
    throw std::logic_error("no pieces");
  };
  EXPECT_THROW(RunInWorkers(plan), std::runtime_error);
  plan.start = [](const WorkerPlan::Say&) -> WorkerPlan::DoItem {
    raise(SIGSEGV);
    return nullptr;
  };
  EXPECT_THROW(RunInWorkers(plan), std::runtime_error);
}

TEST(Workers, AWorkerKilledInItsStartIsReplacedAsOftenAsPlanned) {
  const TemporaryFolder temporary;
  const std::filesystem::path log = temporary.path() / "starts";
  for (const int kills : {1, 2}) {
    std::map<int, std::string> replies;
    WorkerPlan plan = Squares(3, 1, NoTrouble, replies);
    plan.retries = 1;
    plan.start = [&, inner = plan.start](const WorkerPlan::Say& say) {
      std::ofstream(log, std::ios::app).put('x').flush();
      if (std::filesystem::file_size(log) <= static_cast<size_t>(kills)) raise(SIGKILL);
      return inner(say);
    };
    if (kills == 1) {
      EXPECT_TRUE(RunInWorkers(plan).lost.empty());
      EXPECT_EQ(replies.size(), 3u);
    } else {
      EXPECT_THAT(ErrorOf([&] { RunInWorkers(plan); }),
                  HasSubstr("while starting a worker, the worker was killed (signal 9), often "
                            "because the memory limit was reached; use fewer workers"));
    }
    std::filesystem::remove(log);
  }
}

// A signal to the whole process group ends a worker, and the run stops. It is no fault.
TEST(Workers, AWorkerThatTheStopEndedInItsStartIsNoFault) {
  for (const int ending : {SIGTERM, SIGKILL}) {
    bool stop = false;
    WorkerPlan plan;
    plan.items = {0};
    plan.start = [&](const WorkerPlan::Say& say) -> WorkerPlan::DoItem {
      say("begun");
      usleep(50000);
      raise(ending);
      return nullptr;
    };
    plan.on_message = [&](const std::string&) { stop = true; };
    plan.stop = [&stop, asked = 0]() mutable { return stop && asked++ > 0; };
    EXPECT_TRUE(RunInWorkers(plan).stopped);
  }
}

TEST(Workers, LackOfMemoryIsReportedAsSuch) {
  std::map<int, std::string> replies;
  const WorkReport report = RunInWorkers(Squares(
      1, 1, [](int) { throw std::bad_alloc(); }, replies));
  ASSERT_EQ(report.lost.size(), 1u);
  EXPECT_EQ(report.lost[0].why,
            "the worker has not enough memory; use fewer workers or more memory");
  EXPECT_TRUE(LacksMemory(report.lost[0].why));
  EXPECT_FALSE(LacksMemory("map::at"));
}

TEST(Workers, StopEndsWorkersAtOnce) {
  std::map<int, std::string> replies;
  WorkerPlan plan = Squares(
      100, 2,
      [](int item) {
        if (item >= 4) sleep(1000);
      },
      replies);
  plan.stop = [&] { return replies.size() == 4; };
  const WorkReport report = RunInWorkers(plan);
  EXPECT_TRUE(report.stopped);
  EXPECT_EQ(replies.size(), 4u);
}

TEST(Workers, WorkersStartConcurrently) {
  // Each start waits until the others have begun.
  constexpr int kJobs = 3, kPolls = 1000;
  const TemporaryFolder temporary;
  const auto begun = [&] {
    return std::distance(std::filesystem::directory_iterator(temporary.path()), {});
  };
  std::map<int, std::string> replies;
  WorkerPlan plan = Squares(
      8, kJobs, [](int) { usleep(50000); }, replies);
  std::vector<std::string> said;
  plan.on_message = [&said](const std::string& line) { said.push_back(line); };
  plan.start = [&, inner = plan.start](const WorkerPlan::Say& say) {
    std::ofstream(temporary.path() / std::to_string(getpid())).put(1);
    for (int i = 0; i < kPolls && begun() < kJobs; ++i) usleep(10000);
    say(begun() == kJobs ? "together" : "alone");
    return inner(say);
  };
  RunInWorkers(plan);
  EXPECT_EQ(std::count(said.begin(), said.end(), "together"), kJobs);
}

TEST(Workers, WhatAWorkerHoldsIsDestroyedAfterItsLastItem) {
  const TemporaryFolder temporary;
  const auto held_file = [&](const char* end) {
    return temporary.path() / (std::to_string(getpid()) + end);
  };
  struct Held {
    std::filesystem::path begun, ended;
    Held(std::filesystem::path begun_file, std::filesystem::path ended_file)
        : begun(std::move(begun_file)), ended(std::move(ended_file)) {
      std::ofstream(begun).put('x');
    }
    ~Held() { std::filesystem::rename(begun, ended); }
  };
  std::map<int, std::string> replies;
  WorkerPlan plan = Squares(4, 2, NoTrouble, replies);
  plan.start = [&](const WorkerPlan::Say&) {
    const auto held = std::make_shared<Held>(held_file(".begun"), held_file(".ended"));
    return [held](int) { return std::string(); };
  };
  RunInWorkers(plan);
  // One worker may finish all items while the other one starts, which is then killed.
  int ended = 0;
  for (const auto& file : std::filesystem::directory_iterator(temporary.path())) {
    ended += file.path().extension() == ".ended";
  }
  EXPECT_GE(ended, 1);
}

// Else the calling process would wait for a dead worker as long as the program runs.
TEST(Workers, AProgramThatAWorkerStartedDoesNotHideItsDeath) {
  std::map<int, std::string> replies;
  const WorkerPlan plan = Squares(
      1, 1,
      [](int) {
        if (system("sleep 20 &") == 0) raise(SIGKILL);
      },
      replies);
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(RunInWorkers(plan).lost.size(), 1u);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(15));
}

TEST(Workers, MessagesAndWarningsAreApart) {
  std::map<int, std::string> replies;
  std::vector<std::string> messages, warnings;
  WorkerPlan plan = Squares(1, 1, NoTrouble, replies);
  plan.start = [](const WorkerPlan::Say& say) {
    say("half done");
    say.warning("the program ended");
    return [](int) { return std::string(); };
  };
  plan.on_message = [&](const std::string& line) { messages.push_back(line); };
  plan.on_warning = [&](const std::string& line) { warnings.push_back(line); };
  RunInWorkers(plan);
  EXPECT_EQ(messages, std::vector<std::string>{"half done"});
  EXPECT_EQ(warnings, std::vector<std::string>{"the program ended"});
}

}  // namespace
}  // namespace pickbed::tests
