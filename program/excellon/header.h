// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/program/number_format.h"
#include "panelcal/program/operation.h"
#include "panelcal/program/source_text.h"

namespace panelcal::excellon {

/// A machine setting of the header, passed on in order.
struct HeaderSetting {
  int line = 0;
  std::string text;
};

/// What a program says before its body.
struct Header {
  NumberFormat format;
  bool states_format = false;   ///< unit known from the header or a CAM comment
  bool states_digits = false;   ///< digit counts from a CAM comment, whatever the unit
  std::string format_evidence;  ///< which line says so, for people
  std::map<int, Tool> tools;
  std::vector<HeaderSetting> settings;
  bool incremental = false;     ///< ICI,ON
  bool deletes_blocks = false;  ///< BLKD: blocks that begin with / are not executed
  LinePlace body;               ///< the first line behind the header
};

/// Reads the header, or finds that there is none.
///
/// Fails  into the log: header-unclosed, header-word-unknown, argument-invalid, not-supported,
///        number-malformed, number-too-long, block-syntax
/// Source CNC-7 manual, Part Program Headers; decision "comment hints" in docs/conventions.md
Header read_header(const SourceText& source, DiagnosticLog& log);

}  // namespace panelcal::excellon
