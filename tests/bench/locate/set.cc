// SPDX-License-Identifier: Apache-2.0
// Locates the discs of a set that `panelcal synth --sweep` has made, by panelcal and by OpenCV, and
// prints a table in Markdown: datasets/fiducials/README.md.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "tools/batch/manifest/csv_fields.h"
#include "vision/picture/files/image_io.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/bench/locate/methods.h"

namespace panelcal::bench {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Farther from the truth, something else was found.
constexpr double kFalse_px = 2;

/// A row of the manifest.
struct Row {
  std::map<std::string, std::string> columns;
  double number(const std::string& column) const { return std::stod(columns.at(column)); }
};

struct Tally {
  std::vector<double> errors_px;  ///< of what was found near the truth
  int n = 0;
  int n_false = 0;
  double ms = 0;

  void add(const Answer& answer, const Eigen::Vector2d& truth_px) {
    ++n;
    ms += answer.ms;
    if (!answer.is_found) return;
    const double error_px = (answer.center_px - truth_px).norm();
    if (error_px > kFalse_px) {
      ++n_false;
    } else {
      errors_px.push_back(error_px);
    }
  }
};

template <class T>
T taken(Expected<T> value) {
  if (!value) throw std::runtime_error(value.error().text());
  return *std::move(value);
}

std::vector<Row> read_rows(const fs::path& manifest) {
  const std::string text = taken(read_file(manifest));
  std::vector<std::vector<batch::CsvField>> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const auto fields = batch::split_csv(std::string_view(text).substr(at, end - at));
    if (!fields) throw std::runtime_error("the manifest is not CSV");
    lines.push_back(*fields);
    at = end + 1;
  }
  std::vector<Row> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    Row row;
    for (std::size_t k = 0; k < lines[i].size(); ++k) {
      row.columns[lines[0].at(k).text] = lines[i][k].text;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

/// Facts that OpenCV's methods may be tuned by.
Condition condition_of(const Row& row) {
  Condition condition;
  condition.name = row.columns.at("id");
  condition.contrast = 127.5;
  condition.noise = row.number("noise");
  condition.blur_px = row.number("blur_px");
  return condition;
}

/// "0.012"; "-" where nothing was found.
std::string quantile_text(std::vector<double> errors_px, double share) {
  if (errors_px.empty()) return "-";
  const auto at = static_cast<std::size_t>(share * static_cast<double>(errors_px.size() - 1));
  std::ranges::nth_element(errors_px, errors_px.begin() + static_cast<std::ptrdiff_t>(at));
  return fmt::format("{:.3f}", errors_px[at]);
}

void print_table(const std::string& title,
                 const std::vector<Method>& methods,
                 const std::vector<Tally>& tallies) {
  fmt::print("\n{}, {} pictures:\n\n", title, tallies.front().n);
  fmt::print("| method | found % | elsewhere % | median px | rms px | 95 % px | ms |\n");
  fmt::print("| --- | --- | --- | --- | --- | --- | --- |\n");
  for (std::size_t i = 0; i < methods.size(); ++i) {
    const Tally& tally = tallies[i];
    double square = 0;
    for (const double error_px : tally.errors_px) square += error_px * error_px;
    const auto n_found = static_cast<double>(tally.errors_px.size());
    fmt::print("| {} | {:.1f} | {:.1f} | {} | {} | {} | {:.1f} |\n",
               methods[i].name,
               100 * n_found / tally.n,
               100.0 * tally.n_false / tally.n,
               quantile_text(tally.errors_px, 0.5),
               n_found > 0 ? fmt::format("{:.3f}", std::sqrt(square / n_found)) : "-",
               quantile_text(tally.errors_px, 0.95),
               tally.ms / tally.n);
  }
}

void run(const fs::path& set) {
  const std::vector<Method> methods = methods_for(Shape::Disc);
  std::vector<Tally> all(methods.size());
  std::map<double, std::vector<Tally>> by_noise, by_debris;
  for (const Row& row : read_rows(set / "manifest.csv")) {
    const Json truth = Json::parse(taken(read_file(set / row.columns.at("truth"))));
    const Mark mark = make_mark(Shape::Disc, 0.5 * truth.at("size_px").get<double>());
    const Condition condition = condition_of(row);
    for (const Json& one : truth.at("pictures")) {
      const Image image =
          taken(read_image(set / row.columns.at("images") / one.at("file").get<std::string>()));
      const Eigen::Vector2d center_px(one.at("center_px")[0], one.at("center_px")[1]);
      const auto tallies_of = [&](auto& groups, const std::string& column) -> auto& {
        return groups.try_emplace(row.number(column), methods.size()).first->second;
      };
      auto& of_noise = tallies_of(by_noise, "noise");
      auto& of_debris = tallies_of(by_debris, "debris_rim_share");
      // The window is right to the pixel, for the one method that has to be told.
      const Eigen::Vector2d window_px = center_px.array().round().matrix();
      for (std::size_t i = 0; i < methods.size(); ++i) {
        const Answer answer = methods[i].find({image, mark, condition, window_px});
        all[i].add(answer, center_px);
        of_noise[i].add(answer, center_px);
        of_debris[i].add(answer, center_px);
      }
    }
  }
  print_table("All", methods, all);
  for (const auto& [noise, tallies] : by_noise) {
    print_table(fmt::format("Noise of {} grey levels", noise), methods, tallies);
  }
  for (const auto& [share, tallies] : by_debris) {
    print_table(fmt::format("Debris on {:.0f} % of the rim", 100 * share), methods, tallies);
  }
}

}  // namespace
}  // namespace panelcal::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: locate_set SET, a set of datasets/fiducials/sweep.toml\n");
    return 2;
  }
  try {
    panelcal::bench::run(argv[1]);
  } catch (const std::exception& error) {
    fmt::print(stderr, "locate_set: {}\n", error.what());
    return 1;
  }
  return 0;
}
