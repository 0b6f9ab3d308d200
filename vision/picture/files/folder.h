// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"

namespace panelcal {

/// One picture of a folder: where the optical axis stood, and what the optional columns say.
struct PictureRow {
  int line = 0;      ///< in images.csv
  std::string file;  ///< relative to the folder, never outside of it
  Position<frame::Machine> axis;
  std::optional<Length> z;
  std::optional<int> tool;
  std::optional<std::string> lamp;
  std::optional<double> zoom;
  std::optional<int> seq;           ///< of the measurement request it answers; $uvis,insp asks for
                                    ///< several pictures of one
  std::optional<std::string> time;  ///< as written
};

/// A folder of recorded pictures and its list `images.csv` (contract, "Picture folders").
struct PictureFolder {
  std::filesystem::path folder;
  std::vector<PictureRow> rows;

  std::filesystem::path path_of(const PictureRow& row) const { return folder / row.file; }
};

/// Reads DIR/images.csv; does not open the pictures.
///
/// Header `file,x,y` and optional z, tool, lamp, zoom, seq, time in any order; numbers in mm. An
/// optional field may be empty. CR LF and a UTF-8 byte order mark are accepted.
///
/// Fails  file-unreadable; images-csv (file:line:column, the text, what was expected)
Expected<PictureFolder> read_picture_folder(const std::filesystem::path& folder);

/// The same from the text of images.csv; `name` stands in the diagnostics.
Expected<std::vector<PictureRow>> parse_images_csv(std::string_view text, std::string_view name);

/// The text of an images.csv with those columns that any row uses; numbers read back exactly.
std::string format_images_csv(std::span<const PictureRow> rows);

}  // namespace panelcal
