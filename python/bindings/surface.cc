// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "machine/files/file_register.h"
#include "python/bindings/convert.h"
#include "surface/files/probe_file.h"
#include "surface/fit/shape.h"
#include "surface/map/file.h"
#include "surface/map/zoned_map.h"
#include "tools/cli/process/version.h"
#include "tools/surface/made_facts.h"
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace panelcal::python {
namespace {

using Path = std::filesystem::path;

/// Of `panelcal surface fit`: the radius of a probe's tip.
constexpr Length kUsualMargin = mm(0.5);
constexpr double kNoHeight = std::numeric_limits<double>::quiet_NaN();

/// Probes as arrays, whatever they came from.
struct Probes {
  std::vector<ProbePoint> points;
  std::vector<MapSource> sources;
  std::optional<int> z_axis;
};

Probes read_probes_of(const Path& file, std::optional<double> sigma_um, std::optional<int> z_axis) {
  ProbeFileOptions reading;
  if (sigma_um) reading.sigma = um(*sigma_um);
  reading.z_axis = z_axis;
  const std::string bytes = value_of(read_file(file, kMaxProbeFileBytes));
  ProbeFile read = value_of(parse_probe_file(bytes, file.string(), reading));
  return {std::move(read.points), {{file.string(), sha256(bytes)}}, read.z_axis};
}

Probes probes_of(const Doubles& places_mm, const Doubles& heights_mm, const Doubles* sigma_um) {
  const std::vector<Eigen::Vector2d> places = points_of(places_mm, "places_mm");
  const std::vector<double> heights = values_of(heights_mm, places.size(), "heights_mm");
  const double assumed_um = ProbeFileOptions().scatter().in_um();
  const std::vector<double> sigmas = sigma_um != nullptr
                                         ? values_of(*sigma_um, places.size(), "sigma_um")
                                         : std::vector<double>(places.size(), assumed_um);
  Probes out;
  for (std::size_t i = 0; i < places.size(); ++i) {
    out.points.push_back({.place = position_mm<frame::Nominal>(places[i]),
                          .measured = {mm(heights[i]), um(sigmas[i])},
                          .name = fmt::format("probe {}", i),
                          .from = {"fit_surface", static_cast<int>(i) + 1, 0},
                          .is_sigma_assumed = sigma_um == nullptr});
  }
  return out;
}

std::shared_ptr<StoredZones> fit(Probes probes, const std::string& model, double reach_mm) {
  HeightMapOptions how;
  how.model = surface_model(model);
  if (model != "auto" && !how.model) {
    std::string words;
    for (const std::string_view word : surface_model_words()) words += ", " + std::string(word);
    raise_usage("fit_surface", "model = " + quoted(model), "auto" + words);
  }
  how.max_extrapolation = mm(reach_mm);
  ZonedMap map = value_of(
      ZonedMap::of_probes(probes.points, {}, value_of(Voids::make({}, kUsualMargin)), how));
  return std::make_shared<StoredZones>(StoredZones{std::move(probes.points),
                                                   std::move(map),
                                                   std::move(probes.sources),
                                                   std::string("panelcal ") + kVersion,
                                                   probes.z_axis});
}

/// A map must not replace the probes that it was made of.
void check_no_source(const StoredZones& self, const Path& file) {
  FileRegister files;
  for (const MapSource& source : self.sources) {
    if (!source.file.empty()) files.add(source.file, "a file of probes");
  }
  const auto use = files.use_of(file);
  if (!use) return;
  raise({Code::OutputInUse,
         {"panelcal.Surface.save", 0, 0},
         fmt::format("{} is {}", quoted(file.string()), *use),
         "a file of its own for each output"});
}

py::dict query(const StoredZones& self, const Doubles& places_mm) {
  std::vector<double> heights_mm, sigmas_um, outside_mm;
  std::vector<std::string> sources;
  const std::vector<Eigen::Vector2d> places = points_of(places_mm, "places_mm");
  {
    const py::gil_scoped_release release;
    for (const Eigen::Vector2d& place : places) {
      const auto found = self.map.height_at(position_mm<frame::Nominal>(place));
      heights_mm.push_back(found ? found->height.height.in_mm() : kNoHeight);
      sigmas_um.push_back(found ? found->height.sigma.in_um() : kNoHeight);
      outside_mm.push_back(found ? found->height.outside.in_mm() : kNoHeight);
      sources.emplace_back(found ? surface::source_word(found->height.source) : "refused");
    }
  }
  py::dict out;
  out["height_mm"] = array_of(std::move(heights_mm));
  out["sigma_um"] = array_of(std::move(sigmas_um));
  out["outside_mm"] = array_of(std::move(outside_mm));
  out["source"] = sources;
  return out;
}

py::list outliers_of(const StoredZones& self) {
  py::list out;
  for (std::size_t i_zone = 0; i_zone < self.map.maps().size(); ++i_zone) {
    for (const SurfaceOutlier& one : self.map.map(i_zone).outliers()) {
      out.append(self.map.probes(i_zone)[one.i_point]);
    }
  }
  return out;
}

std::string summary_of(const StoredZones& self) {
  std::string out;
  for (const HeightMap& map : self.map.maps()) {
    out += (out.empty() ? "" : "; ") + map.surface().summary();
  }
  return out;
}

}  // namespace

void bind_surface(py::module_& module) {
  py::class_<StoredZones, std::shared_ptr<StoredZones>>(module, "Surface", R"(
Heights of a panel with their uncertainty; `fit_surface` and `read_surface` make one.

Attributes
----------
summary : str
    The model in words.
outliers : list of int
    Probes, from 0, that do not fit the others and are left out.
n_probes : int
text : str
    What `save` writes: docs/formats/surface_map.md.

Notes
-----
Immutable: threads may share it.)")
      .def_property_readonly("summary", &summary_of)
      .def_property_readonly("outliers", &outliers_of)
      .def_property_readonly("n_probes", [](const StoredZones& self) { return self.points.size(); })
      .def_property_readonly("text", [](const StoredZones& self) { return map_file_text(self); })
      .def("query", &query, py::arg("places_mm"), R"(Heights at nominal places.

Parameters
----------
places_mm : array_like, shape (n, 2)
    From work zero.

Returns
-------
dict
    height_mm, sigma_um (one standard deviation) and outside_mm (of the probes'
    hull), ndarrays of shape (n,), NaN where the map refuses a height; source, a
    list of measured, filled, extrapolated, void or refused.)")
      .def(
          "save",
          [](const StoredZones& self, const Path& file) {
            check_no_source(self, file);
            value_of(write_file(file, map_file_text(self)));
          },
          py::arg("file"),
          py::call_guard<py::gil_scoped_release>(),
          "Writes the map whole or not at all, and not over the probes that it was made of; "
          "`panelcal run --surface` reads it.")
      .def("__repr__", [](const StoredZones& self) {
        return "<panelcal.Surface of " + std::to_string(self.points.size()) +
               " probes: " + summary_of(self) + ">";
      });
  module.def(
      "fit_surface_file",
      [](const Path& file,
         std::optional<double> sigma_um,
         std::optional<int> z_axis,
         const std::string& model,
         double reach_mm) { return fit(read_probes_of(file, sigma_um, z_axis), model, reach_mm); },
      py::arg("file"),
      py::arg("sigma_um"),
      py::arg("z_axis"),
      py::arg("model"),
      py::arg("max_extrapolation_mm"),
      py::call_guard<py::gil_scoped_release>());
  module.def(
      "fit_surface",
      [](const Doubles& places_mm,
         const Doubles& heights_mm,
         const std::optional<Doubles>& sigma_um,
         const std::string& model,
         double reach_mm) {
        Probes probes = probes_of(places_mm, heights_mm, sigma_um ? &*sigma_um : nullptr);
        const py::gil_scoped_release release;
        return fit(std::move(probes), model, reach_mm);
      },
      py::arg("places_mm"),
      py::arg("heights_mm"),
      py::arg("sigma_um"),
      py::arg("model"),
      py::arg("max_extrapolation_mm"));
  module.def(
      "read_surface",
      [](const Path& file) {
        return std::make_shared<StoredZones>(value_of(read_zoned_map_file(file)));
      },
      py::arg("file"),
      py::call_guard<py::gil_scoped_release>());
}

}  // namespace panelcal::python
