// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace panelcal {

/// Numbers for Prometheus, as the textfile collector of its node exporter reads them from *.prom.
///
/// Source Prometheus, Exposition formats, text format 0.0.4
/// See    tests/tools/metrics_test.py; docs/howto/metrics.md
class Metrics {
 public:
  using Labels = std::vector<std::pair<std::string_view, std::string>>;

  /// A number of a metric; numbers of the same metric follow one another.
  void gauge(std::string_view name, std::string_view help, const Labels& labels, double value);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::string name_;
};

}  // namespace panelcal
