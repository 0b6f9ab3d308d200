// SPDX-License-Identifier: Apache-2.0
#include "tools/batch/manifest/manifest.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <unordered_map>

#include "calib/base/clock.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/base/json/strict_json.h"
#include "tools/batch/manifest/csv_fields.h"
#include <fmt/format.h>

namespace panelcal::batch {
namespace {

struct KnownColumn {
  std::string_view name;
  std::string ManifestJob::*member;
  bool is_file;
};

constexpr std::array<KnownColumn, 9> kKnownColumns = {{
    {"id", &ManifestJob::id, false},
    {"program", &ManifestJob::program, true},
    {"machine", &ManifestJob::machine, true},
    {"images", &ManifestJob::images, true},
    {"measurements", &ManifestJob::measurements, true},
    {"probes", &ManifestJob::probes, true},
    {"truth", &ManifestJob::truth, true},
    {"clock", &ManifestJob::clock, false},
    {"output", &ManifestJob::output, true},
}};
constexpr std::size_t kLongestId = 100;
constexpr std::size_t kMaxManifestBytes = std::size_t{1} << 31;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_letter_or_digit(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

bool is_factor_name(std::string_view text) {
  return !text.empty() && !(text.front() >= '0' && text.front() <= '9') &&
         std::ranges::all_of(text, [](char c) { return is_letter_or_digit(c) || c == '_'; });
}

const KnownColumn* known_column(std::string_view name) {
  const auto found = std::ranges::find(kKnownColumns, name, &KnownColumn::name);
  return found == kKnownColumns.end() ? nullptr : &*found;
}

/// Takes rows of either form, and makes jobs of them.
class ManifestReader {
 public:
  ManifestReader(std::string_view text,
                 const std::string& file,
                 const std::string& folder,
                 const ManifestDefaults& defaults)
      : rest_(text), file_(file), folder_(folder), defaults_(defaults) {
    if (rest_.starts_with(kByteOrderMark)) rest_.remove_prefix(kByteOrderMark.size());
    const std::size_t first = rest_.find_first_not_of(" \t\r\n");
    is_json_ = first != std::string_view::npos && rest_[first] == '{';
  }

  Expected<std::vector<ManifestJob>> read() {
    std::string_view line;
    while (next_line(line)) {
      if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
      if (is_json_) {
        PANELCAL_CHECK(read_object(line));
      } else if (columns_.empty()) {
        PANELCAL_CHECK(read_header(line));
      } else {
        PANELCAL_CHECK(read_row(line));
      }
    }
    line_ = std::max(line_, 1);
    if (jobs_.empty()) return error(1, "the manifest has no job", "at least one row");
    return std::move(jobs_);
  }

 private:
  bool next_line(std::string_view& line) {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    line = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    ++line_;
    return true;
  }

  tl::unexpected<Diagnostic> error(int column, std::string what, std::string expected) const {
    return failure({Code::Usage, {file_, line_, column}, std::move(what), std::move(expected)});
  }

  Expected<void> check_column(std::string_view name, int column) const {
    if (known_column(name) != nullptr) return {};
    std::vector<std::string_view> names;
    for (const KnownColumn& one : kKnownColumns) names.push_back(one.name);
    const std::string_view near = nearest_word(name, names);
    if (!near.empty()) {
      return error(column, "unknown column " + quoted(name), "did you mean " + quoted(near) + "?");
    }
    if (is_factor_name(name)) return {};
    return error(column,
                 "column " + quoted(name) + " cannot be a factor's",
                 "a name of letters, digits and _ that begins with no digit");
  }

  Expected<void> read_header(std::string_view line) {
    PANELCAL_TRY(columns_, split(line));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      const CsvField& column = columns_[i];
      PANELCAL_CHECK(check_column(column.text, column.column));
      const auto end = columns_.begin() + static_cast<std::ptrdiff_t>(i);
      if (std::ranges::find(columns_.begin(), end, column.text, &CsvField::text) != end) {
        return error(column.column, "column " + quoted(column.text) + " comes twice", "it once");
      }
    }
    return {};
  }

  Expected<std::vector<CsvField>> split(std::string_view line) const {
    auto fields = split_csv(line);
    if (fields) return *std::move(fields);
    return error(fields.error(), "a quote that is not closed, or text beside it", "\"a, b\"");
  }

  Expected<void> read_row(std::string_view line) {
    PANELCAL_TRY(const std::vector<CsvField> fields, split(line));
    if (fields.size() != columns_.size()) {
      return error(1,
                   fmt::format("{} fields", fields.size()),
                   fmt::format("{}, as in the header", columns_.size()));
    }
    ManifestJob job;
    places_.clear();
    for (std::size_t i = 0; i < fields.size(); ++i) {
      put(job, columns_[i].text, fields[i].text, fields[i].column);
    }
    return take(std::move(job));
  }

  Expected<void> read_object(std::string_view line) {
    auto object = internal::parse_strict_json(line, file_);
    if (!object) {
      Diagnostic problem = std::move(object).error();
      problem.place.line = line_;
      return failure(std::move(problem));
    }
    if (!object->is_object()) return error(1, "no object", "{\"program\": \"job.exc\", ...}");
    ManifestJob job;
    places_.clear();
    for (const auto& [key, value] : object->items()) {
      // Where the key stands: names of columns have no escapes.
      const std::size_t at = line.find("\"" + key + "\"");
      const int column = at == std::string_view::npos ? 1 : static_cast<int>(at) + 1;
      PANELCAL_CHECK(check_column(key, column));
      if (value.is_null()) continue;
      const bool is_known = known_column(key) != nullptr;
      if (!value.is_string() && (is_known || value.is_structured())) {
        return error(column,
                     fmt::format("{} is {}", quoted(key), quoted(value.dump())),
                     is_known ? "a text" : "a text, a number or a truth value");
      }
      put(job, key, value.is_string() ? value.get<std::string>() : value.dump(), column);
    }
    return take(std::move(job));
  }

  void put(ManifestJob& job, const std::string& name, const std::string& text, int column) {
    places_[name] = column;
    const KnownColumn* const known = known_column(name);
    if (known == nullptr) {
      job.factors.emplace_back(name, text);
      return;
    }
    job.*(known->member) = known->is_file && !text.empty() ? path_of(text) : text;
  }

  std::string path_of(const std::string& text) const {
    return (std::filesystem::path(folder_) / text).lexically_normal().string();
  }

  int column_of(const std::string& name) const {
    const auto at = places_.find(name);
    return at == places_.end() ? 1 : at->second;
  }

  Expected<void> take(ManifestJob job) {
    job.number = static_cast<std::int64_t>(jobs_.size()) + 1;
    job.line = line_;
    if (job.id.empty()) job.id = fmt::format("{:06}", job.number);
    if (job.machine.empty()) job.machine = defaults_.machine;
    if (job.program.empty()) return error(1, "a job without a program", "\"program\"");
    if (job.machine.empty()) return error(1, "a job without a machine", "\"machine\", or -m");
    if (!job.images.empty() && !job.measurements.empty()) {
      return error(column_of("measurements"), "two sources", "\"images\" or \"measurements\"");
    }
    if (!is_job_id(job.id)) {
      return error(column_of("id"), "id " + quoted(job.id), std::string(kJobIdWords));
    }
    if (!job.clock.empty() && !from_iso_8601(job.clock + "Z")) {
      return error(column_of("clock"),
                   "clock " + quoted(job.clock),
                   "a date and a time, such as 2026-11-21T13:45:00");
    }
    PANELCAL_CHECK(take_once(ids_, job.id, "id"));
    if (!job.output.empty()) PANELCAL_CHECK(take_once(outputs_, job.output, "output"));
    jobs_.push_back(std::move(job));
    return {};
  }

  Expected<void> take_once(std::unordered_map<std::string, int>& taken,
                           const std::string& text,
                           const std::string& column) const {
    const auto [at, is_new] = taken.emplace(text, line_);
    if (is_new) return {};
    return error(column_of(column),
                 fmt::format("{} {} stands in line {} too", column, quoted(text), at->second),
                 "one of its own for each job");
  }

  std::string_view rest_;
  const std::string& file_;
  const std::string& folder_;
  const ManifestDefaults& defaults_;
  bool is_json_ = false;
  int line_ = 0;
  std::vector<CsvField> columns_;
  std::unordered_map<std::string, int> places_;  ///< columns of the row's values
  std::unordered_map<std::string, int> ids_;     ///< and the lines that they stand in
  std::unordered_map<std::string, int> outputs_;
  std::vector<ManifestJob> jobs_;
};

}  // namespace

bool is_job_id(std::string_view text) {
  return !text.empty() && text.size() <= kLongestId && text.front() != '.' &&
         std::ranges::all_of(text, [](char c) {
           return is_letter_or_digit(c) || c == '.' || c == '_' || c == '-';
         });
}

Expected<Manifest> parse_manifest(std::string_view text,
                                  const std::string& file,
                                  const std::string& folder,
                                  const ManifestDefaults& defaults) {
  PANELCAL_TRY(auto jobs, ManifestReader(text, file, folder, defaults).read());
  return Manifest{file, sha256(text), std::move(jobs)};
}

Expected<Manifest> read_manifest(const std::string& path, const ManifestDefaults& defaults) {
  const bool is_input = path == "-";
  PANELCAL_TRY(const std::string text,
               read_file(is_input ? "/dev/stdin" : path, kMaxManifestBytes));
  const std::string folder =
      is_input ? std::string() : std::filesystem::path(path).parent_path().string();
  return parse_manifest(text, is_input ? "standard input" : path, folder, defaults);
}

std::vector<std::int64_t> sample_of(const Manifest& manifest, std::size_t n) {
  std::vector<std::int64_t> numbers;
  if (n >= manifest.jobs.size()) {
    for (const ManifestJob& job : manifest.jobs) numbers.push_back(job.number);
    return numbers;
  }
  std::vector<std::pair<std::string, std::int64_t>> digests;
  digests.reserve(manifest.jobs.size());
  for (const ManifestJob& job : manifest.jobs) digests.emplace_back(sha256(job.id), job.number);
  std::ranges::partial_sort(digests, digests.begin() + static_cast<std::ptrdiff_t>(n));
  for (std::size_t i = 0; i < n; ++i) numbers.push_back(digests[i].second);
  std::ranges::sort(numbers);
  return numbers;
}

}  // namespace panelcal::batch
