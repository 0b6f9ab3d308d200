// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "program/walk/probing.h"

namespace panelcal::test {

/// Heights in the order of probing, mm.
class Heights final : public ProbeSource {
 public:
  explicit Heights(std::vector<double> heights_mm) : heights_mm_(std::move(heights_mm)) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    const double height_mm = heights_mm_.at(static_cast<std::size_t>(request.seq));
    return ProbeReading{request, ProbeStatus::Found, {{mm(height_mm), um(1)}}, ""};
  }

 private:
  std::vector<double> heights_mm_;
};

}  // namespace panelcal::test
