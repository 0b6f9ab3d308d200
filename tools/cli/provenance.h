// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/amount.h"
#include "program/judge/tally.h"
#include "program/walk/walk.h"
#include "tools/cli/options/options.h"

namespace panelcal {

/// The maker and the inputs of an output.
using Provenance = std::vector<std::pair<std::string, std::string>>;

/// The words of the command line, without what changes no output: threads, passwords.
std::pair<std::string, std::string> command_line_row(const Options& options);

/// The origin of an output, to make it again: no dates, a replay is the same to the bit.
/// `files` are other inputs; empty names are left out.
Provenance provenance_of(const Options& options,
                         const Program& program,
                         const std::vector<std::string>& files);

/// Rows of their SHA-256, of those that can be read; empty names are left out.
Provenance file_digests(const std::vector<std::string>& files);

/// The row "ledger head" of a page, as `history verify --against` reads it; none where there is no
/// ledger. One that cannot be read is said, and keeps no page from being written.
Provenance ledger_head_row(const std::filesystem::path& ledger);

/// As given; the user, if none was; "unknown" if the system does not say.
std::string asking_person(const std::string& given);

/// "key: value" for comments.
std::vector<std::string> comment_lines(const Provenance& provenance);

/// "12 holes, 2 slots, 1 rout move".
std::string amount(const Tally& tally);

}  // namespace panelcal
