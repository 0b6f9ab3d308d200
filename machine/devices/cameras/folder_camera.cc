// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/folder_camera.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "vision/picture/files/image_io.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

bool is_picture(const std::filesystem::path& file) {
  constexpr std::array<std::string_view, 6> kExtensions = {
      ".bmp", ".jpeg", ".jpg", ".png", ".tif", ".tiff"};
  std::string extension = file.extension().string();
  std::ranges::transform(
      extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::ranges::find(kExtensions, extension) != kExtensions.end();
}

class FolderCamera final : public CameraDevice {
 public:
  FolderCamera(std::filesystem::path folder, std::vector<std::filesystem::path> files)
      : folder_(std::move(folder)), files_(std::move(files)) {}

  Expected<Image> take() override {
    if (i_next_ == files_.size()) {
      return failure({Code::DeviceFrame,
                      {name(), 0, 0},
                      fmt::format("all {} picture(s) have been shown", files_.size()),
                      "a picture for each view"});
    }
    return read_image(files_[i_next_++]);
  }
  std::string name() const override { return "folder:" + folder_.string(); }

 private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> files_;
  std::size_t i_next_ = 0;
};

}  // namespace

Expected<std::unique_ptr<CameraDevice>> open_folder_camera(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    if (is_picture(entry->path())) files.push_back(entry->path());
  }
  if (error) {
    return failure({Code::FileUnreadable, {folder.string(), 0, 0}, error.message(), "a folder"});
  }
  if (files.empty()) {
    return failure({Code::PictureMissing,
                    {folder.string(), 0, 0},
                    "there is no picture in the folder",
                    ".png, .tif, .bmp or .jpg"});
  }
  std::ranges::sort(files);
  return std::make_unique<FolderCamera>(folder, std::move(files));
}

}  // namespace panelcal
