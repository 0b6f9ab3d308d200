// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/operator_source.h"

#include <future>
#include <thread>

#include "machine/operator/orders.h"
#include "program/walk/walk.h"

#include "tests/machine/operator/operated_station.h"

namespace panelcal::test {
namespace {

using internal::Answer;
using internal::Choice;
using internal::Desk;
using internal::JobFolder;
using internal::OperatorSource;
using internal::PictureFeed;
using internal::Screen;
using internal::ScreenQuestion;

constexpr double kPixel_mm = 0.01;

/// Four panel fiducials of one series.
constexpr std::string_view kFourTargets = R"(M48
METRIC,TZ
FMAT,2
VER,1
T1C0.8
%
G90
$uvis,alg,0,4
G34,1
G36X5.0Y5.0
G36X65.0Y5.0
G36X5.0Y45.0
G36X65.0Y45.0
T1
X20.0Y20.0
M30
)";

/// Answers as it is told, and shows a grey picture of the place that it is asked for.
class ScriptedSource final : public MeasurementSource, public ViewTaker {
 public:
  ScriptedSource(PictureFeed& feed, const PictureLocator& locator)
      : feed_(feed), locator_(locator) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    asked.push_back(request);
    View view;
    view.axis = request.expected_in_machine();
    const TakenPicture picture{Image(280, 240, Image::kFullScale8, 100), view.axis, "grey.png", ""};
    feed_.see({request, view, picture, *locator_.camera_of(request), detection});
    if (answers.empty()) return NominalSource().measure(request);
    Expected<Measurement> answer = std::move(answers.front());
    answers.erase(answers.begin());
    if (answer) answer->request = request;
    return answer;
  }
  bool can_set(CameraSetting setting) const override {
    return has_lights && (setting == CameraSetting::Lamp || setting == CameraSetting::Exposure);
  }
  std::optional<double> exposure_us() const override {
    return has_lights && tells_exposure ? std::optional(1500.0) : std::nullopt;
  }
  Expected<TakenPicture> take(const MeasurementRequest&, const View& view) override {
    views.push_back(view);
    return TakenPicture{Image(280, 240, Image::kFullScale8, 100), view.axis, "", ""};
  }

  std::vector<Expected<Measurement>> answers;  ///< then those of a perfect panel
  Detection detection;
  std::vector<MeasurementRequest> asked;
  std::vector<View> views;
  bool has_lights = true;
  bool tells_exposure = true;

 private:
  PictureFeed& feed_;
  const PictureLocator& locator_;
};

Measurement lost(MeasurementStatus status = MeasurementStatus::NotFound) {
  Measurement out;
  out.status = status;
  out.reason = "nothing like it";
  return out;
}

class OperatorSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    machine_ = small_config(folder_.path());
    const Program program = program_of(std::string(program_text_));
    DiagnosticLog log;
    nominal_ = check(program, machine_.walk, log).survey;
    ASSERT_FALSE(nominal_.measurements.empty());
    auto locator = PictureLocator::create(machine_);
    ASSERT_TRUE(locator);
    locator_.emplace(*std::move(locator));
    internal::JobRecord record;
    record.id = "2026-11-27-1";
    auto folder = JobFolder::create(folder_.path(), record);
    ASSERT_TRUE(folder);
    job_folder_.emplace(*std::move(folder));
    Screen screen;
    screen.job.emplace();
    screen.job->state = internal::JobState::Measuring;
    desk_.emplace(screen);
    feed_.emplace(*desk_, machine_.vision, 6);
    script_ = std::make_shared<ScriptedSource>(*feed_, *locator_);
    source_.emplace(
        OperatorSource::Station{
            *desk_, *job_folder_, *feed_, machine_, nominal_, clock_, n_questions_},
        script_,
        script_.get(),
        std::map<std::int64_t, Measurement>());
  }

  const MeasurementRequest& request(std::size_t seq) const {
    return nominal_.measurements[seq].request;
  }
  /// Measures in a thread of its own, as the station does.
  std::future<Expected<Measurement>> measure(std::size_t seq) {
    return std::async(std::launch::async, [this, seq] { return source_->measure(request(seq)); });
  }
  /// The question when it is open, and is this one.
  ScreenQuestion question(int id = 1) {
    while (true) {
      const std::uint64_t number = desk_->state().number;
      const auto open = desk_->read([](const Screen& screen) { return screen.job->question; });
      if (open && open->id == id) return *open;
      desk_->wait(number, ~std::uint64_t{0}, std::chrono::seconds(1));
    }
  }
  /// As the station takes an answer.
  Expected<void> tell(Answer answer) {
    answer.who = "Anna";
    return desk_->try_change([&](Screen& screen) -> Expected<void> {
      PANELCAL_CHECK(internal::take_answer(screen, answer));
      desk_->answer(answer);
      return {};
    });
  }
  Expected<void> jog(double x_mm, double y_mm) {
    return desk_->try_change([&](Screen& screen) -> Expected<void> {
      PANELCAL_CHECK(internal::take_jog(screen, {x_mm, y_mm}));
      desk_->jog({x_mm, y_mm});
      return {};
    });
  }

  std::string program_text_ = std::string(kSmallProgram);
  TemporaryFolder folder_;
  MachineConfig machine_;
  Survey nominal_;
  Clock clock_ = fixed_clock(*from_iso_8601("2026-11-27T08:00:00Z"));
  std::optional<PictureLocator> locator_;
  std::optional<JobFolder> job_folder_;
  std::optional<Desk> desk_;
  std::optional<PictureFeed> feed_;
  std::shared_ptr<ScriptedSource> script_;
  int n_questions_ = 0;
  std::optional<OperatorSource> source_;
};

class FourTargets : public OperatorSourceTest {
 protected:
  FourTargets() { program_text_ = kFourTargets; }

  std::future<Survey> begin_survey(DiagnosticLog& log) {
    return std::async(std::launch::async, [&] {
      return survey(program_of(program_text_), machine_.walk, *source_, log);
    });
  }
  /// All four seen with a small covariance, the third 0.2 mm beside its place.
  void answer_with_a_displaced_third() {
    for (const std::size_t seq : {0, 1, 2, 3}) {
      Measurement answer;
      answer.status = MeasurementStatus::Found;
      const Eigen::Vector2d beside_mm(seq == 2 ? 0.2 : 0, 0);
      answer.measured.position =
          position_mm<frame::Actual>((request(seq).expected.in_mm() + beside_mm).eval());
      answer.measured.cov = 1e-6 * Eigen::Matrix2d::Identity();
      script_->answers.emplace_back(answer);
    }
  }
};

TEST_F(OperatorSourceTest, AsksNothingAboutWhatIsFound) {
  const auto found = measure(0).get();
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_FALSE(found->decision.is_by_person());
  EXPECT_EQ(job_folder_->measurements().size(), 1U);
  EXPECT_TRUE(job_folder_->choices().empty());
}

TEST_F(OperatorSourceTest, LooksAgainWithAnotherLamp) {
  script_->answers = {lost()};
  auto found = measure(0);
  EXPECT_EQ(question().reason, "nothing like it");
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Again, .lamp = 40}));
  const auto answer = found.get();
  ASSERT_TRUE(answer) << answer.error().text();
  EXPECT_EQ(answer->status, MeasurementStatus::Found);
  EXPECT_EQ(answer->decision.by, Decider::Camera);
  EXPECT_EQ(answer->decision.who, "Anna");
  EXPECT_EQ(answer->decision.when, "2026-11-27T08:00:00Z");
  ASSERT_EQ(script_->asked.size(), 2U);
  EXPECT_EQ(script_->asked[1].settings.lamp, 40);
  EXPECT_FALSE(answer->request.settings.lamp);
  ASSERT_EQ(job_folder_->choices().size(), 1U);
  EXPECT_EQ(job_folder_->choices()[0].who, "Anna");
}

TEST_F(OperatorSourceTest, LooksAgainWithAnotherExposureForThatLookAlone) {
  script_->answers = {lost()};
  auto found = measure(0);
  EXPECT_EQ(question().exposure_us, 1500);
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Again, .exposure_us = 3000}));
  const auto answer = found.get();
  ASSERT_TRUE(answer) << answer.error().text();
  ASSERT_EQ(script_->asked.size(), 2U);
  EXPECT_EQ(script_->asked[1].settings.exposure_us, 3000);
  EXPECT_FALSE(answer->request.settings.exposure_us);
  EXPECT_NE(job_folder_->choices()[0].what.find("exposure 3000 us"), std::string::npos);
}

TEST_F(OperatorSourceTest, RefusesAnExposureThatTheCameraCannotSet) {
  script_->has_lights = false;
  script_->answers = {lost()};
  auto found = measure(0);
  EXPECT_TRUE(question().why_not.contains("exposure"));
  EXPECT_TRUE(question().why_not.contains("lamp"));
  EXPECT_FALSE(question().exposure_us);
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::Again, .exposure_us = 3000}));
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::Again, .lamp = 30}));
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Again}));
  EXPECT_TRUE(found.get());
}

TEST_F(OperatorSourceTest, RefusesAnExposureThatCouldNotBePutBack) {
  script_->tells_exposure = false;
  script_->answers = {lost()};
  auto found = measure(0);
  EXPECT_TRUE(question().why_not.contains("exposure"));
  EXPECT_FALSE(question().why_not.contains("lamp"));
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::Again, .exposure_us = 3000}));
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Again}));
  EXPECT_TRUE(found.get());
}

TEST_F(OperatorSourceTest, SearchesWhereAPersonPoints) {
  script_->answers = {lost()};
  auto found = measure(0);
  question();
  // test_camera(): the axis meets the picture at (142.7, 115.4) px, and y points down.
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Search, .at_px = {{152.7, 135.4}}}));
  const auto answer = found.get();
  ASSERT_TRUE(answer) << answer.error().text();
  const Eigen::Vector2d moved_mm = script_->asked[1].expected.in_mm() - request(0).expected.in_mm();
  // Turned by 4 mrad, which moves 0.2 mm by less than 1 um.
  EXPECT_NEAR(moved_mm.x(), 10 * kPixel_mm, 0.001);
  EXPECT_NEAR(moved_mm.y(), -20 * kPixel_mm, 0.001);
  EXPECT_EQ(answer->request.expected, request(0).expected);
  EXPECT_EQ(answer->decision.by, Decider::Camera);
}

TEST_F(OperatorSourceTest, TakesTheCandidateThatAPersonChooses) {
  Measurement ambiguous = lost(MeasurementStatus::Ambiguous);
  const Eigen::Vector2d expected_mm = request(0).expected.in_mm();
  for (const double x_mm : {-0.3, 0.2, 9.0}) {  // the last one lies outside of the picture
    MeasuredCandidate candidate;
    candidate.place.position =
        position_mm<frame::Actual>((expected_mm + Eigen::Vector2d(x_mm, 0)).eval());
    candidate.place.cov = 4e-6 * Eigen::Matrix2d::Identity();
    candidate.score = 0.9;
    candidate.counts = true;
    ambiguous.candidates.push_back(candidate);
  }
  script_->answers = {ambiguous};
  auto found = measure(0);
  const ScreenQuestion asked = question();
  ASSERT_EQ(asked.candidates.size(), 2U);
  EXPECT_NEAR(asked.candidates[1].at_px.x() - asked.candidates[0].at_px.x(), 50, 0.1);
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::Candidate, .index = 2}));
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Candidate, .index = 1}));
  const auto answer = found.get();
  ASSERT_TRUE(answer) << answer.error().text();
  EXPECT_EQ(answer->status, MeasurementStatus::Found);
  EXPECT_EQ(answer->measured.position, ambiguous.candidates[1].place.position);
  EXPECT_EQ(answer->measured.cov, ambiguous.candidates[1].place.cov);
  EXPECT_EQ(answer->decision.by, Decider::Candidate);
  EXPECT_TRUE(answer->reason.empty());
  // A series may not choose another one.
  EXPECT_TRUE(answer->candidates.empty());
}

TEST_F(OperatorSourceTest, PlacesByHandWithHalfAPixel) {
  script_->answers = {lost(MeasurementStatus::Rejected)};
  auto found = measure(0);
  question();
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Hand, .at_px = {{142.7, 115.4}}}));
  const auto answer = found.get();
  ASSERT_TRUE(answer) << answer.error().text();
  EXPECT_NEAR((answer->measured.position - request(0).expected).in_mm().norm(), 0, 1e-9);
  const double variance_mm2 = 0.25 * kPixel_mm * kPixel_mm;
  EXPECT_NEAR(answer->measured.cov(0, 0), variance_mm2, 1e-3 * variance_mm2);
  EXPECT_NEAR(answer->measured.cov(1, 1), variance_mm2, 1e-3 * variance_mm2);
  EXPECT_TRUE(answer->by_camera.has_value());
  EXPECT_EQ(answer->image, "grey.png");
}

TEST_F(OperatorSourceTest, SkipsNoTargetThatTheFitNeeds) {
  script_->answers = {lost()};
  auto found = measure(0);
  // Three targets and the stretch model: two would leave fewer equations than it has parameters.
  EXPECT_NE(question().why_not.at("skip").find("2 of 3 targets"), std::string::npos);
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::Skip}));
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::LeaveBoardOut}));
  ASSERT_TRUE(desk_->try_change([&](Screen&) -> Expected<void> {
    desk_->stop();
    return {};
  }));
  EXPECT_EQ(found.get().error().code, Code::Interrupted);
}

TEST_F(FourTargets, SkipsOneOfThemAndNoSecond) {
  script_->answers = {lost()};
  auto found = measure(0);
  question();
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Skip}));
  const auto answer = found.get();
  ASSERT_TRUE(answer) << answer.error().text();
  EXPECT_EQ(answer->status, MeasurementStatus::Skipped);
  EXPECT_EQ(answer->decision.by, Decider::Skip);
  EXPECT_NE(answer->reason.find("skipped by Anna"), std::string::npos);

  script_->answers = {lost()};
  auto second = measure(1);
  EXPECT_NE(question(2).why_not.at("skip").find("2 of 4 targets"), std::string::npos);
  ASSERT_TRUE(tell({.question = 2, .choice = Choice::Again}));
  EXPECT_TRUE(second.get());
}

TEST_F(FourTargets, FitsTheOthersOfASkippedOne) {
  script_->answers = {lost()};
  DiagnosticLog log;
  auto surveyed = begin_survey(log);
  question();
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Skip}));
  const Survey survey = surveyed.get();
  EXPECT_FALSE(log.has_errors()) << all_text(log);
  EXPECT_TRUE(survey.is_complete());
  ASSERT_EQ(survey.series.size(), 1U);
  EXPECT_EQ(survey.series[0].points, (std::vector<std::size_t>{1, 2, 3}));
  EXPECT_TRUE(std::ranges::any_of(log.kept(), [](const Diagnostic& diagnostic) {
    return diagnostic.code == Code::TargetDropped;
  })) << all_text(log);
}

TEST_F(FourTargets, AsksAboutATargetThatItsSeriesContradicts) {
  answer_with_a_displaced_third();
  DiagnosticLog log;
  auto surveyed = begin_survey(log);
  const ScreenQuestion asked = question();
  EXPECT_EQ(asked.seq, 2);
  EXPECT_NE(std::ranges::find(asked.choices, "keep"), asked.choices.end());
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Again}));
  const Survey survey = surveyed.get();
  EXPECT_FALSE(log.has_errors()) << all_text(log);
  EXPECT_TRUE(survey.is_accepted());
  EXPECT_EQ(survey.measurements[2].decision.by, Decider::Camera);
  // In the journal as well, which still takes more.
  EXPECT_TRUE(job_folder_->append(internal::JobChoice{2, "x", "Anna", "now"}));
  ASSERT_EQ(job_folder_->measurements().size(), 4U);
  EXPECT_EQ(job_folder_->measurements()[2].decision.by, Decider::Camera);
}

TEST_F(FourTargets, HoldsTheJobWhereAPersonKeepsAContradictedTarget) {
  answer_with_a_displaced_third();
  DiagnosticLog log;
  auto surveyed = begin_survey(log);
  question();
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Keep}));
  const Survey survey = surveyed.get();
  EXPECT_TRUE(log.has_errors());
  EXPECT_FALSE(survey.is_accepted());
  EXPECT_FALSE(survey.measurements[2].decision.is_by_person());
  ASSERT_EQ(job_folder_->choices().size(), 1U);
  EXPECT_EQ(job_folder_->choices()[0].who, "Anna");
}

TEST_F(OperatorSourceTest, TakesOneAnswerToOneQuestion) {
  script_->answers = {lost()};
  auto found = measure(0);
  question();
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Hand, .at_px = {{100, 100}}}));
  EXPECT_FALSE(tell({.question = 1, .choice = Choice::Hand, .at_px = {{200, 200}}}));
  const auto answer = found.get();
  ASSERT_TRUE(answer);
  EXPECT_LT(answer->measured.position.in_mm().x(), request(0).expected.in_mm().x());
}

TEST_F(OperatorSourceTest, AsksAgainWhereAnAnswerCannotBeCarriedOut) {
  const auto broken = [] {
    return failure({Code::PictureMissing, {"images.csv", 0, 0}, "no picture is there", ""});
  };
  script_->answers.emplace_back(lost());
  script_->answers.emplace_back(broken());
  auto found = measure(0);
  question();
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Search, .at_px = {{10, 10}}}));
  EXPECT_NE(question(2).reason.find("no picture is there"), std::string::npos);
  ASSERT_TRUE(tell({.question = 2, .choice = Choice::Again}));
  EXPECT_TRUE(found.get());
}

TEST_F(OperatorSourceTest, JogsWithinTheSearchRadius) {
  script_->answers = {lost()};
  auto found = measure(0);
  question();
  EXPECT_FALSE(jog(0.95, 0));  // search_radius_mm = 0.9
  ASSERT_TRUE(jog(0.5, 0));
  EXPECT_FALSE(jog(0.5, 0));
  // When its picture is there, a pixel of it is a place beside.
  while (desk_->read([](const Screen& screen) { return screen.job->question->is_jogging; })) {
    desk_->wait(desk_->state().number, ~std::uint64_t{0}, std::chrono::milliseconds(20));
  }
  const std::uint64_t frame = desk_->read([](const Screen& screen) { return screen.frame; });
  EXPECT_FALSE(
      tell({.question = 1, .choice = Choice::Hand, .at_px = {{142.7, 115.4}}, .frame = 1}));
  ASSERT_TRUE(
      tell({.question = 1, .choice = Choice::Hand, .at_px = {{142.7, 115.4}}, .frame = frame}));
  const auto answer = found.get();
  ASSERT_TRUE(answer);
  EXPECT_NEAR(answer->measured.position.in_mm().x() - request(0).expected.in_mm().x(), 0.5, 1e-9);
}

TEST_F(OperatorSourceTest, ShowsWhatTheCameraSeesWhileAQuestionIsOpen) {
  OperatorSource::Station live{
      *desk_, *job_folder_, *feed_, machine_, nominal_, clock_, n_questions_};
  live.is_live = true;
  source_.emplace(live, script_, script_.get(), std::map<std::int64_t, Measurement>());
  script_->answers = {lost()};
  desk_->set_watched(true);
  auto found = measure(0);
  question();
  const std::uint64_t first = desk_->frame()->number;
  while (desk_->frame()->number < first + 2) {
    desk_->wait(~std::uint64_t{0}, desk_->frame()->number, std::chrono::seconds(1));
  }
  ASSERT_TRUE(tell({.question = 1, .choice = Choice::Again}));
  ASSERT_TRUE(found.get());
  // The camera did not move for it.
  for (const View& view : script_->views) {
    EXPECT_EQ(view.axis, request(0).expected_in_machine());
  }
  EXPECT_GE(script_->views.size(), 2U);
}

TEST_F(OperatorSourceTest, EndsByAStop) {
  script_->answers = {lost()};
  auto found = measure(0);
  question();
  ASSERT_TRUE(desk_->try_change([&](Screen&) -> Expected<void> {
    desk_->stop();
    return {};
  }));
  const auto answer = found.get();
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, Code::Interrupted);
  EXPECT_TRUE(job_folder_->measurements().empty());
}

}  // namespace
}  // namespace panelcal::test
