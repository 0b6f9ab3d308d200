// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/help/help_topics.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <utility>
#include <vector>

#include "calib/base/append_format.h"
#include "calib/base/diagnostic.h"
#include "calib/base/fields/page.h"
#include "calib/json_files.h"
#include "machine/align/json_file.h"
#include "machine/config/json_files.h"
#include "machine/config/machine_file.h"
#include "program/excellon/text/header_words.h"
#include "program/excellon/text/lexer.h"
#include "program/model/recorded.h"
#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/walk/probe_line.h"
#include "surface/json_files.h"
#include "tools/cli/process/exit_code.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string diagnostics_page() {
  std::string out =
      "# Diagnostics\n\n"
      "`FILE:LINE:COLUMN: error|warning[CODE]: SUMMARY: WHAT; expected REMEDY`\n\n"
      "The exit code is that of the worst error; warnings do not change it. After `interrupted` it "
      "is 128 and the signal's number.\n\n"
      "| code | severity | exit | summary | what to do |\n| --- | --- | --- | --- | --- |\n";
  for (const CodeInfo& code : diagnostic_catalogue()) {
    const bool is_error = code.severity == Severity::Error;
    const Diagnostic example{code.code, {}, "", ""};
    internal::append_format(out,
                            "| `{}` | {} | {} | {} | {} |\n",
                            code.slug,
                            is_error ? "error" : "warning",
                            static_cast<int>(exit_code(example)),
                            code.summary,
                            code.advice);
  }
  return out;
}

/// A bar inside a table's cell would end it.
std::string markdown_cell(std::string_view text) {
  std::string safe(text);
  for (auto at = safe.find('|'); at != std::string::npos; at = safe.find('|', at + 2)) {
    safe.insert(at, 1, '\\');
  }
  return safe;
}

void append_row(std::string& out,
                std::string_view form,
                CommandClass command_class,
                std::string_view section,
                std::string_view effect,
                std::string_view test) {
  internal::append_format(out,
                          "| `{}` | {} | {} | {} | `{}` |\n",
                          markdown_cell(form),
                          name(command_class),
                          effect,
                          section,
                          test);
}

/// What becomes of the commands of a table.
struct Treated {
  std::size_t n_working = 0;
  std::size_t n_passed_on = 0;
  std::size_t n_refused = 0;

  Treated& operator+=(const Treated& other) {
    n_working += other.n_working;
    n_passed_on += other.n_passed_on;
    n_refused += other.n_refused;
    return *this;
  }
};

/// Of a table without a column for it: what the machine alone has to do with begins with "Passed
/// on".
template <class Row>
Treated treated(std::span<const Row> rows) {
  const auto n_passed_on = static_cast<std::size_t>(std::ranges::count_if(
      rows, [](const Row& row) { return std::string_view(row.effect).starts_with("Passed on"); }));
  return {.n_working = rows.size() - n_passed_on, .n_passed_on = n_passed_on};
}

void append_counts(std::string& out,
                   std::initializer_list<std::pair<std::string_view, Treated>> tables) {
  out +=
      "\n## Counts\n\n"
      "Of the rows above. *works*: panelcal acts on it; *passed on*: the machine has it to do, "
      "since it changes no coordinate; *refused*: an error, for the reason in its row.\n\n"
      "| table | rows | works | passed on | refused |\n| --- | --- | --- | --- | --- |\n";
  const auto append = [&](std::string_view table, const Treated& rows) {
    internal::append_format(out,
                            "| {} | {} | {} | {} | {} |\n",
                            table,
                            rows.n_working + rows.n_passed_on + rows.n_refused,
                            rows.n_working,
                            rows.n_passed_on,
                            rows.n_refused);
  };
  Treated all;
  for (const auto& [table, rows] : tables) {
    append(table, rows);
    all += rows;
  }
  append("all", all);
}

void append_excellon_counts(std::string& out) {
  Treated body = treated(excellon::command_table());
  body += treated(excellon::word_table());
  const std::vector<excellon::HeaderWordInfo> words = excellon::header_word_table();
  const auto n_of = [&](std::string_view kind) {
    return static_cast<std::size_t>(
        std::ranges::count(words, kind, &excellon::HeaderWordInfo::kind));
  };
  const Treated header{n_of("handled"), n_of("passed"), n_of("refused")};
  const Treated format_one{.n_working = excellon::format_one_table().size()};
  append_counts(out, {{"Body", body}, {"Header", header}, {"Format One", format_one}});
}

constexpr std::string_view kExcellonHead =
    "# Excellon commands\n\n"
    "Every command of the CNC-7 manual, what panelcal does with it, and the file in "
    "tests/program "
    "that shows it. Nothing is skipped: a command that is not listed here is an error.\n\n"
    "A file ends with M30 or M00 (Format One: M30 or M02); alone at the end of the last line "
    "they need no line end. A file without its end may have been cut off and is an error "
    "(`end-missing`). `--accept-unterminated` accepts one that stops behind a complete line "
    "and outside of headers, patterns, cycles and contours; the output says so. A format that "
    "its "
    "numbers alone would decide is refused then (`format-ambiguous`). The file of a "
    "stored pattern has no such mark: its last line must be complete.\n\n"
    "A text without any line that a program may have is no drill program (`not-a-program`).\n\n"
    "What a program leaves open of its number format is taken from `--format`, `nc_param.txt` "
    "beside it or `[program]` of machine.toml, or its numbers decide; where they can be meant in "
    "two ways it is refused (`format-ambiguous`).\n\n"
    "## Notation\n\n"
    "Notation that the manual does not have is accepted where it has one reading only, with one "
    "warning for each kind (`notation-accepted`):\n\n"
    "- small letters, `x1y2`; texts of M45, M47 and M97 to M99 stay as they are\n"
    "- block numbers, `N10X1Y2`\n"
    "- comments in brackets, or behind `;` at the end of a block; not one that states a number "
    "format, "
    "which would be lost\n"
    "- NUL characters before and behind the program\n"
    "- blanks in header commands, `METRIC, TZ`\n"
    "- more digits than the format has, if the first ones are zeros, numbers count from the "
    "right "
    "(TZ), and METRIC or a CAM comment states the digits\n"
    "- M02 blocks with X or Y whose count no M02 alone ends before the next ones, which count "
    "from "
    "their own pattern; those of R#M02 end by themselves\n"
    "- two blocks in a line: `T1M06`, `T1X#Y#`, `G05X#Y#` and `X#Y#M30`\n\n"
    "Header commands may stand behind the header, or before the first block of a program without "
    "one; those that are passed on, ICI, and INCH and METRIC before the first coordinate, also "
    "in "
    "the body outside of patterns (`header-word-in-body`). Repeating the header's option is no "
    "harm; another one, which the control would not use, is an error. A second header is read "
    "with the first one. A comment in the body that states other digits than those in force is "
    "an "
    "error.\n\n"
    "## Body\n\n"
    "| command | class | what it does | manual section | test |\n"
    "| --- | --- | --- | --- | --- |\n";

std::string excellon_page() {
  std::string out(kExcellonHead);
  for (const excellon::CommandInfo& command : excellon::command_table()) {
    const std::string code = excellon::code_text(command.command);
    std::string form(command.operands);
    if (form.find(code) == std::string::npos) form = code + form;
    append_row(out, form, command.command_class, command.section, command.effect, command.test);
  }
  for (const excellon::WordInfo& word : excellon::word_table()) {
    append_row(out, word.form, word.command_class, word.section, word.effect, word.test);
  }
  out +=
      "\n## Header\n\n"
      "Besides `T#...`, `#/#/#`, `/` and comments, which are as in the body. *passed*: given to "
      "the "
      "machine in order; tests: `header_test`.\n\n"
      "| word | class | what it does | |\n| --- | --- | --- | --- |\n";
  for (const excellon::HeaderWordInfo& word : excellon::header_word_table()) {
    internal::append_format(out,
                            "| `{}` | {} | {} | {} |\n",
                            word.word,
                            name(word.command_class),
                            word.effect,
                            word.kind);
  }
  out +=
      "\n## Format One\n\n"
      "After FMAT,1 these codes mean others; a Format Two code on the right is then an error.\n\n"
      "| Format One | means |\n| --- | --- |\n";
  for (const excellon::FormatOneInfo& row : excellon::format_one_table()) {
    internal::append_format(
        out, "| `{}{:02}` | `{}` |\n", row.letter, row.number, excellon::code_text(row.command));
  }
  append_excellon_counts(out);
  return out;
}

/// "135" as "1000 3000 5000".
std::string format_names(std::string_view first_digits) {
  std::string out;
  for (const char digit : first_digits)
    out += fmt::format("{}{}000", out.empty() ? "" : " ", digit);
  return out;
}

/// The code behind the coordinate where the manual writes it: `X#Y#G1`.
std::string sieb_meyer_form(const sieb_meyer::CommandInfo& command) {
  const std::string code = sieb_meyer::code_text(command.command);
  const std::string_view operands = command.operands;
  if (operands.find(code) != std::string_view::npos) return std::string(operands);
  for (const std::string_view place : {"X#Y#", "(X#Y#)"}) {
    if (!operands.starts_with(place)) continue;
    return std::string(place) + code + std::string(operands.substr(place.size()));
  }
  return code + (operands.starts_with("with") ? " " : "") + std::string(operands);
}

template <class Row>
void append_sieb_meyer_row(std::string& out, std::string_view form, const Row& row) {
  internal::append_format(out,
                          "| `{}` | {} | {} | {} | {} | `{}` |\n",
                          markdown_cell(form),
                          name(row.command_class),
                          row.effect,
                          format_names(row.formats),
                          row.section,
                          row.test);
}

void append_sieb_meyer_counts(std::string& out) {
  Treated lines = treated(sieb_meyer::command_table());
  lines += treated(sieb_meyer::word_table());
  using sieb_meyer::Treatment;
  const auto n_of = [](Treatment treatment) {
    return static_cast<std::size_t>(
        std::ranges::count(sieb_meyer::cnc_table(), treatment, &sieb_meyer::CncInfo::treatment));
  };
  const Treated cnc{n_of(Treatment::Obeyed), n_of(Treatment::Passed), n_of(Treatment::Refused)};
  append_counts(out, {{"Program lines", lines}, {"CNC commands", cnc}});
}

std::string sieb_meyer_page() {
  std::string out =
      "# SIEB & MEYER commands\n\n"
      "Every command of the CNC 8x.00 Command Set (table B), what panelcal does with it, the "
      "formats "
      "that have it, and the file in tests/program/sieb_meyer that shows it. Nothing is skipped: "
      "what is not listed here, or not in the program's format, is an error.\n\n"
      "A file ends with its tool table: the second `$`, in format 1000 the 91st. A file without "
      "it may have been cut off and is an error (`end-missing`, `tool-table-invalid`), with "
      "`--accept-unterminated` too. A subprogram has no such mark: its last line must be "
      "complete.\n\n"
      "Output in this language states what a control would keep from the program before: axis "
      "version (`M49,FV#`), how slots are nibbled (`M49,NONIBO` and `M49,NIB0.013`, until the "
      "source "
      "says otherwise), no rotation and no scale (`M49,NORA`, `M49,NOSA`: both are in the "
      "coordinates), and the tool data that the source has. Program zero is the operator's unless "
      "the source has FA or NOFA. Each row below is in the output, executed before, or named as "
      "lost (`written_form_test`).\n\n"
      "The digits behind %% state the number format: 1000, 3000 and 5000 are in millimetres. `%%` "
      "alone leaves the numbers to the control's setting (FP; `[program]` units, zeros and digits "
      "of machine.toml, if all three are there), and so do the formats xx01 to xx10, which have to "
      "have a unit, zeros and digits there or in `--format`. `--format inch,tz,2.4` rules over "
      "all. In inch every length is in inch, those of M49 have a point, and `[program] rates` "
      "states the unit of F and R (`inch_test`).\n\n"
      "## Program lines\n\n"
      "| command | class | what it does | formats | manual section | test |\n"
      "| --- | --- | --- | --- | --- | --- |\n";
  for (const sieb_meyer::CommandInfo& command : sieb_meyer::command_table()) {
    append_sieb_meyer_row(out, sieb_meyer_form(command), command);
  }
  for (const sieb_meyer::WordInfo& word : sieb_meyer::word_table()) {
    append_sieb_meyer_row(out, word.form, word);
  }
  out +=
      "\n## CNC commands\n\n"
      "What M49 gives to the control. *obeyed*: panelcal acts on it; *passed on*: given to the "
      "machine "
      "in order, since it changes no coordinate; *refused*: an error, since it would change where "
      "the tool goes in a way that the manual does not describe. Any other command is passed on "
      "with a warning; `M49,M#` is the machine function M#. Test: `cnc_commands_test`.\n\n"
      "| M49, | treatment | what it does |\n| --- | --- | --- |\n";
  for (const sieb_meyer::CncInfo& command : sieb_meyer::cnc_table()) {
    internal::append_format(out,
                            "| `{}` | {} | {} |\n",
                            command.name,
                            sieb_meyer::name(command.treatment),
                            command.effect);
  }
  append_sieb_meyer_counts(out);
  return out;
}

std::string machine_toml_page() {
  return "# machine.toml\n\n"
         "One file describes a machine; `datasets/demo/machine.toml` is a commented example. "
         "Unknown "
         "keys are errors that name the nearest known one, and keys that tables lack are named for "
         "all tables at once. Names of files count from the file that has them. Numbers are "
         "finite; a key's end is its unit.\n\n"
         "`panelcal check -m machine.toml` validates it, and holds it against itself: what "
         "[coupon] "
         "promises, the mark, the plate and the surface rectangle within travel, and all that the "
         "calibrations of [nightly] need; with a PROGRAM its vision tools and the places that the "
         "camera has to reach. It refuses keys that contradict each other: holes of the coupon "
         "that "
         "overlap, more `min_holes` than a night drills, a mark or a place of "
         "`[nightly.surface]` among the coupon's rows, files of nights that are another's "
         "(`[nightly.surface] file`, "
         "`[nightly.table] file`, `reports`), vision tools larger than the picture or below 6 px, "
         "a "
         "`search_radius_mm` below a pixel, and, without a PROGRAM, a stated `rotate` that is too "
         "small for `model`.\n\n"
         "This page is `panelcal help machine.toml`. Editors that know JSON Schema complete and "
         "check the file by `share/schema/machine.schema.json`, which is `panelcal help "
         "machine.schema.json`.\n" +
         internal::page_of(internal::machine_file());
}

std::vector<internal::JsonFile> json_files() {
  return {internal::camera_file(),
          internal::spindle_file(),
          internal::table_file(),
          internal::alignment_file(),
          internal::surface_map_file(),
          internal::measurements_file(),
          internal::calibrations_file(),
          internal::probes_file(),
          internal::plate_looks_file(),
          internal::ledger_entry_file(),
          internal::coupon_file(),
          internal::truth_file(),
          internal::sample_truth_file()};
}

std::string json_files_page() {
  std::string out =
      "# JSON files\n\n"
      "All keys are required but those that may be absent, and no other is allowed: an unknown key "
      "is an error that names the nearest known one. Numbers are finite and are written in the "
      "fewest digits that read back exactly; a key's end is its unit, and where it has none, "
      "`units` says it. Keys of objects in objects stand behind a dot, those of lists of objects "
      "behind `[]`.\n\n"
      "This page is `panelcal help json-files`. Each file has a JSON Schema in `share/schema/`, "
      "which `panelcal help camera.cal.schema.json` and so on prints.\n";
  for (const internal::JsonFile& file : json_files()) out += internal::page_of(file);
  return out;
}

/// The schema of "camera.cal.json" for the topic "camera.cal.schema.json".
std::optional<std::string> json_schema(std::string_view topic) {
  constexpr std::string_view kEnd = ".schema.json";
  if (!topic.ends_with(kEnd)) return std::nullopt;
  topic.remove_suffix(kEnd.size());
  for (const internal::JsonFile& file : json_files()) {
    if (file.name.substr(0, file.name.rfind('.')) == topic) return internal::schema_of(file);
  }
  return std::nullopt;
}

}  // namespace

std::span<const HelpTopic> help_topics() {
  static constexpr auto kTopics = std::to_array<HelpTopic>({
      {"completion.bash", "Completion of words in bash: eval \"$(panelcal help completion.bash)\""},
      {"completion.fish", "Completion of words in fish: panelcal help completion.fish | source"},
      {"completion.zsh", "Completion of words in zsh: source <(panelcal help completion.zsh)"},
      {"diagnostics", "Every error and warning, with its cause and its remedy"},
      {"excellon", "Every command of Excellon programs, and what panelcal does with it"},
      {"json-files", "The JSON files that panelcal reads, key by key"},
      {"machine.schema.json",
       "JSON Schema of machine.toml; each JSON file has one, see json-files"},
      {"machine.toml", "Every key of the machine file, with its unit, range and default"},
      {"panelcal.1", "Manual page in the language of man(7); each command has one: panelcal-run.1"},
      {"sieb-meyer", "Every command of SIEB & MEYER programs, and what panelcal does with it"},
      {"topics", "This list"},
  });
  return kTopics;
}

std::optional<std::string> help_topic(std::string_view topic) {
  if (topic == "diagnostics") return diagnostics_page();
  if (topic == "excellon") return excellon_page();
  if (topic == "sieb-meyer") return sieb_meyer_page();
  if (topic == "machine.toml") return machine_toml_page();
  if (topic == "machine.schema.json") return internal::schema_of(internal::machine_file());
  if (topic == "json-files") return json_files_page();
  return json_schema(topic);
}

}  // namespace panelcal
