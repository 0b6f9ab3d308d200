// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/models.h"

#include <optional>
#include <string>
#include <vector>

#include "tools/plan/design/design.h"
#include <gtest/gtest.h>

namespace panelcal::plan {
namespace {

// The judge of the rule is the walk: what it fits to a series on a perfect panel.

/// Not in one line, whatever their number.
std::string place(int i) {
  return "X" + std::to_string(10 * i) + ".Y" + std::to_string(i * i + 20 * (i % 2)) + ".";
}

std::string excellon_program(int n) {
  std::string text = "M48\nMETRIC,TZ\nT1C1.0\n%\nG34,1\n";
  for (int i = 0; i < n; ++i) text += "G36" + place(i) + "\n";
  return text + "T1\nX1.0Y1.0\nM30\n";
}

/// Measurement mode 5 sees one coordinate of each target, other modes two.
std::string sieb_meyer_program(int n) {
  std::string text = "%%5000\n";
  for (int i = 0; i < n; ++i) text += place(i) + (i % 3 == 2 ? "G33\n" : "G32\n");
  return text + "G31\nX1.Y1.T1\nG30\n$\nT1D1.F6.\n$\n";
}

/// Number of series on which the rule was compared.
std::size_t expect_as_walked(const std::string& file,
                             const std::string& text,
                             WalkOptions options) {
  DiagnosticLog log;
  const Program program = load_program({file, text}, log);
  NominalSource source;
  const Survey found = survey(program, options, source, log);
  EXPECT_FALSE(log.has_errors()) << log.kept().front().text() << "\n" << text;
  const ModelRule rule{program.dialect, options.model, options.sieb_meyer.fits_scale};
  for (const SeriesResult& series : found.series) {
    EXPECT_EQ(name(rule(series.level, design_of(found, series))), name(series.model)) << text;
  }
  return found.series.size();
}

const std::vector<std::optional<PanelModel>> kFixed = {
    std::nullopt, PanelModel::Offset, PanelModel::Rigid};

TEST(ModelRule, IsThatOfTheWalkInExcellon) {
  for (const auto& fixed : kFixed) {
    for (int n = 1; n <= 5; ++n) {
      WalkOptions options;
      options.series_size = n;
      options.model = fixed;
      EXPECT_EQ(expect_as_walked("p.exc", excellon_program(n), options), 1u);
    }
  }
}

TEST(ModelRule, IsThatOfTheWalkInSiebMeyer) {
  for (const auto& fixed : kFixed) {
    for (const bool fits_scale : {false, true}) {
      for (const int mode : {1, 5}) {
        // One slot does not determine an offset.
        for (int n = mode == 5 ? 3 : 1; n <= 7; ++n) {
          WalkOptions options;
          options.model = fixed;
          options.sieb_meyer.measurement_mode = mode;
          options.sieb_meyer.fits_scale = fits_scale;
          EXPECT_EQ(expect_as_walked("p.s5", sieb_meyer_program(n), options), 1u);
        }
      }
    }
  }
}

TEST(ModelRule, GivesAPatternOfSiebMeyerAnOffsetForAtMostTwo) {
  const std::vector<DesignTarget> two(2);
  const ModelRule rule{Dialect::SiebMeyer, PanelModel::Affine, true};
  EXPECT_EQ(rule(CorrectionLevel::Nested, two), PanelModel::Offset);
  EXPECT_EQ(rule.most_targets(CorrectionLevel::Nested), 2u);
  EXPECT_GT(rule.most_targets(CorrectionLevel::Base), 1000u);
}

}  // namespace
}  // namespace panelcal::plan
