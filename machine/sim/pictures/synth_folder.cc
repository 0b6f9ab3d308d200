// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/synth_folder.h"

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/strict_json.h"
#include "machine/sim/truth.h"
#include "vision/picture/files/folder.h"
#include <nlohmann/json.hpp>

namespace panelcal::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTruth = "truth.json";
constexpr std::string_view kList = "images.csv";
constexpr std::size_t kLeastDigits = 4;

std::size_t count_digits(std::string_view text) {
  const std::size_t end = text.find_first_not_of("0123456789");
  return end == std::string_view::npos ? text.size() : end;
}

/// Takes `word` and a number from the front of a text, if both are there.
void skip_number(std::string_view& text, std::string_view word) {
  if (!text.starts_with(word)) return;
  const std::size_t n_digits = count_digits(text.substr(word.size()));
  if (n_digits > 0) text.remove_prefix(word.size() + n_digits);
}

/// NNNN.png, NNNN_2.png, NNNN_view2.png, NNNN_view2_2.png: the names that synth gives.
bool is_numbered_picture(std::string_view name) {
  const std::size_t n_digits = count_digits(name);
  if (n_digits < kLeastDigits) return false;
  name.remove_prefix(n_digits);
  skip_number(name, "_view");
  skip_number(name, "_");
  return name == ".png";
}

/// A member of an object that is a text; empty if there is none.
std::string json_text_at(const nlohmann::json& value, const char* key) {
  const auto at = value.is_object() ? value.find(key) : value.end();
  const bool is_text = value.is_object() && at != value.end() && at->is_string();
  return is_text ? at->get<std::string>() : std::string();
}

std::vector<std::string> pictures_of_samples(const nlohmann::json& truth) {
  std::vector<std::string> names;
  const auto pictures = truth.find("pictures");
  if (pictures == truth.end() || !pictures->is_array()) return names;
  for (const nlohmann::json& picture : *pictures) names.push_back(json_text_at(picture, "file"));
  return names;
}

std::vector<std::string> pictures_of_list(const fs::path& folder) {
  std::vector<std::string> names;
  const auto list = read_picture_folder(folder);
  if (!list) return names;
  for (const PictureRow& row : list->rows) names.push_back(row.file);
  return names;
}

/// Names of what an earlier synth made. Only its truth.json tells: cameras write images.csv too.
std::set<std::string, std::less<>> made_by_synth(const fs::path& folder) {
  std::set<std::string, std::less<>> made;
  const auto text = read_file(folder / kTruth, kMaxTruthBytes);
  if (!text) return made;
  const auto truth = parse_strict_json(*text, std::string(kTruth));
  if (!truth) return made;
  const std::string kind = json_text_at(*truth, "kind");
  std::vector<std::string> pictures;
  if (kind == "sample-truth") {
    pictures = pictures_of_samples(*truth);
  } else if (kind == "truth") {
    pictures = pictures_of_list(folder);
    made.emplace(kList);
  } else {
    return made;
  }
  made.emplace(kTruth);
  for (std::string& name : pictures) {
    if (is_numbered_picture(name)) made.insert(std::move(name));
  }
  return made;
}

Diagnostic cannot(const fs::path& folder, const std::error_code& error) {
  return {Code::DeviceWrite,
          {folder.string(), 0, 0},
          "cannot be made a picture folder: " + error.message(),
          ""};
}

}  // namespace

Expected<void> prepare_synth_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return failure(cannot(folder, error));
  const auto made = made_by_synth(folder);
  // In the order of their names, so that the message is the same everywhere.
  std::set<std::string> foreign;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    const bool would_mix = name == kTruth || name == kList || is_numbered_picture(name);
    if (would_mix && !made.contains(name)) foreign.insert(name);
  }
  if (error) return failure(cannot(folder, error));
  if (!foreign.empty()) {
    return failure({Code::Usage,
                    {folder.string(), 0, 0},
                    quoted(*foreign.begin()) + " in it was not written by a finished synth",
                    "a folder without pictures, or one that synth wrote"});
  }
  for (const std::string& name : made) {
    fs::remove(folder / name, error);
    if (error) return failure(cannot(folder, error));
  }
  return {};
}

}  // namespace panelcal::internal
