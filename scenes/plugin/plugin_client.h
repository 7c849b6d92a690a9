#pragma once

// A plug-in: another program that estimates poses or plans grasps and answers requests. It is a
// child process that talks over its standard input and output, or a server on a TCP socket.
//
// The messages are maps with a key "verb" (scenes/plugin/plugin_messages.h). docs/pages/reference/
// plugin_protocol.md describes them for authors of plug-ins.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "scenes/plugin/channel.h"
#include "scenes/plugin/child_process.h"
#include "scenes/plugin/message.h"

namespace pickbed::scenes {

inline constexpr int kPluginProtocol = 1;

// Words that a plug-in may list in `needs`: inputs without which it cannot work.
inline constexpr char kNeedsColor[] = "color";    // the image has a color
inline constexpr char kNeedsBin[] = "bin";        // the pose of the bin is known
inline constexpr char kNeedsCounts[] = "counts";  // the number of instances is known

// How a request failed.
enum class PluginFault {
  kCrashed,   // the program ended or closed its stream
  kReported,  // the program reported an error and goes on
  kTimeout,   // no answer in time
  kMalformed  // the answer breaks the rules
};

// A failed request.
class PluginError : public std::runtime_error {
 public:
  PluginError(PluginFault plugin_fault, const std::string& text,
              std::vector<std::string> traceback_lines = {})
      : std::runtime_error(text), fault(plugin_fault), traceback(std::move(traceback_lines)) {}

  PluginFault fault;
  std::vector<std::string> traceback;  // the program's own report, by line; may be empty
};

// How to reach a plug-in. Exactly one of `command` and `connect` is given.
struct PluginAddress {
  std::vector<std::string> command = {};  // a program and its arguments
  std::string connect = {};               // host:port
  double timeout_s = 60;                  // maximum time for the answer to an image
  std::filesystem::path log_dir = {};     // for the standard error of a child; empty = no file
  // Maximum time for each answer of the start, unless timeout_s is longer. Programs load libraries
  // and networks then.
  double start_timeout_s = 60;

  // Returns the command or address in words, for messages.
  std::string InWords() const;
};

// What the plug-in reports about itself.
struct PluginIdentity {
  std::string name;
  std::string version;             // its own version, such as a hash of its weights; may be empty
  std::vector<std::string> roles;  // "estimator", "planner"
  std::vector<std::string> needs;  // kNeedsColor, kNeedsBin, kNeedsCounts
};

// Seconds of the requests that start a plug-in.
struct PluginStartTimes {
  double hello_s = 0;  // includes the start of the program
  double setup_s = 0;
};

// Client of one plug-in.
class PluginClient {
 public:
  // Writes the entries of a message.
  using Write = std::function<void(MessageWriter&)>;

  // Starts the plug-in in a role ("estimator" or "planner") with the message that `write_setup`
  // writes. Data that the message refers to must outlive this object, because the message is sent
  // again when the plug-in is started again. Throws InputError if the address is wrong, or if the
  // plug-in does not start, speaks another protocol, has not the role or refuses its setup.
  PluginClient(const PluginAddress& address, const std::string& role, const Write& write_setup);
  ~PluginClient();  // calls Close()

  // Starts the plug-in, asks what it is and closes it again, without a setup. Throws as above.
  static PluginIdentity IdentityOf(const PluginAddress& address, const std::string& role);

  PluginClient(const PluginClient&) = delete;
  PluginClient& operator=(const PluginClient&) = delete;

  // Sends a request and returns the answer, which has no "error". Throws PluginError. A plug-in
  // that ended, gave no answer in time or broke the stream is started again by the next request.
  MessageValue Ask(const MessageWriter& request);

  // Sends "close", waits up to kCloseGrace for the end of a child and then kills it. Returns how it
  // ended, see ChildProcess::End(). The next request starts the plug-in again.
  std::string Close();
  static constexpr std::chrono::milliseconds kCloseGrace{2000};

  const PluginIdentity& identity() const { return identity_; }
  const PluginStartTimes& start_times() const { return start_times_; }
  const std::filesystem::path& log_file() const { return log_->file(); }
  // Number of starts after the first one.
  int restarts() const { return restarts_; }

 private:
  PluginClient(const PluginAddress& address, const std::string& role);
  void Open();
  void Start();
  // Calls Open() or Start(); rethrows a PluginError as InputError.
  void First(void (PluginClient::*start)());
  void SayHello();
  MessageValue Exchange(const MessageWriter& request, double limit_s);
  std::string Stop(std::chrono::milliseconds grace);
  [[noreturn]] void ThrowBroken(const ReceivedMessage& received, double limit_s);
  double StartLimit_s() const;

  PluginAddress address_;
  std::string role_;
  MessageWriter setup_;
  PluginIdentity identity_;
  PluginStartTimes start_times_;
  std::unique_ptr<ChildLog> log_;
  std::unique_ptr<ChildProcess> child_;
  std::unique_ptr<MessageChannel> channel_;
  bool was_started_ = false;
  int restarts_ = 0;
};

}  // namespace pickbed::scenes
