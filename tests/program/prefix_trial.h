// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "program/walk/walk.h"

namespace panelcal::test {

/// A program that a trial cuts off, with the stored patterns or subprograms that it may call.
struct WholeFile {
  SourceText source;
  std::map<std::string, SourceText, std::less<>> patterns;
};

/// The counts of the prefixes of one or more files, and what is wrong with one of them.
struct PrefixTrial {
  std::size_t n_files = 0;
  std::size_t n_whole = 0;     ///< files that are accepted, some with the option only
  std::size_t n_prefixes = 0;  ///< each read twice: without and with the option
  std::size_t n_as_whole = 0;  ///< accepted without the option: only what follows the end is cut
  std::size_t n_accepted = 0;  ///< accepted with the option only
  std::vector<std::string> complaints;
};

/// Cuts a file off at every byte; of one above `most_prefixes` bytes at all of its last bytes and
/// at as many others, evenly spread and next to line ends.
///
/// A prefix is refused, or accepted without --accept-unterminated with all holes of the file, or
/// with it (Excellon only) with the first holes of the file.
void try_prefixes(const WholeFile& file, std::size_t most_prefixes, PrefixTrial& trial);

}  // namespace panelcal::test
