// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/synth_folder.h"

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kTruth = "truth.json";
constexpr std::string_view kList = "images.csv";
constexpr std::size_t kLeastDigits = 4;
constexpr std::size_t kDigestChars = 64;
constexpr std::size_t kMaxManifestBytes = std::size_t{1} << 28;
constexpr std::size_t kMaxSynthFileBytes = std::size_t{1} << 30;

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

/// "DIGEST  NAME", a line of a manifest.
struct ManifestLine {
  std::string_view digest;
  std::string_view name;
};

std::optional<ManifestLine> parse_line(std::string_view line) {
  constexpr std::string_view kGap = "  ";
  if (line.size() <= kDigestChars || line.substr(kDigestChars, kGap.size()) != kGap) {
    return std::nullopt;
  }
  return ManifestLine{line.substr(0, kDigestChars), line.substr(kDigestChars + kGap.size())};
}

bool is_of_synth(std::string_view name) {
  return name == kTruth || name == kList || is_numbered_picture(name);
}

/// Names of what an earlier synth wrote and is there unchanged.
std::set<std::string, std::less<>> made_by_synth(const fs::path& folder) {
  std::set<std::string, std::less<>> made;
  const auto text = read_file(folder / kSynthManifest, kMaxManifestBytes);
  if (!text) return made;
  for (std::string_view rest = *text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const auto line = parse_line(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (!line || !is_of_synth(line->name)) continue;
    const auto bytes = read_file(folder / line->name, kMaxSynthFileBytes);
    if (bytes && sha256(*bytes) == line->digest) made.emplace(line->name);
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
    if (is_of_synth(name) && !made.contains(name)) foreign.insert(name);
  }
  if (error) return failure(cannot(folder, error));
  if (!foreign.empty()) {
    return failure({Code::Usage,
                    {folder.string(), 0, 0},
                    quoted(*foreign.begin()) + " in it is not as a finished synth wrote it",
                    "a folder without pictures, or one that synth wrote"});
  }
  std::vector<std::string> removed(made.begin(), made.end());
  // Last, so that one that is interrupted here still knows its own.
  removed.emplace_back(kSynthManifest);
  for (const std::string& name : removed) {
    fs::remove(folder / name, error);
    if (error) return failure(cannot(folder, error));
  }
  return {};
}

Expected<void> finish_synth_folder(const fs::path& folder, std::vector<std::string> names) {
  std::ranges::sort(names);
  std::string text;
  for (const std::string& name : names) {
    PANELCAL_TRY(const std::string bytes, read_file(folder / name, kMaxSynthFileBytes));
    text += fmt::format("{}  {}\n", sha256(bytes), name);
  }
  return write_file(folder / kSynthManifest, text);
}

}  // namespace panelcal::internal
