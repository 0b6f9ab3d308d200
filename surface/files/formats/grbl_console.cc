// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "surface/files/probe_readers.h"
#include "surface/files/text_fields.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// GRBL prints three decimals of a mm and four of an inch; a sum of G54, G92 and TLO is off the
/// WCO of a status report by the rounding of all four.
constexpr double kGrblRounding = 0.0021;
constexpr std::size_t kInchDecimals = 4;

using GrblVector = std::array<double, 3>;

bool is_work_system(std::string_view name) {
  return name.size() >= 3 && name.starts_with("G5") && name[2] >= '4' && name[2] <= '9';
}

/// A value that a console states again and again, such as the work offset.
struct GrblStated {
  GrblVector value{};
  int line = 0;
};

/// Of which only what holds during the probing counts: what was stated last ahead of the first
/// probe, and everything behind it.
class GrblStatements {
 public:
  void state(const std::string& name, const GrblStated& stated, bool is_probing) {
    std::vector<GrblStated>& all = all_[name];
    if (!is_probing) all.clear();
    all.push_back(stated);
  }

  std::optional<GrblStated> find(const std::string& name) const {
    const auto found = all_.find(name);
    return found == all_.end() ? std::nullopt : std::optional(found->second.front());
  }

  /// The work coordinate systems that are stated, and their offsets.
  std::vector<std::pair<std::string, GrblStated>> systems() const {
    std::vector<std::pair<std::string, GrblStated>> out;
    for (const auto& [name, all] : all_) {
      if (is_work_system(name)) out.emplace_back(name, all.front());
    }
    return out;
  }

  /// Fails  measurement-file: a value that changed during the probing
  Expected<void> check_constant(const std::string& file) const {
    for (const auto& [name, all] : all_) {
      for (const GrblStated& other : all) {
        if (other.value == all.front().value) continue;
        return failure(
            {Code::MeasurementFile,
             {file, other.line, 1},
             fmt::format(
                 "{} is {:g},{:g},{:g}", name, other.value[0], other.value[1], other.value[2]),
             fmt::format("that of line {} at all probes: keep the lines of one work zero",
                         all.front().line)});
      }
    }
    return {};
  }

 private:
  std::map<std::string, std::vector<GrblStated>> all_;
};

struct GrblProbe {
  GrblVector place{};
  bool is_touched = false;
  TextField from;
};

GrblVector sum_of(const GrblVector& a, const GrblVector& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

bool is_close(const GrblVector& a, const GrblVector& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > kGrblRounding) return false;
  }
  return true;
}

class GrblConsole {
 public:
  GrblConsole(std::string_view text, const std::string& file, const ProbeFileOptions& options)
      : lines_(text, file), file_(file), options_(options) {}

  Expected<ProbeFile> read() {
    while (true) {
      PANELCAL_TRY(const std::optional<TextField> line, lines_.next_filled());
      if (!line) break;
      PANELCAL_CHECK(read_line(*line));
    }
    PANELCAL_CHECK(offsets_.check_constant(file_));
    return finish();
  }

 private:
  Expected<void> read_line(const TextField& line) {
    PANELCAL_CHECK(read_unit(line));
    PANELCAL_CHECK(note_lost_position(line));
    note_sent_system(line);
    for (std::size_t at = line.text.find_first_of("[<"); at != std::string_view::npos;
         at = line.text.find_first_of("[<", at + 1)) {
      const bool is_status = line.text[at] == '<';
      const std::size_t end = line.text.find(is_status ? '>' : ']', at);
      const TextField record = part_of(line, at + 1, end);
      if (end == std::string_view::npos) {
        if (!record.text.starts_with("PRB:")) continue;
        return failure(unexpected_field(file_, record, "\"]\" behind a probe"));
      }
      PANELCAL_CHECK(is_status ? read_status(record) : read_record(record));
    }
    return {};
  }

  /// `$13=1` of `$$`, or the order to set it.
  Expected<void> read_unit(const TextField& line) {
    const std::size_t at = line.text.find("$13=");
    if (at == std::string_view::npos) return {};
    const TextField value = part_of(line, at + 4, at + 5);
    if (value.text != "0" && value.text != "1") {
      return failure(unexpected_field(file_, value, "0 for mm or 1 for inch"));
    }
    const bool is_inch = value.text == "1";
    if (is_inch_ && *is_inch_ != is_inch) {
      return failure(unexpected_field(
          file_,
          value,
          fmt::format("one unit in all of the file; line {} has the other", unit_line_)));
    }
    is_inch_ = is_inch;
    unit_line_ = line.line;
    return {};
  }

  /// Behind a reset or a limit switch the machine's coordinates are others.
  Expected<void> note_lost_position(const TextField& line) {
    const bool is_start = line.text.find("Grbl") != std::string_view::npos &&
                          line.text.find("'$'") != std::string_view::npos;
    const bool is_alarm = line.text.find("ALARM:1") != std::string_view::npos ||
                          line.text.find("ALARM:3") != std::string_view::npos;
    if ((is_start || is_alarm) && !probes_.empty()) lost_ = line;
    return {};
  }

  /// `G55` of a line that was sent, where the console shows such lines.
  void note_sent_system(const TextField& line) {
    if (line.text.find_first_of("[<") != std::string_view::npos) return;
    for (std::size_t at = line.text.find("G5"); at != std::string_view::npos;
         at = line.text.find("G5", at + 1)) {
      const std::string_view word = line.text.substr(at, 3);
      if (is_work_system(word)) sent_system_ = part_of(line, at, at + 3);
    }
  }

  Expected<std::vector<double>> numbers_of(const TextField& list, std::size_t n_least) const {
    std::vector<double> out;
    const auto cells = cells_of(list);
    if (cells.size() < n_least || cells.size() > 9) {
      return failure(unexpected_field(file_, list, fmt::format("{} numbers or more", n_least)));
    }
    for (const TextField& cell : cells) {
      PANELCAL_TRY(out.emplace_back(), number_of(file_, cell));
    }
    return out;
  }

  Expected<GrblStated> vector_of(const TextField& list) const {
    PANELCAL_TRY(const std::vector<double> numbers, numbers_of(list, 3));
    return GrblStated{{numbers[0], numbers[1], numbers[2]}, list.line};
  }

  Expected<void> read_status(const TextField& record) {
    const std::size_t at = record.text.find("|WCO:");
    if (at == std::string_view::npos) return {};
    const std::size_t end = record.text.find('|', at + 1);
    PANELCAL_TRY(const GrblStated wco, vector_of(part_of(record, at + 5, end)));
    offsets_.state("WCO", wco, !probes_.empty());
    return {};
  }

  Expected<void> read_record(const TextField& record) {
    const std::size_t colon = record.text.find(':');
    if (colon == std::string_view::npos) return {};
    const std::string name(record.text.substr(0, colon));
    const TextField body = part_of(record, colon + 1);
    // `$#` repeats the last probe behind TLO.
    const bool is_listed = std::exchange(is_behind_tlo_, name == "TLO");
    if (name == "PRB") return is_listed ? Expected<void>{} : read_probe(body);
    if (name == "GC") return read_state(body);
    if (name == "TLO") {
      PANELCAL_TRY(const std::vector<double> numbers, numbers_of(body, 1));
      GrblStated tlo{{0, 0, numbers[0]}, body.line};
      if (numbers.size() >= 3) tlo.value = {numbers[0], numbers[1], numbers[2]};
      offsets_.state(name, tlo, !probes_.empty());
    } else if (is_work_system(name) || name == "G92") {
      PANELCAL_TRY(const GrblStated stated, vector_of(body));
      offsets_.state(name, stated, !probes_.empty());
    }
    return {};
  }

  /// [GC:G0 G54 G17 ...]: which work coordinate system is active.
  Expected<void> read_state(const TextField& body) {
    for (const TextField& word : words_of(body)) {
      if (!is_work_system(word.text)) continue;
      if (active_ && active_->text != word.text && !probes_.empty()) {
        return failure(unexpected_field(
            file_,
            word,
            fmt::format("{} at all probes, as in line {}", active_->text, active_->line)));
      }
      active_ = word;
    }
    return {};
  }

  Expected<void> read_probe(const TextField& body) {
    const std::size_t colon = body.text.rfind(':');
    const TextField flag = colon == std::string_view::npos ? part_of(body, body.text.size())
                                                           : part_of(body, colon + 1);
    if (flag.text != "0" && flag.text != "1") {
      return failure(unexpected_field(file_, flag, "1 for a probe that touched, or 0"));
    }
    const TextField list = part_of(body, 0, colon);
    PANELCAL_TRY(const std::vector<double> numbers, numbers_of(list, 3));
    const GrblProbe probe{{numbers[0], numbers[1], numbers[2]}, flag.text == "1", body};
    const bool is_never = !probe.is_touched && probe.place == GrblVector{};
    if (is_never) return {};
    if (lost_) {
      return failure(unexpected_field(
          file_,
          *lost_,
          fmt::format("no reset and no alarm between probes: that of line {} has other coordinates",
                      body.line)));
    }
    const std::vector<double> others(numbers.begin() + 3, numbers.end());
    if (!others_) others_ = others;
    if (others != *others_) {
      return failure(
          unexpected_field(file_, list, "axes behind Z where they were at the first probe"));
    }
    if (probes_.size() == kMaxFileProbes) {
      return failure({Code::MeasurementFile,
                      {file_, body.line, 1},
                      "the console is too long",
                      fmt::format("at most {} probes", kMaxFileProbes)});
    }
    const TextField x = cells_of(list)[0];
    const std::size_t point = x.text.find('.');
    n_decimals_ = point == std::string_view::npos ? 0 : x.text.size() - point - 1;
    probes_.push_back(probe);
    return {};
  }

  Expected<double> find_unit_mm(std::string& text) const {
    const TextField& first = probes_.front().from;
    if (is_inch_) {
      const Length unit = *is_inch_ ? inch(1) : mm(1);
      if (options_.unit && *options_.unit != unit) {
        return failure({Code::MeasurementFile,
                        {file_, unit_line_, 1},
                        fmt::format("$13={}", *is_inch_ ? 1 : 0),
                        "the unit that --unit says, or no --unit"});
      }
      text = fmt::format(
          "{} ($13={}, line {})", *is_inch_ ? "inch" : "mm", *is_inch_ ? 1 : 0, unit_line_);
      return unit.in_mm();
    }
    if (options_.unit || n_decimals_ < kInchDecimals) return options_.unit_mm();
    return failure(unexpected_field(
        file_,
        first,
        "three decimals of mm; of four, as GRBL prints inches, $13 of $$ or --unit says the unit"));
  }

  /// What is taken off the machine's coordinates.
  Expected<GrblVector> find_zero(std::string& text) const {
    const auto wco = offsets_.find("WCO");
    const auto g92 = offsets_.find("G92"), tlo = offsets_.find("TLO");
    const GrblVector shared =
        sum_of(g92 ? g92->value : GrblVector{}, tlo ? tlo->value : GrblVector{});
    std::vector<std::pair<std::string, GrblStated>> systems = offsets_.systems();
    const bool has_systems = !systems.empty();
    std::erase_if(systems, [&](const auto& one) { return active_ && active_->text != one.first; });
    if (has_systems && systems.empty()) {
      return failure(
          unexpected_field(file_, *active_, "a system whose offset the lines of $# state"));
    }
    if (wco) {
      const bool agrees = systems.empty() || std::ranges::any_of(systems, [&](const auto& system) {
                            return is_close(sum_of(system.second.value, shared), wco->value);
                          });
      if (!agrees) {
        return failure(
            {Code::MeasurementFile,
             {file_, wco->line, 1},
             fmt::format("WCO is {:g},{:g},{:g}", wco->value[0], wco->value[1], wco->value[2]),
             fmt::format("{} + G92 + TLO of line {}: keep the lines of one work zero",
                         systems.front().first,
                         systems.front().second.line)});
      }
      text = fmt::format("the work zero, by WCO of line {}", wco->line);
      return wco->value;
    }
    if (systems.empty()) {
      text = "the machine's zero: the console has neither WCO nor $#";
      return GrblVector{};
    }
    if (!active_ && sent_system_ && sent_system_->text != "G54") {
      return failure(
          unexpected_field(file_,
                           *sent_system_,
                           "WCO of a status report, or $G behind it: they say which zero holds"));
    }
    text = fmt::format("the work zero, by {} + G92 + TLO of line {}{}",
                       systems.front().first,
                       systems.front().second.line,
                       active_ ? "" : ", taken as active: the console has no [GC:...]");
    return sum_of(systems.front().second.value, shared);
  }

  Expected<ProbeFile> finish() const {
    ProbeFile out;
    out.format = ProbeFormat::GrblConsole;
    out.file = file_;
    if (probes_.empty()) return out;
    PANELCAL_TRY(const double unit_mm, find_unit_mm(out.unit));
    PANELCAL_TRY(const GrblVector zero, find_zero(out.zero));
    for (const GrblProbe& probe : probes_) {
      const auto place = position_mm<frame::Nominal>((probe.place[0] - zero[0]) * unit_mm,
                                                     (probe.place[1] - zero[1]) * unit_mm);
      std::string name = fmt::format("probe of line {}", probe.from.line);
      const Place from = {file_, probe.from.line, probe.from.column};
      if (probe.is_touched) {
        const Length height = mm((probe.place[2] - zero[2]) * unit_mm);
        out.points.push_back({place, {height, options_.scatter()}, std::move(name), from});
      } else {
        out.missing.push_back({place, std::move(name), "the probe touched nothing", from});
      }
    }
    return out;
  }

  TextLines lines_;
  const std::string& file_;
  const ProbeFileOptions& options_;
  GrblStatements offsets_;
  std::vector<GrblProbe> probes_;
  std::optional<bool> is_inch_;
  int unit_line_ = 0;
  std::optional<TextField> active_;       ///< [GC:...]
  std::optional<TextField> sent_system_;  ///< other than G54 at last, of a line that was sent
  std::optional<TextField> lost_;
  std::optional<std::vector<double>> others_;
  std::size_t n_decimals_ = 0;
  bool is_behind_tlo_ = false;
};

}  // namespace

Expected<ProbeFile> parse_grbl_console(std::string_view text,
                                       const std::string& file,
                                       const ProbeFileOptions& options) {
  return GrblConsole(text, file, options).read();
}

}  // namespace panelcal::internal
