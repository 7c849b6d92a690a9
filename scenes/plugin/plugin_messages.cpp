#include "scenes/plugin/plugin_messages.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "scenes/base/cache_file.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/mesh_io/mesh_io.h"

namespace pickbed::scenes {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

constexpr size_t kShape3[] = {3}, kShape33[] = {3, 3}, kShape44[] = {4, 4};

void Vector(const Eigen::Vector3d& v, MessageWriter& message) {
  message.Numbers({v.data(), 3}, kShape3);
}

void Matrix(const Pose& X, MessageWriter& message) {
  const RowMajor4 rows = X.matrix();
  message.Numbers({rows.data(), 16}, kShape44);
}

void OptionalMatrix(const std::optional<Pose>& X, MessageWriter& message) {
  if (X) {
    Matrix(*X, message);
  } else {
    message.Nil();
  }
}

void Symmetries(const SymmetrySet& symmetries_O, MessageWriter& message) {
  message.BeginMap(2);
  message.Text("discrete");
  message.BeginList(symmetries_O.discrete_O.size());
  for (const Pose& X_OO : symmetries_O.discrete_O) Matrix(X_OO, message);
  message.Text("continuous");
  message.BeginList(symmetries_O.continuous_O.size());
  for (const ContinuousSymmetry& axis : symmetries_O.continuous_O) {
    message.BeginMap(2);
    message.Text("axis");
    Vector(axis.axis_O, message);
    message.Text("offset_m");
    Vector(axis.offset_O, message);
  }
}

// Elements of a fixed-size Eigen type, which are contiguous in a vector.
template <typename Element>
void Elements(std::string_view dtype, const std::vector<Element>& elements,
              MessageWriter& message) {
  static_assert(sizeof(Element) == 3 * sizeof(typename Element::Scalar));
  const size_t shape[] = {elements.size(), 3};
  message.Array(dtype, shape, std::as_bytes(std::span(elements)));
}

// Returns a hash of the files of a mesh: the OBJ, its material and its texture.
std::string HashOfMeshFiles(const std::filesystem::path& mesh) {
  uint64_t hash = 0;
  for (const char* extension : {".obj", ".mtl", ".png"}) {
    std::filesystem::path file = mesh;
    file.replace_extension(extension);
    if (!IsRegularFile(file)) continue;
    const std::string bytes = ReadFileBytes(file);
    hash = HashBytes(bytes.data(), bytes.size(), hash);
  }
  return fmt::format("{:016x}", hash);
}

// Returns the file of the mesh in metres. The name contains the hash, so that the content is always
// the same. A further file of the folder, written last, has a hash of the other files.
std::filesystem::path MeshFile(const ObjectModel& object, const std::filesystem::path& folder) {
  const TriangleMesh& mesh = object.mesh_O;
  uint64_t hash = HashBytes(mesh.colors.data(), mesh.colors.size() * sizeof(Rgb8), MeshHash(mesh));
  hash = HashBytes(mesh.texture.data(), mesh.texture.size() * sizeof(Rgb8), hash);
  hash = HashBytes(&mesh.base_color, sizeof(Rgb8), hash);
  const std::filesystem::path own = folder / fmt::format("{:016x}", hash);
  const std::filesystem::path file = own / "mesh.obj";
  const auto read = [&](const std::string& stored) {
    CheckInput(stored == HashOfMeshFiles(file), "the mesh beside it is damaged");
    return stored;
  };
  const auto make = [&] {
    SaveObj(file, mesh);
    return HashOfMeshFiles(file);
  };
  Cached(own / "mesh.hash", read, make, [](const std::string& made) { return made; });
  return file;
}

void Object(const ObjectModel& object, const std::filesystem::path& mesh_dir,
            MessageWriter& message) {
  message.BeginMap(8);
  message.Text("name");
  message.Text(object.name);
  message.Text("mesh");
  message.Text(MeshFile(object, mesh_dir).string());
  message.Text("vertices_m");
  Elements("float64", object.mesh_O.vertices, message);
  message.Text("triangles");
  Elements("int32", object.mesh_O.triangles, message);
  message.Text("diameter_m");
  message.Real(object.diameter_m);
  message.Text("symmetries");
  Symmetries(object.symmetries_O, message);
  message.Text("mass_kg");
  message.Real(object.mass.mass_kg);
  message.Text("friction");
  message.Real(object.friction);
}

void CameraEntries(const CameraIntrinsics& k, MessageWriter& message) {
  const RowMajor3 K{{k.fx(), 0, k.cx()}, {0, k.fy(), k.cy()}, {0, 0, 1}};
  message.Numbers({K.data(), 9}, kShape33);
}

// Entries that both requests have.
constexpr size_t kFrameEntries = 8;
void FrameEntries(const char* verb, const PluginFrame& input, const ObjectSet& objects,
                  MessageWriter& message) {
  const RgbdFrame& frame = input.frame;
  const size_t width = frame.depth_m.width(), height = frame.depth_m.height();
  message.Text("verb");
  message.Text(verb);
  message.Text("depth_m");
  const size_t depth_shape[] = {height, width};
  message.Array("float32", depth_shape, std::as_bytes(std::span(frame.depth_m.pixels())));
  message.Text("color");
  if (frame.color.empty()) {
    message.Nil();
  } else {
    const size_t color_shape[] = {height, width, 3};
    message.Array("uint8", color_shape, std::as_bytes(std::span(frame.color.pixels())));
  }
  message.Text("K");
  CameraEntries(frame.intrinsics, message);
  message.Text("X_WC");
  OptionalMatrix(input.X_WC, message);
  message.Text("X_CB");
  OptionalMatrix(input.X_CB, message);
  message.Text("counts");
  if (input.counts.empty()) {
    message.Nil();
  } else {
    message.BeginMap(objects.size());
    for (size_t i = 0; i < objects.size(); ++i) {
      message.Text(objects[i]->name);
      message.Integer(input.counts[i]);
    }
  }
  message.Text("seed");
  message.Unsigned(input.seed);
}

void PoseEntry(const PluginPose& pose, const ObjectSet& objects, MessageWriter& message) {
  const RowMajor3 R = pose.X_CO.linear();
  message.BeginMap(4);
  message.Text("object");
  message.Text(objects[pose.object]->name);
  message.Text("R");
  message.Numbers({R.data(), 9}, kShape33);
  message.Text("t_m");
  Vector(pose.X_CO.translation(), message);
  message.Text("score");
  message.Real(pose.score);
}

static_assert(sizeof(Rgb8) == 3, "an image of colors is sent as it is in memory");

// Rules of received values. Each throws MessageError.

double Finite(const MessageValue& item, const char* key) {
  const double value = item.At(key).Real(key);
  if (!std::isfinite(value)) throw MessageError(fmt::format("{} is not finite", key));
  return value;
}

double PoseScore(const MessageValue& item, PluginScores scores) {
  const double score = Finite(item, "score");
  if (scores == PluginScores::kProbabilities && (score < 0 || score > 1)) {
    throw MessageError(
        fmt::format("score {:g} is outside 0 to 1; give the probability that the pose is right, or "
                    "set estimator.scores=raw and convert the scores with pickbed calibrate",
                    score));
  }
  return score;
}

std::vector<double> FiniteNumbers(const MessageValue& item, const char* key, size_t count) {
  std::vector<double> numbers = item.At(key).Numbers(key);
  if (numbers.size() != count) {
    throw MessageError(fmt::format("{} has {} numbers instead of {}", key, numbers.size(), count));
  }
  if (!std::all_of(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); })) {
    throw MessageError(fmt::format("{} is not finite", key));
  }
  return numbers;
}

Eigen::Matrix3d Rotation(const Eigen::Matrix3d& R, const char* key) {
  try {
    return ProperRotation(R, key);
  } catch (const InputError& error) {
    throw MessageError(error.what());
  }
}

// A distance of an object beyond this multiple of the working distance is an error.
constexpr double kMaxDistances = 20;

void RequirePlausible(const ObjectModel& object, const Pose& X_CO, double working_distance_m) {
  const Eigen::Vector3d center_C = X_CO * MeshBounds(object.mesh_O).center();
  const double distance_m = center_C.norm();
  if (distance_m <= kMaxDistances * working_distance_m) return;
  const Eigen::Vector3d shrunk_C = center_C - 0.999 * X_CO.translation();
  const bool is_mm = shrunk_C.norm() < 4 * working_distance_m;
  throw MessageError(fmt::format(
      "t_m puts the object {:.4g} m from the camera, but the bin is at {:.2g} m{}", distance_m,
      working_distance_m, is_mm ? "; t_m is in millimetres and must be in metres" : ""));
}

PluginPose ReadPose(const MessageValue& item, const ObjectSet& objects, double working_distance_m,
                    PluginScores scores) {
  PluginPose pose;
  const std::string& name = item.At("object").Text("object");
  std::vector<std::string> names;
  for (const auto& object : objects) names.push_back(object->name);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) throw MessageError(UnknownNameMessage("object", name, names));
  pose.object = ObjectId(static_cast<int>(found - names.begin()));
  const std::vector<double> R = FiniteNumbers(item, "R", 9), t_m = FiniteNumbers(item, "t_m", 3);
  pose.X_CO.linear() = Rotation(Eigen::Map<const RowMajor3>(R.data()), "R");
  pose.X_CO.translation() = Eigen::Map<const Eigen::Vector3d>(t_m.data());
  pose.score = PoseScore(item, scores);
  RequirePlausible(*objects[pose.object], pose.X_CO, working_distance_m);
  return pose;
}

constexpr double kMaxGraspDistance_m = 20;

// A gripper without fingers has no opening and takes any width.
void RequireFitsOpening(const PluginGrasp& grasp, std::span<const PluginGripper> grippers) {
  constexpr double kRounding_m = 1e-6;
  for (const PluginGripper& gripper : grippers) {
    const bool is_its_own =
        grasp.gripper == gripper.name || (grasp.gripper.empty() && &gripper == &grippers.front());
    if (!is_its_own || gripper.max_opening_m <= 0) continue;
    if (grasp.width_m <= gripper.max_opening_m + kRounding_m) return;
    throw MessageError(fmt::format("width_m is {:.4g}, but gripper {} opens at most {:.4g} m",
                                   grasp.width_m, gripper.name, gripper.max_opening_m));
  }
}

PluginGrasp ReadGrasp(const MessageValue& item, std::span<const PluginGripper> grippers,
                      int poses) {
  PluginGrasp grasp;
  const std::vector<double> X_WG = FiniteNumbers(item, "X_WG", 16);
  const Eigen::Map<const RowMajor4> matrix(X_WG.data());
  if (!matrix.row(3).isApprox(Eigen::RowVector4d(0, 0, 0, 1), 1e-9)) {
    throw MessageError("X_WG has another last row than [0, 0, 0, 1]");
  }
  grasp.X_WG.linear() = Rotation(matrix.topLeftCorner<3, 3>(), "X_WG");
  grasp.X_WG.translation() = matrix.topRightCorner<3, 1>();
  if (grasp.X_WG.translation().norm() > kMaxGraspDistance_m) {
    throw MessageError(fmt::format("X_WG is {:.4g} m from the bin; positions are in metres",
                                   grasp.X_WG.translation().norm()));
  }
  grasp.width_m = Finite(item, "width_m");
  if (grasp.width_m < 0) throw MessageError("width_m is negative");
  if (grasp.width_m > 10) throw MessageError("width_m is in millimetres and must be in metres");
  grasp.score = Finite(item, "score");
  if (const MessageValue* gripper = item.Find("gripper")) {
    std::vector<std::string> names;
    for (const PluginGripper& known : grippers) names.push_back(known.name);
    grasp.gripper = gripper->Text("gripper");
    if (std::find(names.begin(), names.end(), grasp.gripper) == names.end()) {
      throw MessageError(UnknownNameMessage("gripper", grasp.gripper, names));
    }
  }
  RequireFitsOpening(grasp, grippers);
  if (const MessageValue* pose = item.Find("pose")) {
    const int64_t index = pose->Integer("pose");
    if (index < -1 || index >= poses) {
      throw MessageError(fmt::format("pose {} is none of the {} poses", index, poses));
    }
    grasp.pose = static_cast<int>(index);
  }
  return grasp;
}

// Throws an error, or adds it to `faults` if that is given.
void Report(const std::string& text, std::vector<std::string>* faults) {
  if (faults == nullptr) throw PluginError(PluginFault::kMalformed, text);
  faults->push_back(text);
}

// Reads each item of a list. An error names the item.
template <typename Item>
std::vector<Item> ReadItems(const MessageValue& answer, const char* key, const char* noun,
                            std::vector<std::string>* faults,
                            const std::function<Item(const MessageValue&)>& read) {
  std::vector<Item> items;
  const MessageValue::List* list = nullptr;
  try {
    list = &answer.At(key).Items(key);
  } catch (const MessageError& error) {
    Report(fmt::format("gave a wrong answer: {}", error.what()), faults);
    return items;
  }
  if (list->size() > kMaxPluginItems) {
    Report(fmt::format("gave {} {}s; give only the best ones, at most {}", list->size(), noun,
                       kMaxPluginItems),
           faults);
    return items;
  }
  for (size_t i = 0; i < list->size(); ++i) {
    try {
      items.push_back(read((*list)[i]));
    } catch (const MessageError& error) {
      Report(fmt::format("gave a wrong {} (number {}): {}", noun, i, error.what()), faults);
    }
  }
  return items;
}

}  // namespace

void WriteSetup(const PluginSetup& setup, const std::filesystem::path& mesh_dir,
                MessageWriter& message) {
  message.BeginMap(9);
  message.Text("verb");
  message.Text("setup");
  message.Text("objects");
  message.BeginList(setup.objects.size());
  for (const auto& object : setup.objects) Object(*object, mesh_dir, message);
  message.Text("camera");
  message.BeginMap(3);
  message.Text("width");
  message.Integer(setup.intrinsics.width());
  message.Text("height");
  message.Integer(setup.intrinsics.height());
  message.Text("K");
  CameraEntries(setup.intrinsics, message);
  message.Text("working_distance_m");
  message.Real(setup.working_distance_m);
  message.Text("bin");
  if (setup.bin == nullptr) {
    message.Nil();
  } else {
    message.BeginMap(2);
    message.Text("inner_size_m");
    Vector(setup.bin->inner_size_m, message);
    message.Text("wall_m");
    message.Real(setup.bin->wall_m);
  }
  message.Text("min_score");
  message.Real(setup.min_score);
  message.Text("model");
  message.Text(setup.model);
  message.Text("mode");
  message.Text(setup.mode);
  message.Text("grippers");
  message.BeginList(setup.grippers.size());
  for (const PluginGripper& gripper : setup.grippers) {
    message.BeginMap(5);
    message.Text("name");
    message.Text(gripper.name);
    message.Text("mechanism");
    message.Text(gripper.mechanism);
    message.Text("max_opening_m");
    message.Real(gripper.max_opening_m);
    message.Text("approach_m");
    message.Real(gripper.approach_m);
    message.Text("settings");
    message.Text(gripper.settings);
  }
}

void WriteEstimate(const PluginFrame& frame, const ObjectSet& objects, MessageWriter& message) {
  message.BeginMap(kFrameEntries);
  FrameEntries("estimate", frame, objects, message);
}

void WritePlanGrasps(const PluginFrame& frame, const ObjectSet& objects,
                     const std::vector<PluginPose>* poses, MessageWriter& message) {
  message.BeginMap(kFrameEntries + 1);
  FrameEntries("plan_grasps", frame, objects, message);
  message.Text("poses");
  if (poses == nullptr) return message.Nil();
  message.BeginList(poses->size());
  for (const PluginPose& pose : *poses) PoseEntry(pose, objects, message);
}

std::vector<PluginPose> ReadPoses(const MessageValue& answer, const ObjectSet& objects,
                                  double working_distance_m, std::vector<std::string>* faults,
                                  PluginScores scores) {
  return ReadItems<PluginPose>(answer, "poses", "pose", faults, [&](const MessageValue& item) {
    return ReadPose(item, objects, working_distance_m, scores);
  });
}

std::vector<PluginGrasp> ReadGrasps(const MessageValue& answer,
                                    std::span<const PluginGripper> grippers, int poses,
                                    std::vector<std::string>* faults) {
  return ReadItems<PluginGrasp>(answer, "grasps", "grasp", faults, [&](const MessageValue& item) {
    return ReadGrasp(item, grippers, poses);
  });
}

}  // namespace pickbed::scenes
