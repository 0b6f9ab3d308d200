// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/measuring/surface_commands.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "program/sieb_meyer/measuring/grid_gaps.h"
#include "surface/map/height_map.h"
#include "surface/map/height_tolerance.h"
#include <fmt/format.h>

namespace panelcal::sieb_meyer {
namespace {

/// The tolerance that no command of the program names.
constexpr const char* kConfigured = "surface tolerance";

/// Letters of SPAV, in the order of AverageKind.
constexpr std::array<std::string_view, 4> kAverageLetters = {"A", "M", "O", "T"};

std::vector<Length> heights_of(const std::vector<HeightEstimate>& estimates) {
  std::vector<Length> heights;
  for (const HeightEstimate& estimate : estimates) heights.push_back(estimate.height);
  return heights;
}

std::string place_text(const Eigen::Vector2d& nominal_mm) {
  return fmt::format("({:.4f}, {:.4f}) mm", nominal_mm.x(), nominal_mm.y());
}

}  // namespace

SurfaceSession::SurfaceSession(const Settings& settings,
                               Survey& survey,
                               ProbeSource* source,
                               const Reporter& reporter,
                               DiagnosticLog& log)
    : settings_(settings),
      survey_(survey),
      source_(source),
      reporter_(reporter),
      log_(log),
      average_(settings.average) {
  if (settings.surface_tolerance) tolerances_[kConfigured] = *settings.surface_tolerance;
}

void SurfaceSession::stop(Code code, int line, std::string what, std::string expected) {
  reporter_.report(code, line, std::move(what), std::move(expected));
  must_stop_ = true;
}

bool SurfaceSession::set_reference_height(Length height) {
  if (configured_reference_ && *configured_reference_ != height) return false;
  configured_reference_ = height;
  return true;
}

/// The configured tolerance holds until the program states another.
void SurfaceSession::set_tolerance(const std::string& name, Length tolerance) {
  tolerances_.erase(kConfigured);
  tolerances_[name] = tolerance;
}

/// "Clear all values in the surface memory", and the grid's are among them.
void SurfaceSession::clear_memory() {
  memory_.clear();
  clear_grid();
}

// --- probing -----------------------------------------------------------------------------------

std::optional<std::vector<HeightEstimate>> SurfaceSession::probe(ProbeRequest request,
                                                                 Missing missing) {
  const std::size_t index = n_probed_++;
  if (source_ != nullptr) {
    request.seq = static_cast<std::int64_t>(index);
    request.reference = configured_reference_.value_or(settings_.surface_height);
    Expected<ProbeReading> reading = source_->probe(request);
    if (!reading) {
      log_.add(std::move(reading).error());
      must_stop_ = true;
      return std::nullopt;
    }
    survey_.probes.push_back(*std::move(reading));
  }
  const ProbeReading& reading = survey_.probes[index];
  if (reading.status == ProbeStatus::Found && !reading.heights.empty()) return reading.heights;
  if (missing == Missing::LeavesGap && settings_.fills_gaps) return std::nullopt;
  stop(Code::SurfaceNotFound,
       request.line,
       fmt::format("{} at nominal ({:.4f}, {:.4f}) mm{}{}",
                   request.command,
                   request.nominal.in_mm().x(),
                   request.nominal.in_mm().y(),
                   reading.reason.empty() ? "" : ": ",
                   reading.reason),
       "");
  return std::nullopt;
}

void SurfaceSession::detect(ProbeRequest request) {
  const int line = request.line;
  const std::optional<int> memory = request.memory;
  auto heights = probe(std::move(request));
  if (!heights) return;
  last_ = *std::move(heights);
  last_is_of_grid_ = false;
  store(line, memory, last_);
}

void SurfaceSession::store_last(int line, std::optional<int> memory) {
  if (last_.empty()) {
    return stop(
        Code::SurfaceMissing, line, "G73 has no measured value to save", "X#Y#G73 before it");
  }
  store(line, memory, last_);
}

void SurfaceSession::store(int line,
                           std::optional<int> memory,
                           const std::vector<HeightEstimate>& heights) {
  current_ = heights;
  if (!memory && memory_.n_to_average() >= SurfaceMemory::kAveragingCapacity) {
    return stop(
        Code::AveragingFull,
        line,
        fmt::format("G73 adds a value to {} that wait for their average", memory_.n_to_average()),
        "G74 before it");
  }
  const auto done = memory ? memory_.store(*memory, heights) : memory_.add(heights);
  if (!done) stop(Code::ArgumentInvalid, line, done.error(), "");
}

bool SurfaceSession::set_average(std::string_view letter) {
  const auto known = std::ranges::find(kAverageLetters, letter);
  if (known == kAverageLetters.end()) return false;
  average_ = static_cast<AverageKind>(known - kAverageLetters.begin());
  return true;
}

std::string_view SurfaceSession::average_letter() const {
  return kAverageLetters.at(static_cast<std::size_t>(average_));
}

void SurfaceSession::average(int line, int memory) {
  auto average = memory_.take_average(average_);
  if (!average) {
    return stop(Code::SurfaceMissing, line, "G74: " + average.error(), "");
  }
  const auto done = memory_.store(memory, *average);
  if (!done) stop(Code::ArgumentInvalid, line, done.error(), "");
}

void SurfaceSession::take_reference(int line, int memory) {
  auto heights = memory_.load(memory);
  if (!heights) {
    return stop(Code::SurfaceMissing,
                line,
                fmt::format("L{} takes a value that was never stored", memory),
                fmt::format("G73L{0} or G74L{0} before it", memory));
  }
  current_ = *std::move(heights);
}

void SurfaceSession::record(ProbeRequest request) {
  probe(std::move(request));
}

std::vector<Length> SurfaceSession::reference() const {
  return heights_of(current_);
}

// --- the grid ----------------------------------------------------------------------------------

/// A new reference begins a new grid; its own value is no node.
void SurfaceSession::grid_reference(ProbeRequest request) {
  clear_grid();
  const int line = request.line;
  grid_reference_place_ = request.nominal;
  auto heights = probe(std::move(request));
  if (!heights) return;
  grid_reference_ = last_ = *std::move(heights);
  last_is_of_grid_ = true;
  holds_tolerances(line, grid_reference_place_.in_mm(), grid_reference_);
}

void SurfaceSession::clear_grid() {
  points_.clear();
  point_lines_.clear();
  filled_.clear();
  grid_.reset();
  grid_reference_.clear();
}

/// Stops the walk where a height is too far from the reference.
bool SurfaceSession::holds_tolerances(int line,
                                      const Eigen::Vector2d& nominal_mm,
                                      const std::vector<HeightEstimate>& heights) {
  const std::vector<Length> references = grid_references();
  for (const auto& [name, tolerance] : tolerances_) {
    const std::vector<Length> tolerances = {tolerance};
    const auto held = check_height(name, heights, references, tolerances);
    if (held) continue;
    stop(Code::SurfaceOutOfTolerance,
         line,
         fmt::format(
             "at nominal ({:.4f}, {:.4f}) mm: {}", nominal_mm.x(), nominal_mm.y(), held.error()),
         "");
    return false;
  }
  return true;
}

std::vector<Length> SurfaceSession::grid_references() const {
  if (configured_reference_) return {*configured_reference_};
  return heights_of(grid_reference_);
}

std::optional<PlaneReference> SurfaceSession::measured_reference() const {
  if (configured_reference_ || grid_reference_.empty()) return std::nullopt;
  const std::vector<Length> heights = heights_of(grid_reference_);
  return PlaneReference{
      grid_reference_place_, heights.front(), {heights.begin() + 1, heights.end()}};
}

void SurfaceSession::grid_point(ProbeRequest request) {
  const int line = request.line;
  const Eigen::Vector2d nominal_mm = request.nominal.in_mm();
  auto heights = probe(std::move(request), Missing::LeavesGap);
  if (!heights) return;
  if (grid_reference_.empty() && !configured_reference_) {
    grid_reference_ = *heights;
    grid_reference_place_ = position_mm<frame::Nominal>(nominal_mm);
  }
  last_ = *heights;
  last_is_of_grid_ = true;
  if (!holds_tolerances(line, nominal_mm, *heights)) return;
  forget_filled();
  points_.push_back({nominal_mm, *std::move(heights)});
  point_lines_.push_back(line);
}

/// A further point may make another grid, so what was filled is to be predicted anew.
void SurfaceSession::forget_filled() {
  grid_.reset();
  if (source_ != nullptr) {
    survey_.filled_nodes.resize(survey_.filled_nodes.size() - filled_.size());
  }
  points_.resize(points_.size() - filled_.size());
  point_lines_.resize(points_.size());
  filled_.clear();
}

const GridMap* SurfaceSession::grid(int line) {
  if (points_.empty() || must_stop_) return nullptr;
  if (!grid_) {
    if (settings_.fills_gaps && !fill_gaps(line)) return nullptr;
    auto map = GridMap::from_points(points_);
    if (!map) {
      const int at = map.error().i_point ? point_lines_[*map.error().i_point] : line;
      stop(Code::GridInvalid, at, map.error().text, "");
      return nullptr;
    }
    grid_ = *std::move(map);
  }
  return &*grid_;
}

/// Nodes that are not probed get the height that the others predict, each with a warning.
bool SurfaceSession::fill_gaps(int line) {
  filled_.clear();
  const std::vector<Eigen::Vector2d> missing_mm = missing_nodes(points_);
  if (missing_mm.empty()) return true;
  auto filled = fill_nodes(points_, missing_mm, settings_.grid_hold);
  if (!filled) {
    stop(filled.error().code,
         line,
         fmt::format("the gaps of the grid cannot be filled, the first at {}: {}",
                     place_text(missing_mm.front()),
                     filled.error().what),
         filled.error().expected);
    return false;
  }
  for (FilledNode& node : *filled) {
    node.line = line;
    reporter_.report(Code::GridFilled,
                     line,
                     fmt::format("the grid has no point at {}", place_text(node.place.in_mm())),
                     "all nodes ([surface] fill_gaps lets some be missing)");
    points_.push_back({node.place.in_mm(), node.heights});
    point_lines_.push_back(line);
    if (source_ != nullptr) survey_.filled_nodes.push_back(node);
  }
  filled_ = *std::move(filled);
  return true;
}

/// Set where a node that was filled has a part in the height: within a cell of it.
std::optional<PredictedHeight> SurfaceSession::predicted_at(
    const GridHeight& found, const Eigen::Vector2d& nominal_mm) const {
  std::optional<PredictedHeight> predicted;
  for (const FilledNode& node : filled_) {
    const Eigen::Vector2d node_mm = node.place.in_mm();
    const auto is_beside = [](std::span<const double> axis_mm, double at_mm, double node_at_mm) {
      const double inside_mm = std::clamp(at_mm, axis_mm.front(), axis_mm.back());
      const auto above = std::ranges::upper_bound(axis_mm, std::min(inside_mm, node_at_mm));
      const auto below = std::ranges::lower_bound(axis_mm, std::max(inside_mm, node_at_mm));
      // Nothing of the axis lies strictly between the place and the node.
      return above >= below;
    };
    if (!is_beside(grid_->columns_mm(), nominal_mm.x(), node_mm.x()) ||
        !is_beside(grid_->rows_mm(), nominal_mm.y(), node_mm.y())) {
      continue;
    }
    const bool is_worse = predicted && predicted->source == HeightSource::Extrapolated;
    predicted =
        PredictedHeight{found.heights.front().sigma, is_worse ? predicted->source : node.source};
  }
  return predicted;
}

std::optional<SurfaceSession::GridSurface> SurfaceSession::grid_surface_at(
    int line, const Eigen::Vector2d& nominal_mm) {
  const GridMap* const map = grid(line);
  const std::vector<Length> references = grid_references();
  if (map == nullptr || references.empty()) return std::nullopt;
  const GridHeight found = map->height_at(nominal_mm);
  const bool is_far = found.outside > settings_.grid_hold;
  if (!found.is_inside()) {
    const std::string what = fmt::format(
        "{} is {:.3f} mm outside the grid", place_text(nominal_mm), found.outside.in_mm());
    if (is_far) {
      stop(Code::GridInvalid,
           line,
           what,
           fmt::format("at most {:.3f} mm ([surface] grid_hold_mm)", settings_.grid_hold.in_mm()));
      return std::nullopt;
    }
    reporter_.report(Code::GridOutside, line, what);
  }
  GridSurface surface;
  surface.heights = heights_of(found.heights);
  surface.deviation = surface.heights.front() - references.front();
  surface.predicted = predicted_at(found, nominal_mm);
  return surface;
}

}  // namespace panelcal::sieb_meyer
