#include "eval/cli/command_help.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <sstream>

#include "scenes/scenario/find_scenario.h"
#include "tests/support/temporary_folder.h"

namespace pickbed::tests {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;

const CommandRow& RowNamed(const std::string& name) {
  for (const CommandRow& row : CommandTable()) {
    if (row.name == name) return row;
  }
  throw std::logic_error(name);
}

OptionHelp OptionOf(const CommandHelp& command, const std::string& names) {
  for (const OptionHelp& option : command.options) {
    if (option.names == names) return option;
  }
  ADD_FAILURE() << command.name << " has no " << names;
  return {};
}

TEST(CommandHelp, EveryCommandAndArgumentIsDescribed) {
  for (const CommandRow& row : CommandTable()) {
    const CommandHelp command = DescribeCommand(row);
    EXPECT_EQ(command.name, std::string("pickbed ") + row.name);
    EXPECT_THAT(command.options, Each(AllOf(Field(&OptionHelp::names, Not(IsEmpty())),
                                            Field(&OptionHelp::help, Not(IsEmpty())))))
        << row.name;
  }
}

TEST(CommandHelp, ValuesRangesAndDefaultsAreInWords) {
  const CommandHelp run = DescribeCommand(RowNamed("run"));
  const OptionHelp scenario = OptionOf(run, "SCENARIO");
  EXPECT_TRUE(scenario.is_positional);
  EXPECT_TRUE(scenario.required);
  EXPECT_EQ(OptionOf(run, "--trials").value, "whole number from 1 to 1000000");
  EXPECT_EQ(OptionOf(run, "--catalog").default_value, "objects");
  EXPECT_EQ(OptionOf(run, "--resume").value, "");
  const OptionHelp out = OptionOf(run, "--out");
  EXPECT_EQ(out.default_value, "results/<scenario>");
  EXPECT_EQ(out.help, "folder of the results");
  EXPECT_EQ(OptionOf(DescribeCommand(RowNamed("sweep")), "--out").default_value,
            "results/<name of the sweep file>");
  EXPECT_EQ(OptionOf(run, "--jobs").default_value, "number of processors")
      << "the reference must not depend on the machine";
  const OptionHelp task = OptionOf(DescribeCommand(RowNamed("estimate")), "--task");
  EXPECT_THAT(task.choices, ElementsAre("localisation", "detection"));
  EXPECT_EQ(task.value, "localisation, detection");
}

TEST(CommandHelp, SubcommandsAreDescribed) {
  const auto name = [](const char* words) { return Field(&CommandHelp::name, words); };
  EXPECT_THAT(DescribeCommand(RowNamed("dataset")).subcommands,
              ElementsAre(name("pickbed dataset make"), name("pickbed dataset check"),
                          name("pickbed dataset truth")));
  EXPECT_THAT(DescribeCommand(RowNamed("benchmark")).subcommands,
              IsSupersetOf({name("pickbed benchmark crops"), name("pickbed benchmark bins")}));
}

TEST(CommandHelp, CommandsRunAsUsualAfterTheirDescription) {
  DescribeCommand(RowNamed("completion"));
  std::string words[] = {"completion", "bash"};
  char* argv[] = {words[0].data(), words[1].data()};
  testing::internal::CaptureStdout();
  EXPECT_EQ(CompletionCommand(2, argv), 0);
  fflush(stdout);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), HasSubstr("complete "));
}

// Returns what bash offers for the last of the words.
std::vector<std::string> Completed(const std::string& words) {
  const TemporaryFolder folder;
  const std::string script = folder.Write("completion.sh", BashCompletion()).string();
  const std::string ask =
      folder
          .Write("ask.sh", fmt::format("source {}\nCOMP_WORDS=({})\n"
                                       "((COMP_CWORD = ${{#COMP_WORDS[@]}} - 1))\n"
                                       "_pickbed\n"
                                       "echo \"${{COMPREPLY[@]}}\"\n",
                                       script, words))
          .string();
  const std::unique_ptr<FILE, int (*)(FILE*)> shell(popen(("bash --norc " + ask).c_str(), "r"),
                                                    &pclose);
  std::string text;
  for (int c = 0; (c = std::fgetc(shell.get())) != EOF;) text += static_cast<char>(c);
  std::istringstream stream(text);
  std::vector<std::string> offered;
  for (std::string word; stream >> word;) offered.push_back(word);
  return offered;
}

TEST(BashCompletion, OffersCommandsOptionsAndNames) {
  EXPECT_THAT(Completed("pickbed re"), ElementsAre("report", "replay", "render"));
  EXPECT_THAT(Completed("pickbed run --res"), ElementsAre("--resume"));
  EXPECT_THAT(Completed("pickbed run dem"), ElementsAre("demo"));
  EXPECT_THAT(Completed("pickbed run bin_rod --js"), ElementsAre("--json-progress", "--json"));
  EXPECT_THAT(Completed("pickbed grasps rod jaw_8"),
              ElementsAre("jaw_8cm", "jaw_8cm_long", "jaw_8cm_slim"));
  EXPECT_THAT(Completed("pickbed grasps brack"), ElementsAre("bracket"));
  EXPECT_THAT(Completed("pickbed sensor show structured"), ElementsAre("structured_light"));
  EXPECT_THAT(Completed("pickbed train rod --scenario dem"), ElementsAre("demo"));
  EXPECT_THAT(Completed("pickbed estimate demo --task d"), ElementsAre("detection"));
  EXPECT_THAT(Completed("pickbed dataset m"), ElementsAre("make"));
  EXPECT_THAT(Completed("pickbed run demo --out re"), IsEmpty()) << "a file name";
}

TEST(BashCompletion, KnowsEveryCommandAndPreset) {
  std::vector<std::string> names;
  for (const CommandRow& row : CommandTable()) names.push_back(row.name);
  EXPECT_EQ(Completed("pickbed \"\""), names);
  EXPECT_THAT(Completed("pickbed run \"\""), IsSupersetOf(PresetNames()));
}

}  // namespace
}  // namespace pickbed::tests
