// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "machine/files/file_register.h"

namespace panelcal {

/// Notes machine.toml and every file that it names: ledger, coupon's state, calibrations, plates,
/// tables, templates, programs of commands, folders of its cameras.
///
/// Every text of machine.toml that names an existing file, beside it or here, counts, whatever its
/// key: a key that is new is protected too. A machine.toml that is not valid has files to protect
/// all the same, since a night that fails still writes its report.
///
/// In     except: the key of what this process puts in force, such as "table.calibration"; empty:
///        none
/// See    tests/machine/files/machine_files_test.cc
void add_machine_files(const std::filesystem::path& machine_toml,
                       FileRegister& files,
                       std::string_view except = {});

/// True for a file named as a night's record, `2026-11-21.json` or `2026-11-21-2.html`, but for a
/// page whose heading is another's: a job's report may be named by its day.
bool is_night_record(const std::filesystem::path& file);

/// Notes the records of nights in the folder of reports, `2026-11-21.json` or `2026-11-21-2.html`:
/// `history verify -m` holds the ledger against them.
///
/// In     except: a night, "2026-11-21", whose records may be replaced; empty: none
void add_night_records(const std::filesystem::path& reports,
                       FileRegister& files,
                       std::string_view except = {});

/// Notes a ledger with its lock and what SQLite puts beside it.
void add_ledger(const std::filesystem::path& ledger, const std::string& what, FileRegister& files);

/// Notes what a camera's address names: folder:DIR, video:FILE, v4l2:DEVICE.
void add_camera(std::string_view address, const std::string& what, FileRegister& files);

}  // namespace panelcal
