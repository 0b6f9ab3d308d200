// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/programs.h"

#include <algorithm>
#include <system_error>

#include "calib/base/files/atomic_file.h"
#include "machine/operator/command.h"
#include "machine/operator/settings.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kNameCharacters =
    "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
constexpr std::size_t kMaxName = 100;

}  // namespace

Expected<void> check_name(const std::string& name) {
  const bool is_good = !name.empty() && name.size() <= kMaxName && name.front() != '.' &&
                       name.find_first_not_of(kNameCharacters) == std::string::npos;
  if (is_good) return {};
  return failure(
      refused("name " + quoted(name),
              fmt::format("at most {} letters, digits and ._-, with no point first", kMaxName)));
}

std::vector<ScreenProgram> list_programs(const std::filesystem::path& folder) {
  std::vector<ScreenProgram> programs;
  std::error_code error;
  std::filesystem::directory_iterator entry(folder, error);
  for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error)) {
    std::error_code unreadable;
    const std::string name = entry->path().filename().string();
    const bool is_file =
        entry->symlink_status(unreadable).type() == std::filesystem::file_type::regular;
    if (!is_file || unreadable || !check_name(name)) continue;
    const std::uintmax_t size = entry->file_size(unreadable);
    if (!unreadable && size <= kMaxProgramBytes) programs.push_back({name, size});
  }
  std::ranges::sort(programs, {}, &ScreenProgram::name);
  return programs;
}

Expected<void> store_program(const std::filesystem::path& folder,
                             const std::string& name,
                             std::string_view bytes) {
  PANELCAL_CHECK(check_name(name));
  if (bytes.size() > kMaxProgramBytes) {
    return failure(refused(fmt::format("a program of {} bytes", bytes.size()),
                           fmt::format("at most {}", kMaxProgramBytes)));
  }
  return write_file(folder / name, bytes);
}

}  // namespace panelcal::internal
