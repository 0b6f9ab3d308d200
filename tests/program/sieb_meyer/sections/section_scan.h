// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "program/sieb_meyer/sections/sections.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {

/// Sections that scan_sections finds in a text, and its diagnostics.
struct Scan {
  SectionTree tree;
  std::string text;
  std::vector<std::string> diagnostics;

  const Section& operator[](std::size_t i) const { return tree.sections.at(i); }
  /// Text that copies of a section execute.
  std::string body(std::size_t i) const {
    const Section& section = tree.sections.at(i);
    return text.substr(section.begin.offset, section.body_end - section.begin.offset);
  }
};

/// `text` from its first line on.
inline Scan scan(std::string text, const SectionRules& rules = {}) {
  DiagnosticLog log;
  const Reporter reporter("p.ss", log);
  Scan out{scan_sections(text, {}, text.size(), rules, reporter), std::move(text), {}};
  for (const Diagnostic& diagnostic : log.kept()) {
    out.diagnostics.push_back(diagnostic.text());
  }
  EXPECT_EQ(out.tree.is_sound, !log.has_errors());
  return out;
}

/// A text that nothing is wrong with.
inline Scan sound(std::string text, const SectionRules& rules = {}) {
  Scan out = scan(std::move(text), rules);
  EXPECT_THAT(out.diagnostics, testing::IsEmpty()) << out.text;
  return out;
}

/// The text has one error; its place and code as `3:1 section-mixed`; it names `fact`.
inline void expect_refused(std::string text,
                           const std::string& place_and_code,
                           const std::string& fact,
                           const SectionRules& rules = {}) {
  const std::size_t at = place_and_code.find(' ');
  const std::string start =
      "p.ss:" + place_and_code.substr(0, at) + ": error[" + place_and_code.substr(at + 1) + "]";
  const Scan out = scan(std::move(text), rules);
  EXPECT_THAT(out.diagnostics, testing::ElementsAre(test::Reports(start, fact))) << out.text;
}

inline void expect_refused(std::string text,
                           const std::string& place_and_code,
                           const SectionRules& rules = {}) {
  expect_refused(std::move(text), place_and_code, "", rules);
}

}  // namespace panelcal::sieb_meyer
