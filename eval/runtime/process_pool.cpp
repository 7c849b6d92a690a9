#include "eval/runtime/process_pool.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "scenes/base/error.h"

namespace pickbed::eval {
namespace {

constexpr int kPollMs = 200;                      // poll interval at which `stop` is checked
constexpr int kNoItem = -1;                       // item of an idle worker
constexpr std::chrono::seconds kEndLimit{10};     // for idle workers to end
constexpr std::chrono::milliseconds kEndPoll{1};  // poll interval in this time

enum class Kind : uint8_t { kReady, kDone, kSaid, kWarned, kFailed, kBadInput };

// Message on the socket: kind, length, bytes.
struct Message {
  Kind kind = Kind::kReady;
  std::string text;
};

bool ReadBytes(int socket, void* data, size_t size) {
  auto* bytes = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t got = read(socket, bytes, size);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    bytes += got;
    size -= got;
  }
  return true;
}

bool SendBytes(int socket, const void* data, size_t size) {
  const auto* bytes = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = send(socket, bytes, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes += sent;
    size -= sent;
  }
  return true;
}

bool SendMessage(int socket, Kind kind, std::string_view text) {
  const uint32_t length = static_cast<uint32_t>(text.size());
  return SendBytes(socket, &kind, sizeof(kind)) && SendBytes(socket, &length, sizeof(length)) &&
         SendBytes(socket, text.data(), length);
}

std::optional<Message> ReadMessage(int socket) {
  Message message;
  uint32_t length = 0;
  if (!ReadBytes(socket, &message.kind, sizeof(message.kind))) return std::nullopt;
  if (!ReadBytes(socket, &length, sizeof(length))) return std::nullopt;
  message.text.resize(length);
  if (!ReadBytes(socket, message.text.data(), length)) return std::nullopt;
  return message;
}

constexpr std::string_view kMemoryAdvice = "use fewer workers or more memory";
constexpr std::string_view kNoMemory =
    "the worker has not enough memory; use fewer workers or more memory";

// Whether a process was ended by another one or by the kernel, and not by its own fault.
bool WasKilled(int status) {
  return WIFSIGNALED(status) && (WTERMSIG(status) == SIGKILL || WTERMSIG(status) == SIGTERM);
}

// Main loop of a worker: start, then one item after another until the socket closes.
void Serve(const WorkerPlan& plan, int socket) {
  try {
    const WorkerPlan::Say say{
        [socket](std::string_view line) { SendMessage(socket, Kind::kSaid, line); },
        [socket](std::string_view line) { SendMessage(socket, Kind::kWarned, line); }};
    const WorkerPlan::DoItem do_item = plan.start(say);
    SendMessage(socket, Kind::kReady, "");
    int item = 0;
    while (ReadBytes(socket, &item, sizeof(item))) {
      try {
        SendMessage(socket, Kind::kDone, do_item(item));
      } catch (const InputError&) {
        throw;
      } catch (const std::filesystem::filesystem_error&) {
        throw;  // the folder is at fault, and not the item
      } catch (const std::bad_alloc&) {
        SendMessage(socket, Kind::kFailed, kNoMemory);
      } catch (const std::exception& error) {
        SendMessage(socket, Kind::kFailed, error.what());
      }
    }
  } catch (const InputError& error) {
    SendMessage(socket, Kind::kBadInput, error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    SendMessage(socket, Kind::kBadInput,
                fmt::format("cannot use '{}': {}; repeat the command when it can be reached",
                            error.path1().string(), error.code().message()));
  } catch (const std::bad_alloc&) {
    SendMessage(socket, Kind::kBadInput, kNoMemory);
  } catch (const std::exception& error) {
    SendMessage(socket, Kind::kFailed, error.what());
  } catch (...) {  // no exception may unwind into the frames of the parent
    SendMessage(socket, Kind::kFailed, "an exception of unknown type");
  }
}

std::string DeathReason(int status) {
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL) {
    return fmt::format(
        "the worker was killed (signal 9), often because the memory limit was reached; {}",
        kMemoryAdvice);
  }
  if (WIFSIGNALED(status)) {
    return fmt::format("the worker was ended by signal {} ({})", WTERMSIG(status),
                       strsignal(WTERMSIG(status)));
  }
  return fmt::format("the worker ended with status {}", WEXITSTATUS(status));
}

// Worker process as seen by the parent. The destructor ends the process.
class Worker {
 public:
  Worker(const WorkerPlan& plan, const std::vector<std::unique_ptr<Worker>>& others) {
    int pair[2];
    // Programs that a worker starts must not keep its socket open.
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) {
      throw std::runtime_error(fmt::format("cannot open a socket: {}", strerror(errno)));
    }
    const pid_t parent = getpid();
    pid_ = fork();
    if (pid_ < 0) throw std::runtime_error(fmt::format("cannot fork: {}", strerror(errno)));
    if (pid_ == 0) {
      // Ctrl-C reaches the whole process group, but only the parent reacts. A worker ends with its
      // parent.
      signal(SIGINT, SIG_IGN);
      signal(SIGTERM, SIG_DFL);
      prctl(PR_SET_PDEATHSIG, SIGKILL);
      if (getppid() != parent) _exit(1);
      close(pair[0]);
      for (const auto& other : others) close(other->socket_);
      Serve(plan, pair[1]);
      // No destructors: static state belongs to the parent.
      _exit(0);
    }
    close(pair[1]);
    socket_ = pair[0];
  }
  ~Worker() {
    if (socket_ >= 0) close(socket_);
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  int socket() const { return socket_; }
  bool ready() const { return ready_; }
  bool idle() const { return ready_ && item_ == kNoItem; }
  int item() const { return item_; }
  std::optional<int> group() const { return group_; }

  void SetReady() { ready_ = true; }
  void Assign(int item, int group) {
    item_ = item;
    group_ = group;
    // A dead worker is detected when its socket is read.
    SendBytes(socket_, &item, sizeof(item));
  }
  void SetIdle() { item_ = kNoItem; }

  // Lets an idle worker end by itself, so that it can end programs that it started.
  void LetEnd() {
    if (idle()) close(std::exchange(socket_, -1));
  }
  // Waits until a worker after LetEnd() has ended, or until the deadline.
  void WaitUntil(std::chrono::steady_clock::time_point deadline) {
    while (socket_ < 0 && pid_ > 0 && std::chrono::steady_clock::now() < deadline) {
      if (waitpid(pid_, nullptr, WNOHANG) == pid_) {
        pid_ = -1;
      } else {
        std::this_thread::sleep_for(kEndPoll);
      }
    }
  }

  // Waits for the end of the process and returns its status.
  int Reap() {
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_ = -1;
  int socket_ = -1;
  bool ready_ = false;
  int item_ = kNoItem;
  std::optional<int> group_;  // of the last item
};

// Parent side: distributes the items and handles replies.
class ItemDispatcher {
 public:
  explicit ItemDispatcher(const WorkerPlan& plan) : plan_(plan) {
    for (const int item : plan.items) waiting_[GroupOf(item)].push_back(item);
    waiting_items_ = static_cast<int>(plan.items.size());
  }

  WorkReport Run() {
    while (waiting_items_ > 0 || busy() > 0) {
      if (plan_.stop && plan_.stop()) {
        report_.stopped = true;
        break;
      }
      StartWorkers();
      for (auto& worker : workers_) {
        if (worker->idle() && waiting_items_ > 0) Give(*worker);
      }
      Listen();
    }
    for (const auto& worker : workers_) worker->LetEnd();
    const auto deadline = std::chrono::steady_clock::now() + kEndLimit;
    for (const auto& worker : workers_) worker->WaitUntil(deadline);
    workers_.clear();
    return std::move(report_);
  }

 private:
  int busy() const {
    return static_cast<int>(std::count_if(workers_.begin(), workers_.end(), [](const auto& worker) {
      return worker->item() != kNoItem;
    }));
  }

  int GroupOf(int item) const { return plan_.group ? plan_.group(item) : 0; }

  // Group of the worker's last item; else a group without a worker; else the group with most items.
  int GroupFor(const Worker& worker) const {
    if (worker.group() && waiting_.contains(*worker.group())) return *worker.group();
    for (const auto& [group, items] : waiting_) {
      const bool taken = std::any_of(workers_.begin(), workers_.end(),
                                     [&](const auto& other) { return other->group() == group; });
      if (!taken) return group;
    }
    return std::max_element(
               waiting_.begin(), waiting_.end(),
               [](const auto& a, const auto& b) { return a.second.size() < b.second.size(); })
        ->first;
  }

  // Assigns the next item that is needed; none if all waiting items are needless.
  void Give(Worker& worker) {
    while (waiting_items_ > 0 && worker.idle()) {
      const auto group = waiting_.find(GroupFor(worker));
      const int item = group->second.front();
      const bool needless = plan_.needless && plan_.needless(item);
      if (!needless) worker.Assign(item, group->first);
      group->second.pop_front();
      if (group->second.empty()) waiting_.erase(group);
      --waiting_items_;
    }
  }

  // Queues the item again, or reports it as lost after `retries`.
  void Retry(int item, const std::string& why) {
    if (tried_[item]++ < plan_.retries) {
      waiting_[GroupOf(item)].push_front(item);
      ++waiting_items_;
      return;
    }
    report_.lost.push_back({item, why});
    if (plan_.on_lost) plan_.on_lost(item, why);
  }

  // Starts workers up to the number of jobs or of remaining items.
  void StartWorkers() {
    const int wanted = std::min<int>(plan_.jobs, busy() + waiting_items_);
    while (static_cast<int>(workers_.size()) < wanted) {
      workers_.push_back(std::make_unique<Worker>(plan_, workers_));
    }
  }

  void Listen() {
    std::vector<pollfd> polled;
    for (const auto& worker : workers_) polled.push_back({worker->socket(), POLLIN, 0});
    if (poll(polled.data(), polled.size(), kPollMs) <= 0) return;
    for (size_t i = polled.size(); i-- > 0;) {
      if (polled[i].revents == 0) continue;
      const auto message = ReadMessage(workers_[i]->socket());
      if (message) {
        Take(*message, *workers_[i]);
      } else {
        RemoveEnded(i);
      }
    }
  }

  void Take(const Message& message, Worker& worker) {
    switch (message.kind) {
      case Kind::kReady:
        worker.SetReady();
        return;
      case Kind::kSaid:
        if (plan_.on_message) plan_.on_message(message.text);
        return;
      case Kind::kWarned:
        if (plan_.on_warning) plan_.on_warning(message.text);
        return;
      case Kind::kDone:
        if (plan_.on_done) plan_.on_done(worker.item(), message.text);
        worker.SetIdle();
        return;
      case Kind::kFailed:
        if (!worker.ready()) throw std::runtime_error(message.text);
        Retry(worker.item(), message.text);
        worker.SetIdle();
        return;
      case Kind::kBadInput:
        throw InputError(message.text);
    }
  }

  void RemoveEnded(size_t index) {
    const int item = workers_[index]->item();
    const bool was_ready = workers_[index]->ready();
    const int status = workers_[index]->Reap();
    const std::string why = DeathReason(status);
    workers_.erase(workers_.begin() + index);
    if (!was_ready) {
      // A signal to all processes of the run may end a worker before `stop` sees it.
      if (plan_.stop && plan_.stop()) return;
      const std::string message = "while starting a worker, " + why;
      if (!WasKilled(status)) throw std::runtime_error(message);
      CheckInput(starts_lost_++ < plan_.retries, message);
    }
    if (item != kNoItem) Retry(item, why);
  }

  const WorkerPlan& plan_;
  std::map<int, std::deque<int>> waiting_;  // by group; no group is empty
  int waiting_items_ = 0;
  std::map<int, int> tried_;  // failed executions by item
  int starts_lost_ = 0;       // workers that were killed before they were ready
  std::vector<std::unique_ptr<Worker>> workers_;
  WorkReport report_;
};

}  // namespace

bool LacksMemory(std::string_view why) { return why.ends_with(kMemoryAdvice); }

WorkReport RunInWorkers(const WorkerPlan& plan) { return ItemDispatcher(plan).Run(); }

}  // namespace pickbed::eval
