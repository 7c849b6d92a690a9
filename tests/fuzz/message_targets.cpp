#include <fmt/format.h>

#include <cmath>

#include "scenes/base/error.h"
#include "scenes/plugin/message.h"
#include "scenes/plugin/plugin_client.h"
#include "scenes/plugin/plugin_messages.h"
#include "tests/eval/cube_scenario.h"
#include "tests/fuzz/format_targets.h"
#include "tests/fuzz/target_parts.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

std::string BytesOf(const MessageWriter& message) {
  std::string bytes;
  for (const std::span<const std::byte> chunk : message.Chunks()) {
    bytes.append(reinterpret_cast<const char*>(chunk.data()), chunk.size());
  }
  return bytes;
}

MessageValue ValueOf(const std::string& bytes) {
  return ReadMessageValue(std::as_bytes(std::span(bytes)));
}

FuzzTarget WithoutFile(FuzzTarget target) {
  target.reads_file = false;
  return target;
}

FuzzTarget ValueTarget() {
  const auto run = [](const fs::path&, const std::string& bytes) { ValueOf(bytes); };
  const auto seeds = [] {
    MessageWriter writer;
    writer.BeginMap(4);
    writer.Text("score");
    writer.Real(0.5);
    writer.Text("items");
    writer.BeginList(3);
    writer.Nil();
    writer.Bool(true);
    writer.Integer(-70000);
    writer.Text("count");
    writer.Unsigned(uint64_t{1} << 40);
    writer.Text("pose");
    const std::vector<double> numbers(12, 1.5);
    writer.Numbers(numbers, std::vector<size_t>{3, 4});
    return Contents{BytesOf(writer)};
  };
  return WithoutFile({"message", run, seeds});
}

// ---- Handshake ----

std::string HelloAnswer() {
  MessageWriter hello;
  hello.BeginMap(5);
  hello.Text("protocol");
  hello.Integer(kPluginProtocol);
  hello.Text("name");
  hello.Text("raw");
  hello.Text("version");
  hello.Text("1.2");
  hello.Text("roles");
  hello.BeginList(2);
  hello.Text("estimator");
  hello.Text("planner");
  hello.Text("needs");
  hello.BeginList(1);
  hello.Text(kNeedsColor);
  return BytesOf(hello);
}

// Returns the message with its length before it, as a plug-in sends it.
std::string Framed(const std::string& message) {
  std::string frame;
  for (const int shift : {24, 16, 8, 0}) frame += static_cast<char>(message.size() >> shift);
  return frame + message;
}

// Asks a plug-in that answers with this stream and ends.
void ReadHello(const fs::path& folder, const std::string& stream) {
  const fs::path file = folder / "stream";
  WriteFileAtomically(file, stream);
  PluginAddress address;
  address.command = {"/bin/cat", file.string()};
  address.timeout_s = address.start_timeout_s = 10;
  const PluginIdentity identity = PluginClient::IdentityOf(address, "estimator");
  RequireLaw(!identity.roles.empty(), "a plug-in has a role");
  RequireLaw(!identity.name.empty(), "a plug-in has a name");
}

FuzzTarget HelloTarget() {
  const auto run = [](const fs::path& folder, const std::string& bytes) {
    ReadHello(folder, Framed(bytes));
  };
  return {"plugin_hello", run, [] { return Contents{HelloAnswer()}; }};
}

FuzzTarget StreamTarget() {
  return {"plugin_stream", ReadHello, [] { return Contents{Framed(HelloAnswer())}; }};
}

// ---- Answers ----

// Reads an answer. Its faults are refusals.
template <typename Read>
auto OrRefused(Read read) {
  try {
    return read();
  } catch (const PluginError& error) {
    throw MessageError(error.what());
  }
}

bool IsPose(const Pose& X) {
  return X.matrix().allFinite() && X.linear().isUnitary(1e-9) && X.linear().determinant() > 0;
}

constexpr double kWorkingDistance_m = 0.6;

FuzzTarget PosesTarget() {
  const auto run = [](const fs::path&, const std::string& bytes) {
    const ObjectSet objects = EasyCube();
    const MessageValue answer = ValueOf(bytes);
    for (const PluginPose& pose :
         OrRefused([&] { return ReadPoses(answer, objects, kWorkingDistance_m); })) {
      RequireLaw(pose.object == 0 && IsPose(pose.X_CO), "an object has a pose");
      RequireLaw(pose.X_CO.translation().norm() < 100, "an object is near the camera");
      RequireLaw(pose.score >= 0 && pose.score <= 1, "a score is a probability");
    }
  };
  const auto seeds = [] {
    MessageWriter answer;
    answer.BeginMap(1);
    answer.Text("poses");
    answer.BeginList(2);
    for (const double x_m : {0.0, 0.125}) {
      answer.BeginMap(4);
      answer.Text("object");
      answer.Text("cube");
      answer.Text("R");
      const std::vector<double> R{0, -1, 0, 1, 0, 0, 0, 0, 1}, t_m{x_m, -0.05, 0.6};
      answer.Numbers(R, std::vector<size_t>{3, 3});
      answer.Text("t_m");
      answer.Numbers(t_m, std::vector<size_t>{3});
      answer.Text("score");
      answer.Real(0.75);
    }
    return Contents{BytesOf(answer)};
  };
  return WithoutFile({"plugin_poses", run, seeds});
}

FuzzTarget PlannedGraspsTarget() {
  const auto run = [](const fs::path&, const std::string& bytes) {
    const std::vector<PluginGripper> grippers{{"jaw", "parallel_jaw", 0.08, 0.1},
                                              {"cup", "suction_cup", 0, 0.1}};
    const MessageValue answer = ValueOf(bytes);
    for (const PluginGrasp& grasp : OrRefused([&] { return ReadGrasps(answer, grippers, 2); })) {
      RequireLaw(IsPose(grasp.X_WG) && std::isfinite(grasp.score), "a grasp has a pose");
      RequireLaw(grasp.width_m >= 0 && (grasp.gripper == "cup" || grasp.width_m <= 0.0801),
                 "a gripper opens as wide as its grasp");
      RequireLaw(grasp.pose >= -1 && grasp.pose < 2, "a grasp is of a pose");
    }
  };
  const auto seeds = [] {
    MessageWriter answer;
    answer.BeginMap(1);
    answer.Text("grasps");
    answer.BeginList(2);
    for (const char* gripper : {"jaw", "cup"}) {
      answer.BeginMap(5);
      answer.Text("X_WG");
      const std::vector<double> X_WG{1, 0, 0, 0.05, 0, -1, 0, 0.02, 0, 0, -1, 0.1, 0, 0, 0, 1};
      answer.Numbers(X_WG, std::vector<size_t>{4, 4});
      answer.Text("width_m");
      answer.Real(0.03);
      answer.Text("score");
      answer.Real(1.5);
      answer.Text("gripper");
      answer.Text(gripper);
      answer.Text("pose");
      answer.Integer(1);
    }
    return Contents{BytesOf(answer)};
  };
  return WithoutFile({"plugin_grasps", run, seeds});
}

}  // namespace

std::vector<FuzzTarget> MessageTargets() {
  return {ValueTarget(), HelloTarget(), StreamTarget(), PosesTarget(), PlannedGraspsTarget()};
}

}  // namespace pickbed::tests
