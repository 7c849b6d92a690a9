#include "eval/reference/setting_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "eval/metrics/result_columns.h"

namespace pickbed::eval {
namespace {

std::string Number(double number) { return fmt::format("{:.10g}", number); }

std::string InRange(const std::string& type, Range range) {
  return fmt::format("{} from {} to {}", type, Number(range.min), Number(range.max));
}

class RowCollector : public SettingsVisitor {
 public:
  std::vector<SettingRow> TakeRows() { return std::move(rows_); }

  void Real(const char* key, double& value, Range range, const char* help) override {
    Add(key, InRange("number", range), Number(value), help);
  }
  void Integer(const char* key, int& value, Range range, const char* help) override {
    Add(key, InRange("whole number", range), std::to_string(value), help);
  }
  void Seed(const char* key, uint64_t& value, const char* help) override {
    Add(key, "whole number from 0", std::to_string(value), help);
  }
  void Bool(const char* key, bool& value, const char* help) override {
    Add(key, "true or false", value ? "true" : "false", help);
  }
  void Text(const char* key, std::string& value, const std::vector<std::string>& choices,
            const char* help) override {
    const std::string kind = choices.empty() ? "text" : fmt::format("{}", fmt::join(choices, ", "));
    Add(key, kind, value.empty() ? kEmptySetting : value, help);
  }
  void Names(const char* key, std::vector<std::string>& value, const char* help) override {
    Add(key, "name or list of names", fmt::format("{}", fmt::join(value, ", ")), help);
  }
  void Words(const char* key, std::vector<std::string>& value, const char* help) override {
    Add(key, "list of words",
        value.empty() ? kEmptySetting : fmt::format("{}", fmt::join(value, " ")), help);
  }
  void Vector2(const char* key, Eigen::Vector2d& value, Range range, const char* help) override {
    Add(key, InRange("2 numbers", range),
        fmt::format("[{}, {}]", Number(value.x()), Number(value.y())), help);
  }
  void Vector3(const char* key, Eigen::Vector3d& value, Range range, const char* help) override {
    Add(key, InRange("3 numbers", range),
        fmt::format("[{}, {}, {}]", Number(value.x()), Number(value.y()), Number(value.z())), help);
  }
  void Group(const char* key, const VisitFunction& visit, const char* help) override {
    Add(key, "group", "", help);
    Enter(key, visit);
  }
  void List(const char* key, size_t size, const std::function<void(size_t)>& resize,
            const std::function<void(size_t, SettingsVisitor&)>& visit, const char* help) override {
    Add(key, "list", size == 0 ? kEmptySetting : fmt::format("{} items", size), help);
    resize(0);
    resize(1);
    Enter(std::string(key) + ".N", [&](SettingsVisitor& item) { visit(0, item); });
  }

 private:
  void Add(const std::string& key, const std::string& value, const std::string& default_value,
           const std::string& help) {
    rows_.push_back({prefix_ + key, value, default_value, UnitInName(key), help});
  }
  void Enter(const std::string& key, const VisitFunction& visit) {
    const size_t length = prefix_.size();
    prefix_ += key + ".";
    visit(*this);
    prefix_.resize(length);
  }

  std::string prefix_;
  std::vector<SettingRow> rows_;
};

}  // namespace

std::vector<SettingRow> SettingRows(const VisitFunction& visit) {
  RowCollector collector;
  visit(collector);
  return collector.TakeRows();
}

}  // namespace pickbed::eval
