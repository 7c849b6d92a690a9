#include <fmt/format.h>

#include <filesystem>

#include "eval/cli/arguments.h"
#include "eval/cli/commands.h"
#include "eval/draw/gripper_sheet.h"
#include "grasp/grippers/table.h"
#include "scenes/base/files.h"
#include "scenes/image/image_io.h"

namespace pickbed::eval {

int GripperCommand(int argc, char** argv) {
  CLI::App app(
      "`gripper show` draws a gripper with its frame and dimensions, and prints its settings.",
      "pickbed gripper");
  std::string action, name, out;
  app.add_option("ACTION", action, "show")->required()->check(CLI::IsMember({"show"}));
  app.add_option("GRIPPER", name, "name of a gripper (see pickbed list grippers), or a .yaml file")
      ->required();
  app.add_option("--out", out, "file name of the picture [results/gripper_NAME.png]");
  app.footer("Example: pickbed gripper show cup_30mm --out cup.png");
  if (!ParseArguments(app, argc, argv)) return 0;

  const auto gripper = LoadGripper(name);
  const std::filesystem::path path =
      out.empty() ? std::filesystem::path("results") / fmt::format("gripper_{}.png", gripper->name)
                  : std::filesystem::path(out);
  if (path.has_parent_path()) MakeFolder(path.parent_path());
  WritePng(path, GripperSheet(*gripper));
  fmt::print("{}: {}, {}\n{}picture: {}\n", gripper->name, gripper->mechanism(), gripper->Summary(),
             GripperText(*gripper), path.string());
  return 0;
}

}  // namespace pickbed::eval
