// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/output/facts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "calib/advice/added_targets.h"
#include "calib/advice/convex_hull.h"
#include "calib/base/statistics/random.h"
#include "tools/plan/output/json.h"
#include "tools/plan/output/text.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

namespace panelcal::plan {
namespace {

using Place = Position<frame::Nominal>;
using testing::HasSubstr;
using testing::Not;

constexpr double kNoise_mm = 2e-3;

std::string point(double x_mm, double y_mm) {
  return fmt::format("X{:.3f}Y{:.3f}", x_mm, y_mm);
}

std::string program_of(const std::string& vision, const std::string& holes) {
  return "M48\nMETRIC,TZ\nT1C1.0\nT2C2.0\n%\nG34,1\n" + vision + "T1\n" + holes + "M30\n";
}

std::string blocks(const std::string& command, const std::vector<Eigen::Vector2d>& places) {
  std::string out;
  for (const Eigen::Vector2d& p : places) out += command + point(p.x(), p.y()) + "\n";
  return out;
}

struct Made {
  Program program;
  WalkOptions options;
  Survey survey;
  Plan plan;
};

/// As the command does: the walk has a model that everything determines where `wanted` differs.
Made make(const std::string& text,
          WalkOptions options,
          std::size_t n_added = 1,
          std::optional<PanelModel> wanted = std::nullopt) {
  DiagnosticLog log;
  Made out;
  out.options = options;
  out.program = load_program({"p.exc", text}, log);
  NominalSource source;
  out.survey = survey(out.program, options, source, log);
  EXPECT_FALSE(log.has_errors()) << log.kept().front().text();
  std::vector<PanelModel> programmed;
  for (const SeriesResult& series : out.survey.series) {
    programmed.push_back(wanted.value_or(series.model));
  }
  PlanRequest request;
  request.fiducial_sigma = mm(kNoise_mm);
  request.sigma_source = "assumed";
  request.n_added = n_added;
  request.fixed_model = wanted ? wanted : options.model;
  out.plan = make_plan(out.program, options, out.survey, programmed, request);
  return out;
}

WalkOptions series_of(int n, PanelModel model) {
  WalkOptions options;
  options.series_size = n;
  options.model = model;
  return options;
}

const std::vector<Eigen::Vector2d> kSquare = {{0, 0}, {300, 0}, {300, 300}, {0, 300}};

TEST(PlanFacts, GiveTheKnownLeverageTable) {
  struct Row {
    std::vector<Eigen::Vector2d> targets;
    PanelModel model;
    double expected;
  };
  const std::vector<Row> table = {
      {{kSquare[0], kSquare[1]}, PanelModel::Rigid, std::sqrt(3.0)},
      {{kSquare[0], kSquare[1]}, PanelModel::Similarity, std::sqrt(3.0)},
      {{kSquare[0], kSquare[2]}, PanelModel::Rigid, 1},
      {{kSquare[0], kSquare[2]}, PanelModel::Similarity, 1},
      {{kSquare[0], kSquare[1], kSquare[3]}, PanelModel::Similarity, 1},
      {{kSquare[0], kSquare[1], kSquare[3]}, PanelModel::Affine, std::sqrt(3.0)},
      {kSquare, PanelModel::Similarity, std::sqrt(0.5)},
      {kSquare, PanelModel::Affine, std::sqrt(0.75)},
      {{{0, 0}, {100, 0}, {0, 100}}, PanelModel::Affine, std::sqrt(43.0)},
  };
  std::vector<Eigen::Vector2d> holes = kSquare;
  holes.emplace_back(111, 87);
  for (const Row& row : table) {
    const int n = static_cast<int>(row.targets.size());
    const Made made =
        make(program_of(blocks("G36", row.targets), blocks("", holes)), series_of(n, row.model));
    ASSERT_EQ(made.plan.series.size(), 1u);
    const ModelPlan& found = made.plan.series[0].in_force();
    EXPECT_NEAR(found.stats.worst, row.expected, 1e-9) << n << " targets, " << name(row.model);
    EXPECT_EQ(found.stats.n, 5);
  }
}

TEST(PlanFacts, NameTheWorstHoleAndThoseOutsideOfTheHull) {
  const Made made = make(program_of(blocks("G36", {kSquare[0], kSquare[1], kSquare[3]}),
                                    blocks("", {{10, 10}, {290, 290}, {150, 160}}) + "T2\n" +
                                        blocks("", {{300, 300}})),
                         series_of(3, PanelModel::Affine));
  const SeriesPlan& series = made.plan.series.at(0);
  EXPECT_EQ(series.in_force().stats.worst_place.line, 15);
  EXPECT_EQ(series.in_force().stats.worst_place.tool, 2);
  EXPECT_EQ(series.n_places, 4);
  EXPECT_EQ(series.n_outside, 3);
  EXPECT_NEAR(series.farthest.in_mm(), 150 * std::sqrt(2), 1e-9);
  ASSERT_TRUE(series.one);
  ASSERT_EQ(series.one->pads.size(), 1u);
  EXPECT_EQ(series.one->pads[0].line, 15);
  EXPECT_EQ(series.one->stats.n, 4);
  EXPECT_LT(series.one->stats.worst, 0.88);
}

/// Answers at the nominal place with the noise that the plan counts on.
class NoisySource final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement out{.request = request, .status = MeasurementStatus::Found};
    out.measured = {request.expected, kNoise_mm * kNoise_mm * Eigen::Matrix2d::Identity()};
    return out;
  }
};

/// The greatest predicted sigma of holes, by the nested series that corrects them; none: by base.
class SigmaSink final : public OperationSink {
 public:
  void put(const Operation& operation) override {
    const auto* drill = std::get_if<Drill>(&operation.what);
    if (drill == nullptr) return;
    const auto& nested = *operation.origin->nested_series;
    double& worst = worst_mm[nested ? static_cast<int>(*nested) : -1];
    worst = std::max(worst, greatest_sigma(drill->cov_mm2));
  }
  std::map<int, double> worst_mm;
};

/// The judge is the job itself: what `run` predicts for its holes if targets have this noise.
TEST(PlanFacts, AgreeWithWhatAJobPredicts) {
  const std::string vision =
      blocks("G36", {{5, 5}, {200, 10}, {8, 250}}) +
      "M50,1\nM25\nG46X20.0Y20.0\nG46X60.0Y35.0\nG46X22.0Y50.0\nM01\nM02X90.0\n"
      "R2M02Y100.0\nM08\nM51,1\nM25\nM52,3\n";
  const std::string holes =
      "X30.0Y40.0\nX75.0Y20.0\nX10.0Y62.0\nM01\nM02X90.0\nR2M02Y100.0\nM08\nG47\nX210.0Y260."
      "0\nX0Y0\n";
  for (const PanelModel model : {PanelModel::Similarity, PanelModel::Stretch, PanelModel::Affine}) {
    WalkOptions options = series_of(3, model);
    options.uncertainty.stage_repeatability = um(1.5);
    options.uncertainty.drill_wander = um(4);
    const Made made =
        make(program_of(vision, "").substr(0, program_of(vision, "").find("T1\nM30")) + "T1\n" +
                 holes + "M30\n",
             options);
    DiagnosticLog log;
    NoisySource source;
    const Survey seen = survey(made.program, options, source, log);
    SigmaSink sink;
    execute(made.program, options, seen, sink, log);
    ASSERT_FALSE(log.has_errors());
    ASSERT_FALSE(sink.worst_mm.empty());
    for (const SeriesPlan& series : made.plan.series) {
      const int key =
          series.level == CorrectionLevel::Base ? -1 : static_cast<int>(series.i_series);
      const ModelPlan& found = series.in_force();
      ASSERT_TRUE(found.fit);
      EXPECT_NEAR(made.plan.total_sigma(series, *found.fit, found.stats.worst_place).in_mm(),
                  sink.worst_mm.at(key),
                  1e-6 * sink.worst_mm.at(key))
          << name(model) << ", series " << series.i_series;
    }
  }
}

std::string random_holes(int n, Random& random) {
  std::vector<Eigen::Vector2d> holes;
  for (int i = 0; i < n; ++i) holes.emplace_back(random.uniform(0, 400), random.uniform(0, 300));
  return blocks("", holes);
}

/// Thinning the candidates costs little against all of them.
TEST(PlanFacts, ThinnedCandidatesLoseLittle) {
  constexpr double kLoss = 1.03;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Random random(seed);
    std::vector<Eigen::Vector2d> targets;
    for (int i = 0; i < 3; ++i)
      targets.emplace_back(random.uniform(0, 400), random.uniform(0, 300));
    const Made made = make(program_of(blocks("G36", targets), random_holes(6000, random)),
                           series_of(3, PanelModel::Affine));
    const SeriesPlan& series = made.plan.series.at(0);
    ASSERT_TRUE(series.is_thinned);
    EXPECT_LT(series.candidates.size(), 2400u);
    std::vector<Place> all;
    PlaceSink sink(made.survey, [&](const PassingPlace& place) { all.push_back(place.nominal); });
    DiagnosticLog log;
    execute(made.program, made.options, made.survey, sink, log);
    const auto corners = convex_hull(all);
    const Addition best = best_additions({.model = PanelModel::Affine,
                                          .targets = series.design,
                                          .candidates = all,
                                          .corners = corners},
                                         1);
    ASSERT_TRUE(best.worst_after);
    ASSERT_TRUE(series.one);
    EXPECT_LE(series.one->stats.worst, kLoss * *best.worst_after) << "seed " << seed;
    EXPECT_GE(series.one->stats.worst, *best.worst_after * (1 - 1e-9));
  }
}

TEST(PlanFacts, BaseOfBoardsIsJudgedByTheTargetsItFinds) {
  const std::string vision =
      blocks("G36", {{5, 5}, {200, 10}, {8, 250}}) +
      "M50,1\nM25\nG46X20.0Y20.0\nG46X60.0Y35.0\nG46X22.0Y50.0\nM01\nM02X90.0\nM08\n"
      "M51,1\nM25\nM52,3\n";
  const Made made = make(
      "M48\nMETRIC,TZ\nT1C1.0\n%\nG34,1\n" + vision + "T1\nX30.0Y40.0\nM01\nM02X90.0\nM08\nM30\n",
      series_of(3, PanelModel::Stretch));
  ASSERT_EQ(made.plan.series.size(), 2u);  // both boards are alike
  EXPECT_EQ(made.plan.n_like_worst, 2u);
  EXPECT_TRUE(made.plan.series[0].serves_targets);
  EXPECT_EQ(made.plan.series[0].n_places, 6);
  EXPECT_EQ(made.plan.series[1].n_places, 1);
}

TEST(PlanFacts, SayWhatMakesAnUndeterminedSeriesWhole) {
  const std::string text = program_of(blocks("G36", {{0, 0}, {150, 0}, {300, 0}}),
                                      blocks("", {{20, 20}, {280, 290}, {10, 300}}));
  const Made made = make(text, series_of(3, PanelModel::Offset), 1, PanelModel::Affine);
  const SeriesPlan& series = made.plan.series.at(0);
  EXPECT_FALSE(series.in_force().fit);
  ASSERT_TRUE(series.one && series.one->fit);
  EXPECT_EQ(series.one->pads.size(), 1u);
  const std::string said = plan_text(made.plan, made.survey);
  EXPECT_THAT(said, HasSubstr("do not determine the model \"affine\""));
  EXPECT_THAT(said, HasSubstr("would determine it"));
}

/// The judge is the job with the target that was advised: the model it fits, and its worst hole.
TEST(PlanFacts, FurtherTargetsHaveTheModelOfAJobThatMeasuresThem) {
  constexpr double kRounding = 1e-9;
  const std::vector<Eigen::Vector2d> all = {{0, 0}, {200, 150}, {10, 140}, {190, 5}};
  const std::string holes = blocks("", {{20, 130}, {180, 20}, {100, 70}, {150, 160}});
  for (const std::size_t n : {1u, 2u, 3u}) {
    for (const std::size_t n_added : {1u, 2u}) {
      const std::vector<Eigen::Vector2d> targets(all.begin(),
                                                 all.begin() + static_cast<std::ptrdiff_t>(n));
      WalkOptions options;
      options.series_size = static_cast<int>(n);
      const Made made = make(program_of(blocks("G36", targets), holes), options, n_added);
      const SeriesPlan& series = made.plan.series.at(0);
      const auto& addition = n_added == 1 ? series.one : series.several;
      ASSERT_TRUE(addition && addition->fit);
      std::vector<Eigen::Vector2d> more = targets;
      for (const PlannedPlace& pad : addition->pads) more.push_back(pad.nominal.in_mm());
      options.series_size = static_cast<int>(more.size());
      const Made job = make(program_of(blocks("G36", more), holes), options);
      const SeriesPlan& measured = job.plan.series.at(0);
      EXPECT_EQ(addition->model, job.survey.series.at(0).model) << n << " + " << n_added;
      EXPECT_NEAR(addition->stats.worst, measured.in_force().stats.worst, kRounding);
      EXPECT_EQ(addition->worst_if_kept.has_value(), addition->model != series.programmed);
      if (!addition->worst_if_kept) continue;
      // As the table of that job has it, for the model that was in force before.
      const auto kept = std::ranges::find(measured.models, series.programmed, &ModelPlan::model);
      EXPECT_NEAR(*addition->worst_if_kept, kept->stats.worst, kRounding);
      EXPECT_THAT(plan_text(made.plan, made.survey),
                  HasSubstr(fmt::format(
                      "{} instead of {}", name(addition->model), name(series.programmed))));
    }
  }
}

TEST(PlanFacts, FurtherTargetsKeepAFixedModel) {
  const Made made = make(program_of(blocks("G36", {kSquare[0], kSquare[2]}), blocks("", kSquare)),
                         series_of(2, PanelModel::Rigid));
  const SeriesPlan& series = made.plan.series.at(0);
  ASSERT_TRUE(series.one);
  EXPECT_EQ(series.one->model, PanelModel::Rigid);
  EXPECT_THAT(plan_text(made.plan, made.survey), Not(HasSubstr("instead of")));
}

TEST(PlanFacts, NeverMakeTheWayLonger) {
  Random random(12);
  std::string vision;
  for (int s = 0; s < 6; ++s) {
    std::vector<Eigen::Vector2d> targets;
    for (int i = 0; i < 3; ++i)
      targets.emplace_back(random.uniform(0, 400), random.uniform(0, 300));
    vision += blocks(s == 0 ? "G36" : "G46", targets);
  }
  const Made made = make(program_of(vision, "X1.0Y1.0\n"), series_of(3, PanelModel::Stretch));
  const VisitPlan& visits = made.plan.visits;
  EXPECT_LT(visits.within_series_length, visits.programmed);
  EXPECT_LT(visits.free_length, visits.within_series_length);
  EXPECT_FALSE(visits.is_exact);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_LT(visits.free[k], 3u);  // the base series first
}

/// The document, as a reader has it.
facts::Json document_of(const Made& made) {
  const PlanOrigin origin{"a<b.exc", "m", {{"made by", "x"}}};
  return facts::Json::parse(facts::text(plan_facts(made.plan, made.survey, origin)));
}

TEST(PlanDocument, HoldsTheWorstPlaceAndThePads) {
  const Made made = make(program_of(blocks("G36", {kSquare[0], kSquare[1], kSquare[3]}),
                                    blocks("", {{10, 10}, {290, 290}, {300, 300}})),
                         series_of(3, PanelModel::Affine),
                         2);
  const facts::Json document = document_of(made);
  EXPECT_EQ(document["program"], "a<b.exc");
  const facts::Json& series = document["series"][0];
  const facts::Json& affine = series["models"].back();
  EXPECT_EQ(affine["model"], "affine");
  EXPECT_NEAR(affine["worst_leverage"].get<double>(), std::sqrt(3.0), 1e-9);
  EXPECT_EQ(affine["worst_at"]["nominal_mm"], facts::Json({300.0, 300.0}));
  EXPECT_EQ(series["additions"][0]["pads"].size(), 1u);
  EXPECT_EQ(series["additions"][1]["pads"].size(), 2u);
  EXPECT_EQ(series["candidates"]["x_mm"], facts::Json({10.0, 290.0, 300.0}));
  // Of the hole at (10, 10) too, a corner of the places' hull.
  EXPECT_EQ(series["places_hull_mm"].size(), 2u);
}

/// The page computes the leverage by these when a target is dragged; the judge is the plan itself.
TEST(PlanDocument, HoldsWhatTheLeverageFollowsFrom) {
  const std::vector<Eigen::Vector2d> targets = {{0, 0}, {280, 10}, {15, 240}, {260, 255}};
  const Made made = make(program_of(blocks("G36", targets), blocks("", kSquare)),
                         series_of(4, PanelModel::Stretch));
  const facts::Json document = document_of(made);
  const facts::Json& series = document["series"][0];
  for (const facts::Json& model : series["models"]) {
    const facts::Json& rows = document["jacobians"][model["model"].get<std::string>()];
    Eigen::MatrixXd jacobian(6, static_cast<Eigen::Index>(rows[0].size()));
    for (Eigen::Index i = 0; i < jacobian.size(); ++i) {
      const auto row = static_cast<std::size_t>(i % 6), column = static_cast<std::size_t>(i / 6);
      jacobian(i % 6, i / 6) = rows[row][column];
    }
    Eigen::MatrixXd information = Eigen::MatrixXd::Zero(6, 6);
    for (const facts::Json& target : series["targets"]) {
      const double x = target["nominal_mm"][0], y = target["nominal_mm"][1];
      Eigen::MatrixXd design(2, 6);
      design << x, y, 0, 0, 1, 0, 0, 0, x, y, 0, 1;
      Eigen::Matrix2d weight;
      weight << target["weight"][0], target["weight"][1], target["weight"][1], target["weight"][2];
      information += design.transpose() * weight * design;
    }
    const Eigen::MatrixXd cov =
        jacobian * (jacobian.transpose() * information * jacobian).inverse() * jacobian.transpose();
    const LeverageMap leverage{MapCovariance(cov)};
    double worst = 0;
    for (const facts::Json& corner : series["places_hull_mm"]) {
      worst = std::max(worst, leverage(position_mm<frame::Nominal>(corner[0], corner[1])));
    }
    EXPECT_NEAR(worst, model["worst_leverage"].get<double>(), 1e-6) << model["model"];
  }
}

TEST(PlanDocument, NamesTheModelOfEachNumberOfFurtherTargets) {
  const Made made = make(program_of(blocks("G36", {kSquare[0]}), blocks("", kSquare)),
                         series_of(1, PanelModel::Stretch));
  const facts::Json models = document_of(made)["series"][0]["models_with"];
  ASSERT_EQ(models.size(), kMostAdded + 1);
  for (std::size_t n = 0; n < 4; ++n) {
    EXPECT_EQ(models[n],
              name(model_at_most(PanelModel::Stretch, 2 * static_cast<int>(n + 1), false)))
        << n;
  }
}

TEST(PlanDocument, LivesWithoutTargetsAndWithoutHoles) {
  const Made without_targets = make(program_of("", "X1.0Y1.0\n"), {});
  const Made without_holes = make(program_of(blocks("G36", {{0, 0}, {9, 0}, {0, 9}}), ""),
                                  series_of(3, PanelModel::Affine));
  EXPECT_EQ(document_of(without_targets)["series"].size(), 0u);
  EXPECT_FALSE(plan_text(without_targets.plan, without_targets.survey).empty());
  // Nothing is certain to 0.00 where there is nothing.
  EXPECT_THAT(plan_text(without_holes.plan, without_holes.survey), Not(HasSubstr("0.00 ")));
  const facts::Json document = document_of(without_holes);
  for (const facts::Json& model : document["series"][0]["models"]) {
    EXPECT_TRUE(model["determined"]);
    EXPECT_FALSE(model.contains("worst_leverage")) << model;
    EXPECT_FALSE(model.contains("worst_at")) << model;
  }
}

}  // namespace
}  // namespace panelcal::plan
