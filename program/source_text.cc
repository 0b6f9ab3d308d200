// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/source_text.h"

#include <utility>

#include "panelcal/calib/base/atomic_file.h"

namespace panelcal {

Expected<SourceText> read_source(const std::filesystem::path& path) {
  constexpr std::string_view kUtf8Mark = "\xEF\xBB\xBF";
  PANELCAL_TRY(std::string bytes, read_file(path));
  if (bytes.starts_with(kUtf8Mark)) bytes.erase(0, kUtf8Mark.size());
  return SourceText{path.string(), std::move(bytes)};
}

SourceLine LineCursor::next() {
  const char* const begin = bytes_.data() + offset_;
  const char* const end = bytes_.data() + bytes_.size();
  const char* stop = begin;
  while (stop != end && *stop != '\n' && *stop != '\r') ++stop;
  const SourceLine line{{begin, static_cast<std::size_t>(stop - begin)}, number_++};
  if (stop != end) stop += (*stop == '\r' && stop + 1 != end && stop[1] == '\n') ? 2 : 1;
  offset_ = static_cast<std::size_t>(stop - bytes_.data());
  return line;
}

}  // namespace panelcal
