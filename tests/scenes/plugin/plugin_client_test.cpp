#include "scenes/plugin/plugin_client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cerrno>

#include "tests/support/error_of.h"
#include "tests/support/plugin_scripts.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

void EmptySetup(MessageWriter& message) {
  message.BeginMap(1);
  message.Text("verb");
  message.Text("setup");
}

MessageWriter Request(const std::string& verb) {
  MessageWriter message;
  message.BeginMap(1);
  message.Text("verb");
  message.Text(verb);
  return message;
}

// A plug-in without pickbed_plugin. `body` handles a request m, whose verb is v, and may set the
// answer a.
std::string RawPlugin(const std::string& body) {
  return "import msgpack, os, struct, sys, time\n"
         "count = 0\n"
         "while True:\n"
         "    head = sys.stdin.buffer.read(4)\n"
         "    if len(head) < 4: break\n"
         "    m = msgpack.unpackb(sys.stdin.buffer.read(struct.unpack('>I', head)[0]))\n"
         "    v = m['verb']\n"
         "    if v == 'close': break\n"
         "    a = {'protocol': 1, 'name': 'raw', 'roles': ['estimator']} if v == 'hello' else {}\n"
         "    count += v == 'count'\n"
         "    if v == 'count': a = {'count': count, 'pid': os.getpid()}\n" +
         body +
         "\n    body = msgpack.packb(a)\n"
         "    sys.stdout.buffer.write(struct.pack('>I', len(body)) + body)\n"
         "    sys.stdout.buffer.flush()\n";
}

class PluginClientTest : public testing::Test {
 protected:
  PluginAddress Address(const std::string& code, double timeout_s = 30) {
    return {PythonCommand(folder_, "plugin.py", code), "", timeout_s, folder_.path() / "logs"};
  }
  // Returns why a plug-in with this code cannot be started.
  std::string StartError(const std::string& code) {
    return ErrorOf([&] { PluginClient client(Address(code), "estimator", EmptySetup); });
  }
  // Returns the failure of a request.
  static PluginError FailureOf(PluginClient& client, const std::string& verb) {
    try {
      client.Ask(Request(verb));
    } catch (const PluginError& error) {
      return error;
    }
    return {PluginFault::kReported, "no failure"};
  }
  static int64_t Count(PluginClient& client) {
    return client.Ask(Request("count")).At("count").Integer("");
  }

  TemporaryFolder folder_;
};

TEST_F(PluginClientTest, OneChildAnswersAllRequests) {
  PluginClient client(Address(RawPlugin("")), "estimator", EmptySetup);
  EXPECT_EQ(client.identity().name, "raw");
  EXPECT_THAT(client.identity().roles, ElementsAre("estimator"));
  for (int i = 1; i <= 3; ++i) EXPECT_EQ(Count(client), i);
  EXPECT_EQ(client.restarts(), 0);
}

TEST_F(PluginClientTest, ItsEndLeavesNoProcess) {
  pid_t child = 0;
  {
    PluginClient client(Address(RawPlugin("")), "estimator", EmptySetup);
    child = static_cast<pid_t>(client.Ask(Request("count")).At("pid").Integer(""));
    EXPECT_EQ(client.Close(), "ended with status 0");
    EXPECT_EQ(Count(client), 1) << "started again";
  }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
  EXPECT_EQ(errno, ECHILD);
  EXPECT_GT(child, 0);
}

TEST_F(PluginClientTest, AProgramThatEndedIsStartedAgain) {
  PluginClient client(
      Address(RawPlugin("    if v == 'die':\n        print('out of memory', file=sys.stderr)\n"
                        "        os._exit(7)")),
      "estimator", EmptySetup);
  EXPECT_EQ(Count(client), 1);
  const PluginError failure = FailureOf(client, "die");
  EXPECT_EQ(failure.fault, PluginFault::kCrashed);
  EXPECT_STREQ(failure.what(), "ended with status 7: out of memory");
  EXPECT_THAT(failure.traceback, ElementsAre("out of memory"));
  EXPECT_EQ(Count(client), 1) << "a new child";
  EXPECT_EQ(client.restarts(), 1);
}

TEST_F(PluginClientTest, AHangIsEndedAtTheTimeLimit) {
  PluginClient client(Address(RawPlugin("    if v == 'hang': time.sleep(60)"), 1), "estimator",
                      EmptySetup);
  const PluginError failure = FailureOf(client, "hang");
  EXPECT_EQ(failure.fault, PluginFault::kTimeout);
  EXPECT_THAT(failure.what(), HasSubstr("no answer within 1 s"));
  EXPECT_EQ(Count(client), 1);
}

TEST_F(PluginClientTest, AReportedErrorKeepsTheChild) {
  PluginClient client(Address(RawPlugin("    if v == 'fail': a = {'error': 'no\\nluck', "
                                        "'traceback': 'line 1\\n\\nline 2\\n'}")),
                      "estimator", EmptySetup);
  EXPECT_EQ(Count(client), 1);
  const PluginError failure = FailureOf(client, "fail");
  EXPECT_EQ(failure.fault, PluginFault::kReported);
  EXPECT_STREQ(failure.what(), "reported an error: no luck");
  EXPECT_THAT(failure.traceback, ElementsAre("line 1", "line 2"));
  EXPECT_EQ(Count(client), 2) << "the same child";
}

TEST_F(PluginClientTest, AnswersThatAreNoMessagesAreMalformed) {
  PluginClient client(
      Address(RawPlugin("    if v == 'print':\n        print('found 3 poses', flush=True)\n"
                        "    if v == 'bytes':\n"
                        "        sys.stdout.buffer.write(b'\\0\\0\\0\\1\\xc1')\n"
                        "    if v == 'list': a = [1]\n"
                        "    if v == 'huge':\n"
                        "        sys.stdout.buffer.write(b'\\x7f\\0\\0\\0')")),
      "estimator", EmptySetup);
  const PluginError print = FailureOf(client, "print");
  EXPECT_EQ(print.fault, PluginFault::kMalformed);
  EXPECT_THAT(print.what(), AllOf(HasSubstr("wrote 'found 3 poses' to its standard output"),
                                  HasSubstr("standard error")));
  EXPECT_THAT(FailureOf(client, "bytes").what(), HasSubstr("unknown type, 0xc1"));
  EXPECT_THAT(FailureOf(client, "list").what(), HasSubstr("is a list and no map"));
  EXPECT_EQ(FailureOf(client, "huge").fault, PluginFault::kMalformed);
  EXPECT_EQ(Count(client), 1);
}

TEST_F(PluginClientTest, AStartThatFailsIsOneLineWithTheReason) {
  EXPECT_THAT(StartError("import no_such_module\n"),
              AllOf(HasSubstr("plugin.py' ended with status 1: ModuleNotFoundError: No module "
                              "named 'no_such_module'"),
                    HasSubstr("estimator_1.log"), testing::Not(HasSubstr("\n"))));
  EXPECT_THAT(StartError("pass\n"),
              HasSubstr("ended with status 0; it must read messages until its input ends (in "
                        "Python: pb.serve())"));
  EXPECT_THAT(StartError("print('hello, here I am')\n"),
              HasSubstr("wrote 'hello, here I am' to its standard output"));
  EXPECT_THAT(StartError(RawPlugin("    if v == 'hello': a['protocol'] = 2")),
              HasSubstr("speaks protocol 2, but this pickbed speaks 1"));
  EXPECT_THAT(StartError(RawPlugin("    if v == 'hello': a['roles'] = ['planner']")),
              HasSubstr("is no estimator, but has the roles [planner]"));
  EXPECT_THAT(StartError(RawPlugin("    if v == 'hello': del a['name']")),
              HasSubstr("wrong answer to hello: has no 'name'"));
  EXPECT_THAT(StartError(RawPlugin("    if v == 'setup': a = {'error': 'no GPU'}")),
              HasSubstr("reported an error: no GPU"));
}

TEST_F(PluginClientTest, AnUnknownNeedIsRefusedWithTheKnownOnes) {
  const auto hello = [](const std::string& needs) {
    return RawPlugin("    if v == 'hello': a['needs'] = " + needs);
  };
  EXPECT_THAT(StartError(hello("['color', 'depths']")),
              HasSubstr("gave a wrong answer to hello: unknown word in needs: 'depths'; known: "
                        "color, bin, counts"));
  EXPECT_THAT(StartError(hello("['colour']")), HasSubstr("did you mean 'color'?"));
  EXPECT_THAT(StartError(RawPlugin("    if v == 'hello': a['ne3ds'] = ['color']")),
              HasSubstr("unknown key 'ne3ds'; did you mean needs?"));
  PluginClient client(Address(hello("['counts', 'bin', 'color']")), "estimator", EmptySetup);
  EXPECT_THAT(client.identity().needs, ElementsAre("counts", "bin", "color"));
}

// The protocol says that other keys are ignored.
TEST_F(PluginClientTest, KeysThatResembleKnownOnesAreAccepted) {
  const std::string body =
      "    if v == 'hello': a.update({'seeds': 3, 'rules': ['a'], 'game': ''})";
  PluginClient client(Address(RawPlugin(body)), "estimator", EmptySetup);
  EXPECT_THAT(client.identity().needs, ElementsAre());
}

TEST_F(PluginClientTest, TheStartHasALimitOfItsOwn) {
  PluginAddress address = Address("import time\ntime.sleep(60)\n", 0.1);
  address.start_timeout_s = 0.5;
  EXPECT_THAT(ErrorOf([&] { PluginClient client(address, "estimator", EmptySetup); }),
              HasSubstr("no answer within 0.5 s"));
  // The start of this one takes longer than an answer to an image may.
  PluginClient client(Address(RawPlugin("    if v == 'setup': time.sleep(0.3)"), 0.2), "estimator",
                      EmptySetup);
  EXPECT_EQ(client.restarts(), 0);
}

// Without a setup, and without the end of a program that has none.
TEST_F(PluginClientTest, APluginIsAskedWhatItIs) {
  const std::string ended = (folder_.path() / "ended").string();
  const std::string code =
      "import pickbed_plugin as pb\nclass Mine(pb.Estimator):\n    version = '2.1'\n"
      "    needs = ['color']\n    def setup(self, setup): raise ValueError('planted')\n"
      "    def close(self): open('" +
      ended + "', 'w')\npb.serve(Mine())\n";
  const PluginIdentity identity = PluginClient::IdentityOf(Address(code), "estimator");
  EXPECT_EQ(identity.name, "Mine");
  EXPECT_EQ(identity.version, "2.1");
  EXPECT_THAT(identity.needs, ElementsAre("color"));
  EXPECT_FALSE(std::filesystem::exists(ended));
  EXPECT_EQ(PluginClient::IdentityOf(Address(RawPlugin("")), "estimator").version, "")
      << "the version is optional";
  EXPECT_THAT(ErrorOf([&] { PluginClient::IdentityOf(Address(code), "planner"); }),
              HasSubstr("is no planner"));
}

TEST_F(PluginClientTest, ExactlyOneWayToReachItIsGiven) {
  EXPECT_THAT(ErrorOf([&] { PluginClient client({}, "estimator", EmptySetup); }),
              HasSubstr("neither command nor connect"));
  EXPECT_THAT(ErrorOf([&] {
                PluginClient client({{"x"}, "localhost:1"}, "estimator", EmptySetup);
              }),
              HasSubstr("both command and connect"));
}

TEST_F(PluginClientTest, AProgramThatIsGoneFailsOneRequestAtATime) {
  PluginAddress address = Address(RawPlugin("    if v == 'die': os._exit(1)"));
  PluginClient client(address, "estimator", EmptySetup);
  EXPECT_EQ(FailureOf(client, "die").fault, PluginFault::kCrashed);
  std::filesystem::remove(address.command[1]);
  for (int i = 0; i < 2; ++i) EXPECT_EQ(FailureOf(client, "count").fault, PluginFault::kCrashed);
  Address(RawPlugin(""));  // writes the program again
  EXPECT_EQ(Count(client), 1);
}

// The Python package keeps the stream of messages for itself.
TEST_F(PluginClientTest, PrintsOfAPythonPluginGoToItsLog) {
  PluginClient client(
      Address("print('before the import')\n" +
              EstimatorCode("    print('in the function')\n    os.system('echo from a child')\n"
                            "    return []")),
      "estimator", [](MessageWriter& message) {
        message.BeginMap(9);
        for (const char* key : {"objects", "grippers"}) {
          message.Text(key);
          message.BeginList(0);
        }
        message.Text("verb");
        message.Text("setup");
        message.Text("camera");
        message.BeginMap(3);
        for (const char* key : {"width", "height", "K"}) {
          message.Text(key);
          message.Nil();
        }
        for (const char* key : {"bin", "min_score", "model", "mode", "working_distance_m"}) {
          message.Text(key);
          message.Nil();
        }
      });
  MessageWriter request;
  request.BeginMap(8);
  request.Text("verb");
  request.Text("estimate");
  for (const char* key : {"depth_m", "color", "K", "X_WC", "X_CB", "counts", "seed"}) {
    request.Text(key);
    request.Nil();
  }
  EXPECT_TRUE(client.Ask(request).At("poses").Items("").empty());
  const std::string log = ReadFileBytes(client.log_file());
  for (const char* text : {"before the import", "in the function", "from a child"}) {
    EXPECT_THAT(log, HasSubstr(text));
  }
}

}  // namespace
}  // namespace pickbed::tests
