// SPDX-License-Identifier: Apache-2.0
#include "tools/history/surface.h"

#include <utility>

#include "surface/map/difference.h"
#include "surface/map/file.h"
#include "tools/surface/difference.h"
#include <fmt/format.h>

namespace panelcal::history {

Expected<AnswerPart> surface_answer(const CalibrationEntry& before,
                                    const CalibrationEntry& after,
                                    const std::string& file) {
  const std::string earlier = fmt::format("entry {}", before.entry.id);
  const std::string later = fmt::format("entry {}", after.entry.id);
  PANELCAL_TRY(StoredMap was, parse_map_file(before.result, file + " " + earlier));
  PANELCAL_TRY(StoredMap is, parse_map_file(after.result, file + " " + later));
  auto difference = difference_of(was, is);
  if (!difference) {
    Diagnostic problem = std::move(difference).error();
    problem.place.file = file + " " + later;
    return failure(std::move(problem));
  }
  const surface::ComparedMaps maps = {
      earlier, later, std::move(was), std::move(is), *std::move(difference)};
  return AnswerPart{surface::difference_text(maps), surface::difference_facts(maps, {})};
}

}  // namespace panelcal::history
