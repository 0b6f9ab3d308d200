// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <sys/types.h>

namespace panelcal {

/// The files that a process reads, or that its machine keeps: no output may replace one of them.
///
/// A file is known by device and inode, so that links and hard links count, and by its place, so
/// that one that does not exist yet counts as well.
///
/// See    tests/machine/files/file_register_test.cc
class FileRegister {
 public:
  /// Notes a file, which need not exist; `-` is what standard input was redirected from. `what` is
  /// its part in the sentence "FILE is ...", such as "the ledger of machine.toml".
  void add(const std::filesystem::path& file, std::string what);

  /// Notes a folder of pictures with everything in it, now and later, and what its links lead to.
  void add_folder(const std::filesystem::path& folder, std::string what);

  /// The use of the file that an output under this name would replace, in words: "the program", "in
  /// the pictures of
  /// --images". Nothing if the name is free.
  std::optional<std::string> use_of(const std::filesystem::path& output) const;

 private:
  struct Identity {
    dev_t device = 0;
    ino_t inode = 0;

    bool operator==(const Identity&) const = default;
  };
  struct Entry {
    std::filesystem::path place;       ///< absolute, without links
    std::optional<Identity> identity;  ///< of what exists
    std::string what;
  };

  static std::optional<Identity> identity_of(const std::filesystem::path& file);
  static Entry entry_of(const std::filesystem::path& file, std::string what);
  static bool holds(const Entry& folder, const Entry& file);

  std::vector<Entry> files_;
  std::vector<Entry> folders_;
};

}  // namespace panelcal
