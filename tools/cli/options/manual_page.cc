// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/options/manual_page.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <utility>

#include "calib/base/append_format.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal {
namespace {

using internal::append_format;

/// Text that man(7) prints as it is, within a line.
std::string plain(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else {
      // man(7) prints typographic signs for these, which a shell does not take.
      constexpr std::string_view kSigns = "-'^`~";
      constexpr std::array<std::string_view, 5> kNames = {
          "\\-", "\\(aq", "\\(ha", "\\(ga", "\\(ti"};
      const auto at = kSigns.find(c);
      if (at == kSigns.npos) {
        out += c;
      } else {
        out += kNames[at];
      }
    }
  }
  return out;
}

/// A whole line: a full stop at its beginning would be an order.
std::string plain_line(std::string_view text) {
  return (text.starts_with('.') ? "\\&" : "") + plain(text);
}

/// "panelcal surface fit", "panelcal-surface-fit".
std::string full_name(const CommandHelp& command, char between) {
  std::string name = command.name.empty() ? "panelcal" : "panelcal " + command.name;
  std::ranges::replace(name, ' ', between);
  return name;
}

/// Paragraphs as they are; lines that begin with a blank keep their form.
void append_text(std::string_view text, std::string& out) {
  bool is_verbatim = false, is_new_paragraph = false;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) {
      is_new_paragraph = true;
      continue;
    }
    const bool was_verbatim = std::exchange(is_verbatim, line.starts_with(' '));
    if (is_verbatim && !was_verbatim) out += ".RS\n.EX\n";
    if (!is_verbatim && was_verbatim) out += ".EE\n.RE\n";
    if (is_verbatim && was_verbatim && is_new_paragraph) out += "\\&\n";
    if (!is_verbatim && (was_verbatim || is_new_paragraph)) out += ".PP\n";
    out += plain_line(is_verbatim ? line.substr(2) : line) + '\n';
    is_new_paragraph = false;
  }
  if (is_verbatim) out += ".EE\n.RE\n";
}

/// The examples that a page begins with, and what follows them.
struct SplitPage {
  std::string_view examples;
  std::string_view description;
};

SplitPage split(std::string_view page) {
  const std::string_view heading = page.substr(0, std::min(page.find('\n'), page.size()));
  if (heading != "Example" && heading != "Examples") return {"", page};
  page.remove_prefix(heading.size());
  auto end = page.find("\n\n");
  while (end != page.npos && page.substr(end + 2).starts_with(' '))
    end = page.find("\n\n", end + 2);
  if (end == page.npos) return {page, ""};
  return {page.substr(1, end), page.substr(end + 2)};
}

void append_option(const OptionHelp& option, std::string& out) {
  out += ".TP\n";
  std::string names;
  for (const std::string& name : option.names) {
    append_format(names, "{}\\fB{}\\fR", names.empty() ? "" : ", ", plain(name));
  }
  if (!option.value.empty()) {
    append_format(names, "{}\\fI{}\\fR", names.empty() ? "" : " ", plain(option.value));
  }
  out += names + '\n';
  std::string help = plain_line(option.help);
  if (!option.choices.empty()) {
    append_format(help, "; one of {}", plain(fmt::format("{}", fmt::join(option.choices, ", "))));
  }
  if (option.is_required) help += " (required)";
  out += help + '\n';
}

void append_synopsis(const CommandHelp& command, std::string& out) {
  append_format(out, ".SH SYNOPSIS\n\\fB{}\\fR", plain(full_name(command, ' ')));
  if (!command.below.empty()) out += " \\fICOMMAND\\fR";
  out += " [\\fIOPTIONS\\fR]";
  for (const OptionHelp& option : command.options) {
    if (!option.names.empty()) continue;
    const std::string value = "\\fI" + plain(option.value) + "\\fR";
    out += option.is_required ? ' ' + value : " [" + value + ']';
  }
  out += '\n';
}

/// The page of the command above and those of the commands below it.
void append_see_also(const CommandHelp& command, std::string& out) {
  std::string pages;
  const auto add = [&](const std::string& name) {
    append_format(pages, "{}\\fB{}\\fR(1)", pages.empty() ? "" : ", ", plain(name));
  };
  const std::string own = full_name(command, '-');
  if (!command.name.empty()) add(own.substr(0, own.rfind('-')));
  for (const std::string& below : command.below) add(own + '-' + below);
  out += ".SH SEE ALSO\n" + pages + '\n';
}

}  // namespace

std::string manual_page_name(const CommandHelp& command) {
  return full_name(command, '-') + ".1";
}

std::string manual_page(const CommandHelp& command, const std::string& version) {
  const std::string name = full_name(command, '-');
  std::string title = name;
  std::ranges::transform(title, title.begin(), [](unsigned char c) { return std::toupper(c); });
  std::string out = fmt::format(".TH {} 1 \"\" \"panelcal {}\" \"panelcal\"\n.SH NAME\n{} \\- {}\n",
                                plain(title),
                                version,
                                plain(name),
                                plain(command.summary));
  append_synopsis(command, out);
  const SplitPage page = split(command.page);
  if (!page.description.empty()) {
    out += ".SH DESCRIPTION\n";
    append_text(page.description, out);
  }
  if (!command.options.empty()) {
    out += ".SH OPTIONS\n";
    for (const OptionHelp& option : command.options) append_option(option, out);
  }
  if (!page.examples.empty()) {
    out += ".SH EXAMPLES\n";
    append_text(page.examples, out);
  }
  append_see_also(command, out);
  return out;
}

}  // namespace panelcal
