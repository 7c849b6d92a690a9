#include "eval/python/scenarios.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "eval/python/arrays.h"
#include "eval/python/calls.h"
#include "eval/python/docstring.h"
#include "eval/python/module.h"
#include "eval/trial/oracle_estimator.h"
#include "grasp/grippers/table.h"
#include "grasp/planners/table.h"
#include "scenes/base/error.h"
#include "scenes/geometry/symmetry.h"
#include "scenes/objects/object_catalog.h"
#include "scenes/scenario/find_scenario.h"
#include "scenes/scenario/scenario_text.h"
#include "sim/sensor/sensor_profile.h"

namespace pickbed::eval {
namespace {

namespace py = pybind11;

class DictWriter : public SettingsVisitor {
 public:
  explicit DictWriter(py::dict dict) : dict_(std::move(dict)) {}

  void Real(const char* key, double& value, Range, const char*) override { dict_[key] = value; }
  void Integer(const char* key, int& value, Range, const char*) override { dict_[key] = value; }
  void Seed(const char* key, uint64_t& value, const char*) override { dict_[key] = value; }
  void Bool(const char* key, bool& value, const char*) override { dict_[key] = value; }
  void Text(const char* key, std::string& value, const std::vector<std::string>&,
            const char*) override {
    dict_[key] = value;
  }
  void Names(const char* key, std::vector<std::string>& value, const char*) override {
    dict_[key] = value;
  }
  void Words(const char* key, std::vector<std::string>& value, const char*) override {
    dict_[key] = value;
  }
  void Vector2(const char* key, Eigen::Vector2d& value, Range, const char*) override {
    dict_[key] = std::vector<double>{value.x(), value.y()};
  }
  void Vector3(const char* key, Eigen::Vector3d& value, Range, const char*) override {
    dict_[key] = std::vector<double>{value.x(), value.y(), value.z()};
  }
  void Group(const char* key, const VisitFunction& visit, const char*) override {
    dict_[key] = SettingsDict(visit);
  }
  void List(const char* key, size_t size, const std::function<void(size_t)>&,
            const std::function<void(size_t, SettingsVisitor&)>& visit, const char*) override {
    py::list items;
    for (size_t i = 0; i < size; ++i) {
      items.append(SettingsDict([&](SettingsVisitor& item) { visit(i, item); }));
    }
    dict_[key] = items;
  }

 private:
  py::dict dict_;
};

// A value as JSON, which is YAML too.
std::string ValueText(const py::handle& value) {
  py::object plain = py::reinterpret_borrow<py::object>(value);
  if (py::hasattr(plain, "tolist")) plain = plain.attr("tolist")();  // of NumPy
  if (py::hasattr(plain, "__fspath__")) plain = plain.attr("__fspath__")();
  try {
    return py::str(py::module_::import("json").attr("dumps")(plain));
  } catch (const py::error_already_set& error) {
    if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError)) throw;
    const std::string type = py::str(py::type::of(value).attr("__name__"));
    throw InputError(fmt::format("a setting has a value of type {}, which is no setting", type));
  }
}

LoadedScenario LoadFrom(const std::filesystem::path& scenario, const py::object& settings,
                        const std::string& catalog, std::optional<int> trials) {
  const ScenarioRequest request{scenario.string(), AssignmentsFrom(settings), catalog, trials};
  return WithoutLock([&] { return FindScenario(request); });
}

template <typename Rows>
std::vector<std::string> RowNames(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.push_back(row.name);
  return names;
}

void AddTables(py::module_& module) {
  module.def("preset_names", PresetNames, Doc("PresetNames"));
  module.def(
      "estimator_names", [] { return RowNames(EstimatorNames()); }, Doc("EstimatorNames"));
  module.def(
      "planner_names", [] { return RowNames(PlannerTable()); }, Doc("PlannerTable"));
  module.def("gripper_names", GripperNames, Doc("GripperNames"));
  module.def("sensor_names", SensorProfileNames, "Names of the files in assets/sensors, sorted.");
  module.def(
      "object_names", [](const std::string& catalog) { return OpenCatalog(catalog).Names(); },
      py::arg("catalog") = "objects",
      "Names of the objects in the folder `catalog` and of the shipped ones, sorted.");
}

void AddCameraIntrinsics(py::module_& module) {
  py::class_<CameraIntrinsics>(module, "CameraIntrinsics", Doc("CameraIntrinsics"))
      .def(py::init<int, int, double, double, double, double>(), py::arg("width"),
           py::arg("height"), py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"),
           "Raises InputError that names every invalid value.")
      .def_static("from_matrix", &IntrinsicsFrom, py::arg("K"), py::arg("width"), py::arg("height"),
                  "Returns the camera with this 3 x 3 matrix and image size.")
      .def_property_readonly("width", &CameraIntrinsics::width)
      .def_property_readonly("height", &CameraIntrinsics::height)
      .def_property_readonly("fx", &CameraIntrinsics::fx)
      .def_property_readonly("fy", &CameraIntrinsics::fy)
      .def_property_readonly("cx", &CameraIntrinsics::cx)
      .def_property_readonly("cy", &CameraIntrinsics::cy)
      .def_property_readonly("K", &CameraMatrix, "3 x 3 camera matrix, px")
      .def("__repr__", [](const CameraIntrinsics& k) {
        return fmt::format("CameraIntrinsics(width={}, height={}, fx={}, fy={}, cx={}, cy={})",
                           k.width(), k.height(), k.fx(), k.fy(), k.cx(), k.cy());
      });
}

void AddObjectModel(py::module_& module) {
  py::class_<ObjectModel, std::shared_ptr<ObjectModel>>(module, "ObjectModel", Doc("ObjectModel"))
      .def_readonly("name", &ObjectModel::name)
      .def_property_readonly(
          "vertices_O_m",
          [](const py::object& self) {
            return Share(self.cast<const ObjectModel&>().mesh_O.vertices, self);
          },
          "vertices of the mesh in O, an array of shape (n, 3), m")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) {
            return Share(self.cast<const ObjectModel&>().mesh_O.triangles, self);
          },
          "indices of the vertices, counter-clockwise as seen from outside, of shape (n, 3)")
      .def_readonly("diameter_m", &ObjectModel::diameter_m,
                    "largest distance between two vertices, m")
      .def_readonly("friction", &ObjectModel::friction, Doc("ObjectModel::friction"))
      .def_property_readonly("mass_kg", [](const ObjectModel& o) { return o.mass.mass_kg; })
      .def_property_readonly(
          "com_O_m", [](const ObjectModel& o) { return ArrayOf(o.mass.com_O); },
          "center of mass in O, m")
      .def(
          "symmetry_transforms",
          [](const ObjectModel& o, int steps) {
            return ArrayOf(SymmetryTransforms(o.symmetries_O, steps));
          },
          py::arg("steps") = 315, Doc("SymmetryTransforms"))
      .def("__repr__", [](const ObjectModel& o) {
        return fmt::format("<ObjectModel {}: diameter {:.4f} m, mass {:.4f} kg>", o.name,
                           o.diameter_m, o.mass.mass_kg);
      });
  module.def(
      "load_object",
      [](const std::string& name, const std::string& catalog) {
        return std::const_pointer_cast<ObjectModel>(
            WithoutLock([&] { return OpenCatalog(catalog).Load(name); }));
      },
      py::arg("name"), py::arg("catalog") = "objects",
      "Loads an object of the folder `catalog` or a shipped one. Raises InputError for an unknown "
      "name.");
  module.def(
      "load_mesh_object",
      [](const std::filesystem::path& mesh, const std::string& unit, double mass_kg,
         double friction) {
        const MeshObjectSpec spec{.mesh = mesh,
                                  .unit = unit,
                                  .mass_kg = mass_kg,
                                  .friction = friction,
                                  .symmetries_O = {}};
        return std::const_pointer_cast<ObjectModel>(
            WithoutLock([&] { return LoadMeshObject(mesh.stem().string(), spec); }));
      },
      py::arg("mesh"), py::arg("unit") = "m", py::arg("mass_kg") = 0.1, py::arg("friction") = 0.5,
      Doc("LoadMeshObject"));
}

void AddScenario(py::module_& module) {
  py::class_<LoadedScenario, std::shared_ptr<LoadedScenario>>(module, "Scenario",
                                                              Doc("LoadedScenario"))
      .def(
          py::init(&LoadFrom), py::arg("scenario"), py::arg("settings") = py::none(),
          py::arg("catalog") = "objects", py::arg("trials") = py::none(),
          "Loads a preset or a scenario file with the objects that it needs. `settings`: overrides "
          "as with --set, a dict {\"objects.0.count\": 3} or a list [\"objects.0.count=3\"]. "
          "`catalog`: folder of your own objects. `trials`: number of bins. Raises InputError for "
          "an unknown name or a bad value.")
      .def_readonly("name", &LoadedScenario::name, Doc("LoadedScenario::name"))
      .def_property_readonly("seed", [](const LoadedScenario& s) { return s.spec.seed; })
      .def_property_readonly(
          "trials", [](const LoadedScenario& s) { return s.spec.trials; }, "number of bins")
      .def_property_readonly(
          "settings",
          [](const LoadedScenario& s) {
            ScenarioSpec copy = s.spec;  // Visit() is not const, because readers set the values
            return SettingsDict([&copy](SettingsVisitor& v) { copy.Visit(v); });
          },
          "all effective settings as nested dicts and lists; a copy")
      .def(
          "text", [](const LoadedScenario& s) { return ScenarioText(s.spec, s.spec.folder); },
          "Returns all effective settings as YAML, as in the results folder of a run.")
      .def_property_readonly(
          "objects",
          [](const LoadedScenario& s) {
            std::vector<std::shared_ptr<ObjectModel>> objects;
            for (const auto& object : s.objects) {
              objects.push_back(std::const_pointer_cast<ObjectModel>(object));
            }
            return objects;
          },
          "the objects, in the order of the settings; an object index refers to this list")
      .def_property_readonly(
          "camera", [](const LoadedScenario& s) { return CameraOf(s.spec).intrinsics; },
          "intrinsics of the camera")
      .def_property_readonly(
          "X_WC", [](const LoadedScenario& s) { return ArrayOf(CameraOf(s.spec).X_WC()); },
          "pose of the camera in the world")
      .def("__repr__", [](const LoadedScenario& s) {
        return fmt::format("<Scenario {}: {}>", s.name, ObjectsInWords(s.spec));
      });
}

}  // namespace

py::dict SettingsDict(const VisitFunction& visit) {
  py::dict dict;
  DictWriter writer(dict);
  visit(writer);
  return dict;
}

std::vector<std::string> AssignmentsFrom(const py::object& settings) {
  std::vector<std::string> assignments;
  if (settings.is_none()) return assignments;
  if (py::isinstance<py::dict>(settings)) {
    for (const auto& [key, value] : settings.cast<py::dict>()) {
      assignments.push_back(std::string(py::str(key)) + "=" + ValueText(value));
    }
    return assignments;
  }
  CheckInput(py::isinstance<py::list>(settings) || py::isinstance<py::tuple>(settings),
             "settings must be a dict {\"key\": value} or a list [\"key=value\"]");
  for (const py::handle& item : settings) {
    CheckInput(py::isinstance<py::str>(item),
               "settings must be a dict {\"key\": value} or a list [\"key=value\"]");
    assignments.push_back(item.cast<std::string>());
  }
  return assignments;
}

void AddScenarios(py::module_& module) {
  AddTables(module);
  AddCameraIntrinsics(module);
  AddObjectModel(module);
  AddScenario(module);
}

}  // namespace pickbed::eval
