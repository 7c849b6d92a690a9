#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/metrics/metric_table.h"
#include "eval/stats/statistics.h"
#include "eval/trial/oracle_estimator.h"
#include "grasp/grippers/table.h"
#include "grasp/outcome.h"
#include "grasp/plan/plan.h"
#include "grasp/planners/table.h"
#include "perception/icp/final_refinement.h"
#include "scenes/base/error.h"
#include "scenes/camera/camera.h"
#include "scenes/scenario/failure_reason.h"
#include "scenes/scenario/scenario_spec.h"
#include "scenes/scenario/scenario_text.h"
#include "scenes/shape_families/shape_family.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {
namespace {

void Row(const std::string& name, const std::string& help) {
  fmt::print("  {:<20} {}\n", name, help);
}

void ListObjects(const std::string& catalog_folder) {
  const ObjectCatalog catalog = OpenCatalog(catalog_folder);
  for (const std::string& name : catalog.Names()) {
    const auto model = catalog.Load(name);
    const Eigen::Vector3d size_mm = 1e3 * MeshBounds(model->mesh_O).size();
    Row(name, fmt::format("{:.0f} x {:.0f} x {:.0f} mm, {:.0f} g, {} triangles{}", size_mm.x(),
                          size_mm.y(), size_mm.z(), 1e3 * model->mass.mass_kg,
                          model->mesh_O.triangles.size(),
                          model->symmetries_O.trivial() ? "" : ", symmetric"));
  }
}

void ListShapeFamilies(const std::string&) {
  for (const ShapeFamilyRow& row : ShapeFamilyTable()) {
    Row(row.name, fmt::format("{:<12}{}{}", ShapeDomainName(row.domain), row.help,
                              row.held_out ? "; held out" : ""));
  }
}

void ListEstimators(const std::string&) {
  for (const EstimatorName& row : EstimatorNames()) Row(row.name, row.help);
}

void ListRefiners(const std::string&) {
  for (const RefinerRow& row : RefinerTable()) Row(row.name, row.help);
}

void ListGrippers(const std::string&) {
  for (const std::string& name : GripperNames()) {
    const auto gripper = LoadGripper(name);
    Row(name, fmt::format("{}, {}", gripper->mechanism(), gripper->Summary()));
  }
}

void ListSensors(const std::string&) {
  const double focal_px = CameraIntrinsics().fx();  // for profiles that have no focal length
  for (const std::string& name : SensorProfileNames()) {
    const SensorProfile s = LoadSensorProfile(name);
    Row(name, fmt::format("noise {:.1f} mm and steps of {:.1f} mm at 1 m, holes {} and "
                          "{} at edges, from {:g} to {:g} m",
                          1e3 * AxialSigma_m(s, 1, 0), 1e3 * ReadingStep_m(s, 1, focal_px),
                          PercentText(s.random_dropout), WholePercentText(s.edge_dropout),
                          s.min_range_m, s.max_range_m));
  }
}

void ListBins(const std::string&) {
  for (const std::string& name : BinNames()) {
    const BinSpec bin = LoadBin(name);
    const Eigen::Vector3d mm = 1e3 * bin.inner_size_m;
    Row(name, bin.inner_size_m.z() > 0
                  ? fmt::format("{:.0f} x {:.0f} mm, walls {:.0f} mm high", mm.x(), mm.y(), mm.z())
                  : fmt::format("table of {:.0f} x {:.0f} mm", mm.x(), mm.y()));
  }
}

void ListMetrics(const std::string&) {
  for (const MetricRow& row : MetricsIn(kListed))
    Row(row.name, fmt::format("{} ({})", row.help, row.unit));
}

void ListPolicies(const std::string&) {
  for (const PolicyRow& row : PolicyTable()) Row(row.name, row.help);
}

void ListPlanners(const std::string&) {
  for (const PlannerRow& row : PlannerTable()) Row(row.name, row.help);
}

void ListRankings(const std::string&) {
  for (const RankingRow& row : RankingTable()) Row(row.name, row.help);
}

void ListFailures(const std::string&) {
  for (const FailureRow& row : FailureTable()) {
    Row(std::string(row.name), fmt::format("{:<9} {}", StageName(row.stage), row.help));
  }
}

void ListRules(const std::string&) {
  for (const SuccessRuleRow& row : SuccessRuleTable()) Row(row.name, row.help);
}

void ListPresets(const std::string&) {
  for (const std::string& name : PresetNames()) {
    const ScenarioSpec spec = LoadScenario(PresetsDir() / (name + ".yaml"));
    Row(name, fmt::format("{}; {} trials", ObjectsInWords(spec), spec.trials));
  }
}

void ListSettings(const std::string&) {
  ScenarioSpec spec;
  spec.objects.resize(1);
  fmt::print("{}", WriteSettings([&](SettingsVisitor& v) { spec.Visit(v); }, true));
  SensorProfile sensor;
  fmt::print("\nKeys of a sensor file with their defaults\n{}",
             WriteSettings([&](SettingsVisitor& v) { sensor.Visit(v); }, true));
  for (const GripperRow& row : GripperTable()) {
    fmt::print("\nKeys of a gripper file with their defaults: {}\n{}", row.help,
               row.make()->SettingsHelp(MechanismNames()));
  }
}

struct Topic {
  const char* name;
  const char* title;
  void (*print)(const std::string& catalog_folder);
};
constexpr std::array<Topic, 15> kTopics{{
    {"presets", "Preset scenarios", ListPresets},
    {"objects", "Objects", ListObjects},
    {"shape_families", "Shape families, from which objects are sampled", ListShapeFamilies},
    {"estimators", "Pose estimators", ListEstimators},
    {"refiners", "Refiners of reported poses", ListRefiners},
    {"bins", "Bins", ListBins},
    {"grippers", "Grippers", ListGrippers},
    {"sensors", "Depth sensors", ListSensors},
    {"metrics", "Pose errors", ListMetrics},
    {"policies", "Policies that end the picking of a bin", ListPolicies},
    {"planners", "Grasp planners", ListPlanners},
    {"rankings", "Rankings of planned grasps", ListRankings},
    {"failures", "Failure reasons, with the responsible stage", ListFailures},
    {"rules", "Rules for a successful grasp", ListRules},
    {"settings", "Keys of a scenario file with their defaults", ListSettings},
}};

}  // namespace

int ListCommand(int argc, char** argv) {
  CLI::App app("Lists the available objects, estimators, grippers, sensors and other choices.",
               "pickbed list");
  std::string wanted;
  std::string catalog = "objects";
  std::vector<std::string> names;
  for (const Topic& topic : kTopics) names.push_back(topic.name);
  app.add_option("TOPIC", wanted, "one topic from the list below; default: all except settings");
  app.add_option("--catalog", catalog, "folder with your own objects")->capture_default_str();
  app.footer(fmt::format("Topics: {}\nExample: pickbed list grippers", fmt::join(names, ", ")));
  if (!ParseArguments(app, argc, argv)) return 0;

  if (wanted == "losses") {
    fmt::print(stderr, "pickbed: 'list losses' is deprecated, write 'list failures'\n");
    wanted = "failures";
  }
  CheckInput(wanted.empty() || std::find(names.begin(), names.end(), wanted) != names.end(),
             UnknownNameMessage("topic", wanted, names));
  for (const Topic& topic : kTopics) {
    const bool by_default = topic.print != ListSettings;
    if (wanted.empty() ? !by_default : wanted != topic.name) continue;
    fmt::print("{}\n", topic.title);
    topic.print(catalog);
    if (wanted.empty()) fmt::print("\n");
  }
  return 0;
}

}  // namespace pickbed::eval
