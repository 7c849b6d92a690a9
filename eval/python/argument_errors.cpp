#include "eval/python/argument_errors.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace pickbed::eval {
namespace {

namespace py = pybind11;

// Splits a text at the commas that are in no brackets and no quotes.
std::vector<std::string> SplitAtCommas(std::string_view text) {
  std::vector<std::string> items(1);
  int depth = 0;
  char quote = 0;
  for (const char c : text) {
    if (quote != 0) {
      if (c == quote) quote = 0;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else {
      depth += (c == '(' || c == '[' || c == '{') - (c == ')' || c == ']' || c == '}');
      if (c == ',' && depth == 0) {
        items.emplace_back();
        continue;
      }
    }
    if (c != ' ' || !items.back().empty()) items.back() += c;
  }
  if (items.back().empty()) items.pop_back();
  return items;
}

struct Parameter {
  std::string name, type, default_value;  // default_value: empty = required
  std::string InWords() const {
    return default_value.empty() ? name : fmt::format("{}={}", name, default_value);
  }
};

// Reads the parameters from the first line of a docstring of pybind11, such as
// "capture(self: pickbed.Cell, attempt: int = 0) -> pickbed.CapturedView".
std::optional<std::vector<Parameter>> ParametersIn(const std::string& doc) {
  const std::string line = doc.substr(0, doc.find('\n'));
  const size_t open = line.find('('), close = line.rfind(") ->");
  if (open == std::string::npos || close == std::string::npos) return std::nullopt;
  std::vector<Parameter> parameters;
  for (const std::string& item :
       SplitAtCommas(std::string_view(line).substr(open + 1, close - open - 1))) {
    const size_t colon = item.find(": ");
    if (colon == std::string::npos) return std::nullopt;
    const size_t equals = item.find(" = ");
    const size_t type_end = equals == std::string::npos ? item.size() : equals;
    parameters.push_back({item.substr(0, colon), item.substr(colon + 2, type_end - colon - 2),
                          equals == std::string::npos ? "" : item.substr(equals + 3)});
  }
  return parameters;
}

std::string InWords(py::handle value) {
  constexpr size_t kMaxShown = 40;
  const std::string type = py::str(py::type::of(value).attr("__name__"));
  const std::string text = value.is_none() ? "None" : std::string(py::repr(value));
  if (value.is_none()) return text;
  if (text.size() > kMaxShown || text.find('\n') != std::string::npos) {
    return fmt::format("a value of type {}", type);
  }
  return fmt::format("{} of type {}", text, type);
}

std::string Fault(const std::string& path, const std::string& wanted, py::handle value) {
  return fmt::format("{} must be {}, not {}", path, wanted, InWords(value));
}

bool IsNumber(py::handle value) {
  if (PyUnicode_Check(value.ptr()) || PyBytes_Check(value.ptr())) return false;
  const auto number = py::reinterpret_steal<py::object>(PyNumber_Float(value.ptr()));
  if (!number) PyErr_Clear();
  return static_cast<bool>(number);
}

std::string NumberFault(const std::string& path, const std::string& type, py::handle value) {
  if (type == "float") return IsNumber(value) ? "" : Fault(path, "a number", value);
  const auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!whole) {
    PyErr_Clear();
    return Fault(path, "a whole number", value);
  }
  constexpr int64_t kMax = std::numeric_limits<int>::max();
  const bool is_in_range = whole >= py::int_(-kMax) && whole <= py::int_(kMax);
  return is_in_range ? "" : fmt::format("{} = {} is out of range", path, InWords(value));
}

std::string FaultOf(const std::string& path, const std::string& type, py::handle value);

// Fault of a sequence. `types` are the types of its items; one type is of any number of items.
std::string ItemsFault(const std::string& path, const std::vector<std::string>& types,
                       bool is_tuple, py::handle value) {
  const std::string wanted = is_tuple ? fmt::format("a list of {} values", types.size()) : "a list";
  const bool is_text = PyUnicode_Check(value.ptr()) || PyBytes_Check(value.ptr());
  if (is_text || PySequence_Check(value.ptr()) == 0) return Fault(path, wanted, value);
  const auto items = py::reinterpret_borrow<py::sequence>(value);
  if (is_tuple && items.size() != types.size()) return Fault(path, wanted, value);
  for (size_t i = 0; i < items.size(); ++i) {
    const py::object item = items[i];
    const std::string fault =
        FaultOf(fmt::format("{}[{}]", path, i), types[is_tuple ? i : 0], item);
    if (!fault.empty()) return fault;
  }
  return "";
}

// Returns why the value does not have a type as pybind11 writes it; empty if it has, or if the type
// is not known here.
std::string FaultOf(const std::string& path, const std::string& type, py::handle value) {
  const auto inner = [&](std::string_view outer) {
    return SplitAtCommas(
        std::string_view(type).substr(outer.size(), type.size() - outer.size() - 1));
  };
  if (type == "float" || type == "int") return NumberFault(path, type, value);
  if (type == "bool") {  // NumPy has a type of its own
    const bool is_bool = PyBool_Check(value.ptr()) ||
                         std::string_view(Py_TYPE(value.ptr())->tp_name) == "numpy.bool_";
    return is_bool ? "" : Fault(path, "True or False", value);
  }
  if (type == "str") return PyUnicode_Check(value.ptr()) ? "" : Fault(path, "a text", value);
  if (type == "os.PathLike") {
    const bool is_path = PyUnicode_Check(value.ptr()) || py::hasattr(value, "__fspath__");
    return is_path ? "" : Fault(path, "a path", value);
  }
  if (type == "dict" || type.starts_with("Dict[")) {
    return PyDict_Check(value.ptr()) ? "" : Fault(path, "a dict", value);
  }
  if (type.starts_with("Optional[")) {
    return value.is_none() ? "" : FaultOf(path, inner("Optional[").front(), value);
  }
  if (type.starts_with("List[")) return ItemsFault(path, inner("List["), false, value);
  if (type.starts_with("Tuple[")) return ItemsFault(path, inner("Tuple["), true, value);
  constexpr std::string_view kModule = "pickbed.";
  if (!type.starts_with(kModule)) return "";
  const std::string name = type.substr(kModule.size());
  const py::module_ module = py::module_::import("pickbed");
  const bool has_type =
      !py::hasattr(module, name.c_str()) || py::isinstance(value, module.attr(name.c_str()));
  return has_type ? "" : Fault(path, "a " + name, value);
}

// Returns what is wrong with the arguments of a call.
std::string ArgumentFault(std::vector<Parameter> parameters, py::tuple args, py::dict kwargs) {
  size_t first = 0;
  if (!parameters.empty() && parameters.front().name == "self") {
    parameters.erase(parameters.begin());
    first = 1;
  }
  std::vector<std::string> known;
  for (const Parameter& parameter : parameters) known.push_back(parameter.InWords());
  const std::string takes = fmt::format("it takes ({})", fmt::join(known, ", "));
  if (args.size() - first > parameters.size()) {
    return fmt::format("{} arguments are given; {}", args.size() - first, takes);
  }
  py::dict left(kwargs.attr("copy")());
  for (size_t i = 0; i < parameters.size(); ++i) {
    const Parameter& parameter = parameters[i];
    const py::str name(parameter.name);
    std::optional<py::object> value;
    if (i + first < args.size()) value = args[i + first];
    if (left.contains(name)) {
      if (value) return fmt::format("{} is given twice", parameter.name);
      value = left.attr("pop")(name);
    }
    if (!value && parameter.default_value.empty()) {
      return fmt::format("{} is missing; {}", parameter.name, takes);
    }
    if (!value) continue;
    const std::string fault = FaultOf(parameter.name, parameter.type, *value);
    if (!fault.empty()) return fault;
  }
  for (const auto& [name, value] : left) {
    return fmt::format("there is no argument {}; {}", std::string(py::str(name)), takes);
  }
  return fmt::format("an argument has a wrong type; {}", takes);
}

bool IsFromDispatcher(const py::error_already_set& error) {
  if (!error.matches(PyExc_TypeError)) return false;
  const std::string text = py::str(error.value());
  return text.find("incompatible function arguments") != std::string::npos ||
         text.find("incompatible constructor arguments") != std::string::npos;
}

// Returns the function with one line per error. `name` is for messages.
template <typename... Extra>
py::cpp_function Wrapped(const py::object& function, const std::string& name,
                         const Extra&... extra) {
  const std::string doc = py::str(function.attr("__doc__"));
  py::options options;
  options.disable_function_signatures();  // the docstring has it already
  return py::cpp_function(
      [function, name, doc](const py::args& args, const py::kwargs& kwargs) -> py::object {
        try {
          return function(*args, **kwargs);
        } catch (const py::error_already_set& error) {
          if (!IsFromDispatcher(error)) throw;
          const auto parameters = ParametersIn(doc);
          if (!parameters) throw;
          throw py::type_error(
              fmt::format("{}(): {}", name, ArgumentFault(*parameters, args, kwargs)));
        }
      },
      py::name(name.c_str()), doc.c_str(), extra...);
}

void ShortenInClass(const py::object& type, const std::string& type_name) {
  const py::dict members(type.attr("__dict__").attr("copy")());
  for (const auto& [key, member] : members) {
    const std::string name = py::str(key);
    const bool is_constructor = name == "__init__";
    if (name.starts_with("_") && !is_constructor) continue;
    const std::string shown = is_constructor ? type_name : name;
    if (PyInstanceMethod_Check(member.ptr())) {
      py::setattr(type, name.c_str(), Wrapped(member.attr("__func__"), shown, py::is_method(type)));
    } else if (Py_IS_TYPE(member.ptr(), &PyStaticMethod_Type)) {
      py::setattr(type, name.c_str(),
                  py::staticmethod(Wrapped(member.attr("__func__"), shown, py::scope(type))));
    }
  }
}

}  // namespace

void ShortenArgumentErrors(py::module_& module) {
  const py::dict members(module.attr("__dict__").attr("copy")());
  for (const auto& [key, member] : members) {
    const std::string name = py::str(key);
    const auto value = py::reinterpret_borrow<py::object>(member);
    if (PyType_Check(member.ptr())) {
      ShortenInClass(value, name);
    } else if (PyCFunction_Check(member.ptr()) && !name.starts_with("_")) {
      py::setattr(module, name.c_str(), Wrapped(value, name, py::scope(module)));
    }
  }
}

}  // namespace pickbed::eval
