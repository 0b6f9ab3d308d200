// SPDX-License-Identifier: Apache-2.0
#include "surface/files/formats/marlin_console.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "surface/files/probe_readers.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Marlin prints places to 0.001 mm, old versions to 0.1 and 0.01 mm.
constexpr double kMarlinRounding_mm = 0.051;

/// Where the nodes of a mesh stand, and how that is known.
struct MarlinPlaces {
  LatticeAxis x, y;
  std::string source;
};

LatticeAxis axis_between(double first_mm, double last_mm, int n_nodes) {
  return {first_mm, (last_mm - first_mm) / (n_nodes - 1), n_nodes};
}

/// Sorted, each once.
std::vector<double> places_along(const std::vector<MarlinTouch>& touches, int axis) {
  std::vector<double> out;
  for (const MarlinTouch& touch : touches) out.push_back(touch.place_mm[axis]);
  std::ranges::sort(out);
  const auto rest = std::ranges::unique(
      out, [](double a, double b) { return std::abs(a - b) <= kMarlinRounding_mm; });
  out.erase(rest.begin(), rest.end());
  return out;
}

/// Empty if they are not n evenly spaced places.
std::optional<LatticeAxis> even_axis(const std::vector<double>& places_mm, int n_nodes) {
  if (places_mm.size() != static_cast<std::size_t>(n_nodes)) return std::nullopt;
  const LatticeAxis out = axis_between(places_mm.front(), places_mm.back(), n_nodes);
  for (int i = 0; i < n_nodes; ++i) {
    if (std::abs(out.at_mm(i) - places_mm[static_cast<std::size_t>(i)]) > kMarlinRounding_mm) {
      return std::nullopt;
    }
  }
  return out;
}

bool are_same_heights(const MarlinTable& a, const MarlinTable& b) {
  const auto is_same = [](const ReadNode& p, const ReadNode& q) { return p.height == q.height; };
  return std::ranges::equal(a.rows, b.rows, [&](const auto& p, const auto& q) {
    return std::ranges::equal(p, q, is_same);
  });
}

class MarlinPlacer {
 public:
  MarlinPlacer(const std::string& file,
               const MarlinTable& table,
               const MarlinRecords& records,
               const std::optional<MeshCorners>& flags)
      : file_(file), table_(table), records_(records), flags_(flags) {}

  Expected<MarlinPlaces> places() {
    if (!records_.x_mm.empty() || !records_.y_mm.empty()) {
      PANELCAL_CHECK(
          add(records_.x_mm, records_.y_mm, "X-Axis and Y-Axis Mesh Points", kMarlinRounding_mm));
    } else if (!records_.touches.empty() && !table_.low_mm) {
      PANELCAL_CHECK(add(places_along(records_.touches, 0),
                         places_along(records_.touches, 1),
                         "the lines \"Bed X: Y: Z:\"",
                         kMarlinRounding_mm));
    }
    if (flags_) {
      PANELCAL_CHECK(add_ends({flags_->low_mm.x(), flags_->high_mm.x(), columns()},
                              {flags_->low_mm.y(), flags_->high_mm.y(), rows()},
                              "--mesh-mm",
                              kMarlinRounding_mm));
    }
    // Cut off to whole mm: the last resort, and a check of the others.
    if (table_.low_mm) {
      PANELCAL_CHECK(add_ends({table_.low_mm->x(), table_.high_mm->x(), columns()},
                              {table_.low_mm->y(), table_.high_mm->y(), rows()},
                              "the report's corners, whole mm",
                              1));
    }
    if (found_) return *found_;
    return failure(unexpected_field(
        file_, table_.title, "places too: the lines of G29 V4 or G29 W, or --mesh-mm X0,Y0,X1,Y1"));
  }

 private:
  struct Ends {
    double first_mm, last_mm;
    int n_nodes;
  };
  int columns() const { return table_.n_columns; }
  int rows() const { return static_cast<int>(table_.rows.size()); }

  Expected<void> add(const std::vector<double>& x_mm,
                     const std::vector<double>& y_mm,
                     const std::string& source,
                     double tolerance_mm) {
    const auto x = even_axis(x_mm, columns());
    const auto y = even_axis(y_mm, rows());
    if (x && y) return add_axes({*x, *y, source}, tolerance_mm);
    return failure(unexpected_field(
        file_,
        table_.title,
        fmt::format("as many columns and rows, evenly spaced, as {} have: {} and {}",
                    source,
                    x_mm.size(),
                    y_mm.size())));
  }
  Expected<void> add_ends(const Ends& x,
                          const Ends& y,
                          const std::string& source,
                          double tolerance_mm) {
    return add_axes({axis_between(x.first_mm, x.last_mm, x.n_nodes),
                     axis_between(y.first_mm, y.last_mm, y.n_nodes),
                     source},
                    tolerance_mm);
  }

  Expected<void> add_axes(MarlinPlaces places, double tolerance_mm) {
    if (!found_) {
      found_ = std::move(places);
      return {};
    }
    for (const auto& [a, b] :
         {std::pair(&found_->x, &places.x), std::pair(&found_->y, &places.y)}) {
      if (std::abs(a->first_mm - b->first_mm) < tolerance_mm &&
          std::abs(a->last_mm() - b->last_mm()) < tolerance_mm) {
        continue;
      }
      return failure(
          {Code::MeasurementFile,
           {file_, table_.title.line, table_.title.column},
           fmt::format(
               "nodes from {:g} to {:g} mm by {}", b->first_mm, b->last_mm(), places.source),
           fmt::format(
               "from {:g} to {:g} mm, as {} say", a->first_mm, a->last_mm(), found_->source)});
    }
    return {};
  }

  const std::string& file_;
  const MarlinTable& table_;
  const MarlinRecords& records_;
  const std::optional<MeshCorners>& flags_;
  std::optional<MarlinPlaces> found_;
};

/// Nodes that no line of G29 V4 names: Marlin made their heights up of the others'.
void leave_out_untouched(const MarlinRecords& records, ReadGrid& grid) {
  std::vector<bool> is_touched(grid.nodes.size(), false);
  for (const MarlinTouch& touch : records.touches) {
    const double i = std::round((touch.place_mm.x() - grid.x.first_mm) / grid.x.step_mm);
    const double j = std::round((touch.place_mm.y() - grid.y.first_mm) / grid.y.step_mm);
    if (i < 0 || j < 0 || i >= grid.x.n_nodes || j >= grid.y.n_nodes) continue;
    is_touched[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid.x.n_nodes) +
               static_cast<std::size_t>(i)] = true;
  }
  for (std::size_t k = 0; k < grid.nodes.size(); ++k) {
    if (is_touched[k] || !grid.nodes[k].height) continue;
    grid.nodes[k].height.reset();
    grid.nodes[k].reason = "no touch of it in the console: Marlin extrapolates such heights";
  }
}

ProbeFile file_of_touches(const std::string& file,
                          const MarlinRecords& records,
                          const ProbeFileOptions& options) {
  ProbeFile out;
  out.format = ProbeFormat::MarlinConsole;
  out.file = file;
  for (const MarlinTouch& touch : records.touches) {
    out.points.push_back({position_mm<frame::Nominal>(touch.place_mm),
                          {mm(touch.height_mm), options.scatter()},
                          fmt::format("probe of line {}", touch.from.line),
                          {file, touch.from.line, touch.from.column}});
  }
  return out;
}

}  // namespace

Expected<ProbeFile> parse_marlin_console(std::string_view text,
                                         const std::string& file,
                                         const ProbeFileOptions& options) {
  PANELCAL_CHECK(check_line_end(text, file));
  PANELCAL_TRY(const MarlinRecords records, read_marlin_records(text, file));
  if (records.tables.empty()) {
    if (!options.mesh) return file_of_touches(file, records, options);
    return failure({Code::MeasurementFile, {file, 0, 0}, "no mesh", "one, for --mesh-mm"});
  }
  const MarlinTable& table = records.tables.front();
  for (const MarlinTable& other : records.tables) {
    if (are_same_heights(other, table)) continue;
    return failure({Code::MeasurementFile,
                    {file, other.title.line, other.title.column},
                    "another mesh",
                    fmt::format("one mesh a file; line {} has the first", table.title.line)});
  }
  const LatticeAxis counted_x{0, 1, table.n_columns};
  const LatticeAxis counted_y{0, 1, static_cast<int>(table.rows.size())};
  PANELCAL_CHECK(check_grid(file, table.title, counted_x, counted_y));
  PANELCAL_TRY(MarlinPlaces places, MarlinPlacer(file, table, records, options.mesh).places());
  ReadGrid grid{places.x, places.y, {}};
  PANELCAL_CHECK(check_grid(file, table.title, grid.x, grid.y));
  for (const auto& row : table.rows) grid.nodes.insert(grid.nodes.end(), row.begin(), row.end());
  if (!records.touches.empty() && !table.low_mm) leave_out_untouched(records, grid);
  ProbeFile out = file_of_grid(ProbeFormat::MarlinConsole, file, grid, options);
  out.zero = fmt::format("the printer's zero, heights from its nozzle at Z 0; places by {}",
                         places.source);
  return out;
}

}  // namespace panelcal::internal
