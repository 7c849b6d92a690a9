#include "scenes/plugin/channel.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "tests/support/error_of.h"

namespace pickbed::tests {
namespace {

using testing::HasSubstr;

Deadline In(double seconds) {
  return PluginClock::now() +
         std::chrono::duration_cast<PluginClock::duration>(std::chrono::duration<double>(seconds));
}

// A channel and the other end of its pipes.
struct TwoEnds {
  TwoEnds() {
    if (pipe(to_) != 0 || pipe(from_) != 0) throw std::runtime_error("pipe");
    channel = std::make_unique<MessageChannel>(from_[0], to_[1]);
  }
  ~TwoEnds() {
    CloseWriter();
    CloseReader();
  }
  void CloseReader() {
    if (to_[0] >= 0) close(std::exchange(to_[0], -1));
  }
  void CloseWriter() {
    if (from_[1] >= 0) close(std::exchange(from_[1], -1));
  }
  void Write(const std::string& bytes) {
    ASSERT_EQ(write(from_[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  std::string Read(size_t size) {
    std::string bytes(size, '\0');
    size_t done = 0;
    while (done < size) {
      const ssize_t got = read(to_[0], bytes.data() + done, size - done);
      if (got <= 0) break;
      done += got;
    }
    bytes.resize(done);
    return bytes;
  }

  std::unique_ptr<MessageChannel> channel;

 private:
  int to_[2], from_[2];
};

MessageWriter Large(const std::vector<double>& values) {
  const size_t shape[] = {values.size()};
  MessageWriter message;
  message.BeginList(3);
  message.Text("before");
  message.Array("float64", shape, std::as_bytes(std::span(values)));
  message.Text("after");
  return message;
}

// The message is far larger than the buffer of a pipe, so it is sent in several pieces.
TEST(MessageChannel, LargeMessagesArriveWithTheirLengthBeforeThem) {
  std::vector<double> values(1 << 20);
  for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
  const MessageWriter message = Large(values);
  TwoEnds ends;
  std::string head, body;
  std::thread reader([&] {
    head = ends.Read(4);
    body = ends.Read(message.size());
  });
  EXPECT_EQ(ends.channel->Send(message, In(30)), TransferStatus::kDone);
  reader.join();
  const auto size = static_cast<uint32_t>(message.size());
  EXPECT_EQ(head, std::string({static_cast<char>(size >> 24), static_cast<char>(size >> 16),
                               static_cast<char>(size >> 8), static_cast<char>(size)}));
  const MessageValue read = ReadMessageValue(std::as_bytes(std::span(body.data(), body.size())));
  EXPECT_EQ(read.Items("")[1].Numbers(""), values);
  EXPECT_EQ(read.Items("")[2].Text(""), "after");
}

TEST(MessageChannel, ReceivesWhatTheOtherEndWrites) {
  TwoEnds ends;
  ends.Write(std::string("\0\0\0\1\7\0\0", 7));
  const ReceivedMessage first = ends.channel->Receive(In(5));
  EXPECT_EQ(first.status, TransferStatus::kDone);
  EXPECT_EQ(ReadMessageValue(first.bytes).Integer(""), 7);
  ends.Write(std::string("\0\1\x08", 3));  // the rest of the second length, and its message
  const ReceivedMessage second = ends.channel->Receive(In(5));
  EXPECT_EQ(ReadMessageValue(second.bytes).Integer(""), 8);
}

TEST(MessageChannel, SilenceEndsAtTheDeadline) {
  TwoEnds ends;
  EXPECT_EQ(ends.channel->Receive(In(0.02)).status, TransferStatus::kTimeout);
  ends.Write(std::string("\0\0\0\5abc", 7));
  EXPECT_EQ(ends.channel->Receive(In(0.02)).status, TransferStatus::kTimeout)
      << "a message that stops in between";
  const std::vector<double> values(1 << 20);
  EXPECT_EQ(ends.channel->Send(Large(values), In(0.02)), TransferStatus::kTimeout)
      << "without a reader";
}

// SIGPIPE has its default action in a test, which would end the program.
TEST(MessageChannel, AClosedStreamIsAResultAndRaisesNoSignal) {
  ASSERT_EQ(signal(SIGPIPE, SIG_DFL), SIG_DFL);
  TwoEnds ends;
  ends.CloseReader();
  ends.CloseWriter();
  MessageWriter message;
  message.Nil();
  EXPECT_EQ(ends.channel->Send(message, In(5)), TransferStatus::kClosed);
  EXPECT_EQ(ends.channel->Receive(In(5)).status, TransferStatus::kClosed);
  sigset_t pending;
  sigpending(&pending);
  EXPECT_EQ(sigismember(&pending, SIGPIPE), 0);
}

TEST(MessageChannel, TextInTheStreamIsRecognised) {
  TwoEnds ends;
  ends.Write("Loading the network ...\n");
  const ReceivedMessage received = ends.channel->Receive(In(5));
  EXPECT_EQ(received.status, TransferStatus::kNotAFrame);
  const std::string text(reinterpret_cast<const char*>(received.bytes.data()),
                         received.bytes.size());
  EXPECT_EQ(text, "Loading the network ...\n");
  // The smallest length of four printable letters.
  EXPECT_GT(size_t{0x09090909}, kMaxReceivedBytes);
}

TEST(ConnectTcp, NamesTheAddressAndTheReason) {
  const int server = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(server, reinterpret_cast<sockaddr*>(&address), sizeof(address)), 0);
  socklen_t size = sizeof(address);
  getsockname(server, reinterpret_cast<sockaddr*>(&address), &size);
  const std::string name = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  EXPECT_THAT(ErrorOf([&] { ConnectTcp(name, In(5)); }),
              HasSubstr("cannot connect to " + name + ": Connection refused"));
  ASSERT_EQ(listen(server, 1), 0);
  const int connected = ConnectTcp(name, In(5));
  EXPECT_GE(connected, 0);
  close(connected);
  close(server);
  EXPECT_THAT(ErrorOf([] { ConnectTcp("localhost", In(5)); }), HasSubstr("write host:port"));
  EXPECT_THAT(ErrorOf([] { ConnectTcp(":80", In(5)); }), HasSubstr("write host:port"));
}

}  // namespace
}  // namespace pickbed::tests
