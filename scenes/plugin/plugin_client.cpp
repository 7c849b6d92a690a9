#include "scenes/plugin/plugin_client.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/base/settings_tree.h"

namespace pickbed::scenes {
namespace {

constexpr size_t kTracebackLines = 30;
constexpr std::chrono::milliseconds kGraceAfterEnd{500};  // between a closed stream and the end

Deadline DeadlineIn(double seconds) {
  const std::chrono::duration<double> wait(seconds);
  return PluginClock::now() + std::chrono::duration_cast<PluginClock::duration>(wait);
}

double SecondsSince(PluginClock::time_point start) {
  return std::chrono::duration<double>(PluginClock::now() - start).count();
}

// Lets a child written in Python import pickbed_plugin without an installation. Its output stays
// buffered, so that pickbed_plugin can keep early prints out of the stream of messages.
std::vector<std::string> ChildEnvironment() {
  const char* path = std::getenv("PYTHONPATH");
  const std::string rest = path == nullptr || *path == '\0' ? "" : fmt::format(":{}", path);
  return {fmt::format("PYTHONPATH={}{}", PythonDir().string(), rest),
          "PYTHONUNBUFFERED=", "PICKBED_PLUGIN=1"};
}

bool IsText(const std::vector<std::byte>& bytes) {
  return std::all_of(bytes.begin(), bytes.begin() + 4, [](std::byte byte) {
    const auto letter = std::to_integer<unsigned char>(byte);
    return std::isprint(letter) != 0 || std::isspace(letter) != 0;
  });
}

// The beginning of a stream that is no message, with one line of printable characters.
std::string Quoted(const std::vector<std::byte>& bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    const auto letter = std::to_integer<unsigned char>(byte);
    if (letter == '\n' || letter == '\r') break;
    text += std::isprint(letter) != 0 ? static_cast<char>(letter) : '?';
  }
  return text;
}

std::vector<std::string> Lines(const std::string& text) {
  std::vector<std::string> lines;
  size_t begin = 0;
  while (begin < text.size()) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    if (end > begin) lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  if (lines.size() > kTracebackLines) lines.erase(lines.begin(), lines.end() - kTracebackLines);
  return lines;
}

std::vector<std::string> TextsIn(const MessageValue& map, std::string_view key) {
  std::vector<std::string> texts;
  if (const MessageValue* list = map.Find(key)) {
    for (const MessageValue& item : list->Items(key)) texts.push_back(item.Text(key));
  }
  return texts;
}

// Returns the inputs that the plug-in needs. Throws MessageError for an unknown one.
std::vector<std::string> NeedsIn(const MessageValue& hello) {
  static const std::vector<std::string> kKnown{kNeedsColor, kNeedsBin, kNeedsCounts};
  std::vector<std::string> needs = TextsIn(hello, "needs");
  for (const std::string& need : needs) {
    if (std::find(kKnown.begin(), kKnown.end(), need) != kKnown.end()) continue;
    throw MessageError(UnknownNameMessage("word in needs:", need, kKnown));
  }
  return needs;
}

// A plug-in with a misspelled key would run without the inputs that it needs. It may have other
// keys of its own.
void RequireSoundKeys(const MessageValue& hello) {
  if (hello.map() == nullptr) return;
  const auto may_be = [](const std::string& known, const MessageValue& value) {
    return (known != "roles" && known != "needs") || value.list() != nullptr;
  };
  for (const auto& [key, value] : *hello.map()) {
    for (const char* known : {"protocol", "name", "version", "roles", "needs"}) {
      if (IsDamagedKey(key, known) && hello.Find(known) == nullptr && may_be(known, value)) {
        throw MessageError(
            fmt::format("it has the unknown key '{}'; did you mean {}?", OneLine(key), known));
      }
    }
  }
}

std::string JoinedLines(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

}  // namespace

std::string PluginAddress::InWords() const {
  return command.empty() ? connect : fmt::format("{}", fmt::join(command, " "));
}

PluginClient::PluginClient(const PluginAddress& address, const std::string& role)
    : address_(address), role_(role) {
  CheckInput(address.command.empty() != address.connect.empty(),
             address.connect.empty()
                 ? "neither command nor connect is given; set command, for example "
                   "[python3, my_estimator.py], or connect: host:port"
                 : "both command and connect are given; remove one of them");
  log_ = std::make_unique<ChildLog>(address.command.empty() ? "" : address.log_dir, role);
}

PluginClient::PluginClient(const PluginAddress& address, const std::string& role,
                           const Write& write_setup)
    : PluginClient(address, role) {
  write_setup(setup_);
  First(&PluginClient::Start);
}

PluginIdentity PluginClient::IdentityOf(const PluginAddress& address, const std::string& role) {
  PluginClient client(address, role);
  client.First(&PluginClient::Open);
  return client.identity_;
}

void PluginClient::First(void (PluginClient::*start)()) {
  try {
    (this->*start)();
  } catch (const PluginError& error) {
    const std::string log =
        log_file().empty() ? "" : fmt::format("; its log is {}", log_file().string());
    throw InputError(fmt::format("'{}' {}{}", address_.InWords(), JoinedLines(error.what()), log));
  }
}

PluginClient::~PluginClient() { Close(); }

std::string PluginClient::Close() {
  if (channel_ == nullptr) return "was stopped";
  MessageWriter close;
  close.BeginMap(1);
  close.Text("verb");
  close.Text("close");
  channel_->Send(close, PluginClock::now() + kCloseGrace);
  channel_->CloseOutput();
  return Stop(kCloseGrace);
}

std::string PluginClient::Stop(std::chrono::milliseconds grace) {
  std::string how = "closed the connection";
  if (child_ != nullptr) how = child_->End(grace);
  channel_.reset();
  child_.reset();
  return how;
}

void PluginClient::Open() {
  const auto start = PluginClock::now();
  if (was_started_) ++restarts_;
  log_->Mark();
  if (address_.command.empty()) {
    const auto wait = std::chrono::duration<double>(address_.timeout_s);
    const int socket = ConnectTcp(address_.connect,
                                  start + std::chrono::duration_cast<PluginClock::duration>(wait));
    channel_ = std::make_unique<MessageChannel>(socket, socket);
  } else {
    child_ = std::make_unique<ChildProcess>(address_.command, ChildEnvironment(), *log_);
    const int output = child_->TakeOutput();
    channel_ = std::make_unique<MessageChannel>(output, child_->TakeInput());
  }
  SayHello();
  start_times_.hello_s = SecondsSince(start);
}

void PluginClient::Start() {
  Open();
  const auto before_setup = PluginClock::now();
  Exchange(setup_, StartLimit_s());
  start_times_.setup_s = SecondsSince(before_setup);
  was_started_ = true;
}

void PluginClient::SayHello() {
  MessageWriter hello;
  hello.BeginMap(3);
  hello.Text("verb");
  hello.Text("hello");
  hello.Text("protocol");
  hello.Integer(kPluginProtocol);
  hello.Text("role");
  hello.Text(role_);
  const MessageValue answer = Exchange(hello, StartLimit_s());
  try {
    const int64_t protocol = answer.At("protocol").Integer("protocol");
    if (protocol != kPluginProtocol) {
      throw PluginError(
          PluginFault::kMalformed,
          fmt::format("speaks protocol {}, but this pickbed speaks {}; use the pickbed_plugin of "
                      "this version",
                      protocol, kPluginProtocol));
    }
    RequireSoundKeys(answer);
    const MessageValue* version = answer.Find("version");
    identity_ = {answer.At("name").Text("name"), version ? version->Text("version") : "",
                 TextsIn(answer, "roles"), NeedsIn(answer)};
  } catch (const MessageError& error) {
    throw PluginError(PluginFault::kMalformed,
                      fmt::format("gave a wrong answer to hello: {}", error.what()));
  }
  const auto& roles = identity_.roles;
  if (std::find(roles.begin(), roles.end(), role_) != roles.end()) return;
  throw PluginError(PluginFault::kMalformed,
                    fmt::format("is no {}, but has the roles [{}]", role_, fmt::join(roles, ", ")));
}

MessageValue PluginClient::Ask(const MessageWriter& request) {
  if (channel_ != nullptr) return Exchange(request, address_.timeout_s);
  try {
    Start();
  } catch (const InputError& error) {  // the program or the server is gone now
    throw PluginError(PluginFault::kCrashed, error.what());
  } catch (const PluginError&) {
    Stop(std::chrono::milliseconds(0));
    throw;
  }
  return Exchange(request, address_.timeout_s);
}

void PluginClient::ThrowBroken(const ReceivedMessage& received, double limit_s) {
  const auto& [status, bytes] = received;
  if (status == TransferStatus::kTimeout) {
    Stop(std::chrono::milliseconds(0));
    throw PluginError(
        PluginFault::kTimeout,
        fmt::format("gave no answer within {:g} s; raise timeout_s, or make it faster", limit_s),
        log_->LastLines(kTracebackLines));
  }
  if (status == TransferStatus::kNotAFrame) {
    Stop(std::chrono::milliseconds(0));
    if (!IsText(bytes)) {
      throw PluginError(PluginFault::kMalformed,
                        fmt::format("gave an answer of more than {} MiB, or no message; give only "
                                    "the best poses or grasps",
                                    kMaxReceivedBytes >> 20));
    }
    throw PluginError(
        PluginFault::kMalformed,
        fmt::format("wrote '{}' to its standard output, which is for messages only; print to "
                    "standard error instead",
                    Quoted(bytes)));
  }
  std::string text = Stop(kGraceAfterEnd);
  const bool is_clean_end = text == "ended with status 0";
  const std::vector<std::string> lines = log_->LastLines(kTracebackLines);
  if (!lines.empty()) text += fmt::format(": {}", lines.back());
  if (is_clean_end) {
    text += "; it must read messages until its input ends (in Python: pb.serve())";
  }
  throw PluginError(PluginFault::kCrashed, text, lines);
}

double PluginClient::StartLimit_s() const {
  return std::max(address_.timeout_s, address_.start_timeout_s);
}

MessageValue PluginClient::Exchange(const MessageWriter& request, double limit_s) {
  const Deadline deadline = DeadlineIn(limit_s);
  const TransferStatus sent = channel_->Send(request, deadline);
  if (sent == TransferStatus::kTimeout) ThrowBroken({sent, {}}, limit_s);
  // A program that has ended may have left a last answer, for example text that is no message.
  const ReceivedMessage received = channel_->Receive(deadline);
  if (received.status != TransferStatus::kDone) ThrowBroken(received, limit_s);
  MessageValue answer;
  try {
    answer = ReadMessageValue(received.bytes);
    if (answer.map() == nullptr) throw MessageError(fmt::format("is {} and no map", answer.kind()));
    const MessageValue* error = answer.Find("error");
    if (error == nullptr) return answer;
    const MessageValue* traceback = answer.Find("traceback");
    throw PluginError(
        PluginFault::kReported,
        fmt::format("reported an error: {}", JoinedLines(error->Text("error"))),
        traceback == nullptr ? std::vector<std::string>() : Lines(traceback->Text("traceback")));
  } catch (const MessageError& error) {
    Stop(std::chrono::milliseconds(0));
    throw PluginError(PluginFault::kMalformed, fmt::format("gave an answer that {}", error.what()));
  }
}

}  // namespace pickbed::scenes
