#include "tests/fuzz/damaged_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

#include "eval/bop/layout.h"
#include "eval/bop/read_dataset.h"
#include "eval/draw/overlay.h"
#include "eval/estimate/image_poses.h"
#include "eval/frames/cloud_file.h"
#include "eval/frames/frame_checks.h"
#include "eval/frames/frame_files.h"
#include "eval/frames/image_estimator.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"
#include "scenes/image/number_image.h"
#include "scenes/objects/object_catalog.h"
#include "tests/support/synthetic_depth.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

namespace fs = std::filesystem;

// ---- Frames ----

// Gray by depth, for frames without color.
Image<Rgb8> GrayOf(const Image<float>& depth_m) {
  Image<Rgb8> gray(depth_m.width(), depth_m.height());
  for (size_t i = 0; i < gray.size(); ++i) {
    const auto value = static_cast<uint8_t>(std::clamp(depth_m.data()[i] * 100, 0.f, 255.f));
    gray.data()[i] = {value, value, value};
  }
  return gray;
}

NamedFrame DrawnFrame() {
  SyntheticDepth scene(SmallCamera());
  scene.AddPlane({0, -0.3, -1}, {0, 0, 0.9});
  for (int i = 0; i < 4; ++i) {
    Pose X_CO = BracketPose();
    X_CO.translation() = Eigen::Vector3d(0.07 * (i - 1.5), 0.02 * (i % 2), 0.8);
    scene.AddMesh(BracketMesh(), X_CO);
  }
  Rng rng(1);
  RgbdFrame frame = WithNoise(scene.frame(), 0.002, rng);
  frame.color = GrayOf(frame.depth_m);
  return {"drawn", frame};
}

void AddDatasetFrames(const fs::path& root, std::vector<NamedFrame>& frames) {
  std::error_code none;
  for (const auto& set : fs::directory_iterator(root, none)) {
    if (!set.path().filename().string().starts_with("bop_")) continue;
    for (const int id : SceneIdsOf(set.path(), "test")) {
      const SceneTruth scene =
          ReadSceneTruth(set.path() / "test" / SceneFolderName(id), id, ThrowFault);
      for (const auto& [image_id, image] : scene.images) {
        frames.push_back({fmt::format("{}/{}/{}", set.path().filename().string(), id, image_id),
                          ReadFrame(scene, image)});
      }
    }
  }
}

void AddClouds(const fs::path& root, std::vector<NamedFrame>& frames) {
  for (const std::string& stem : StemsIn(root / "mosd", ".pcd")) {
    const fs::path file = root / "mosd" / (stem + ".pcd");
    frames.push_back({"mosd/" + stem, FrameOfCloud(ReadCloudFile(file), file.string())});
  }
}

// ---- Damages ----

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kSaturated_m = 65.535f;  // the largest number of 16 bits in millimetres

RgbdFrame CutOut(const RgbdFrame& frame, Rng& rng) {
  const int full_width = frame.depth_m.width(), full_height = frame.depth_m.height();
  const int width = std::min(full_width, 120 + rng.Index(120));
  const int height = std::min(full_height, 90 + rng.Index(90));
  // The principal point must stay inside.
  const auto begin = [&](double center, int size, int full) {
    const int first = std::max(0, static_cast<int>(center) - size + 1);
    const int last = std::min(full - size, static_cast<int>(center));
    return first + rng.Index(std::max(1, last - first + 1));
  };
  const int left = begin(frame.intrinsics.cx(), width, full_width);
  const int top = begin(frame.intrinsics.cy(), height, full_height);
  RgbdFrame cut;
  const CameraIntrinsics& k = frame.intrinsics;
  cut.intrinsics = {width, height, k.fx(), k.fy(), k.cx() - left, k.cy() - top};
  cut.depth_m = Image<float>(width, height);
  if (!frame.color.empty()) cut.color = Image<Rgb8>(width, height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      cut.depth_m(x, y) = frame.depth_m(left + x, top + y);
      if (!frame.color.empty()) cut.color(x, y) = frame.color(left + x, top + y);
    }
  }
  return cut;
}

void FillDiscs(Image<float>& depth, float value, Rng& rng) {
  const int discs = 1 + rng.Index(30);
  for (int i = 0; i < discs; ++i) {
    const int cx = rng.Index(depth.width()), cy = rng.Index(depth.height());
    const int radius = 1 + rng.Index(25);
    for (int y = std::max(0, cy - radius); y < std::min(depth.height(), cy + radius); ++y) {
      for (int x = std::max(0, cx - radius); x < std::min(depth.width(), cx + radius); ++x) {
        if (std::hypot(x - cx, y - cy) < radius) depth(x, y) = value;
      }
    }
  }
}

void FillBands(Image<float>& depth, float value, Rng& rng) {
  const int period = 2 + rng.Index(12), share = 1 + rng.Index(period);
  const bool by_rows = rng.Index(2) == 0;
  for (int y = 0; y < depth.height(); ++y) {
    for (int x = 0; x < depth.width(); ++x) {
      if ((by_rows ? y : x) % period < share) depth(x, y) = value;
    }
  }
}

void FillSingle(Image<float>& depth, float value, Rng& rng) {
  const double share = std::pow(10., rng.Uniform(-4, 0));
  for (float& d : depth.pixels()) {
    if (rng.Uniform() < share) d = value;
  }
}

// A damage. `name` says what it does to the readings.
struct Damage {
  const char* name;
  std::function<void(RgbdFrame& frame, Rng& rng)> apply;
};

std::vector<Damage> MakeDamages() {
  std::vector<Damage> damages;
  const auto add = [&](const char* name, const std::function<void(Image<float>&, Rng&)>& apply) {
    damages.push_back({name, [apply](RgbdFrame& frame, Rng& rng) { apply(frame.depth_m, rng); }});
  };
  add("holes", [](auto& depth, Rng& rng) { FillDiscs(depth, 0, rng); });
  add("discs of NaN", [](auto& depth, Rng& rng) { FillDiscs(depth, kNaN, rng); });
  add("saturated discs", [](auto& depth, Rng& rng) { FillDiscs(depth, kSaturated_m, rng); });
  add("constant discs", [](auto& depth, Rng& rng) { FillDiscs(depth, 0.7f, rng); });
  add("missing bands", [](auto& depth, Rng& rng) { FillBands(depth, 0, rng); });
  add("bands of NaN", [](auto& depth, Rng& rng) { FillBands(depth, kNaN, rng); });
  add("saturated bands", [](auto& depth, Rng& rng) { FillBands(depth, kSaturated_m, rng); });
  add("single holes", [](auto& depth, Rng& rng) { FillSingle(depth, 0, rng); });
  add("single NaN", [](auto& depth, Rng& rng) { FillSingle(depth, kNaN, rng); });
  add("single infinite", [](auto& depth, Rng& rng) { FillSingle(depth, kInfinity, rng); });
  add("single negative", [](auto& depth, Rng& rng) { FillSingle(depth, -0.5f, rng); });
  add("single tiny", [](auto& depth, Rng& rng) { FillSingle(depth, 1e-6f, rng); });
  add("single far", [](auto& depth, Rng& rng) { FillSingle(depth, 1e4f, rng); });
  const auto fill = [](auto& depth, float value) {
    std::fill(depth.pixels().begin(), depth.pixels().end(), value);
  };
  add("zero", [fill](auto& depth, Rng&) { fill(depth, 0); });
  add("NaN", [fill](auto& depth, Rng&) { fill(depth, kNaN); });
  add("saturated", [fill](auto& depth, Rng&) { fill(depth, kSaturated_m); });
  add("constant",
      [fill](auto& depth, Rng& rng) { fill(depth, static_cast<float>(rng.Uniform(0.2, 2))); });
  add("one reading", [fill](auto& depth, Rng& rng) {
    fill(depth, 0);
    depth(rng.Index(depth.width()), rng.Index(depth.height())) = 0.8f;
  });
  add("noise", [](auto& depth, Rng& rng) {
    const double sigma = std::pow(10., rng.Uniform(-3, -0.5));
    for (float& d : depth.pixels()) d += static_cast<float>(sigma * rng.Normal());
  });
  add("coarse steps", [](auto& depth, Rng& rng) {
    const double step = std::pow(10., rng.Uniform(-3, -0.3));
    for (float& d : depth.pixels()) d = static_cast<float>(step * std::floor(d / step));
  });
  add("another unit", [](auto& depth, Rng& rng) {
    const double scale = std::pow(10., rng.Index(7) - 3);
    for (float& d : depth.pixels()) d = static_cast<float>(d * scale);
  });
  add("shifted rows", [](auto& depth, Rng& rng) {
    for (int y = 0; y < depth.height(); ++y) {
      const int shift = rng.Index(depth.width());
      std::rotate(depth.row(y), depth.row(y) + shift, depth.row(y) + depth.width());
    }
  });
  const auto paint = [&](const char* name, const Rgb8& color) {
    damages.push_back({name, [color](RgbdFrame& frame, Rng&) {
                         std::fill(frame.color.pixels().begin(), frame.color.pixels().end(), color);
                       }});
  };
  paint("black color", {0, 0, 0});
  paint("saturated color", {255, 255, 255});
  damages.push_back({"no color", [](RgbdFrame& frame, Rng&) { frame.color = {}; }});
  return damages;
}

// ---- Files ----

// A binary cloud of x, y and z. A pixel without reading is not a number, or the origin.
std::string PcdOf(const RgbdFrame& frame) {
  const int width = frame.depth_m.width(), height = frame.depth_m.height();
  std::string pcd = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {}\n"
      "HEIGHT {}\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      width, height, width * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float z = frame.depth_m(x, y);
      const CameraIntrinsics& k = frame.intrinsics;
      const float values[] = {static_cast<float>((x - k.cx()) / k.fx() * z),
                              static_cast<float>((y - k.cy()) / k.fy() * z), z};
      pcd.append(reinterpret_cast<const char*>(values), sizeof values);
    }
  }
  return pcd;
}

// Writes the depth in one of the formats, and the color. Sometimes cuts a file. Adds to `what`.
FrameFiles WriteFiles(const RgbdFrame& frame, const fs::path& folder, Rng& rng, std::string& what) {
  constexpr const char* kDepths[] = {"d.png", "d.npy", "d.tiff", "d.exr", "d.pcd"};
  const std::string name = kDepths[rng.Index(std::size(kDepths))];
  const fs::path depth = folder / name;
  const CameraIntrinsics& k = frame.intrinsics;
  FrameFiles files;
  files.intrinsics = fmt::format("{},{},{},{}", k.fx(), k.fy(), k.cx(), k.cy());
  if (name == "d.png") {
    WritePng16(depth, DepthUnits(frame.depth_m, 1));
  } else if (name == "d.pcd") {
    WriteFileAtomically(depth, PcdOf(frame));
    files.intrinsics.clear();
  } else {
    WriteFloats(depth, frame.depth_m);
  }
  what += " as " + name;
  files.image = depth;
  if (!frame.color.empty()) {
    files.image = folder / (rng.Index(3) == 0 ? "c.jpg" : "c.png");
    const bool is_png = files.image.extension() == ".png";
    WriteFileAtomically(files.image,
                        is_png ? EncodePng(frame.color, 1) : EncodeJpeg(frame.color, 90));
    files.depth = depth;
  }
  if (rng.Index(8) == 0) {
    const fs::path& cut = rng.Index(2) == 0 ? files.image : depth;
    const std::string bytes = ReadFileBytes(cut);
    WriteFileAtomically(cut, bytes.substr(0, rng.Index(static_cast<int>(bytes.size()))));
    what += ", cut " + cut.filename().string();
  }
  return files;
}

void Require(bool condition, const std::string& what, const std::string& fault) {
  if (!condition) throw std::runtime_error(what + ": " + fault);
}

void RequirePose(const std::string& what, const Pose& X_CO, double score) {
  Require(std::isfinite(score), what, fmt::format("score {}", score));
  const Eigen::Matrix3d R = X_CO.linear();
  Require(X_CO.matrix().allFinite() && (R * R.transpose()).isIdentity(1e-6), what,
          "a pose is none");
}

void RequireRefusal(const std::string& what, const std::string& message, const fs::path& folder) {
  Require(message.find('\n') == std::string::npos, what, "several lines: " + message);
  Require(message.find(folder.string()) != std::string::npos, what, "no file: " + message);
}

EstimatorSpec Estimator(const std::string& name) {
  EstimatorSpec spec;
  spec.name = name;
  spec.mode = "fast";
  spec.min_score = 0.01;  // so that many poses go through all stages
  return spec;
}

constexpr const char* kObject = "bracket";

}  // namespace

std::vector<NamedFrame> FramesToDamage(const fs::path& test_data, int limit) {
  std::vector<NamedFrame> all, frames;
  AddDatasetFrames(test_data, all);
  AddClouds(test_data, all);
  std::ranges::sort(all, {}, &NamedFrame::name);
  const size_t count = std::min(all.size(), static_cast<size_t>(limit));
  for (size_t i = 0; i < count; ++i) frames.push_back(std::move(all[i * all.size() / count]));
  if (frames.empty()) frames.push_back(DrawnFrame());
  return frames;
}

NamedFrame DamagedFrame(const NamedFrame& given, Rng& rng) {
  static const std::vector<Damage> damages = MakeDamages();
  NamedFrame damaged{given.name + ":", CutOut(given.frame, rng)};
  const int count = 1 + rng.Index(3);
  for (int i = 0; i < count; ++i) {
    const Damage& damage = damages[rng.Index(static_cast<int>(damages.size()))];
    damage.apply(damaged.frame, rng);
    damaged.name += fmt::format("{} {}", i > 0 ? "," : "", damage.name);
  }
  return damaged;
}

struct DamagedFrameRun::Estimators {
  ObjectSet objects{ObjectCatalog({AssetsDir() / "objects"}).Load(kObject)};
  std::map<std::string, std::unique_ptr<ImageEstimator>> by_frame;

  ImageEstimator& Of(const NamedFrame& frame) {
    auto& estimator = by_frame[frame.name];
    if (!estimator) {
      estimator = std::make_unique<ImageEstimator>(
          ImageEstimatorSetup{objects, Estimator("descriptor")}, frame.frame);
    }
    return *estimator;
  }
};

DamagedFrameRun::DamagedFrameRun(std::vector<NamedFrame> frames)
    : frames_(std::move(frames)), estimators_(std::make_unique<Estimators>()) {}

DamagedFrameRun::~DamagedFrameRun() = default;

DamagedFrameRun::Outcome DamagedFrameRun::RunImage(uint64_t seed, uint64_t number) {
  const TemporaryFolder folder;
  Rng rng = Rng::Derive(seed, number, "damaged image");
  const NamedFrame& given = frames_[number % frames_.size()];
  const NamedFrame damaged = DamagedFrame(given, rng);
  Outcome outcome{damaged.name, "", 0};
  const FrameFiles files = WriteFiles(damaged.frame, folder.path(), rng, outcome.what);
  FrameOfFiles read;
  try {
    read = ReadFrameFiles(files);
  } catch (const InputError& error) {
    outcome.refusal = error.what();
    // The intrinsics are an argument and not a file.
    if (!outcome.refusal.starts_with("--intrinsics")) {
      RequireRefusal(outcome.what, outcome.refusal, folder.path());
    }
    return outcome;
  }
  const ObjectSet& objects = estimators_->objects;
  const std::vector<FrameFinding> findings = CheckFrame(read.frame, objects, read.depth_scale_mm);
  // `estimate` refuses a frame with an error. A dataset with other frames does not, so that the
  // estimator gets it here, too.
  for (const FrameFinding& finding : findings) {
    if (finding.is_error && outcome.refusal.empty()) outcome.refusal = finding.text;
  }
  if (!HasReadings(read.frame.depth_m)) {
    Require(!outcome.refusal.empty(), outcome.what, "a frame without readings has no finding");
    return outcome;
  }
  RegisterColor(findings, read.frame);
  EstimatorInput input{read.frame, std::nullopt};
  input.is_first = true;
  Rng estimate_rng = Rng::Derive(seed, number, "image/estimate");
  const EstimateResult result = estimators_->Of(given).Estimate(input, estimate_rng);
  const Image<Rgb8> picture = VisibleImage(read.frame);
  OverlayInput overlay{picture, read.frame.intrinsics, objects, {}};
  for (const PoseHypothesis& pose : result.hypotheses) {
    RequirePose(outcome.what, pose.X_CO, pose.score);
    overlay.poses.push_back({pose.object, pose.X_CO, pose.score});
  }
  DrawOverlay(overlay);
  ImagePosesJson({files.image.string(), files.depth.string(), read.frame.intrinsics,
                  read.depth_scale_mm, "descriptor:fast", "", result.domain_warnings},
                 result.hypotheses, objects);
  outcome.poses = static_cast<int>(result.hypotheses.size());
  return outcome;
}

}  // namespace pickbed::tests
