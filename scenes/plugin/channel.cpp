#include "scenes/plugin/channel.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "scenes/base/error.h"
#include "scenes/base/network_address.h"

namespace pickbed::scenes {
namespace {

constexpr int kPipeBytes = 1 << 20;  // the limit for users without privileges
constexpr size_t kMaxPieces = 64;    // of one writev()
constexpr size_t kQuotedBytes = 60;  // of a stream that is not a message

// Blocks SIGPIPE of this thread. At the end, removes one that was raised in between.
class NoSigpipe {
 public:
  NoSigpipe() {
    sigemptyset(&pipe_);
    sigaddset(&pipe_, SIGPIPE);
    was_pending_ = IsPending();
    pthread_sigmask(SIG_BLOCK, &pipe_, &before_);
  }
  ~NoSigpipe() {
    constexpr timespec kNow{0, 0};
    if (!was_pending_ && IsPending()) sigtimedwait(&pipe_, nullptr, &kNow);
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoSigpipe(const NoSigpipe&) = delete;
  NoSigpipe& operator=(const NoSigpipe&) = delete;

 private:
  static bool IsPending() {
    sigset_t pending;
    sigemptyset(&pending);
    sigpending(&pending);
    return sigismember(&pending, SIGPIPE) == 1;
  }
  sigset_t pipe_, before_;
  bool was_pending_ = false;
};

// Waits until the descriptor is ready. Returns false when the deadline has passed.
bool WaitFor(int descriptor, short events, Deadline deadline) {
  while (true) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(deadline - PluginClock::now());
    if (left.count() <= 0) return false;
    constexpr int64_t kLongest_ms = 1000000;
    pollfd polled{descriptor, events, 0};
    const int ready = poll(&polled, 1, static_cast<int>(std::min(left.count(), kLongest_ms)));
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
}

void SetUp(int descriptor) {
  fcntl(descriptor, F_SETFL, fcntl(descriptor, F_GETFL) | O_NONBLOCK);
  fcntl(descriptor, F_SETPIPE_SZ, kPipeBytes);  // fails for a socket, which needs none
}

std::vector<iovec> PiecesOf(const MessageWriter& message, std::array<unsigned char, 4>& length) {
  const size_t size = message.size();
  for (int i = 0; i < 4; ++i) length[i] = static_cast<unsigned char>(size >> (8 * (3 - i)));
  std::vector<iovec> pieces{{length.data(), length.size()}};
  for (const auto& chunk : message.Chunks()) {
    pieces.push_back({const_cast<std::byte*>(chunk.data()), chunk.size()});
  }
  return pieces;
}

// Removes the first `sent` bytes of the pieces from `first` on. Returns the new first piece.
size_t Advance(std::vector<iovec>& pieces, size_t first, size_t sent) {
  while (first < pieces.size() && sent >= pieces[first].iov_len) sent -= pieces[first++].iov_len;
  if (first < pieces.size()) {
    pieces[first].iov_base = static_cast<char*>(pieces[first].iov_base) + sent;
    pieces[first].iov_len -= sent;
  }
  return first;
}

// Addresses of a host, freed at the end.
using Addresses = std::unique_ptr<addrinfo, decltype(&freeaddrinfo)>;

Addresses Resolve(const std::string& address) {
  const NetworkAddress parsed = ParseNetworkAddress(address);
  addrinfo hints = {};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error =
      getaddrinfo(parsed.host.c_str(), std::to_string(parsed.port).c_str(), &hints, &found);
  CheckInput(error == 0, fmt::format("cannot connect to {}: {}", address, gai_strerror(error)));
  return {found, freeaddrinfo};
}

// Returns 0 or the error number of a connection attempt.
int FinishConnect(int socket, const addrinfo& address, Deadline deadline) {
  if (connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!WaitFor(socket, POLLOUT, deadline)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof(error);
  getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error;
}

}  // namespace

MessageChannel::MessageChannel(int input, int output) : input_(input), output_(output) {
  SetUp(input_);
  if (output_ != input_) SetUp(output_);
}

MessageChannel::~MessageChannel() {
  if (output_ != input_ && output_ >= 0) close(output_);
  close(input_);
}

void MessageChannel::CloseOutput() {
  if (output_ == input_) {
    shutdown(output_, SHUT_WR);
  } else if (output_ >= 0) {
    close(output_);
    output_ = -1;
  }
}

TransferStatus MessageChannel::Send(const MessageWriter& message, Deadline deadline) {
  const NoSigpipe guard;
  std::array<unsigned char, 4> length;
  std::vector<iovec> pieces = PiecesOf(message, length);
  size_t first = 0;
  while (first < pieces.size()) {
    const auto count = static_cast<int>(std::min(pieces.size() - first, kMaxPieces));
    const ssize_t sent = writev(output_, pieces.data() + first, count);
    if (sent >= 0) {
      first = Advance(pieces, first, static_cast<size_t>(sent));
    } else if (errno == EAGAIN) {
      if (!WaitFor(output_, POLLOUT, deadline)) return TransferStatus::kTimeout;
    } else if (errno != EINTR) {
      return TransferStatus::kClosed;
    }
  }
  return TransferStatus::kDone;
}

TransferStatus MessageChannel::ReadBytes(std::span<std::byte> bytes, Deadline deadline) {
  while (!bytes.empty()) {
    const ssize_t got = read(input_, bytes.data(), bytes.size());
    if (got > 0) {
      bytes = bytes.subspan(static_cast<size_t>(got));
    } else if (got < 0 && errno == EAGAIN) {
      if (!WaitFor(input_, POLLIN, deadline)) return TransferStatus::kTimeout;
    } else if (got == 0 || errno != EINTR) {
      return TransferStatus::kClosed;
    }
  }
  return TransferStatus::kDone;
}

ReceivedMessage MessageChannel::Receive(Deadline deadline) {
  ReceivedMessage message;
  std::array<std::byte, 4> head;
  message.status = ReadBytes(head, deadline);
  if (message.status != TransferStatus::kDone) return message;
  size_t length = 0;
  for (const std::byte byte : head) length = length << 8 | std::to_integer<size_t>(byte);
  if (length > kMaxReceivedBytes) {
    message.status = TransferStatus::kNotAFrame;
    message.bytes.assign(head.begin(), head.end());
    std::array<std::byte, kQuotedBytes> more;
    const ssize_t got = read(input_, more.data(), more.size());
    if (got > 0) message.bytes.insert(message.bytes.end(), more.begin(), more.begin() + got);
    return message;
  }
  message.bytes.resize(length);
  message.status = ReadBytes(message.bytes, deadline);
  return message;
}

int ConnectTcp(const std::string& address, Deadline deadline) {
  const Addresses addresses = Resolve(address);
  int error = 0;
  for (const addrinfo* a = addresses.get(); a != nullptr; a = a->ai_next) {
    const int descriptor = socket(a->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (descriptor < 0) continue;
    error = FinishConnect(descriptor, *a, deadline);
    if (error == 0) {
      const int yes = 1;
      setsockopt(descriptor, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
      return descriptor;
    }
    close(descriptor);
  }
  throw InputError(fmt::format("cannot connect to {}: {}; start the program there first", address,
                               std::strerror(error)));
}

}  // namespace pickbed::scenes
