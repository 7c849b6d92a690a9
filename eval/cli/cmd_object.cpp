#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/family_sheet.h"
#include "eval/draw/object_sheet.h"
#include "eval/export/made_object_json.h"
#include "eval/runtime/progress.h"
#include "scenes/base/error.h"
#include "scenes/base/files.h"
#include "scenes/base/message_text.h"
#include "scenes/image/image_io.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/shape_families/sampled_names.h"

namespace pickbed::eval {
namespace {

constexpr int kMakerVersion = 2;  // increase it when the same mesh gives another object

struct AddArguments {
  ObjectRequest request;
  std::string catalog = "objects";
  bool replace = false;
};

// Returns a key of everything that the result depends on.
std::string KeyOf(const ObjectRequest& request) {
  const std::string bytes = ReadFileBytes(request.mesh);
  return fmt::format("v{} {:016x} {} {} {} {} {} {} {}", kMakerVersion,
                     HashBytes(bytes.data(), bytes.size()), request.unit, request.density_kgpm3,
                     request.mass_kg, request.friction, request.symmetry_tolerance, request.drops,
                     request.center);
}

bool IsMadeAlready(const std::filesystem::path& folder, const std::string& key) {
  std::error_code error;
  if (!std::filesystem::exists(folder / kObjectFile, error)) return false;
  if (!std::filesystem::exists(folder / kMadeObjectFile, error)) return false;
  const auto json = nlohmann::json::parse(ReadFileBytes(folder / kMadeObjectFile), nullptr, false);
  return json.is_object() && json.value("key", "") == key;
}

// Returns what to do with the new object: correct a guessed mass, name it in a scenario, train.
std::string NextSteps(const AddArguments& arguments, const MadeObject& made) {
  const std::string& name = arguments.request.name;
  const std::string catalog =
      arguments.catalog == AddArguments().catalog ? "" : " --catalog " + arguments.catalog;
  std::string text;
  if (made.mass_by_default_density) {
    text += "set the mass with --mass KG or --density KG_PER_M3, and --replace\n";
  }
  return text + fmt::format(
                    "next: name it in a scenario file {0}.yaml, for example\n"
                    "  objects: [{{name: {0}, count: 20}}]\n"
                    "and train an estimator for it:\n"
                    "  pickbed train --scenario {0}.yaml{1}\n",
                    name, catalog);
}

void Add(const AddArguments& arguments) {
  const ObjectRequest& request = arguments.request;
  CheckInput(!request.name.empty() && request.name.find_first_of("/\\ .") == std::string::npos,
             fmt::format("--name '{}': the name of an object must not be empty or contain '/', "
                         "'\\', '.' or a space",
                         request.name));
  CheckInput(request.name == Printable(request.name),
             fmt::format("--name '{}': the name of an object must not contain control characters "
                         "or bytes that are not UTF-8",
                         request.name));
  std::error_code error;
  CheckInput(std::filesystem::is_regular_file(request.mesh, error),
             fmt::format("mesh '{}' is no file; check the path", request.mesh.string()));
  CheckInput(request.mass_kg == 0 || (request.mass_kg >= 1e-6 && request.mass_kg <= 100),
             fmt::format("--mass {}: must be from 1e-6 to 100 kg", request.mass_kg));
  const std::filesystem::path folder = std::filesystem::path(arguments.catalog) / request.name;
  const std::string key = KeyOf(request);
  if (IsMadeAlready(folder, key)) {
    fmt::print("{} was already made from this mesh with these options: nothing to do\n",
               folder.string());
    return;
  }
  CheckInput(arguments.replace || !std::filesystem::exists(folder / kObjectFile),
             fmt::format("{} exists and was made from another mesh or with other options; pass "
                         "--replace or another --name",
                         folder.string()));
  ProgressLine progress;
  const MadeObject made =
      MakeObject(request, [&](const std::string& stage) { progress.Show(stage + " ..."); });
  progress.Show("draw ...");
  WriteObject(made.record, folder);
  WritePng(folder / kObjectSheetFile, ObjectSheet(made));
  WriteFileAtomically(folder / kMadeObjectFile, MadeObjectJson(key, made));
  progress.Show("done", true);
  if (std::filesystem::exists(AssetsDir() / "objects" / request.name / kObjectFile, error)) {
    fmt::print(stderr,
               "pickbed: the program has an object '{}', too; scenarios that use the catalog {} "
               "now get yours\n",
               request.name, arguments.catalog);
  }
  fmt::print("{}\n{}picture: {}\n{}", request.name, ObjectText(made),
             (folder / kObjectSheetFile).string(), NextSteps(arguments, made));
}

// ---- pickbed object sample ----

struct SampleArguments {
  std::string family;
  std::string domain;
  std::string split = "seen";
  int64_t seed = 0;
  int count = 1;
  std::string out;
};

void Sample(const SampleArguments& arguments) {
  CheckInput(arguments.family.empty() != arguments.domain.empty(),
             arguments.family.empty()
                 ? "give a FAMILY of `pickbed list shape_families`, or --domain"
                 : "give either FAMILY or --domain, not both");
  const std::string& what = arguments.family.empty() ? arguments.domain : arguments.family;
  if (!arguments.domain.empty()) ShapeDomainFromName(arguments.domain);
  ProgressLine progress;
  for (int i = 0; i < arguments.count; ++i) {
    const uint64_t seed = static_cast<uint64_t>(arguments.seed) + static_cast<uint64_t>(i);
    const SampledShape shape = SampleShapeOf(what, arguments.split, seed);
    const std::string name = fmt::format(
        "{}_{}{}", shape.family->name,
        shape.split == ShapeSplit::kSeen ? "" : ShapeSplitName(shape.split) + "_", shape.seed);
    progress.Show(fmt::format("{} ({} of {}) ...", name, i + 1, arguments.count));
    WriteObject(MakeSampledObject(shape), std::filesystem::path(arguments.out) / name);
  }
  progress.Show("done", true);
  fmt::print("{} written to {}\nnext: name them in a scenario file and pass --catalog {}\n",
             Counted(static_cast<size_t>(arguments.count), "object"), arguments.out, arguments.out);
}

void AddSampleCommand(CLI::App& app, SampleArguments& a) {
  CLI::App* sample =
      app.add_subcommand("sample", "write objects that are drawn from a shape family or a domain");
  sample->add_option("FAMILY", a.family, "a row of `pickbed list shape_families`");
  sample->add_option("--domain", a.domain, "draw the family, too: machine or supermarket");
  sample
      ->add_option("--split", a.split,
                   "seen, unseen_sizes or outside; with --domain also unseen_families")
      ->capture_default_str();
  sample->add_option("--seed", a.seed, "seed of the first object; the next ones count up")
      ->check(CLI::Range(int64_t{0}, std::numeric_limits<int64_t>::max()))
      ->capture_default_str();
  sample->add_option("--count", a.count, "number of objects")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sample->add_option("--out", a.out, "folder that receives the folders of the objects")->required();
  sample->footer("Example: pickbed object sample cup --seed 1 --count 5 --out objects");
}

// ---- pickbed object families ----

struct FamiliesArguments {
  std::string split = "seen";
  int64_t seed = 0;
  std::string out;
};

void AddFamiliesCommand(CLI::App& app, FamiliesArguments& a) {
  CLI::App* families =
      app.add_subcommand("families", "draw one sampled shape of each shape family on a sheet");
  families->add_option("--split", a.split, "seen, unseen_sizes or outside")->capture_default_str();
  families->add_option("--seed", a.seed, "seed of the shapes")
      ->check(CLI::Range(int64_t{0}, std::numeric_limits<int64_t>::max()))
      ->capture_default_str();
  families->add_option("--out", a.out, "PNG file")->required();
  families->footer("Example: pickbed object families --seed 1 --out families.png");
}

}  // namespace

int ObjectCommand(int argc, char** argv) {
  CLI::App app(
      "Adds an object to the catalog, from a mesh or from a shape family: unit, mass, convex "
      "pieces, symmetries and resting poses.",
      "pickbed object");
  app.require_subcommand(1);
  CLI::App* add = app.add_subcommand("add", "inspect a mesh and add it to the catalog");
  AddArguments a;
  ObjectRequest& request = a.request;
  add->add_option("MESH", request.mesh, "mesh file: OBJ, PLY, STL, DAE or glTF")->required();
  add->add_option("--name", request.name, "name of the object and of its folder")->required();
  add->add_option("--unit", request.unit,
                  "unit of length of the mesh; default: guessed from its size")
      ->check(CLI::IsMember({"m", "cm", "mm", "in"}));
  add->add_option("--catalog", a.catalog, "folder of the catalog")->capture_default_str();
  add->add_option("--density", request.density_kgpm3,
                  fmt::format("density, kg/m3; steel is 7850 [{:g}]", kDefaultDensity_kgpm3))
      ->check(CLI::Range(1.0, 25000.0));
  add->add_option("--mass", request.mass_kg, "mass, kg; replaces the density")
      ->check(CLI::Range(1e-6, 100.0));
  add->add_option("--friction", request.friction, "friction coefficient against a gripper pad")
      ->check(CLI::Range(0.01, 2.0))
      ->capture_default_str();
  add->add_option("--symmetry-tolerance", request.symmetry_tolerance,
                  "largest deviation from a symmetry, as a share of the diameter")
      ->check(CLI::Range(0.001, 0.1))
      ->capture_default_str();
  add->add_option("--drops", request.drops, "number of simulated drops to find the resting poses")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  add->add_flag("--center", request.center, "move the origin to the center of the object");
  add->add_flag("--replace", a.replace, "overwrite an object with the same name");
  app.footer("Example: pickbed object add drill.stl --name drill --unit mm --mass 0.9");
  SampleArguments sample;
  AddSampleCommand(app, sample);
  FamiliesArguments families;
  AddFamiliesCommand(app, families);
  if (!ParseArguments(app, argc, argv)) return 0;
  if (app.got_subcommand("sample")) {
    Sample(sample);
  } else if (app.got_subcommand("families")) {
    WritePng(families.out, FamilySheet(ShapeSplitFromName(families.split), families.seed));
    fmt::print("sheet: {}\n", families.out);
  } else {
    Add(a);
  }
  return 0;
}

}  // namespace pickbed::eval
