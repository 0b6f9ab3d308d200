// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/overlay_paths.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "tools/cli/output_paths.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

using Path = std::filesystem::path;

bool is_png(const Path& path) {
  return extension_of(path) == ".png";
}

/// True if a name is surely not meant for a folder.
bool is_other_picture(const Path& path) {
  constexpr std::array<std::string_view, 10> kExtensions = {
      ".bmp", ".gif", ".jpeg", ".jpg", ".pdf", ".pgm", ".svg", ".tif", ".tiff", ".webp"};
  std::error_code ignored;
  return std::ranges::find(kExtensions, extension_of(path)) != kExtensions.end() &&
         !std::filesystem::is_directory(path, ignored);
}

/// Path of the overlay of each picture: OUT.png for the only one, else OUT/NAME.png.
///
/// Fails  usage (no PNG; several pictures and one file; two pictures of one name)
Expected<std::vector<Path>> overlay_paths(const LocateCommandOptions& options) {
  const Path out(options.overlay);
  if (is_other_picture(out)) {
    return failure(locate_usage(
        fmt::format("--overlay {} is not written: overlays are PNG files", quoted(options.overlay)),
        "a name that ends in .png, or a folder"));
  }
  std::vector<Path> paths;
  if (is_png(out)) {
    if (options.images.size() > 1) {
      return failure(locate_usage(fmt::format("--overlay {} is one file, and there are {} pictures",
                                              quoted(options.overlay),
                                              options.images.size()),
                                  "a folder"));
    }
    paths.push_back(out);
  } else {
    for (const std::string& image : options.images) {
      paths.push_back(out / (Path(image).stem().string() + ".png"));
    }
  }
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (const auto first = std::ranges::find(paths, paths[i]) - paths.begin();
        static_cast<std::size_t>(first) != i) {
      return failure(
          locate_usage(fmt::format("the overlays of {} and {} would both be {}",
                                   quoted(options.images[static_cast<std::size_t>(first)]),
                                   quoted(options.images[i]),
                                   quoted(paths[i].string())),
                       "pictures of different names"));
    }
  }
  return paths;
}

/// Makes the folder of several overlays.
Expected<void> make_folder(const LocateCommandOptions& options) {
  if (is_png(options.overlay)) return {};
  std::error_code error;
  std::filesystem::create_directories(options.overlay, error);
  // A path with a trailing slash exists, and yet nothing was created.
  std::error_code ignored;
  if (std::filesystem::is_directory(options.overlay, ignored)) return {};
  return failure({Code::DeviceWrite,
                  {options.overlay, 0, 0},
                  "cannot create the folder: " +
                      (error ? error.message() : std::string("a file has its name")),
                  ""});
}

}  // namespace

Diagnostic locate_usage(std::string what, std::string expected) {
  return {Code::Usage, {"panelcal locate", 0, 0}, std::move(what), std::move(expected)};
}

Expected<std::vector<Path>> make_overlay_paths(const LocateCommandOptions& options,
                                               const CommandContext& context) {
  PANELCAL_TRY(std::vector<Path> paths, overlay_paths(options));
  for (const Path& path : paths) {
    PANELCAL_CHECK(check_output(context.options, context.files, path));
  }
  PANELCAL_CHECK(make_folder(options));
  return paths;
}

}  // namespace panelcal::internal
