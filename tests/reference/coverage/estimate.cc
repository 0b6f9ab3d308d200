// SPDX-License-Identifier: Apache-2.0
// Reads draws of calibration data from standard input and prints what panelcal makes of each.
//
//   draw KIND          camera, spindle-camera, table, settle, delays, focus
//   WORD NUMBER...     as the reader of the kind below names them; mm, px, s
//   end
//
// Out    a JSON object a draw: "value" and "sigma" of each estimated number, or "refused"
// See    tests/reference/coverage/coverage.py, which makes the draws and knows the truth
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/drift/settle.h"
#include "calib/drift/settle_delays.h"
#include "calib/spindle/fit.h"
#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/table/run.h"
#include "vision/locate/focus.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

/// The lines of one draw: a word, then numbers.
struct Line {
  std::string word;
  std::vector<double> numbers;
};
using Draw = std::vector<Line>;

std::vector<double> numbers_of(const Draw& draw, std::string_view word) {
  for (const Line& line : draw) {
    if (line.word == word) return line.numbers;
  }
  return {};
}

Eigen::Matrix2d covariance(const Line& line, std::size_t at) {
  Eigen::Matrix2d cov;
  cov << line.numbers.at(at), line.numbers.at(at + 1), line.numbers.at(at + 1),
      line.numbers.at(at + 2);
  return cov;
}

std::string refused(std::string_view reason) {
  std::string words(reason);
  for (char& c : words) {
    if (c == '"' || c == '\\' || static_cast<unsigned char>(c) < 0x20) c = '\'';
  }
  return fmt::format(R"({{"refused": "{}"}})", words);
}

std::string estimates(const std::vector<double>& value,
                      const std::vector<double>& sigma,
                      const std::string& more = "") {
  return fmt::format(R"({{"value": [{}], "sigma": [{}]{}}})",
                     fmt::join(value, ", "),
                     fmt::join(sigma, ", "),
                     more);
}

/// picture W H; focal F; form I (absent: auto); look axis_x axis_y u v cxx cxy cyy; at u v
std::string camera(const Draw& draw) {
  MarkSights sights;
  std::vector<Eigen::Vector2d> asked_px;
  CameraRunOptions options;
  sights.data.dots.push_back({position_mm<frame::Plate>(0, 0), false, Length()});
  for (const Line& line : draw) {
    const std::vector<double>& n = line.numbers;
    if (line.word == "picture") {
      sights.width_px = static_cast<int>(n.at(0));
      sights.height_px = static_cast<int>(n.at(1));
    } else if (line.word == "focal") {
      options.focal_px = n.at(0);
    } else if (line.word == "form") {
      options.form = kCameraForms.at(static_cast<std::size_t>(n.at(0)));
    } else if (line.word == "at") {
      asked_px.emplace_back(n.at(0), n.at(1));
    } else if (line.word == "look") {
      const std::size_t i = sights.data.views.size();
      sights.data.views.push_back({position_mm<frame::Machine>(n.at(0), n.at(1)), 0});
      sights.names.push_back(fmt::format("{}", i));
      sights.data.seen.push_back(
          {i,
           0,
           {position_px<frame::Image>(Eigen::Vector2d(n.at(2), n.at(3))), covariance(line, 4)}});
    }
  }
  const auto run = fit_camera_run(MachineConfig(), std::move(sights), options);
  if (!run) return refused(run.error().what);
  const CameraModel model = run->fit.model();
  std::vector<double> value{run->fit.parameters.scale_mm_per_px, run->fit.parameters.rotation_rad};
  std::vector<double> sigma{std::sqrt(run->fit.covariance(0, 0)),
                            std::sqrt(run->fit.covariance(1, 1))};
  for (const Eigen::Vector2d& u_px : asked_px) {
    const auto u = position_px<frame::Image>(u_px);
    const CameraModelJacobian j = model.by_parameters(u);
    const Eigen::Matrix2d cov = j * run->fit.covariance * j.transpose();
    const Position<frame::Optical> at = model(u);
    const Eigen::Vector2d& at_mm = at.in_mm();
    value.insert(value.end(), {at_mm.x(), at_mm.y()});
    sigma.insert(sigma.end(), {std::sqrt(cov(0, 0)), std::sqrt(cov(1, 1))});
  }
  return estimates(value,
                   sigma,
                   fmt::format(R"(, "form": "{}", "excess": {}, "left_out": {}, "refusal": "{}")",
                               name(run->fit.form),
                               run->excess,
                               run->n_left_out,
                               refusal(*run)));
}

/// hole x y approach_x approach_y; view x y approach_x approach_y seen_x seen_y cxx cxy cyy
std::string spindle_camera(const Draw& draw) {
  std::vector<CouponHole> holes;
  for (const Line& line : draw) {
    const std::vector<double>& n = line.numbers;
    if (line.word != "hole" && line.word != "view") continue;
    const auto place = position_mm<frame::Machine>(n.at(0), n.at(1));
    const Approach approach{static_cast<int>(n.at(2)), static_cast<int>(n.at(3))};
    if (line.word == "hole") {
      holes.push_back({place, approach, {}});
    } else {
      CouponView view{place, approach, {}};
      view.seen = {position_mm<frame::Optical>(n.at(4), n.at(5)), covariance(line, 6)};
      holes.back().views.push_back(view);
    }
  }
  const SpindleCameraFitResult result = fit_spindle_camera(holes);
  if (!result.fit) return refused(text(result.failure));
  const SpindleCameraFit& fit = *result.fit;
  const Eigen::Vector2d& d_mm = fit.offset.offset.in_mm();
  return estimates(
      {d_mm.x(), d_mm.y(), fit.backlash[0].value.in_mm(), fit.backlash[1].value.in_mm()},
      {std::sqrt(fit.offset.cov_mm2(0, 0)),
       std::sqrt(fit.offset.cov_mm2(1, 1)),
       fit.backlash[0].sigma.in_mm(),
       fit.backlash[1].sigma.in_mm()},
      fmt::format(R"(, "left_out": {}, "low": [{}, {}], "high": [{}, {}])",
                  fit.n_outliers(),
                  fit.wander.low[0].in_mm(),
                  fit.repeatability.low[0].in_mm(),
                  fit.wander.high[0].in_mm(),
                  fit.repeatability.high[0].in_mm()));
}

/// stage SIGMA; dot x y certified; look pose axis_x axis_y dot seen_x seen_y cxx cxy cyy; at x y
std::string table(const Draw& draw) {
  TableSights sights;
  std::vector<Position<frame::Machine>> asked;
  std::map<std::pair<std::size_t, std::pair<double, double>>, std::size_t> views;
  for (const Line& line : draw) {
    const std::vector<double>& n = line.numbers;
    if (line.word == "dot") {
      sights.data.dots.push_back(
          {position_mm<frame::Plate>(n.at(0), n.at(1)), n.at(2) != 0, Length()});
    } else if (line.word == "at") {
      asked.push_back(position_mm<frame::Machine>(n.at(0), n.at(1)));
    } else if (line.word == "look") {
      const auto pose = static_cast<std::size_t>(n.at(0));
      const auto [at, is_new] =
          views.try_emplace({pose, {n.at(1), n.at(2)}}, sights.data.views.size());
      if (is_new)
        sights.data.views.push_back({position_mm<frame::Machine>(n.at(1), n.at(2)), pose});
      sights.data.seen.push_back(
          {at->second,
           static_cast<std::size_t>(n.at(3)),
           {position_mm<frame::Optical>(n.at(4), n.at(5)), covariance(line, 6)}});
    }
  }
  const auto run = calibrate_table(MachineConfig(), std::move(sights));
  if (!run) return refused(run.error().what);
  std::vector<double> value;
  std::vector<double> sigma;
  for (int i = 0; i < TableGeometry::kSize; ++i) {
    value.push_back(run->fit.geometry.value[i]);
    sigma.push_back(std::sqrt(run->fit.geometry.cov(i, i)));
  }
  for (const Position<frame::Machine>& place : asked) {
    const Eigen::Vector2d error_mm = run->fit.map.error_mm(place);
    const Eigen::Matrix2d cov = run->fit.covariance_at(place);
    value.insert(value.end(), {error_mm.x(), error_mm.y()});
    sigma.insert(sigma.end(), {std::sqrt(cov(0, 0)), std::sqrt(cov(1, 1))});
  }
  std::string open;
  for (const std::string& mode : run->fit.undetermined) open += (open.empty() ? "" : "; ") + mode;
  return estimates(value,
                   sigma,
                   fmt::format(R"(, "excess": {}, "left_out": {}, "open": "{}", "refusal": "{}")",
                               run->excess,
                               run->left_out.size(),
                               open,
                               refusal(*run)));
}

std::vector<SettleView> views_of(const Draw& draw) {
  std::vector<SettleView> views;
  for (const Line& line : draw) {
    if (line.word != "view") continue;
    views.push_back({seconds(line.numbers.at(0)),
                     {position_mm<frame::Optical>(line.numbers.at(1), line.numbers.at(2)),
                      covariance(line, 3)}});
  }
  return views;
}

/// limit MM; view t x y cxx cxy cyy
std::string settle(const Draw& draw) {
  const std::vector<SettleView> views = views_of(draw);
  std::string reason;
  const auto found = fit_settle(views, mm(numbers_of(draw, "limit").at(0)), &reason);
  if (!found) return refused(reason);
  return estimates({found->wait.in_s()},
                   {found->sigma.in_s()},
                   fmt::format(R"(, "safe": {}, "hz": {}, "aliases": {}, "motion": {})",
                               found->safe_wait().in_s(),
                               found->frequency_hz,
                               found->aliases.size(),
                               static_cast<int>(found->motion)));
}

/// rounds N LONGEST I; limit MM; view as for settle: the delays of round I after these views
std::string delays(const Draw& draw) {
  const std::vector<double> rounds = numbers_of(draw, "rounds");
  const auto n = static_cast<int>(rounds.at(0));
  const auto i_round = static_cast<int>(rounds.at(2));
  const std::vector<SettleView> seen = views_of(draw);
  std::vector<double> value;
  const Time longest = seconds(rounds.at(1));
  const auto found =
      i_round == 0
          ? first_settle_delays(n, longest)
          : next_settle_delays(seen, n, i_round, longest, mm(numbers_of(draw, "limit").at(0)));
  for (const Time& delay : found) value.push_back(delay.in_s());
  return estimates(value, {});
}

/// sample z sharpness
std::string focus(const Draw& draw) {
  std::vector<FocusSample> samples;
  for (const Line& line : draw) {
    if (line.word == "sample") samples.push_back({mm(line.numbers.at(0)), line.numbers.at(1)});
  }
  std::string reason;
  const auto peak = fit_focus_peak(samples, &reason);
  if (!peak) return refused(reason);
  return estimates({peak->z.in_mm()}, {peak->sigma.in_mm()});
}

std::string answer(const std::string& kind, const Draw& draw) {
  if (kind == "camera") return camera(draw);
  if (kind == "spindle-camera") return spindle_camera(draw);
  if (kind == "table") return table(draw);
  if (kind == "settle") return settle(draw);
  if (kind == "delays") return delays(draw);
  if (kind == "focus") return focus(draw);
  return refused("kind: \"" + kind + "\"");
}

}  // namespace
}  // namespace panelcal

int main() {
  std::string text;
  std::string kind;
  panelcal::Draw draw;
  while (std::getline(std::cin, text)) {
    std::istringstream words(text);
    panelcal::Line line;
    words >> line.word;
    if (line.word == "draw") {
      words >> kind;
      draw.clear();
    } else if (line.word == "end") {
      fmt::print("{}\n", panelcal::answer(kind, draw));
      std::fflush(stdout);
    } else {
      for (std::string number; words >> number;)
        line.numbers.push_back(std::strtod(number.c_str(), nullptr));
      draw.push_back(std::move(line));
    }
  }
  return 0;
}
