// SPDX-License-Identifier: Apache-2.0
// A small job whose facts the tests look at.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/json/facts.h"
#include "calib/base/statistics/random.h"
#include "machine/job/facts/job_facts.h"
#include "program/walk/walk.h"

namespace panelcal::test {

/// Three panel targets; 2 x 1 boards with three targets and two holes each.
inline constexpr const char* kProgram =
    "M48\nMETRIC,TZ\nFMAT,2\nT1C0.700\nT2C1.500\n%\nG05\nG90\nG34,1\n"
    "G36X6.0Y6.0\nG36X224.0Y6.0\nG36X6.0Y269.0\nG34,2\nM50,1\nM25\n"
    "G46X15.0Y15.0\nG46X95.0Y15.0\nG46X95.0Y80.0\nM01\nR1M02X105.0\nM08\n"
    "T1\nM51,1\nM25\nM52,3\nX20.0Y20.0\nX40.0Y60.0\nM01\nR1M02X105.0\nM08\nT2\nX100.0Y200.0\nM30\n";
inline constexpr int kTargets = 9;
inline constexpr int kHoles = 5;
inline constexpr double kSigma_mm = 0.001;

/// Sees every target through a known map; `change` may shear an answer.
class FakeCamera final : public MeasurementSource {
 public:
  using Change = std::function<void(Measurement&)>;
  FakeCamera(const Transform<frame::Actual, frame::Nominal>& panel, Change change)
      : panel_(panel), change_(std::move(change)) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    Measurement m;
    m.request = request;
    m.status = MeasurementStatus::Found;
    const Eigen::Vector2d noise_mm(kSigma_mm * random_.normal(), kSigma_mm * random_.normal());
    m.measured = {panel_(request.nominal) + displacement_mm<frame::Actual>(noise_mm),
                  kSigma_mm * kSigma_mm * Eigen::Matrix2d::Identity()};
    m.score = 0.98;
    m.image = "image_" + std::to_string(request.seq) + ".png";
    if (change_) change_(m);
    return m;
  }

 private:
  Transform<frame::Actual, frame::Nominal> panel_;
  Change change_;
  Random random_{1};
};

/// Everything that facts are made of.
struct Job {
  DiagnosticLog log;
  Truth truth;
  std::optional<TruthComparison> comparison;
  Survey survey;
  Tally tally;
  std::optional<JobVerdict> verdict;
  PlaceTable places;
  JobFactsInput input;
};

inline Truth known_truth() {
  Eigen::Matrix2d linear;
  linear << 1.0002, -0.002, 0.002, 0.9999;
  Truth truth;
  truth.panel = {linear, Eigen::Vector2d(0.4, -0.3)};
  return truth;
}

/// Surveys and, where allowed, executes `text`, as `panelcal run` does.
inline std::unique_ptr<Job> run(const std::string& text,
                                FakeCamera::Change change = {},
                                bool force = false,
                                const Tolerances& tolerances = {}) {
  auto job = std::make_unique<Job>();
  job->truth = known_truth();
  job->comparison.emplace(job->truth);
  WalkOptions options;
  options.base_limits = {um(25), rad(5e-3), 500.0, mm(2)};
  options.nested_limits = {um(25), rad(2e-3), 5000.0, mm(2)};
  options.tolerances = tolerances;
  const Program program = load_program({"panel.exc", text}, job->log);
  FakeCamera camera(job->truth.panel, std::move(change));
  job->survey = survey(program, options, camera, job->log);
  JobFactsInput& input = job->input;
  input.program_file = "panel.exc";
  input.machine_name = "drill 1";
  input.source = "a fake camera";
  input.survey = &job->survey;
  input.forced = force && job->log.has_errors();
  if (job->survey.is_complete() && (force || !job->log.has_errors())) {
    job->verdict.emplace(tolerances);
    Tee tee({&job->tally, &job->places, &*job->comparison, &*job->verdict});
    execute(program, options, job->survey, tee, job->log);
    input.tally = &job->tally;
    input.places = &job->places;
    input.truth = &*job->comparison;
    input.output_file = "corrected.drl";
    if (tolerances.asks_positions()) input.verdict = &*job->verdict;
  }
  for (const Measurement& m : job->survey.measurements) {
    SeenPicture seen;
    seen.status = m.status;
    seen.picture.jpeg = "jpeg of " + std::to_string(m.request.seq);
    input.pictures[m.request.seq].push_back(std::move(seen));
  }
  input.diagnostics = job->log.kept();
  input.provenance = {{"made by", "panelcal test"}};
  return job;
}

/// One corner of a board moved so that the board would be sheared, which no stretch follows.
inline void shear(Measurement& m) {
  if (m.request.seq != 4) return;
  m.measured.position = m.measured.position + displacement_mm<frame::Actual>(0.3, -0.3);
}

/// One corner moved so that the board would be turned: hardly a residual is left.
inline void turn(Measurement& m) {
  if (m.request.seq != 4) return;
  m.measured.position = m.measured.position + displacement_mm<frame::Actual>(0.325, 0.4);
}

inline void lose(Measurement& m) {
  if (m.request.seq != 4) return;
  m.status = MeasurementStatus::NotFound;
  m.reason = "no disc <1 mm> & nothing like it";
}

inline facts::Json facts_of(const Job& job) {
  return facts::Json::parse(job_facts(job.input));
}

}  // namespace panelcal::test
