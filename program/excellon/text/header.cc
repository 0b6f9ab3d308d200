// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header.h"

#include "program/walk/program.h"
#include <fmt/format.h>

namespace panelcal::excellon {

std::string Header::reading() const {
  const std::string evidence = format_evidence();
  return fmt::format("Excellon{}, {} ({})",
                     set == ProgramSet::FormatOne ? " Format One" : "",
                     number_summary(),
                     evidence.empty() ? "not stated" : evidence);
}

const Header& header_of(const Program& program) {
  return static_cast<const Header&>(*program.head);
}

std::string_view text_of(const Program& program) {
  const std::string& respelled = header_of(program).respelled;
  return respelled.empty() ? program.source.bytes : std::string_view(respelled);
}

}  // namespace panelcal::excellon
