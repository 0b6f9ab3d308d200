// SPDX-License-Identifier: Apache-2.0
// Errors of the locator against the physical bound, beside OpenCV's methods in one run. See
// README.md.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "tests/bench/locate/accuracy.h"
#include "tests/bench/locate/check.h"
#include "tests/bench/locate/false.h"
#include "tests/bench/locate/phase.h"
#include "tests/bench/locate/rims.h"
#include "tests/bench/locate/speed.h"

namespace panelcal::bench {
namespace {

struct Options {
  std::string only;  ///< a condition, or "rims", "phase", "false", "speed", "check"; empty: all
  int n = 400;
  int n_false = 10'000;
  std::uint64_t seed = 20261121;
  Shape shape = Shape::Disc;
  double radius_px = 40;
  std::string dump;
  bool with_peers = true;
};

constexpr std::string_view kUsage =
    "usage: locate_bench [--only clean|typical|hard|rims|phase|false|speed|check] [--n PICTURES]\n"
    "                    [--false PICTURES] [--seed N] [--shape disc|ring|hole|cross|square]\n"
    "                    [--radius PX] [--dump DIR] [--no-peers]\n";

template <class T>
bool read_number(std::string_view text, T& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

bool set_option(std::string_view key, const std::string& value, Options& o) {
  if (key == "--only") {
    o.only = value;
    return true;
  }
  if (key == "--dump") {
    o.dump = value;
    return true;
  }
  if (key == "--n") return read_number(value, o.n) && o.n > 0;
  if (key == "--false") return read_number(value, o.n_false) && o.n_false >= 0;
  if (key == "--seed") return read_number(value, o.seed);
  if (key == "--radius") return read_number(value, o.radius_px) && o.radius_px >= 3;
  if (key != "--shape") return false;
  const auto shape = shape_from_name(value);
  if (shape) o.shape = *shape;
  return shape.has_value();
}

std::optional<Options> options_from(const std::vector<std::string>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--no-peers") {
      options.with_peers = false;
      continue;
    }
    if (i + 1 == arguments.size()) return std::nullopt;
    if (!set_option(arguments[i], arguments[i + 1], options)) return std::nullopt;
    ++i;
  }
  return options;
}

void run(const Options& o) {
  const auto wanted = [&](std::string_view part) { return o.only.empty() || o.only == part; };
  const Mark mark = make_mark(o.shape, o.radius_px);
  fmt::print("{}, r = {} px, seed {}\n", name(o.shape), o.radius_px, o.seed);
  if (wanted("check") && !check_bounds(o.seed)) {
    throw std::runtime_error("the bounds are wrong");
  }
  for (const Condition& condition : conditions()) {
    if (wanted(condition.name)) {
      print_accuracy(condition, mark, {o.n, o.seed, o.with_peers, o.dump});
    }
  }
  if (wanted("rims")) print_rims(o.n, o.seed, o.dump);
  if (wanted("phase")) print_phase_bias(o.shape, o.seed);
  if (wanted("speed")) print_speed(mark, o.seed);
  if (wanted("false") && o.n_false > 0) {
    print_false_rate(mark, {o.n_false, o.seed, o.with_peers, o.dump});
  }
}

}  // namespace
}  // namespace panelcal::bench

int main(int argc, char** argv) {
  const auto options = panelcal::bench::options_from({argv + 1, argv + argc});
  if (!options) {
    fmt::print(stderr, "{}", panelcal::bench::kUsage);
    return 2;
  }
  cv::setNumThreads(1);
  std::setvbuf(stdout, nullptr, _IOLBF, BUFSIZ);  // every row shows as soon as it is measured
  try {
    panelcal::bench::run(*options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "locate_bench: {}\n", error.what());
    return 1;
  }
}
