// Pages of the commands and their options.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "eval/cli/command_help.h"
#include "eval/reference/markdown.h"
#include "eval/reference/pages.h"

namespace pickbed::eval {
namespace {

constexpr char kFirstPage[] = "commands.md";
constexpr char kResultsPage[] = "commands_results.md";
constexpr char kDatasetsPage[] = "commands_datasets.md";
constexpr char kObjectsPage[] = "commands_objects.md";
constexpr std::array<std::string_view, 5> kOnResultsPage{"merge", "budget", "replay", "benchmark",
                                                         "tolerance"};
constexpr std::array<std::string_view, 3> kOnDatasetsPage{"dataset", "score", "execute"};

std::string PageOf(const CommandRow& row) {
  const std::span<const CommandRow> first = CommandTable().first(kFirstCommands);
  if (&row >= first.data() && &row < first.data() + first.size()) return kFirstPage;
  if (std::ranges::count(kOnResultsPage, row.name) > 0) return kResultsPage;
  return std::ranges::count(kOnDatasetsPage, row.name) > 0 ? kDatasetsPage : kObjectsPage;
}

// A default in words is no code.
std::string Default(const std::string& value) {
  return value.find(' ') == std::string::npos ? MarkdownCode(value) : MarkdownText(value);
}

std::string OptionTable(const std::vector<OptionHelp>& options) {
  std::vector<std::vector<std::string>> rows{{"argument", "value", "default", "meaning"}};
  for (const OptionHelp& option : options) {
    rows.push_back({MarkdownCode(option.names), MarkdownText(option.value),
                    option.required ? "required" : Default(option.default_value),
                    MarkdownText(option.help)});
  }
  return rows.size() > 1 ? "\n" + MarkdownTable(rows) : "";
}

// The notes of --help without the list of settings, and the example.
std::string Footer(const std::string& footer) {
  const size_t example = footer.find("Example: ");
  std::string notes = footer.substr(0, example);
  while (!notes.empty() && notes.back() == '\n') notes.pop_back();
  const bool lists_settings = notes.find("and their defaults:") != std::string::npos;
  std::string text;
  if (!notes.empty() && !lists_settings) {
    text += fmt::format("\n```text\n{}\n```\n", notes.substr(notes.find_first_not_of('\n')));
  }
  if (example == std::string::npos) return text;
  text += "\n```bash\n";
  size_t at = example + std::string("Example: ").size();
  while (at < footer.size()) {
    const size_t end = std::min(footer.find('\n', at), footer.size());
    const size_t begin = footer.find_first_not_of(' ', at);
    if (begin < end) text += footer.substr(begin, end - begin) + "\n";
    at = end + 1;
  }
  return text + "```\n";
}

void AddCommand(const CommandHelp& command, int level, std::string& text) {
  text += fmt::format("\n{} {}\n\n{}\n", std::string(level, '#'), command.name,
                      MarkdownText(command.help));
  text += OptionTable(command.options) + Footer(command.footer);
  for (const CommandHelp& subcommand : command.subcommands) {
    AddCommand(subcommand, level + 1, text);
  }
}

std::string ListOfCommands() {
  std::vector<std::vector<std::string>> rows{{"command", "what it does"}};
  for (const CommandRow& row : CommandTable()) {
    rows.push_back(
        {fmt::format("[{0}]({1}#pickbed-{0})", row.name, PageOf(row)), MarkdownText(row.help)});
  }
  return MarkdownTable(rows);
}

}  // namespace

void AddCommandPages(Pages& pages) {
  const OptionHelp common = CommonOption();
  pages[kFirstPage] =
      PageHead("Commands") +
      fmt::format(
          "`pickbed COMMAND --help` prints the arguments of a command. All commands have "
          "`--help`, and `{}`: {}. The exit status is 0 when done, 1 for bad input, 2 for "
          "an internal error and 130 after an interrupt.\n\n",
          common.names, MarkdownText(common.help)) +
      ListOfCommands();
  const std::string others =
      fmt::format("All commands are listed in [Commands]({}).\n", kFirstPage);
  pages[kResultsPage] = PageHead("Commands for results and measurements") + others;
  pages[kDatasetsPage] = PageHead("Commands for datasets") + others;
  pages[kObjectsPage] = PageHead("Commands for scenes, objects and models") + others;
  for (const CommandRow& row : CommandTable()) {
    AddCommand(DescribeCommand(row), 2, pages[PageOf(row)]);
  }
}

}  // namespace pickbed::eval
