// SPDX-License-Identifier: Apache-2.0
#include "tests/program/random/random_job.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

namespace panelcal::test {
namespace {

/// Of the whole range in every case; RapidCheck's own ranges grow with the number of cases.
int any(int low, int high) {
  return *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(low, high + 1));
}

/// Shrinks to false.
bool one_in(int n) {
  return any(1, n) == n;
}

/// Shrinks to zero.
int any_either_way(int most) {
  const int n = any(0, 2 * most);
  return n % 2 == 0 ? n / 2 : -(n + 1) / 2;
}

template <std::size_t N>
std::string any_of(const std::array<const char*, N>& words) {
  return words[static_cast<std::size_t>(any(0, static_cast<int>(N) - 1))];
}

Token length(const char* letter, long steps) {
  return {letter, steps, any(0, 15)};
}

struct Point {
  long x = 0;
  long y = 0;
};

Point any_place(int most = 20000) {
  // Round numbers lose most digits where zeros are left off.
  const int grid = most >= 1000 && one_in(3) ? 1000 : 1;
  const int x = any_either_way(most / grid) * grid;
  return {x, any_either_way(most / grid) * grid};
}

constexpr NumberFormat kInch = {.unit = LengthUnit::Inch};
constexpr NumberFormat kMetric = {
    .unit = LengthUnit::Millimeter, .integer_digits = 3, .decimal_digits = 3};

Job any_frame() {
  constexpr auto metric = [](int integer_digits, int decimal_digits) {
    return NumberFormat{.unit = LengthUnit::Millimeter,
                        .integer_digits = integer_digits,
                        .decimal_digits = decimal_digits};
  };
  const std::array<NumberFormat, 6> formats = {
      kInch, kInch, kMetric, kMetric, metric(4, 2), metric(3, 2)};
  Job job;
  job.header_format = formats[static_cast<std::size_t>(any(0, 5))];
  job.format = job.header_format;
  if (kUnitOfTheBody && job.format.decimal_digits > 2 && one_in(5)) {
    const bool is_inch = job.format.unit == LengthUnit::Inch;
    job.format = is_inch ? kMetric : kInch;
    job.preamble.push_back({{is_inch ? "M71" : "M72"}});
  }
  const bool is_inch = job.header_format.unit == LengthUnit::Inch;
  job.header.push_back("VER," + std::to_string(any(1, 8)));
  if (one_in(4)) job.header.emplace_back("OM48,ON");
  if (one_in(4)) job.header.emplace_back("ICI,ON");
  for (const char* index : {"1", "3"}) {
    if (one_in(2)) job.header.push_back(std::string("CP,") + index + (is_inch ? ",.05" : ",1.27"));
  }
  const std::array<const char*, 3> rates = {"", is_inch ? "F090S45" : "F040S45", "B0300"};
  job.header.push_back(std::string("T1C") + (is_inch ? ".04" : "1.0") + any_of(rates));
  job.header.push_back(std::string("T2C") + (is_inch ? ".0315" : "0.8") + any_of(rates));
  job.header.push_back(std::string("T3C") + (is_inch ? ".1" : "2.5") + (one_in(3) ? "H20" : ""));
  if (one_in(4)) job.header.emplace_back("3/2");
  if (one_in(4)) job.header.emplace_back("CAN_TEXT_OFF,.1,.2");
  job.header_end = one_in(2) ? "%" : "M95";
  if (one_in(4)) job.preamble.push_back({{"G93"}, length("X", any(0, 9999)), length("Y", 500)});
  return job;
}

/// Writes lines, and keeps to the rules that panelcal holds programs to.
class JobWriter {
 public:
  explicit JobWriter(Job frame, bool is_bold = false) : job_(std::move(frame)), is_bold_(is_bold) {
    incremental_ = std::ranges::find(job_.header, "ICI,ON") != job_.header.end();
    // A written program is read with the header's rounding.
    if (job_.format.unit != job_.header_format.unit) n_arc_steps_ = 4;
  }

  Job write() {
    line({{"T1"}});
    full_hole();
    for (int n = any(1, 6); n > 0; --n) one_in(4) ? section() : piece();
    line({{one_in(3) ? "M00" : "M30"}});
    return std::move(job_);
  }

  RoutedPattern write_routed() {
    RoutedPattern out;
    line({{"T1"}});
    if (incremental_) line({{"G90"}});
    incremental_ = false;
    std::swap(head_, job_.body);
    for (int n = any(1, 3); n > 0; --n) contour();
    const std::vector<TokenLine> pattern = job_.body;
    out.job = out.repeated = job_;
    out.job.body = head_;
    out.job.body.insert(out.job.body.end(), pattern.begin(), pattern.end());
    out.job.body.push_back({{"M30"}});
    job_.body = head_;
    line({{"M25"}});
    job_.body.insert(job_.body.end(), pattern.begin(), pattern.end());
    for (int n = any(1, 3); n > 0; --n) {
      out.levels.emplace_back();
      line({{"M01"}});
      restarts_ = true;
      for (int n_runs = any(0, 3); n_runs > 0; --n_runs) copies(&out.levels.back(), false);
    }
    line({{"M08"}});
    line({{"M30"}});
    out.repeated.body = job_.body;
    return out;
  }

 private:
  void line(TokenLine words) { job_.body.push_back(std::move(words)); }

  long steps(double mm_length) const { return std::lround(mm_length / job_.step().in_mm()); }

  /// X and Y that lead to a place, as the modes ask for them; at least one of them.
  TokenLine go_to(Point place) {
    const bool is_bound = must_name_both_ && !incremental_;
    TokenLine words;
    const auto axis = [&](const char* letter, long from, long to, bool is_last) {
      const bool is_needed = from != to || is_bound || (is_last && words.empty());
      if (is_needed || one_in(2)) words.push_back(length(letter, incremental_ ? to - from : to));
    };
    axis("X", at_.x, place.x, false);
    axis("Y", at_.y, place.y, true);
    at_ = place;
    must_name_both_ = false;
    return words;
  }

  TokenLine with(TokenLine words, const TokenLine& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  void full_hole() {
    if (incremental_) line({{"G90"}});
    incremental_ = false;
    must_name_both_ = true;
    hole();
  }

  void piece() {
    if (must_name_both_ && !incremental_) return one_in(2) ? hole() : contour();
    switch (any(0, 11)) {
      case 0:
      case 1:
      case 2:
        return contour();
      case 3:
        return cycle();
      case 4:
        return one_in(2) ? routed_circle() : step_slot();
      case 5:
        return text();
      case 6:
        return event();
      case 7:
        return tool();
      case 8:
        return repeat();
      case 9:
        incremental_ = !incremental_;
        return line({{incremental_ ? "G91" : "G90"}});
      default:
        return hole();
    }
  }

  // --- drilling ---

  void drill_mode() {
    if (!std::exchange(is_routing_, false)) return;
    line({{"G05"}});
    if (one_in(3)) infeed();
  }

  void hole() {
    drill_mode();
    for (int n = any(1, 3); n > 0; --n) line(go_to(any_place()));
    has_hole_ = true;
  }

  void repeat() {
    const Point step = any_place(3000);
    const int n = any(1, 4);
    if (has_cycle_ && one_in(2)) {
      line({{"P" + std::to_string(n)}, length("X", step.x), length("Y", step.y)});
    } else {
      if (!has_hole_ || is_routing_) hole();
      line({{"R" + std::to_string(n)}, length("X", step.x), length("Y", step.y)});
    }
    at_ = {at_.x + n * step.x, at_.y + n * step.y};
  }

  void end_hole() {
    has_hole_ = false;
    has_cycle_ = true;
    is_routing_ = false;
  }

  void cycle() {
    const Point a = any_place();
    switch (any(0, 3)) {
      case 0: {
        const long pitch = any(300, 900);
        const long row = any(300, 900);
        long n = any(1, 5);
        if (std::labs(n * pitch - row) < 3) ++n;  // no square
        line({{one_in(2) ? "G82" : "G81"}, length("X", pitch), length("Y", row)});
        line(go_to(a));
        const bool along_x = one_in(2);
        line(
            go_to(along_x ? Point{a.x - n * pitch, a.y + row} : Point{a.x + row, a.y + n * pitch}));
        break;
      }
      case 1:
        line({{"G83"}});
        line(go_to(a));
        line(go_to(one_in(2) ? Point{a.x + any(100, 900), a.y} : Point{a.x, a.y - any(100, 900)}));
        break;
      case 2:
        line(with(go_to(a), {{"G84"}, length("X", steps(any(is_bold_ ? 250 : 510, 900) * 0.01))}));
        break;
      default: {
        TokenLine start = go_to(a);
        const Point end = {a.x + steps(any_either_way(50) * 0.1),
                           a.y + steps(any_either_way(50) * 0.1)};
        start.push_back({"G85"});
        line(with(std::move(start), go_to(end)));
        break;
      }
    }
    end_hole();
  }

  void text() {
    const std::array<const char*, 4> words = {"A", "1,-", "X/7", "+"};
    line({{(one_in(2) ? "M97," : "M98,") + any_of(words)}});
    line(go_to(any_place()));
    end_hole();
    has_cycle_ = false;
  }

  // --- routing ---

  void begin_routing() {
    is_routing_ = has_routed_ = true;
    has_hole_ = has_cycle_ = false;
  }

  void contour() {
    line(with({{"G00"}}, go_to(any_place())));
    begin_routing();
    if (one_in(4)) line(go_to(any_place()));
    if (one_in(3)) line({{one_in(2) ? "G41" : "G42"}});
    if (one_in(8)) line({{"G40"}});
    line({{one_in(3) ? "M14" : "M15"}});
    move_.clear();
    for (int n = any(1, 4); n > 0; --n) {
      const int kind = any(0, 3);
      kind == 0 ? straight() : kind == 3 ? arc_about_center() : arc_of_radius();
      if (one_in(5)) line({{any_of(kTableFeeds)}});
    }
    line({{one_in(2) ? "M16" : "M17"}});
  }

  void rout(const std::string& move, TokenLine place, TokenLine more) {
    TokenLine words;
    if (move != move_ || one_in(2)) words.push_back({move});
    if (words.empty() || !one_in(6)) {
      words = with(std::move(words), place);
    } else {
      line(std::exchange(words, std::move(place)));  // the code in a block of its own
    }
    move_ = move;
    words = with(std::move(words), more);
    if (one_in(6)) words.push_back({any_of(kTableFeeds)});
    line(std::move(words));
  }

  void straight() { rout("G01", go_to(any_place()), {}); }

  void arc_of_radius() {
    Point chord;
    const int most = one_in(4) ? 12 : 3000;
    while (std::hypot(chord.x, chord.y) < n_arc_steps_ * kShortestChord_steps)
      chord = any_place(most);
    const auto least = static_cast<long>(std::ceil(std::hypot(chord.x, chord.y) / 2));
    TokenLine radius;
    if (!radius_ || *radius_ < least || one_in(2)) {
      radius_ = least + (one_in(4) ? any(0, 2) : any(0, 3000));
      if (one_in(10)) *radius_ = least * any(50, 99) / 100;  // adjusted, with a warning
      radius = {length("A", *radius_)};
    }
    rout(one_in(2) ? "G02" : "G03", go_to({at_.x + chord.x, at_.y + chord.y}), radius);
    if (*radius_ < least) radius_.reset();
  }

  void arc_about_center() {
    Point spoke;  // from the centre to the start
    const int most = one_in(4) ? 30 : 3000;
    while (std::hypot(spoke.x, spoke.y) < n_arc_steps_ * kLeastRadius_steps)
      spoke = any_place(most);
    const bool is_clockwise = one_in(2);
    Point end = {-spoke.x, -spoke.y};
    if (!one_in(6)) {
      const double turn_rad = (is_clockwise ? -1 : 1) *
                              any(spoke.x * spoke.x + spoke.y * spoke.y > 2500 ? 10 : 60, 170) *
                              std::numbers::pi / 180;
      const auto x = static_cast<double>(spoke.x);
      const auto y = static_cast<double>(spoke.y);
      end = {std::lround(std::cos(turn_rad) * x - std::sin(turn_rad) * y),
             std::lround(std::sin(turn_rad) * x + std::cos(turn_rad) * y)};
    }
    const int sign = one_in(3) ? -1 : 1;  // of CAM systems, or the manual's
    TokenLine center;
    if (spoke.x != 0) center.push_back(length("I", sign * spoke.x));
    if (spoke.y != 0 || one_in(2)) center.push_back(length("J", sign * spoke.y));
    radius_.reset();
    rout(is_clockwise ? "G02" : "G03",
         go_to({at_.x - spoke.x + end.x, at_.y - spoke.y + end.y}),
         center);
  }

  void routed_circle() {
    radius_ = steps(any(is_bold_ ? 80 : 160, 900) * 0.01);
    line(with({{one_in(2) ? "G32" : "G33"}}, with(go_to(any_place()), {length("A", *radius_)})));
    begin_routing();
  }

  void step_slot() {
    if (in_section_ && !kStepSlotsInCopies) return;
    TokenLine words = with(go_to(any_place()), {{"G87"}});
    words = with(std::move(words), go_to(any_place()));
    line(with(std::move(words), {length("Z", -any(100, 300)), length("U", any(0, 1000))}));
    begin_routing();
  }

  // --- tools, events ---

  void tool() {
    const std::array<const char*, 9> words = {
        "T1", "T2", "T3", "T103", "T0202", "T1F070", "T2B0200H15", "T3S30.5", "T2H"};
    const std::string word = any_of(words);
    if (word == "T2H" && !kHitLimitEnds) return;
    if (one_in(10)) line({{"T0"}});
    line({{word}});
    if (one_in(8)) line({{"T5"}, length("C", steps(1.5))});
    if (one_in(8)) line({{"G07"}});
    if (one_in(4)) is_routing_ ? line({{any_of(kTableFeeds)}}) : infeed();
  }

  void infeed() {
    if (one_in(3)) return line({{"B0250"}});
    if (kInfeedBehindRouts || !has_routed_) line({{one_in(2) ? "F060" : "F080"}});
  }

  void event() {
    const std::array<const char*, 9> words = {
        "; nothing", "M18", "M62", "M63", "M96,1", "M47,LOOK OUT", "M60", "M61", "M19,10"};
    switch (any(0, 3)) {
      case 0:
        return line({{"G04"}, length("X", any(1, 10) * 1000)});
      case 1: {
        const Point place = any_place();
        TokenLine words_of_stop = {{one_in(2) ? "M06" : "M09"}};
        if (one_in(2)) {
          words_of_stop.push_back(length("X", place.x));
          words_of_stop.push_back(length("Y", place.y));
        }
        return line(std::move(words_of_stop));
      }
      case 2:
        if (one_in(3)) {
          line({{"M45,FIRST\\"}});
          return line({{"SECOND"}});
        }
        [[fallthrough]];
      default:
        return line({{any_of(words)}});
    }
  }

  // --- step and repeat ---

  void copies(std::vector<CopyRun>* kept, bool with_tools) {
    if (one_in(6)) {
      restarts_ = true;
      return line({{"M02"}});
    }
    CopyRun run;
    TokenLine words;
    if (one_in(3)) {
      run.count = any(1, 2);
      words.push_back({"R" + std::to_string(run.count)});
    }
    const Point step = any_place();
    words = with(std::move(words), {{"M02"}, length("X", step.x), length("Y", step.y)});
    const auto turn = [&](const char* code, bool& flag) {
      flag = one_in(4);
      if (flag) words.push_back({code});
    };
    turn("M80", run.mirror_x);
    turn("M90", run.mirror_y);
    turn("M70", run.swap_axes);
    if (with_tools && one_in(5)) {
      words.push_back({is_bold_ && one_in(4) ? "T0" : one_in(2) ? "T2" : "T3"});
    }
    line(std::move(words));
    run.step = displacement_mm<frame::Programmed>(static_cast<double>(step.x),
                                                  static_cast<double>(step.y));
    run.restarts = std::exchange(restarts_, false);
    if (kept != nullptr) kept->push_back(run);
  }

  void section() {
    line({{one_in(4) ? "%" : "M25"}});
    has_hole_ = has_cycle_ = false;
    has_routed_ = true;  // the copy before may have
    in_section_ = true;
    for (int n = any(1, 4); n > 0; --n) piece();
    in_section_ = false;
    for (int levels = any(1, 2); levels > 0; --levels) {
      line({{"M01"}});
      for (int n = any(0, 2); n > 0; --n) copies(nullptr, true);
    }
    line({{"M08"}});
    at_ = {};
    must_name_both_ = true;
    has_hole_ = has_cycle_ = false;
  }

  static constexpr std::array<const char*, 4> kTableFeeds = {"F02", "F050", "F4", "F061"};
  static constexpr double kShortestChord_steps = 3;
  static constexpr double kLeastRadius_steps = 8;

  Job job_;
  bool is_bold_;
  int n_arc_steps_ = 1;
  std::vector<TokenLine> head_;
  Point at_;
  bool incremental_ = false;
  bool must_name_both_ = true;  ///< unless G91 is in force
  bool is_routing_ = false;
  bool has_routed_ = false;
  bool in_section_ = false;
  bool has_hole_ = false;   ///< R# has something to repeat
  bool has_cycle_ = false;  ///< P# has
  bool restarts_ = true;    ///< the next copy's offset counts from zero
  std::string move_;        ///< G01, G02 or G03 in force
  std::optional<long> radius_;
};

}  // namespace

rc::Gen<Job> random_job() {
  return rc::gen::exec([] { return JobWriter(any_frame()).write(); });
}

rc::Gen<Job> random_bold_job() {
  return rc::gen::exec([] { return JobWriter(any_frame(), true).write(); });
}

rc::Gen<RoutedPattern> random_routed_pattern() {
  return rc::gen::exec([] { return JobWriter(any_frame()).write_routed(); });
}

}  // namespace panelcal::test
