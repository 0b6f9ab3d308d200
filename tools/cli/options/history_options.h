// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "program/walk/reading_terms.h"
#include "tools/cli/options/facts_files.h"

namespace panelcal {

/// The commands of `panelcal history`.
struct HistoryOptions {
  std::string ledger;
  std::string machine;  ///< these four: empty for all; roll back needs the first three
  std::string kind;
  std::string subject;
  std::string since;  ///< 2026-11-21 or 2026-11-21T08:37:38Z
  std::optional<std::size_t> last;
  std::vector<std::int64_t> ids;   ///< one to show, two to compare
  std::string parameter;           ///< to plot
  std::optional<std::int64_t> to;  ///< entry to go back to; empty: the one before
  std::string reason;
  std::string asked_by;  ///< empty: the user
  std::string output;    ///< of the text; empty: standard output
  FactsFiles facts;
  bool result = false;               ///< show the calibration's own bytes
  std::vector<std::string> against;  ///< verify: files and folders that note the ledger's head
  std::string plate;                 ///< certificate: the plate's file; empty: machine.toml's
  // diff: what a change does to a job.
  std::string program;       ///< empty: only the parameters are compared
  std::string machine_file;  ///< machine.toml; with a program, to verify or to certify
  std::string measurements;  ///< of an earlier job: where in the picture targets were seen
  // push and fleet: a database of many machines.
  std::string store;    ///< its address
  std::string reports;  ///< the folder of the nights; empty: none
  int max_age_h = 36;   ///< of a night that still says something
  std::string clock;    ///< as CheckOptions
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;
};

}  // namespace panelcal
