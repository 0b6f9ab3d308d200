// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

#include "tools/cli/commands.h"
#include "tools/cli/options/facts_files.h"
#include "tools/page/page.h"

namespace panelcal {

/// Writes the facts of a command where its command line wants them: as JSON, and as a page that
/// shows the same. What cannot be written is printed, and takes neither the other file nor the
/// result in words away.
///
/// In     title: of the page; document: makes the facts, as facts::text() writes them, if any are
///        wanted; answer: the result in words
/// Out    the answer, without its text if standard output has the facts, and with the exit code of
///        what could not be written
Answer state_facts(CommandContext& context,
                   const FactsFiles& files,
                   const std::string& title,
                   const std::function<std::string()>& document,
                   Answer answer = {},
                   const PagePictures& pictures = {});

}  // namespace panelcal
