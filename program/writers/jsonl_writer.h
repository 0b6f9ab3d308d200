// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "panelcal/program/writers/text_writer.h"

namespace panelcal {

/// Operations as JSON Lines (docs/formats/operations.md): mm, mm/s, rpm, s.
class JsonlWriter final : public TextWriter {
 public:
  using TextWriter::TextWriter;
  void put(const Operation& operation) override;
};

}  // namespace panelcal
