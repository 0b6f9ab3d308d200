// SPDX-License-Identifier: Apache-2.0
// What the own reader of lines and the own writer of operations save, each beside the general way
// in turns. See README.md.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "program/model/measurement.h"
#include "program/writers/jsonl_writer.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::bench {
namespace {

using namespace internal;

constexpr int kLines = 20000;
constexpr int kTurns = 15;

/// The drilled hole of jsonl_writer.cc as rows.
struct BenchHole {
  int line = 0;
  int tool = 1;
  Position<frame::Nominal> nominal;
  Position<frame::Machine> actual;
  Eigen::Vector2d sigma_mm = Eigen::Vector2d::Zero();
  std::vector<int> path;
};

constexpr std::array kBenchHoleFields = {
    constant<BenchHole>("op", "\"drill\"", ""),
    count<&BenchHole::line>("line", {0, 1 << 30}, ""),
    count<&BenchHole::tool>("tool", {0, 1 << 30}, ""),
    plain<&BenchHole::nominal>("nominal", {}, ""),
    plain<&BenchHole::actual>("actual", {}, ""),
    plain<&BenchHole::sigma_mm>("sigma", {}, ""),
    count<&BenchHole::path>("path", {0, 1 << 30}, "").or_absent(),
};
constexpr JsonTable<BenchHole> kBenchHole{"hole", kBenchHoleFields};

class CountingBytes final : public ByteSink {
 public:
  Expected<void> write(std::string_view bytes) override {
    n_bytes += bytes.size();
    return {};
  }
  std::size_t n_bytes = 0;
};

double seconds_of(const std::function<std::size_t()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  if (work() == 0) std::puts("nothing done");
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Medians of both, and of how many times as long the general way takes, turn by turn.
void compare(const char* name,
             const std::function<std::size_t()>& own,
             const std::function<std::size_t()>& general) {
  std::vector<double> own_s, general_s, ratios;
  for (int turn = 0; turn < kTurns; ++turn) {
    own_s.push_back(seconds_of(own));
    general_s.push_back(seconds_of(general));
    ratios.push_back(general_s.back() / own_s.back());
  }
  const auto median = [](std::vector<double>& all) {
    std::ranges::nth_element(all, all.begin() + kTurns / 2);
    return all[kTurns / 2];
  };
  const double ns = 1e9 / kLines;
  const double own_ns = ns * median(own_s);
  const double general_ns = ns * median(general_s);
  fmt::print("{:<28} own {:6.0f} ns, general {:6.0f} ns a line: {:.2f} times\n",
             name,
             own_ns,
             general_ns,
             median(ratios));
}

void compare_readers() {
  Measurement measurement = {.request = {.line = 12, .command = "G36"},
                             .status = MeasurementStatus::Found};
  measurement.request.settings.tools = {3};
  measurement.request.nominal = position_mm<frame::Nominal>(100.125, 37.3333333333);
  measurement.request.expected = position_mm<frame::Actual>(100.21, 37.41);
  measurement.measured = {position_mm<frame::Actual>(100.2173, 37.4182),
                          1.234567e-6 * Eigen::Matrix2d::Identity()};
  measurement.score = 0.9871;
  measurement.image = "0017.png";
  const std::string text = to_json(measurement);
  compare(
      "read a measurement",
      [&] {
        std::size_t n = 0;
        for (int i = 0; i < kLines; ++i) n += JsonLine::parse(text, {"f", i, 1}) ? 1 : 0;
        return n;
      },
      [&] {
        std::size_t n = 0;
        for (int i = 0; i < kLines; ++i) n += nlohmann::json::parse(text).size();
        return n;
      });
}

void compare_writers() {
  Operation operation;
  operation.line = 12;
  constexpr std::array<int, 2> kPath = {3, 4};
  operation.path = kPath;
  Drill drill;
  drill.tool = 2;
  drill.nominal = position_mm<frame::Nominal>(100.125, 37.3333333333);
  drill.actual = position_mm<frame::Machine>(100.21, 37.41);
  drill.cov_mm2 = 1.234567e-6 * Eigen::Matrix2d::Identity();
  operation.what = drill;
  compare(
      "write a hole",
      [&] {
        CountingBytes bytes;
        JsonlWriter writer(bytes);
        for (int i = 0; i < kLines; ++i) writer.put(operation);
        static_cast<void>(writer.finish());
        return bytes.n_bytes;
      },
      [&] {
        std::string out;
        for (int i = 0; i < kLines; ++i) {
          const BenchHole hole = {
              12, 2, drill.nominal, drill.actual, drill.cov_mm2.diagonal().cwiseSqrt(), {3, 4}};
          out += json_text(kBenchHole, hole, JsonStyle::Line) + "\n";
        }
        return out.size();
      });
}

}  // namespace
}  // namespace panelcal::bench

int main() {
  panelcal::bench::compare_readers();
  panelcal::bench::compare_writers();
}
