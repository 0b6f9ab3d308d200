// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <system_error>

#include "calib/base/files/digest.h"
#include "tools/batch/manifest/manifest.h"
#include <fmt/format.h>
#include <glob.h>

namespace panelcal::batch {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 8> kProgramEndings = {
    ".exc", ".drl", ".ncd", ".nc", ".xln", ".s5", ".sm", ".sm3"};

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// The first that exists, or nothing.
std::string first_of(std::initializer_list<fs::path> paths) {
  const auto found = std::ranges::find_if(paths, is_there);
  return found == paths.end() ? std::string() : found->string();
}

tl::unexpected<Diagnostic> folder_problem(const std::string& where,
                                          std::string what,
                                          std::string expected) {
  return failure({Code::Usage, {where, 0, 0}, std::move(what), std::move(expected)});
}

Expected<std::string> program_in(const fs::path& folder) {
  std::vector<std::string> programs;
  std::error_code error;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string ending = at->path().extension().string();
    if (std::ranges::find(kProgramEndings, ending) != kProgramEndings.end()) {
      programs.push_back(at->path().string());
    }
  }
  if (programs.size() == 1) return programs.front();
  return folder_problem(folder.string(),
                        fmt::format("{} programs in the folder", programs.size()),
                        fmt::format("one file that ends in {}", fmt::join(kProgramEndings, " ")));
}

Expected<ManifestJob> job_in(const fs::path& folder, const ManifestDefaults& defaults) {
  ManifestJob job;
  job.id = folder.filename().string();
  if (!is_job_id(job.id)) {
    return folder_problem(folder.string(), "id " + quoted(job.id), std::string(kJobIdWords));
  }
  PANELCAL_TRY(job.program, program_in(folder));
  const fs::path images = folder / "images";
  job.machine = first_of({folder / "machine.toml", defaults.machine});
  if (job.machine.empty()) {
    return folder_problem(folder.string(), "a job without a machine", "machine.toml there, or -m");
  }
  job.images = is_there(images / "images.csv") ? images.string() : "";
  if (job.images.empty()) job.measurements = first_of({folder / "measurements.jsonl"});
  job.probes = first_of({folder / "probes.jsonl"});
  job.truth = first_of({folder / "truth.json", images / "truth.json"});
  return job;
}

}  // namespace

Expected<Manifest> find_job_folders(const std::string& pattern, const ManifestDefaults& defaults) {
  glob_t found{};
  const int status = ::glob(pattern.c_str(), 0, nullptr, &found);
  const std::unique_ptr<glob_t, void (*)(glob_t*)> freed(&found, &::globfree);
  Manifest manifest{.file = pattern};
  std::string names;
  for (std::size_t i = 0; status == 0 && i < found.gl_pathc; ++i) {
    std::error_code ignored;
    // "jobs/*/" and "jobs/*" name the same folders.
    const fs::path folder = (fs::path(found.gl_pathv[i]) / "").parent_path();
    if (!fs::is_directory(folder, ignored)) continue;
    PANELCAL_TRY(ManifestJob job, job_in(folder, defaults));
    job.number = static_cast<std::int64_t>(manifest.jobs.size()) + 1;
    for (const std::string* part :
         {&job.program, &job.machine, &job.images, &job.measurements, &job.probes, &job.truth}) {
      names += *part + '\n';
    }
    manifest.jobs.push_back(std::move(job));
  }
  if (manifest.jobs.empty()) {
    return folder_problem(
        "panelcal batch", "--pattern " + quoted(pattern) + " finds no folder", "'jobs/*'");
  }
  manifest.sha256 = sha256(names);
  std::vector<std::string> ids;
  for (const ManifestJob& job : manifest.jobs) ids.push_back(job.id);
  std::ranges::sort(ids);
  if (const auto twice = std::ranges::adjacent_find(ids); twice != ids.end()) {
    return folder_problem("panelcal batch",
                          "--pattern finds two folders " + quoted(*twice),
                          "a name of its own for each job's folder");
  }
  return manifest;
}

}  // namespace panelcal::batch
