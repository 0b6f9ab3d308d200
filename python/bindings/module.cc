// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <exception>

#include "python/bindings/convert.h"
#include "tools/cli/process/kept_memory.h"
#include "tools/cli/process/version.h"
#include <fmt/format.h>

namespace panelcal::python {
namespace {

std::string shape_text(const py::array& array) {
  std::string out = "(";
  for (py::ssize_t i = 0; i < array.ndim(); ++i) {
    out += fmt::format("{}{}", i == 0 ? "" : ", ", array.shape(i));
  }
  return out + ")";
}

[[noreturn]] void raise_shape(std::string_view name, const py::array& array, std::string expected) {
  raise({Code::Usage,
         {std::string(name), 0, 0},
         "an array of shape " + shape_text(array),
         std::move(expected)});
}

py::dict as_dict(const Diagnostic& one) {
  py::dict row;
  row["severity"] = one.severity() == Severity::Error ? "error" : "warning";
  row["code"] = text(info(one.code).slug);
  row["file"] = text(one.place.file);
  row["line"] = one.place.line;
  row["column"] = one.place.column;
  row["what"] = text(one.what);
  row["expected"] = text(one.expected);
  row["text"] = text(one.text());
  return row;
}

void set_error(const Raised& raised) {
  const Diagnostic& problem = raised.problem;
  const py::object type = py::module_::import("panelcal._error").attr("Error");
  const py::object error =
      type(text(problem.text()),
           text(info(problem.code).slug),
           text(problem.place.file),
           problem.place.line,
           problem.place.column,
           text(problem.what),
           text(problem.expected),
           raised.log.empty() ? diagnostics({&problem, 1}) : diagnostics(raised.log));
  PyErr_SetObject(type.ptr(), error.ptr());
}

}  // namespace

void raise_usage(std::string_view function, std::string what, std::string expected) {
  raise({Code::Usage,
         {"panelcal." + std::string(function), 0, 0},
         std::move(what),
         std::move(expected)});
}

void raise_errors(const DiagnosticLog& log) {
  const auto is_error = [](const Diagnostic& one) { return one.severity() == Severity::Error; };
  const auto first = std::ranges::find_if(log.kept(), is_error);
  if (first != log.kept().end()) throw Raised{*first, {log.kept().begin(), log.kept().end()}};
}

py::str text(std::string_view bytes) {
  PyObject* const decoded =
      PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "surrogateescape");
  if (decoded == nullptr) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(decoded);
}

py::bytes bytes_of(std::string_view bytes) {
  return {bytes.data(), bytes.size()};
}

py::list diagnostics(std::span<const Diagnostic> log) {
  py::list out;
  for (const Diagnostic& one : log) out.append(as_dict(one));
  return out;
}

std::vector<Eigen::Vector2d> points_of(const Doubles& array, std::string_view name) {
  const bool is_pair = array.ndim() == 1 && array.shape(0) == 2;
  const bool is_empty = array.size() == 0;
  if (!is_pair && !is_empty && !(array.ndim() == 2 && array.shape(1) == 2)) {
    raise_shape(name, array, "(n, 2): x and y of each point");
  }
  std::vector<Eigen::Vector2d> out(static_cast<std::size_t>(array.size()) / 2);
  const double* from = array.data();
  for (Eigen::Vector2d& point : out) {
    point = {from[0], from[1]};
    from += 2;
  }
  return out;
}

std::vector<Eigen::Matrix2d> covariances_of(const Doubles& array,
                                            std::size_t n,
                                            std::string_view name) {
  if (array.size() == 1) {
    const double sigma = *array.data();
    return {n, sigma * sigma * Eigen::Matrix2d::Identity()};
  }
  const bool is_one = array.ndim() == 2 && array.shape(0) == 2 && array.shape(1) == 2;
  const bool is_each = array.ndim() == 3 && static_cast<std::size_t>(array.shape(0)) == n &&
                       array.shape(1) == 2 && array.shape(2) == 2;
  if (!is_one && !is_each) {
    raise_shape(name,
                array,
                fmt::format("({}, 2, 2): a covariance for each point; (2, 2) for all of them; or "
                            "one standard deviation",
                            n));
  }
  std::vector<Eigen::Matrix2d> out(n);
  const double* from = array.data();
  for (Eigen::Matrix2d& cov : out) {
    cov << from[0], from[1], from[2], from[3];
    if (is_each) from += 4;
  }
  return out;
}

std::vector<double> values_of(const Doubles& array, std::size_t n, std::string_view name) {
  if (array.size() == 1) return std::vector<double>(n, *array.data());
  if (array.ndim() != 1 || static_cast<std::size_t>(array.size()) != n) {
    raise_shape(name, array, fmt::format("({},), or one number for all", n));
  }
  return {array.data(), array.data() + array.size()};
}

}  // namespace panelcal::python

PYBIND11_MODULE(_core, module) {
  using namespace panelcal::python;
  panelcal::keep_freed_memory();
  module.doc() = "What panelcal does, in C++. Use it by the package panelcal.";
  module.attr("__version__") = panelcal::kVersion;
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Raised& raised) {
      set_error(raised);
    }
  });
  bind_pictures(module);
  bind_targets(module);
  bind_machine(module);
  bind_locate(module);
  bind_programs(module);
  bind_jobs(module);
  bind_panel(module);
  bind_plan(module);
  bind_surface(module);
  bind_calibrations(module);
}
