#include "eval/cli/command_help.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <sstream>
#include <stdexcept>

#include "eval/cli/arguments.h"

namespace pickbed::eval {
namespace {

constexpr const char* kCommonOption = "--json-progress";

// Receives the description from TakeDescription(); null = commands run as usual.
CommandHelp* receiver = nullptr;

std::string TypeInWords(const std::string& type) {
  if (type == "INT" || type == "UINT") return "whole number";
  if (type == "FLOAT") return "number";
  if (type == "DIR") return "folder";
  return "text";
}

// Splits "{m,cm,mm}" into its values.
std::vector<std::string> ChoicesIn(const std::string& text) {
  std::vector<std::string> choices;
  if (text.size() < 2 || text.front() != '{') return choices;
  std::istringstream values(text.substr(1, text.size() - 2));
  for (std::string value; std::getline(values, value, ',');) choices.push_back(value);
  return choices;
}

// CLI11 describes a value as "INT:INT in [1 - 1024]", "TEXT:{m,cm}" or "FLOAT:POSITIVE".
void DescribeValue(const std::string& type_name, OptionHelp& help) {
  const size_t colon = type_name.find(':');
  const std::string rule = colon == std::string::npos ? "" : type_name.substr(colon + 1);
  help.choices = ChoicesIn(rule);
  if (!help.choices.empty()) {
    help.value = fmt::format("{}", fmt::join(help.choices, ", "));
    return;
  }
  help.value = TypeInWords(rule == "DIR" ? rule : type_name.substr(0, colon));
  if (rule == "POSITIVE") help.value += " above 0";
  if (rule == "NONNEGATIVE") help.value += " from 0";
  const size_t bracket = rule.find('['), dash = rule.find(" - ");
  if (bracket == std::string::npos || dash == std::string::npos) return;
  help.value += fmt::format(" from {} to {}", rule.substr(bracket + 1, dash - bracket - 1),
                            rule.substr(dash + 3, rule.size() - dash - 4));
}

// A default that depends on other arguments is at the end of the help, in brackets.
void TakeDefaultInHelp(OptionHelp& help) {
  const size_t bracket = help.help.rfind(" [");
  if (!help.help.ends_with("]") || bracket == std::string::npos) return;
  help.default_value = help.help.substr(bracket + 2, help.help.size() - bracket - 3);
  help.help.resize(bracket);
}

OptionHelp Described(const CLI::Option& option) {
  OptionHelp help;
  help.is_positional = option.get_positional();
  help.required = option.get_required();
  help.help = option.get_description();
  if (help.is_positional) {
    help.names = option.get_name(true);
  } else {
    for (const std::string& name : option.get_lnames()) {
      help.names += (help.names.empty() ? "--" : ", --") + name;
    }
  }
  if (option.get_items_expected_max() == 0) return help;
  DescribeValue(option.get_type_name(), help);
  help.default_value = option.get_default_str();
  if (help.default_value.empty()) TakeDefaultInHelp(help);
  return help;
}

CommandHelp Described(CLI::App& app, const std::string& name) {
  CommandHelp help{name, app.get_description(), {}, app.get_footer(), {}};
  for (const CLI::Option* option : app.get_options()) {
    const bool hidden = option->get_group().empty();  // a former name
    if (option == app.get_help_ptr() || option->get_name() == kCommonOption || hidden) continue;
    help.options.push_back(Described(*option));
  }
  for (CLI::App* subcommand : app.get_subcommands([](CLI::App*) { return true; })) {
    help.subcommands.push_back(Described(*subcommand, name + " " + subcommand->get_name()));
  }
  return help;
}

}  // namespace

bool TakeDescription(CLI::App& app) {
  if (receiver == nullptr) return false;
  *receiver = Described(app, app.get_name());
  return true;
}

CommandHelp DescribeCommand(const CommandRow& row) {
  if (row.subcommands != nullptr) {
    CommandHelp help{std::string("pickbed ") + row.name, row.help, {}, "", {}};
    for (const CommandRow& subcommand : row.subcommands()) {
      help.subcommands.push_back(DescribeCommand(subcommand));
    }
    return help;
  }
  CommandHelp help;
  receiver = &help;
  std::string name = row.name;
  char* argv[] = {name.data()};
  try {
    row.run(1, argv);
  } catch (...) {
    receiver = nullptr;
    throw;
  }
  receiver = nullptr;
  if (help.name.empty()) throw std::logic_error("command " + name + " has no description");
  return help;
}

OptionHelp CommonOption() {
  CLI::App app("", "pickbed");
  return Described(*AddCommonOption(app));
}

}  // namespace pickbed::eval
