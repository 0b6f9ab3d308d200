// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "program/walk/walk.h"
#include "program/writers/program_writer.h"

#include "tests/program/random/job_events.h"

namespace panelcal::test {

/// A program as it is executed, every copy at its place.
struct WorkRun {
  std::vector<Event> events;
  std::vector<std::string> errors;
};
WorkRun run_on(MeasurementSource& panel, const std::string& text, const WalkOptions& options = {});
/// On a perfect panel.
WorkRun run_nominally(const std::string& text, const WalkOptions& options = {});

/// A program in the other language, or in its own.
struct Translation {
  std::string text;
  std::vector<std::string> losses;  ///< texts, in order
  std::vector<std::string> errors;  ///< of the walk
  bool is_refused = false;          ///< something that decides places or depths has no form
};
Translation translate(const std::string& text, Dialect to, const WalkOptions& options = {});

/// The language that this program is not in.
Dialect other_language(const std::string& text);

/// A program in format 5000 with tools 1 and 2; lines of the body count from 2.
std::string sieb_meyer(const std::string& body);

/// Events that are left in every translation: holes, slots, contours with the side that they are
/// compensated on. Moves that lead nowhere, and step slots, which SIEB & MEYER has not, are left
/// out.
std::vector<Event> work_of(const std::vector<Event>& events);

/// The first difference of the translation; empty if it does the same work.
std::string difference_of_work(const WorkRun& source, const WorkRun& translation);

}  // namespace panelcal::test
