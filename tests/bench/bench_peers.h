// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace panelcal::bench {

/// Processor time of this process so far: other people's work on the machine counts less in it.
double cpu_s();

/// Runs `work` in a child process without output, and gives its result; nothing if the child fails.
std::optional<double> in_child(const std::function<std::optional<double>()>& work);

/// Peak memory of this process so far, MiB.
std::optional<double> peak_mib();

/// Processor time of reading every number of the text by std::from_chars, and nothing else: letters
/// and line ends are stepped over. Throws if there is no number.
double from_chars_floor_s(std::string_view text);

/// Processor time that libgerbv takes to load a file, in a child; nothing if the library is
/// missing.
std::optional<double> libgerbv_load_s(const std::filesystem::path& file);

/// Processor time of the process `gerbv -x rs274x`; nothing if it is missing, fails or does not
/// write every hole.
std::optional<double> gerbv_rewrite_s(const std::filesystem::path& file,
                                      const std::filesystem::path& output,
                                      std::size_t n_holes);

/// A new folder that goes with its contents. Throws if there can be none.
class TemporaryFolder {
 public:
  TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder();
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace panelcal::bench
