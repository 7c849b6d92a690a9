#pragma once

// A stream of messages to and from another program, with time limits. Each message has its length
// before it: four bytes, most significant first.

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "scenes/plugin/message.h"

namespace pickbed::scenes {

using PluginClock = std::chrono::steady_clock;
using Deadline = PluginClock::time_point;

// Maximum size of a received message. Every length that begins with four printable letters is
// larger, so text in the stream is recognised.
inline constexpr size_t kMaxReceivedBytes = size_t{64} << 20;

// How a transfer ended.
enum class TransferStatus {
  kDone,
  kClosed,    // the other end closed the stream
  kTimeout,   // the deadline passed
  kNotAFrame  // the length is larger than kMaxReceivedBytes
};

struct ReceivedMessage {
  TransferStatus status = TransferStatus::kDone;
  std::vector<std::byte> bytes;  // with kNotAFrame: the first bytes in place of a message
};

// Owns the descriptors of the stream. It does not raise SIGPIPE.
class MessageChannel {
 public:
  // Takes the descriptors and makes them non-blocking. They are equal for a socket. Pipes get a
  // buffer of 1 MiB where the system allows it.
  MessageChannel(int input, int output);
  ~MessageChannel();
  MessageChannel(const MessageChannel&) = delete;
  MessageChannel& operator=(const MessageChannel&) = delete;

  TransferStatus Send(const MessageWriter& message, Deadline deadline);
  ReceivedMessage Receive(Deadline deadline);

  // Closes the sending direction, which a reader sees as the end of its input.
  void CloseOutput();

 private:
  TransferStatus ReadBytes(std::span<std::byte> bytes, Deadline deadline);

  int input_;
  int output_;
};

// Connects to "host:port" over TCP and returns the socket. Throws InputError with `address` and the
// system's reason.
int ConnectTcp(const std::string& address, Deadline deadline);

}  // namespace pickbed::scenes
