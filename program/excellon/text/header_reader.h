// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/diagnostic.h"
#include "program/excellon/text/format_choice.h"
#include "program/excellon/text/header.h"
#include "program/text/source_text.h"
#include "program/walk/options.h"

namespace panelcal::excellon {

/// Reads the header, or finds that there is none. Header commands directly behind it, or before the
/// first block of a program without one, are read as its own; so is a second header.
///
/// In     reading: the diameter page, and number formats that are stated outside of the program
///        read_patterns: asked only where numbers decide the format
/// Fails  into the log: header-unclosed, header-word-unknown, argument-invalid, not-supported,
///        number-malformed, number-too-long, block-syntax, format-ambiguous; warns
///        header-word-in-body, notation-accepted, format-assumed, format-overridden
/// Source CNC-7 manual, Part Program Headers; Keyboard and Header Commands vs. Body Commands;
///        decision "comment hints" in docs/conventions.md
Header read_header(const SourceText& source,
                   const ReadOptions& reading,
                   DiagnosticLog& log,
                   const PatternTexts& read_patterns = {});

}  // namespace panelcal::excellon
