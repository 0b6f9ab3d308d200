// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/job_folder.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <tuple>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/facts.h"
#include "calib/base/json/strict_json.h"
#include "machine/operator/command.h"
#include "machine/sources/measurement_file_source.h"
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

namespace panelcal::internal {
namespace {

using facts::Json;

constexpr std::string_view kRecordName = "job.json";
constexpr std::string_view kMeasurementsName = "measurements.jsonl";
constexpr std::string_view kChoicesName = "choices.jsonl";
constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 20;
constexpr std::size_t kDayLength = 10;  // of "2026-11-27"

Diagnostic journal_problem(const std::filesystem::path& file, int error) {
  return {Code::DeviceWrite, {file.string(), 0, 0}, std::system_category().message(error), ""};
}

/// All of the text, or a diagnostic; on the disk when this returns.
Expected<void> append_line(int fd, const std::filesystem::path& file, std::string line) {
  line += '\n';
  for (std::string_view left = line; !left.empty();) {
    const ssize_t n = ::write(fd, left.data(), left.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return failure(journal_problem(file, errno));
    left.remove_prefix(static_cast<std::size_t>(n));
  }
  if (::fdatasync(fd) != 0) return failure(journal_problem(file, errno));
  return {};
}

/// Opens a journal at its end, behind its last whole line.
Expected<int> open_journal(const std::filesystem::path& file) {
  constexpr mode_t kMode = 0666;
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC | O_NOFOLLOW, kMode);
  if (fd < 0) return failure(journal_problem(file, errno));
  const Expected<std::string> text = read_file(file, kMaxMeasurementBytes);
  const std::size_t whole = text ? text->rfind('\n') + 1 : 0;  // npos + 1 is 0
  const bool is_cut = text && whole < text->size();
  if (text && (!is_cut || ::ftruncate(fd, static_cast<off_t>(whole)) == 0)) return fd;
  const int error = errno;
  ::close(fd);
  return failure(text ? journal_problem(file, error) : text.error());
}

std::string record_text(const JobRecord& record) {
  Json out;
  out["id"] = record.id;
  out["program"] = record.program;
  out["program_sha256"] = record.program_sha256;
  out["machine_sha256"] = record.machine_sha256;
  out["source"] = record.source;
  out["who"] = record.who;
  out["started"] = record.started;
  out["state"] = name(record.state);
  out["verdict"] = record.verdict;
  out["n_holes"] = record.n_holes ? Json(*record.n_holes) : Json();
  out["outputs"] = record.outputs;
  out["is_closed"] = record.is_closed;
  return facts::text(out);
}

Expected<JobRecord> record_of(const std::filesystem::path& file) {
  const auto refuse = [&] {
    return failure({Code::Usage, {file.string(), 0, 0}, "not the record of a job", ""});
  };
  PANELCAL_TRY(const std::string text, read_file(file, kMaxRecordBytes));
  PANELCAL_TRY(const nlohmann::json json, parse_strict_json(text, file.string()));
  if (!json.is_object()) return refuse();
  JobRecord record;
  for (const auto& [key, into] : {std::pair("id", &record.id),
                                  std::pair("program", &record.program),
                                  std::pair("program_sha256", &record.program_sha256),
                                  std::pair("machine_sha256", &record.machine_sha256),
                                  std::pair("source", &record.source),
                                  std::pair("verdict", &record.verdict),
                                  std::pair("who", &record.who),
                                  std::pair("started", &record.started)}) {
    if (!json.contains(key) || !json[key].is_string()) return refuse();
    *into = json[key].get<std::string>();
  }
  const bool has_state = json.contains("state") && json["state"].is_string();
  const auto state =
      has_state ? job_state_from_name(json["state"].get<std::string>()) : std::nullopt;
  if (!state || !json.contains("outputs") || !json["outputs"].is_array()) return refuse();
  record.state = *state;
  const bool has_holes = json.contains("n_holes") && json["n_holes"].is_number_integer();
  if (has_holes) record.n_holes = json["n_holes"].get<std::int64_t>();
  const bool has_closed = json.contains("is_closed") && json["is_closed"].is_boolean();
  record.is_closed = has_closed && json["is_closed"].get<bool>();
  for (const auto& output : json["outputs"]) {
    if (!output.is_string()) return refuse();
    record.outputs.push_back(output.get<std::string>());
  }
  return record;
}

std::optional<JobChoice> choice_of(std::string_view line) {
  const auto json = parse_strict_json(line, std::string(kChoicesName));
  if (!json || !json->is_object()) return std::nullopt;
  JobChoice choice;
  const auto has = [&](const char* key, auto is_type) {
    return json->contains(key) && is_type((*json)[key]);
  };
  const auto is_text = [](const nlohmann::json& value) { return value.is_string(); };
  const auto is_count = [](const nlohmann::json& value) { return value.is_number_integer(); };
  if (!has("seq", is_count) || !has("what", is_text) || !has("who", is_text) ||
      !has("when", is_text)) {
    return std::nullopt;
  }
  return JobChoice{(*json)["seq"].get<std::int64_t>(),
                   (*json)["what"].get<std::string>(),
                   (*json)["who"].get<std::string>(),
                   (*json)["when"].get<std::string>()};
}

/// The day, and the number on that day.
std::pair<std::string_view, int> order_of(std::string_view id) {
  int number = 0;
  std::from_chars(id.data() + kDayLength + 1, id.data() + id.size(), number);
  return {id.substr(0, kDayLength), number};
}

}  // namespace

Expected<JobFolder> JobFolder::create(const std::filesystem::path& jobs, JobRecord record) {
  const std::filesystem::path folder = jobs / record.id;
  std::error_code error;
  if (!std::filesystem::create_directory(folder, error)) {
    if (error) return failure(journal_problem(folder, error.value()));
    return failure(refused("job " + record.id + " is there already", "the program opened again"));
  }
  JobFolder out(folder, std::move(record));
  PANELCAL_CHECK(out.write_record());
  PANELCAL_CHECK(out.open_journals());
  return out;
}

Expected<JobFolder> JobFolder::open(const std::filesystem::path& jobs, const std::string& id) {
  if (!is_job_id(id)) return failure(refused("job " + quoted(id), "2026-11-27-1"));
  PANELCAL_TRY(JobRecord record, record_of(jobs / id / kRecordName));
  record.id = id;
  JobFolder out(jobs / id, std::move(record));
  PANELCAL_CHECK(out.open_journals());
  return out;
}

JobFolder::JobFolder(JobFolder&& other) noexcept
    : folder_(std::move(other.folder_)),
      record_(std::move(other.record_)),
      measurements_fd_(std::exchange(other.measurements_fd_, -1)),
      choices_fd_(std::exchange(other.choices_fd_, -1)) {
}

JobFolder::~JobFolder() {
  if (measurements_fd_ >= 0) ::close(measurements_fd_);
  if (choices_fd_ >= 0) ::close(choices_fd_);
}

Expected<void> JobFolder::write_record() const {
  return write_file(file(kRecordName), record_text(record_));
}

Expected<void> JobFolder::open_journals() {
  PANELCAL_TRY(measurements_fd_, open_journal(file(kMeasurementsName)));
  PANELCAL_TRY(choices_fd_, open_journal(file(kChoicesName)));
  return {};
}

std::vector<Measurement> JobFolder::measurements() const {
  std::vector<Measurement> out;
  const auto recorded = read_measurements(file(kMeasurementsName));
  if (!recorded || !recorded->calibrations.empty()) return out;
  for (const RecordedMeasurement& one : recorded->measurements) out.push_back(one.answer);
  return out;
}

std::vector<JobChoice> JobFolder::choices() const {
  std::vector<JobChoice> out;
  const auto text = read_file(file(kChoicesName), kMaxMeasurementBytes);
  if (!text) return out;
  std::string_view left = *text;
  while (!left.empty()) {
    const std::string_view line = left.substr(0, left.find('\n'));
    left.remove_prefix(std::min(left.size(), line.size() + 1));
    if (auto choice = choice_of(line)) out.push_back(*std::move(choice));
  }
  return out;
}

Expected<void> JobFolder::append(const Measurement& measurement) {
  return append_line(measurements_fd_, file(kMeasurementsName), to_json(measurement));
}

Expected<void> JobFolder::replace(const Measurement& measurement) {
  std::string lines;
  for (const Measurement& one : measurements()) {
    lines += to_json(one.request.seq == measurement.request.seq ? measurement : one) + "\n";
  }
  PANELCAL_CHECK(write_file(file(kMeasurementsName), lines));
  ::close(std::exchange(measurements_fd_, -1));
  PANELCAL_TRY(measurements_fd_, open_journal(file(kMeasurementsName)));
  return {};
}

Expected<void> JobFolder::append(const JobChoice& choice) {
  Json json;
  json["seq"] = choice.seq;
  json["what"] = choice.what;
  json["who"] = choice.who;
  json["when"] = choice.when;
  std::string line = facts::text(json);
  line.pop_back();
  return append_line(choices_fd_, file(kChoicesName), std::move(line));
}

Expected<void> JobFolder::begin_anew(JobRecord record) {
  if (::ftruncate(measurements_fd_, 0) != 0 || ::fdatasync(measurements_fd_) != 0) {
    return failure(journal_problem(file(kMeasurementsName), errno));
  }
  record_ = std::move(record);
  return write_record();
}

Expected<void> JobFolder::set_state(JobState state) {
  record_.state = state;
  return write_record();
}

Expected<void> JobFolder::conclude(JobState state,
                                   const std::string& verdict,
                                   std::optional<std::int64_t> n_holes) {
  record_.verdict = verdict;
  record_.n_holes = n_holes;
  return set_state(state);
}

Expected<void> JobFolder::close() {
  record_.is_closed = true;
  return write_record();
}

Expected<void> JobFolder::add_output(const std::string& name) {
  if (std::ranges::find(record_.outputs, name) != record_.outputs.end()) return {};
  record_.outputs.push_back(name);
  return write_record();
}

std::vector<std::string> list_jobs(const std::filesystem::path& jobs) {
  std::vector<std::string> ids;
  std::error_code error;
  std::filesystem::directory_iterator entry(jobs, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::string id = entry->path().filename().string();
    if (is_job_id(id)) ids.push_back(std::move(id));
  }
  std::ranges::sort(ids, {}, [](const std::string& id) { return order_of(id); });
  return ids;
}

std::string picture_name(std::int64_t seq) {
  return fmt::format("picture-{}.jpg", seq);
}

bool is_job_file(std::string_view name) {
  constexpr std::array<std::string_view, 4> kNames = {
      "report.html", "output", "facts.json", kMeasurementsName};
  if (std::ranges::find(kNames, name) != kNames.end()) return true;
  std::int64_t seq = 0;
  constexpr std::size_t kPrefix = std::string_view("picture-").size();
  if (name.size() <= kPrefix) return false;
  const auto [end, error] = std::from_chars(name.data() + kPrefix, name.data() + name.size(), seq);
  return error == std::errc() && seq >= 0 && name == picture_name(seq);
}

bool is_job_id(std::string_view id) {
  constexpr std::size_t kMaxDigits = 6;
  if (id.size() < kDayLength + 2 || id.size() > kDayLength + 1 + kMaxDigits) return false;
  for (std::size_t i = 0; i < id.size(); ++i) {
    const bool is_dash = i == 4 || i == 7 || i == kDayLength;
    const bool is_digit = id[i] >= '0' && id[i] <= '9';
    if (is_dash ? id[i] != '-' : !is_digit) return false;
  }
  return id[kDayLength + 1] != '0';
}

}  // namespace panelcal::internal
