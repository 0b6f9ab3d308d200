// SPDX-License-Identifier: Apache-2.0
// Random whole SIEB & MEYER jobs, against a model that expands them.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "program/walk/walk.h"
#include <Eigen/Core>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/sieb_meyer/naive_sm_model.h"
#include "tests/program/sieb_meyer/random_sm_job.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::BoardMap;
using test::FunctionSource;
using test::naive_events;
using test::NaiveEvent;
using test::random_sm_job;
using test::SmJob;
using test::SmTargets;

/// Doubles of up to 1 m, added up and turned a few times; the fit of a rigid board.
constexpr double kRounding_mm = 1e-6;

// --- what the interpreter does -------------------------------------------------------------------

/// One thing that moves the tool, in work coordinates, mm.
struct Move {
  enum class Kind { Hole, Position, Plunge, Rout, Retract };
  Kind kind = Kind::Hole;
  int tool = 0;
  DepthOfCut cut;
  Vector2d nominal_mm = Vector2d::Zero();
  Vector2d at_mm = Vector2d::Zero();
  Vector2d from_mm = Vector2d::Zero();  ///< of a rout or plunge: where the tool stands
  Vector2d center_mm = Vector2d::Zero();
  int turn = 0;
  int side = 0;

  friend bool operator==(const Move&, const Move&) = default;
};

class MoveRecorder final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    ++n_;
    std::visit([this](const auto& what) { see(what); }, operation.what);
  }
  std::vector<Move> take() { return std::move(moves_); }
  std::int64_t n_operations() const { return n_; }

 private:
  template <class T>
  void see(const T&) {}
  void see(const Drill& drill) {
    add({.kind = Move::Kind::Hole, .tool = drill.tool, .cut = drill.cut}, drill);
  }
  void see(const RapidMove& move) {
    side_ = 0;
    add({.kind = Move::Kind::Position}, move);
    at_mm_ = move.corrected.in_mm();
  }
  void see(const Compensation& compensation) {
    side_ = compensation.side == CompensationSide::Left    ? 1
            : compensation.side == CompensationSide::Right ? -1
                                                           : 0;
  }
  void see(const Plunge& plunge) {
    moves_.push_back(
        {.kind = Move::Kind::Plunge, .tool = plunge.tool, .cut = plunge.cut, .from_mm = at_mm_});
  }
  void see(const Retract&) { moves_.push_back({.kind = Move::Kind::Retract}); }
  void see(const Rout& rout) {
    Move move{.kind = Move::Kind::Rout, .tool = rout.tool, .cut = rout.cut, .from_mm = at_mm_};
    move.side = side_;
    if (rout.kind != RoutKind::Line) {
      move.center_mm = rout.corrected_center.in_mm();
      move.turn = rout.kind == RoutKind::Clockwise ? -1 : 1;
    }
    add(move, rout);
    at_mm_ = rout.corrected.in_mm();
  }
  void add(Move move, const PlacedPoint& place) {
    move.nominal_mm = place.nominal.in_mm();
    move.at_mm = place.corrected.in_mm();
    moves_.push_back(std::move(move));
  }

  std::vector<Move> moves_;
  Vector2d at_mm_ = Vector2d::Zero();
  int side_ = 0;
  std::int64_t n_ = 0;
};

struct JobRun {
  std::vector<Move> moves;
  std::vector<std::string> errors;
  std::int64_t n_operations = 0;
};

BoardMap flat_board() {
  return [](const Vector2d& nominal_mm) { return nominal_mm; };
}

JobRun run_job(const SmJob& job,
               const std::string& text,
               const BoardMap& board,
               const WalkOptions& options = {}) {
  DiagnosticLog log;
  JobRun run;
  ReadOptions reading;
  reading.block_delete = job.deletes_blocks;
  const Program program = load_program({"p.sm5", text}, log, reading);
  FunctionSource source(
      [&](const MeasurementRequest& request) { return board(request.nominal.in_mm()); });
  const Survey found = survey(program, options, source, log);
  if (!log.has_errors()) {
    MoveRecorder recorder;
    execute(program, options, found, recorder, log);
    run.n_operations = recorder.n_operations();
    run.moves = recorder.take();
  }
  for (const Diagnostic& diagnostic : log.kept()) {
    if (diagnostic.severity() == Severity::Error) run.errors.push_back(diagnostic.text());
  }
  return run;
}

void require_clean(const JobRun& run) {
  if (!run.errors.empty()) RC_LOG(run.errors.front());
  RC_ASSERT(run.errors.empty());
}

// --- comparison ----------------------------------------------------------------------------------

bool near(const Vector2d& a, const Vector2d& b) {
  return (a - b).norm() <= kRounding_mm;
}

std::string text_of(const Vector2d& p_mm) {
  return fmt::format("({:.6f}, {:.6f})", p_mm.x(), p_mm.y());
}

bool is_same(const std::optional<Length>& a, const std::optional<double>& b_mm) {
  return a.has_value() == b_mm.has_value() && (!a || std::abs(a->in_mm() - *b_mm) < kRounding_mm);
}

/// Walks through what was done, and takes off what the model expects.
class Comparison {
 public:
  explicit Comparison(const std::vector<Move>& moves) : moves_(moves) {}

  void expect(const std::vector<NaiveEvent>& expected) {
    for (i_event_ = 0; i_event_ < expected.size(); ++i_event_) {
      const NaiveEvent& event = expected[i_event_];
      if (event.group > 0) {
        i_event_ = expect_group(expected);
      } else if (event.kind == NaiveEvent::Kind::Hole) {
        expect_hole(event);
      } else if (event.kind == NaiveEvent::Kind::Figure) {
        expect_figure(event);
      } else {
        expect_rout(event);
      }
    }
    while (i_ < moves_.size()) {
      require(moves_[i_].kind != Move::Kind::Hole && moves_[i_].kind != Move::Kind::Rout,
              "more is done than expected: " + text_of(moves_[i_].at_mm));
      ++i_;
    }
  }

 private:
  void require(bool is_right, const std::string& what) {
    if (!is_right) RC_LOG(fmt::format("event {}: {}", i_event_, what));
    RC_ASSERT(is_right);
  }

  const Move& next(Move::Kind kind) {
    const auto skips = [&](Move::Kind found) {
      return found != kind && found != Move::Kind::Hole && found != Move::Kind::Rout;
    };
    while (i_ < moves_.size() && skips(moves_[i_].kind)) ++i_;
    require(i_ < moves_.size() && moves_[i_].kind == kind, "something else is done");
    return moves_[i_++];
  }

  void require_place(const Vector2d& found_mm, const Vector2d& expected_mm, const char* what) {
    require(near(found_mm, expected_mm),
            fmt::format("{} is {}, expected {}", what, text_of(found_mm), text_of(expected_mm)));
  }

  void require_cut(const Move& move, const NaiveEvent& event) {
    require(move.tool == event.tool, "another tool");
    require(move.cut.is_controlled() == event.cut.is_controlled &&
                is_same(move.cut.z, event.cut.z_mm) &&
                is_same(move.cut.depth, event.cut.depth_mm) &&
                is_same(move.cut.lower_limit, event.cut.lower_limit_mm),
            "another depth");
  }

  void expect_hole(const NaiveEvent& event) {
    const Move& hole = next(Move::Kind::Hole);
    require_place(hole.nominal_mm, event.nominal_mm, "the nominal hole");
    require_place(hole.at_mm, event.at_mm, "the hole");
    require_cut(hole, event);
  }

  /// Holes whose order the manual leaves open. Gives the last event of the group.
  std::size_t expect_group(const std::vector<NaiveEvent>& expected) {
    std::size_t end = i_event_;
    while (end < expected.size() && expected[end].group == expected[i_event_].group) ++end;
    const std::size_t n = end - i_event_;
    std::vector<bool> is_taken(n, false);
    for (std::size_t k = 0; k < n; ++k) {
      const Move& hole = next(Move::Kind::Hole);
      std::size_t i = 0;
      while (i < n && (is_taken[i] || !near(expected[i_event_ + i].at_mm, hole.at_mm))) ++i;
      require(i < n, text_of(hole.at_mm) + " is no hole of the pattern");
      is_taken[i] = true;
      require_cut(hole, expected[i_event_ + i]);
    }
    return end - 1;
  }

  /// An arc may come in two parts.
  void expect_rout(const NaiveEvent& event) {
    const Move* rout = &next(Move::Kind::Rout);
    require_place(rout->from_mm, event.from_mm, "the rout's start");
    const bool is_arc = event.kind == NaiveEvent::Kind::Arc;
    if (is_arc && !near(rout->at_mm, event.at_mm)) {
      require_arc(*rout, event);
      const double radius_mm = (event.at_mm - event.center_mm).norm();
      require(std::abs((rout->at_mm - event.center_mm).norm() - radius_mm) < kRounding_mm,
              "a part of an arc ends off it");
      rout = &next(Move::Kind::Rout);
    }
    require_place(rout->at_mm, event.at_mm, "the rout's end");
    require_place(rout->nominal_mm, event.nominal_mm, "the rout's nominal end");
    require_arc(*rout, event);
    require(rout->side == event.side, "the cutter goes on another side");
    require_cut(*rout, event);
  }

  void require_arc(const Move& rout, const NaiveEvent& event) {
    const bool is_arc = event.kind == NaiveEvent::Kind::Arc;
    require(rout.turn == (is_arc ? event.turn : 0), "another sense of turning");
    if (is_arc) require_place(rout.center_mm, event.center_mm, "the arc's centre");
  }

  /// The manual gives the plunge point and where the cutter's edge ends; not the way in between.
  void expect_figure(const NaiveEvent& event) {
    const Move& plunge = next(Move::Kind::Plunge);
    require_place(plunge.from_mm, event.from_mm, "the plunge point");
    require_cut(plunge, event);
    double turned_rad = 0;
    std::vector<bool> is_reached(event.corners_mm.size(), false);
    while (i_ < moves_.size() && moves_[i_].kind == Move::Kind::Rout) {
      const Move& rout = moves_[i_++];
      require_cut(rout, event);
      for (std::size_t k = 0; k < is_reached.size(); ++k) {
        if (near(rout.at_mm, event.corners_mm[k])) is_reached[k] = true;
      }
      const bool is_round =
          rout.turn != 0 && near(rout.center_mm, event.center_mm) &&
          std::abs((rout.at_mm - event.center_mm).norm() - event.radius_mm) < kRounding_mm;
      if (is_round) turned_rad += turn_of(rout, event.turn);
    }
    require(i_ < moves_.size() && moves_[i_].kind == Move::Kind::Retract, "the cutter stays down");
    require(std::ranges::find(is_reached, false) == is_reached.end(), "a corner is left out");
    require(!event.corners_mm.empty() || std::abs(turned_rad - 2 * std::numbers::pi) < 1e-6,
            fmt::format("the cutter goes round {:.6f} rad", turned_rad));
  }

  double turn_of(const Move& rout, int turn) {
    require(rout.turn == turn, "another sense of turning");
    const Vector2d a = rout.from_mm - rout.center_mm;
    const Vector2d b = rout.at_mm - rout.center_mm;
    const double left = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    const double turned = turn * left;
    return turned < -1e-6 ? turned + 2 * std::numbers::pi : std::abs(turned);
  }

  const std::vector<Move>& moves_;
  std::size_t i_ = 0;
  std::size_t i_event_ = 0;
};

/// Pose of a panel on the table.
BoardMap any_rigid_board() {
  const auto small = [](double most) {
    const int n = *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(0, 2001));
    return most * (n % 2 == 0 ? n : -n) / 2000;
  };
  const double angle = small(0.05);
  const double x_mm = small(10);
  const Vector2d shift_mm(x_mm, small(10));
  return [=](const Vector2d& p_mm) -> Vector2d {
    const Vector2d turned(std::cos(angle) * p_mm.x() - std::sin(angle) * p_mm.y(),
                          std::sin(angle) * p_mm.x() + std::cos(angle) * p_mm.y());
    return turned + shift_mm;
  };
}

// --- properties ----------------------------------------------------------------------------------

RC_GTEST_PROP(SmJob, IsExecutedAsTheModelExpandsIt, ()) {
  const SmJob job = *random_sm_job(SmTargets::None);
  const JobRun run = run_job(job, text_of(job, {}), flat_board());
  require_clean(run);
  Comparison(run.moves).expect(naive_events(job, flat_board()));
}

RC_GTEST_PROP(SmJob, ARigidCorrectionCommutesWithInterpretation, ()) {
  const SmJob job = *random_sm_job(SmTargets::OfTheBoard);
  const BoardMap board = any_rigid_board();
  const JobRun run = run_job(job, text_of(job, test::any_sm_spelling()), board);
  require_clean(run);
  Comparison(run.moves).expect(naive_events(job, board));
}

RC_GTEST_PROP(SmJob, EverySpellingDoesTheSameExactly, ()) {
  const SmJob job = *random_sm_job(SmTargets::None);
  const std::string text = text_of(job, test::any_sm_spelling());
  const JobRun plain = run_job(job, text_of(job, {}), flat_board());
  const JobRun other = run_job(job, text, flat_board());
  RC_LOG(text);
  require_clean(plain);
  require_clean(other);
  RC_ASSERT(plain.n_operations == other.n_operations);
  RC_ASSERT(plain.moves == other.moves);
}

/// Copies are counted in the survey and walked in the execution: one operation fewer than there
/// are is too few for both.
RC_GTEST_PROP(SmJob, TheSurveyCountsWhatIsExecuted, ()) {
  const bool has_targets = *rc::gen::arbitrary<bool>();
  const SmJob job = *random_sm_job(has_targets ? SmTargets::OfTheBoard : SmTargets::None);
  const std::string text = text_of(job, {});
  const JobRun whole = run_job(job, text, flat_board());
  require_clean(whole);
  const auto is_refused = [&](std::int64_t most) {
    WalkOptions options;
    options.max_operations = most;
    const JobRun limited = run_job(job, text, flat_board(), options);
    RC_ASSERT(limited.errors.empty() || limited.moves.empty());
    return std::ranges::any_of(limited.errors, [](const std::string& error) {
      return error.find("too-many-operations") != std::string::npos;
    });
  };
  RC_ASSERT(is_refused(whole.n_operations - 1));
  RC_ASSERT(!is_refused(whole.n_operations));
}

}  // namespace
}  // namespace panelcal
