#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "scenes/base/error.h"
#include "scenes/base/setting_rules.h"
#include "scenes/base/settings.h"

namespace pickbed::scenes {
namespace {

// Collects the values that are not allowed.
class Checker : public SettingsVisitor {
 public:
  using KeyName = std::function<std::string(const std::string& key)>;
  explicit Checker(const KeyName& at) : at_(at) {}
  std::vector<std::string> TakeFaults() { return std::move(faults_); }

  void Real(const char* key, double& value, Range range, const char* help) override {
    if (!IsIn(range, value)) Add(key, fmt::format("= {}: {}", value, NumberRule(range, help)));
  }
  void Integer(const char* key, int& value, Range range, const char* help) override {
    if (!IsIn(range, value)) Add(key, fmt::format("= {}: {}", value, NumberRule(range, help)));
  }
  void Seed(const char*, uint64_t&, const char*) override {}
  void Bool(const char*, bool&, const char*) override {}
  void Text(const char* key, std::string& value, const std::vector<std::string>& choices,
            const char*) override {
    if (IsChoice(value, choices)) return;
    faults_.push_back(UnknownNameMessage(NameOf(key), value, choices));
  }
  void Names(const char* key, std::vector<std::string>& value, const char* help) override {
    if (value.empty()) Add(key, fmt::format("= []: must be a name or a list of names ({})", help));
  }
  void Words(const char*, std::vector<std::string>&, const char*) override {}
  void Vector2(const char* key, Eigen::Vector2d& value, Range range, const char* help) override {
    for (double number : value) Real(key, number, range, help);
  }
  void Vector3(const char* key, Eigen::Vector3d& value, Range range, const char* help) override {
    for (double number : value) Real(key, number, range, help);
  }
  void Group(const char* key, const VisitFunction& visit, const char*) override {
    Enter(key, visit);
  }
  void List(const char* key, size_t size, const std::function<void(size_t)>&,
            const std::function<void(size_t, SettingsVisitor&)>& visit, const char*) override {
    for (size_t i = 0; i < size; ++i) {
      Enter(fmt::format("{}.{}", key, i), [&](SettingsVisitor& item) { visit(i, item); });
    }
  }

 private:
  std::string NameOf(const char* key) const { return at_ ? at_(prefix_ + key) : prefix_ + key; }
  void Add(const char* key, const std::string& fault) {
    faults_.push_back(fmt::format("{} {}", NameOf(key), fault));
  }
  void Enter(const std::string& key, const VisitFunction& visit) {
    const size_t length = prefix_.size();
    prefix_ += key + ".";
    visit(*this);
    prefix_.resize(length);
  }

  const KeyName& at_;
  std::string prefix_;  // path of the map under way, such as "objects.0."
  std::vector<std::string> faults_;
};

}  // namespace

std::string RangeText(Range range) { return fmt::format("from {} to {}", range.min, range.max); }

bool IsIn(Range range, double number) { return number >= range.min && number <= range.max; }

std::string NumberRule(Range range, const char* help) {
  return fmt::format("must be a number {} ({})", RangeText(range), help);
}

bool IsChoice(const std::string& value, const std::vector<std::string>& choices) {
  return choices.empty() || std::find(choices.begin(), choices.end(), value) != choices.end();
}

std::vector<std::string> SettingFaults(
    const VisitFunction& visit, const std::function<std::string(const std::string& key)>& at) {
  Checker checker(at);
  visit(checker);
  return checker.TakeFaults();
}

void CheckSettings(const std::string& name, const VisitFunction& visit) {
  const std::vector<std::string> faults = SettingFaults(visit);
  if (!faults.empty()) throw InputError(fmt::format("{}: {}", name, fmt::join(faults, "; ")));
}

}  // namespace pickbed::scenes
