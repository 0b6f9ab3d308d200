// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include <Eigen/Core>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

// How values go to Python and come from there: what all of the bindings speak.
namespace panelcal::python {

namespace py = pybind11;

/// A problem on its way to Python, where it becomes a panelcal.Error.
struct Raised {
  Diagnostic problem;
  std::vector<Diagnostic> log;  ///< all that was found, where one pass can find several
};

[[noreturn]] inline void raise(Diagnostic problem) {
  throw Raised{std::move(problem), {}};
}
/// A call whose arguments are out of range, or of a wrong shape.
///
/// In     function: name of the called one, which stands in the place of a file
[[noreturn]] void raise_usage(std::string_view function, std::string what, std::string expected);
/// Raises the first error of a log; returns if there is none.
void raise_errors(const DiagnosticLog& log);

/// The value, or its problem raised. Needs no GIL.
template <class T>
T value_of(Expected<T> value) {
  if (!value) throw Raised{std::move(value).error(), {}};
  if constexpr (!std::is_void_v<T>) return *std::move(value);
}

/// Text of a file name or of a program, which may hold any bytes: as os.fsdecode() gives it.
py::str text(std::string_view bytes);
py::bytes bytes_of(std::string_view bytes);
/// Warnings and errors of a log, each as {"severity", "code", "text", "file", "line", ...}.
py::list diagnostics(std::span<const Diagnostic> log);

/// An array that owns what the vector held: nothing is copied.
///
/// In     shape: behind the number of rows: {2} makes n x 2 of 2 n values
template <class T>
py::array array_of(std::vector<T> values, std::vector<py::ssize_t> shape = {}) {
  py::ssize_t n_in_row = 1;
  for (const py::ssize_t n : shape) n_in_row *= n;
  shape.insert(shape.begin(), static_cast<py::ssize_t>(values.size()) / n_in_row);
  auto* const owned = new std::vector<T>(std::move(values));
  const py::capsule owner(owned, [](void* data) { delete static_cast<std::vector<T>*>(data); });
  return py::array_t<T>(std::move(shape), owned->data(), owner);
}

/// A point, a matrix: a few numbers, copied.
template <class Matrix>
py::array_t<double> matrix_of(const Matrix& matrix) {
  const bool is_vector = matrix.cols() == 1;
  py::array_t<double> out(is_vector ? std::vector<py::ssize_t>{matrix.rows()}
                                    : std::vector<py::ssize_t>{matrix.rows(), matrix.cols()});
  double* to = out.mutable_data();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) *to++ = matrix(i, j);
  }
  return out;
}

using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Points of an n x 2 array, or of a single pair.
///
/// In     name: of the argument, as messages have it
std::vector<Eigen::Vector2d> points_of(const Doubles& array, std::string_view name);
/// A covariance for each of n points: of n x 2 x 2, of 2 x 2 for all, or a sigma for all.
std::vector<Eigen::Matrix2d> covariances_of(const Doubles& array,
                                            std::size_t n,
                                            std::string_view name);
/// A value for each of n points: of n, or one for all.
std::vector<double> values_of(const Doubles& array, std::size_t n, std::string_view name);

void bind_pictures(py::module_& module);
void bind_targets(py::module_& module);
void bind_locate(py::module_& module);
void bind_machine(py::module_& module);
void bind_programs(py::module_& module);
void bind_jobs(py::module_& module);
void bind_panel(py::module_& module);
void bind_plan(py::module_& module);
void bind_surface(py::module_& module);
void bind_calibrations(py::module_& module);

}  // namespace panelcal::python
