// SPDX-License-Identifier: Apache-2.0
// A program of its own: operator new is replaced by one that counts.
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "program/judge/job_verdict.h"
#include "program/walk/walk.h"
#include <gtest/gtest.h>

#include "tests/bench/bench_program.h"
#include "tests/program/counted_allocations.h"

namespace panelcal {
namespace {

/// Passes holes on to the verdict, as `run` does, and counts those with a covariance.
class PropagatingSink final : public OperationSink {
 public:
  /// With `forgets_nothing` there is an allocation for every hole.
  PropagatingSink(JobVerdict& verdict, bool forgets_nothing)
      : verdict_(verdict), forgets_nothing_(forgets_nothing) {}

  void put(const Operation& operation) override {
    verdict_.put(operation);
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    ++n_holes_;
    if (drill->cov_mm2.trace() > 0) ++n_uncertain_;
    if (forgets_nothing_) kept_.push_back({drill->cov_mm2.trace()});
  }

  int n_holes() const { return n_holes_; }
  int n_uncertain() const { return n_uncertain_; }

 private:
  JobVerdict& verdict_;
  bool forgets_nothing_;
  int n_holes_ = 0;
  int n_uncertain_ = 0;
  std::vector<std::vector<double>> kept_;
};

WalkOptions judged() {
  WalkOptions options = bench::with_uncertainty();
  options.tolerances.position = um(20);
  return options;
}

/// Allocations of a walk that passes every hole with its covariance and its risk.
std::int64_t allocations(std::string text,
                         int n_holes,
                         bool forgets_nothing = false,
                         const WalkOptions& options = judged()) {
  DiagnosticLog log;
  const Program program = load_program({"p.exc", std::move(text)}, log);
  bench::TurnedPanel panel;
  const Survey found = survey(program, options, panel, log);
  EXPECT_TRUE(log.kept().empty() && found.is_complete());
  JobVerdict verdict(options.tolerances);
  PropagatingSink sink(verdict, forgets_nothing);
  const std::int64_t before = test::n_allocations();
  execute(program, options, found, sink, log);
  const std::int64_t after = test::n_allocations();
  EXPECT_TRUE(log.kept().empty());
  EXPECT_EQ(sink.n_holes(), n_holes);
  EXPECT_EQ(sink.n_uncertain(), n_holes);
  EXPECT_EQ(verdict.n_judged(), n_holes);
  return after - before;
}

constexpr int kHoles = 5000;

TEST(Propagation, AllocatesNothingPerHole) {
  EXPECT_EQ(allocations(bench::plain_program(2 * kHoles), 2 * kHoles),
            allocations(bench::plain_program(kHoles), kHoles));
}

TEST(Propagation, AllocatesNothingPerHoleOfStepAndRepeat) {
  EXPECT_EQ(allocations(bench::repeat_program(2 * kHoles), 2 * kHoles),
            allocations(bench::repeat_program(kHoles), kHoles));
}

TEST(Propagation, AllocatesNothingPerHoleOfSiebMeyer) {
  EXPECT_EQ(allocations(bench::plain_sieb_meyer_program(2 * kHoles), 2 * kHoles),
            allocations(bench::plain_sieb_meyer_program(kHoles), kHoles));
}

/// So it is on a table whose error is taken back.
TEST(Propagation, AllocatesNothingPerHoleOnACalibratedTable) {
  WalkOptions options = judged();
  TableGrid grid;
  grid.low_mm = Eigen::Vector2d::Constant(-1e4);
  grid.high_mm = Eigen::Vector2d::Constant(1e4);
  options.table = std::make_shared<const TableCorrection>(
      TableMap(grid, std::vector<Eigen::Vector2d>(16, Eigen::Vector2d(0.03, -0.02))));
  EXPECT_EQ(allocations(bench::plain_program(2 * kHoles), 2 * kHoles, false, options),
            allocations(bench::plain_program(kHoles), kHoles, false, options));
}

/// A walk that does allocate is seen to.
TEST(Propagation, IsCounted) {
  EXPECT_GE(allocations(bench::plain_program(kHoles), kHoles, true),
            allocations(bench::plain_program(kHoles), kHoles) + kHoles);
}

}  // namespace
}  // namespace panelcal
