// SPDX-License-Identifier: Apache-2.0
#include "tests/program/sieb_meyer/random_sm_job.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "tests/program/sieb_meyer/random_draws.h"

namespace panelcal::test {
namespace {

using Kind = SmNode::Kind;

SmWord code(std::string text) {
  return {std::move(text)};
}

/// Writes lines and what they mean, and keeps to the rules that panelcal holds programs to.
class JobWriter {
 public:
  explicit JobWriter(SmTargets targets) {
    job_.has_targets = targets == SmTargets::OfTheBoard;
    job_.is_3000 = !job_.has_targets && one_in(3);
    job_.deletes_blocks = one_in(2);
    nodes_ = &job_.nodes;
  }

  SmJob write() {
    if (job_.has_targets) board_targets();
    const bool has_brackets = job_.has_targets || !one_in(4);
    if (!has_brackets) {
      for (int n = any(1, 3); n > 0; --n) unbracketed();
      return std::move(job_);
    }
    first_tool();
    for (int n = any(1, 5); n > 0; --n) one_in(2) ? section(1) : piece();
    if (job_.has_targets && one_in(3)) correction_off();
    return std::move(job_);
  }

 private:
  // --- lines ---

  /// A line with a coordinate; what waits to be said comes with it.
  void line(std::vector<SmWord> words, std::string tail = {}, bool is_slashed = false) {
    words.insert(words.end(), prefix_.begin(), prefix_.end());
    prefix_.clear();
    plain_line(std::move(words), std::move(tail), is_slashed);
  }
  void plain_line(std::vector<SmWord> words, std::string tail = {}, bool is_slashed = false) {
    job_.lines.push_back({std::move(words), std::move(tail), is_slashed, any(0, 1 << 20)});
  }
  SmNode& add(SmNode node) {
    nodes_->push_back(std::move(node));
    return nodes_->back();
  }

  /// X and Y that lead to a place, as the mode asks for them; at least one of them.
  std::vector<SmWord> go_to(Microns place, bool in_full = false) {
    const Microns from = incremental_ ? at_ : Microns{};
    std::vector<SmWord> words;
    const bool says_x = place.x != at_.x || in_full || one_in(2);
    const bool says_y = place.y != at_.y || in_full || !says_x || one_in(2);
    if (says_x) words.push_back({"X", place.x - from.x});
    if (says_y) words.push_back({"Y", place.y - from.y});
    at_ = place;
    return words;
  }

  /// Adds words that may stand in any line that drills or begins a contour, and holds for it
  /// already.
  void modes() {
    if (one_in(6)) {
      incremental_ = !incremental_;
      prefix_.push_back(code(incremental_ ? "G91" : "G90"));
    }
    const bool has_tool =
        std::ranges::any_of(prefix_, [](const SmWord& word) { return word.text.starts_with('T'); });
    if (!has_tool && one_in(5)) take_any_tool();
    if (one_in(5)) plane();
    if (one_in(12)) prefix_.push_back(code("M21"));
    if (!job_.is_3000 && one_in(12)) prefix_.push_back(code(one_in(2) ? "M94" : "M95"));
  }

  void take_any_tool() {
    SmNode node;
    node.kind = Kind::Tool;
    node.number = any(1, static_cast<int>(kSmTools_um.size()));
    prefix_.push_back(code("T" + std::to_string(node.number)));
    add(std::move(node));
  }

  void plane() {
    SmNode node;
    node.kind = Kind::Plane;
    const long step_um = job_.is_3000 ? 10 : 1;
    if (one_in(2)) {
      node.z_um = any(0, 300) * 10;
      prefix_.push_back({"Z", node.z_um, step_um});
    }
    if (one_in(2)) {
      node.k_um = any(0, 300) * 10;
      prefix_.push_back({"K", node.k_um, step_um});
    }
    if (one_in(2)) {
      node.depth_control = one_in(2);
      prefix_.push_back(code(*node.depth_control ? "G83" : "G82"));
    }
    add(std::move(node));
  }

  /// Lines that neither move nor change where anything goes.
  void idle_line() {
    const std::array<const char*, 3> orders_of_both = {"", "M20", "M47,HELLO (YOU)"};
    const std::array<const char*, 6> orders = {
        "M34", "M47 TURN", "M49,COMM,E", "M76,A1", "M49,M101", "G80"};
    const std::string tail = job_.is_3000 || one_in(3) ? any_of(orders_of_both) : any_of(orders);
    plain_line({}, tail);
  }

  // --- drilling ---

  void first_tool() {
    take_any_tool();
    hole();
  }

  void piece() {
    switch (any(0, 9)) {
      case 0:
      case 1:
        return contour();
      case 2:
        return rounded_contour();
      case 3:
        return figures();
      case 4:
        return pattern();
      case 5:
        return idle_line();
      case 6:
        return job_.has_targets ? target_hole() : slashed_hole();
      default:
        return hole();
    }
  }

  void hole() {
    for (int n = any(1, 3); n > 0; --n) {
      modes();
      SmNode node;
      node.place = any_place();
      line(go_to(node.place));
      add(std::move(node));
    }
  }

  void target_hole() {
    if (one_in(4)) take_any_tool();
    SmNode node;
    node.kind = Kind::TargetHole;
    node.place = any_place();
    line(go_to(node.place), "G36");
    add(std::move(node));
  }

  /// If blocks are deleted, it is as if the line were not there.
  void slashed_hole() {
    if (!prefix_.empty()) return hole();
    const Microns before = at_;
    const bool was_incremental = std::exchange(incremental_, false);
    SmNode node;
    node.place = any_place();
    std::vector<SmWord> words = go_to(node.place);
    if (was_incremental) words.push_back(code("G90"));
    line(std::move(words), {}, true);
    if (!job_.deletes_blocks) {
      add(std::move(node));
      return;
    }
    at_ = before;
    incremental_ = was_incremental;
  }

  void pattern() {
    modes();
    SmNode node;
    node.kind = Kind::Pattern;
    node.number = any(1, job_.is_3000 ? 2 : 4);
    node.place = any_place();
    if (node.number == 2 || node.number == 4) {
      node.n_in_row = any(2, 9);
      node.second = node.place + Microns{any(300, 30'000), any_either_way(30'000)};
    } else {
      grid(node);
    }
    std::vector<SmWord> words = go_to(node.place);
    words.push_back(code("V" + std::to_string(node.number)));
    line(std::move(words));
    words = go_to(node.second);
    if (node.n_in_row) words.push_back(code("W" + std::to_string(*node.n_in_row)));
    line(std::move(words));
    add(std::move(node));
  }

  void grid(SmNode& node) {
    const bool is_falling = one_in(2);
    const long n_along = any(1, 6);
    const long n_across = any(1, 6);
    const bool is_free = one_in(2);
    const long pitch_um = is_free ? any(500, 4000) : 2540;
    // The corner may be off by up to half a pitch, but with W the rows keep their length.
    const auto off = [&] { return any_either_way(static_cast<int>(pitch_um) / 2 - 20); };
    const long along = n_along * pitch_um + (is_free ? 0 : off());
    const long across = n_across * pitch_um + off();
    if (is_free) node.n_in_row = static_cast<int>(n_along) + 1;
    const Microns sides = is_falling ? Microns{along, across} : Microns{across, along};
    const long sign = one_in(2) ? 1 : -1;
    node.second =
        node.place + Microns{sign * sides.x, is_falling ? -sign * sides.y : sign * sides.y};
  }

  // --- routing ---

  void begin_contour(Microns start) {
    modes();
    std::vector<SmWord> words = go_to(start);
    words.push_back(code("T0"));
    line(std::move(words));
    radius_um_ = 0;
    motion_.clear();
  }

  void end_contour() {
    std::vector<SmWord> words = go_to(at_);
    words.push_back(code("T0"));
    line(std::move(words));
  }

  std::string any_feed() const {
    const std::array<const char*, 3> tenths = {"F12", "F8", "F030"};
    const std::array<const char*, 3> metres = {"F1.2", "F.8", "F2500"};
    return job_.is_3000 ? any_of(tenths) : any_of(metres);
  }

  void rout_line(const SmPiece& piece, std::vector<SmWord> more) {
    const std::string motion = piece.turn == 0 ? "G1" : piece.turn < 0 ? "G2" : "G3";
    std::vector<SmWord> words = go_to(piece.to);
    if (motion != motion_) words.push_back(code(motion));
    if (motion_.empty() || one_in(6)) words.push_back(code(any_feed()));
    if (one_in(8)) words.push_back(code("G11"));
    words.insert(words.end(), more.begin(), more.end());
    motion_ = motion;
    line(std::move(words));
  }

  void contour() {
    SmNode node;
    node.kind = Kind::Contour;
    node.place = any_place();
    begin_contour(node.place);
    int side = one_in(3) ? (one_in(2) ? 1 : -1) : 0;
    for (int n = any(1, 4); n > 0; --n) {
      std::vector<SmWord> more;
      if (motion_.empty() && side != 0) more.push_back(code(side > 0 ? "G41" : "G42"));
      if (!motion_.empty() && one_in(8)) {
        more.push_back(code("G40"));
        side = 0;
      }
      const int kind = any(0, 3);
      SmPiece piece = kind == 0   ? arc_about_center(more)
                      : kind == 1 ? arc_of_radius(more)
                                  : straight();
      piece.side = side;
      rout_line(piece, more);
      node.pieces.push_back(std::move(piece));
    }
    end_contour();
    add(std::move(node));
  }

  /// A place that is not where the cutter stands.
  Microns elsewhere(int least_um, int most_um) {
    // Drawing again and again would never let a counterexample shrink.
    Microns step = any_place(most_um);
    if (norm(step) < least_um) step.x += 2 * least_um;
    return at_ + step;
  }

  SmPiece straight() { return {.to = elsewhere(1, 100'000)}; }

  SmPiece arc_of_radius(std::vector<SmWord>& more) {
    SmPiece piece{.turn = one_in(2) ? 1 : -1, .to = elsewhere(100, 30'000)};
    const double chord = norm(piece.to - at_);
    const auto least = static_cast<long>(std::ceil(0.51 * chord)) + 5;
    const bool still_holds = radius_um_ != 0 && std::abs(radius_um_) >= least;
    if (!still_holds || one_in(2)) {
      radius_um_ = (least + any(0, 40'000)) * (one_in(3) ? -1 : 1);
      more.push_back({"R", radius_um_});
    }
    piece.radius_um = radius_um_;
    return piece;
  }

  /// The end is a spoke turned or mirrored exactly, so that both ends are equally far.
  SmPiece arc_about_center(std::vector<SmWord>& more) {
    Microns spoke = any_place(20'000);
    if (norm(spoke) < 200) spoke.x += 400;
    if (std::abs(spoke.x) == std::abs(spoke.y)) spoke.x += spoke.x < 0 ? -1 : 1;
    const std::array<Microns, 7> ends = {{{-spoke.y, spoke.x},
                                          {-spoke.x, -spoke.y},
                                          {spoke.y, -spoke.x},
                                          {spoke.y, spoke.x},
                                          {-spoke.y, -spoke.x},
                                          {spoke.x, -spoke.y},
                                          {-spoke.x, spoke.y}}};
    Microns end = ends[static_cast<std::size_t>(any(0, 6))];
    if (end == spoke) end = ends[1];
    SmPiece piece{.turn = one_in(2) ? 1 : -1, .to = at_ - spoke + end, .spoke = spoke};
    radius_um_ = 0;
    more.push_back({"I", spoke.x});
    more.push_back({"J", spoke.y});
    return piece;
  }

  /// Straight lines whose corners are rounded where there is room for it.
  void rounded_contour() {
    SmNode node;
    node.kind = Kind::Contour;
    node.place = any_place();
    begin_contour(node.place);
    std::vector<Microns> corners = {node.place};
    for (int n = any(2, 4); n > 0; --n) {
      at_ = corners.back();
      corners.push_back(elsewhere(2000, 60'000));
    }
    at_ = node.place;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      SmPiece piece{.to = corners[i]};
      std::vector<SmWord> more;
      if (i + 1 < corners.size())
        piece.corner_um = corner(corners[i - 1], corners[i], corners[i + 1]);
      if (piece.corner_um) more.push_back({"D", piece.corner_um});
      rout_line(piece, more);
      node.pieces.push_back(std::move(piece));
    }
    end_contour();
    add(std::move(node));
  }

  static std::optional<long> corner(Microns before, Microns at, Microns after) {
    const double half = angle_at(before, at, after) / 2;
    if (half < 0.25 || half > 1.3 || one_in(4)) return std::nullopt;
    const double room = 0.4 * std::min(norm(at - before), norm(after - at));
    return any(100, static_cast<int>(room * std::min(1.0, std::tan(half))));
  }

  void figures() {
    begin_contour(any_place());
    for (int n = any(1, 3); n > 0; --n) {
      SmNode node;
      node.kind = Kind::Figure;
      node.number = any(45, 50);
      node.place = elsewhere(1, 100'000);
      std::vector<SmWord> words = go_to(node.place);
      words.push_back(code("G" + std::to_string(node.number)));
      if (node.number < 49) {
        node.radius_um = any(2000, 20'000);
        words.push_back({"R", node.radius_um});
      } else if (one_in(3)) {
        node.second = {any(4000, 20'000), 0};
        node.second.y = node.second.x;
        words.push_back({"R", node.second.x});
      } else {
        node.second = {any(4000, 20'000), any(4000, 20'000)};
        words.push_back({"I", node.second.x});
        words.push_back({"J", node.second.y});
      }
      const bool has_inside = node.number != 47 && node.number != 48;
      if (!job_.is_3000 && has_inside && one_in(6)) words.push_back(code("G43"));
      line(std::move(words));
      add(std::move(node));
    }
    end_contour();
  }

  // --- sections ---

  /// Offsets without brackets move everything since the last ones.
  void unbracketed() {
    std::vector<SmNode>* const outside = nodes_;
    SmNode node;
    node.kind = Kind::Section;
    nodes_ = &node.body;
    first_tool();
    for (int n = any(0, 3); n > 0; --n) piece();
    offsets(node, false);
    nodes_ = outside;
    add(std::move(node));
  }

  void section(int depth) {
    constexpr int kMostDepth = 3;
    std::vector<SmNode>* const outside = nodes_;
    SmNode node;
    node.kind = Kind::Section;
    nodes_ = &node.body;
    if (one_in(3)) {
      plain_line({code("M31")});
    } else {
      prefix_.push_back(code("M31"));
    }
    if (depth == kMostDepth || !one_in(4)) hole();
    for (int n = any(0, 3); n > 0; --n)
      depth < kMostDepth&& one_in(3) ? section(depth + 1) : piece();
    if (!prefix_.empty()) hole();
    if (one_in(4)) {
      close();
    } else {
      offsets(node, true);
    }
    nodes_ = outside;
    add(std::move(node));
  }

  /// M30 alone, or in the last line, whose coordinate still belongs to the section.
  void close() {
    SmLine& last = job_.lines.back();
    const bool may_join = last.tail.empty() && !last.words.empty() && !last.is_slashed;
    if (may_join && one_in(2)) {
      last.words.push_back(code("M30"));
    } else {
      plain_line({code("M30")});
    }
  }

  void offsets(SmNode& node, bool is_bracketed) {
    for (int n = any(1, 3); n > 0; --n) {
      if (!job_.is_3000 && one_in(4)) {
        row(node);
        continue;
      }
      const std::array<const char*, 8> kinds = {"50", "50", "60", "70", "80", "90", "6070", "6080"};
      const std::string kind = one_in(8) ? "6090" : any_of(kinds);
      const Microns zero = any_place();
      std::vector<SmWord> words = offset(zero);
      words.push_back(code("M" + kind.substr(0, 2)));
      if (kind.size() > 2) words.push_back(code("M" + kind.substr(2)));
      line(std::move(words));
      node.copies.emplace_back(kind, zero);
    }
    if (is_bracketed) close();
    at_ = {};
    incremental_ = false;
  }

  /// Always absolute; what is left out is 0.
  static std::vector<SmWord> offset(Microns zero) {
    std::vector<SmWord> words;
    if (zero.x != 0 || one_in(2)) words.push_back({"X", zero.x});
    if (zero.y != 0 || words.empty() || one_in(2)) words.push_back({"Y", zero.y});
    return words;
  }

  /// M50V2: n copies from the first to the last zero point; exact steps, so that the model may list
  /// them.
  void row(SmNode& node) {
    const int n = any(2, 4);
    const Microns first = any_place();
    const Microns step = any_place(50'000);
    std::vector<SmWord> words = offset(first);
    words.push_back(code("M50"));
    words.push_back(code("V2"));
    line(std::move(words));
    const Microns last = first + Microns{(n - 1) * step.x, (n - 1) * step.y};
    words = offset(last);
    words.push_back(code("M50"));
    words.push_back(code("W" + std::to_string(n)));
    line(std::move(words));
    for (int i = 0; i < n; ++i) {
      node.copies.emplace_back("50", first + Microns{i * step.x, i * step.y});
    }
  }

  // --- targets ---

  void board_targets() {
    const std::array<Microns, 4> places = {
        {{1000, 2000}, {240'000, 3000}, {5000, 180'500}, {238'000, 190'000}}};
    const int n = any(2, 4);
    for (int i = 0; i < n; ++i) {
      line(go_to(places[static_cast<std::size_t>(i)], i == 0), one_in(2) ? "G32" : "G33");
    }
    plain_line({}, "G31");
    correction(true);
  }

  void correction_off() {
    plain_line({}, "G30");
    correction(false);
    hole();
  }

  void correction(bool is_on) {
    SmNode node;
    node.kind = Kind::Correction;
    node.is_on = is_on;
    add(std::move(node));
  }

  SmJob job_;
  std::vector<SmNode>* nodes_ = nullptr;
  std::vector<SmWord> prefix_;  ///< of the next line with a coordinate
  Microns at_;
  bool incremental_ = false;
  std::string motion_;  ///< of this contour's last line
  long radius_um_ = 0;  ///< R that holds in this contour; 0: none
};

}  // namespace

rc::Gen<SmJob> random_sm_job(SmTargets targets) {
  return rc::gen::exec([targets] { return JobWriter(targets).write(); });
}

}  // namespace panelcal::test
