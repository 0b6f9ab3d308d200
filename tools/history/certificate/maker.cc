// SPDX-License-Identifier: Apache-2.0
#include "tools/history/certificate/maker.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string_view>
#include <utility>

#include "calib/base/amount.h"
#include "calib/table/calibration_file.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/kinds/spindle_camera.h"
#include "machine/config/machine_name.h"
#include "machine/nightly/record/night_history.h"
#include "tools/history/certificate/counted_entries.h"
#include <fmt/format.h>

namespace panelcal::history {
namespace {

constexpr std::string_view kLooks = "looks at a hole";
constexpr std::string_view kHoles = "holes about the fit";

const Scatter* find_scatter(const std::vector<Repeatability>& all,
                            const std::string& subject,
                            std::string_view name) {
  const auto found = std::ranges::find_if(all, [&](const Repeatability& one) {
    return one.subject == "spindle-camera " + subject && one.name == name && one.unit == "mm";
  });
  return found == all.end() ? nullptr : &found->scatter;
}

std::optional<CertifiedNight> certified_night(const LedgerEntry& entry) {
  constexpr std::array<std::string_view, 2> kNames = {"offset_x", "offset_y"};
  const auto found = values_of(entry.record, kNames);
  if (!found) return std::nullopt;
  return CertifiedNight{entry.id,
                        entry.time,
                        entry.record.asked_by,
                        {found->value[0], found->value[1]},
                        {std::sqrt(found->cov(0, 0)), std::sqrt(found->cov(1, 1))}};
}

/// S^2 and u^2 of GaugeStudy, over both axes.
void put_over_nights(const std::vector<CertifiedNight>& nights, GaugeStudy& gauge) {
  const auto n = static_cast<double>(nights.size());
  double squares = 0;
  double within = 0;
  for (std::size_t k = 0; k < 2; ++k) {
    double mean = 0;
    for (const CertifiedNight& night : nights) mean += night.value_mm[k] / n;
    for (const CertifiedNight& night : nights) {
      squares += std::pow(night.value_mm[k] - mean, 2);
      within += std::pow(night.sigma_mm[k], 2);
    }
  }
  gauge.over_nights = {squares / (2 * (n - 1)), 2 * (n - 1)};
  gauge.within_variance = within / (2 * n);
}

/// The parts of a certificate, one after the other.
class Maker {
 public:
  Maker(const Ledger& ledger, const CertificateInput& input, const std::vector<LedgerEntry>& all)
      : ledger_(ledger), input_(input), entries_(all) {
    out_.machine = machine_name(input.config);
    put_tolerance();
    out_.repeatability = repeatability_of(entries_);
  }

  Expected<void> put_spindles();
  Expected<void> put_stage();
  Expected<void> put_plate();
  void put_budgets();
  Certificate take() { return std::move(out_); }

 private:
  void lacks(std::string what, std::string why) {
    out_.not_measured.push_back({std::move(what), std::move(why)});
  }
  void put_tolerance();
  void put_gauge(SpindleCertificate& spindle);
  Expected<void> put_reversal(const SpindleCertificate& spindle);
  Expected<void> check_table_in_use();
  void put_table(const LedgerEntry& entry, const TableCalibration& table);
  void put_observed(const SpindleCertificate& spindle, UncertaintyBudget& budget);
  void put_stated(UncertaintyBudget& budget);

  const Ledger& ledger_;
  const CertificateInput& input_;
  CountedEntries entries_;
  Certificate out_;
  std::optional<LedgerEntry> table_;
  bool is_table_in_use_ = false;  ///< machine.toml names the calibration in force
};

void Maker::put_tolerance() {
  const Tolerances& stated = input_.config.walk.tolerances;
  std::optional<Length> tightest = stated.position;
  for (const ToolTolerance& tool : stated.tools) {
    if (tool.position && (!tightest || *tool.position < *tightest)) tightest = tool.position;
  }
  if (tightest) {
    out_.tolerance_mm = tightest->in_mm();
    out_.tolerance_origin = "[tolerance] position_um, the tightest";
  } else if (input_.config.nightly) {
    out_.tolerance_mm = input_.config.nightly->limits.old.tolerance;
    out_.tolerance_origin = "[nightly.drift] tolerance_um";
  } else {
    lacks("percentage of the tolerance", "machine.toml states none: [tolerance] position_um");
  }
}

void Maker::put_gauge(SpindleCertificate& spindle) {
  const Scatter* const looks = find_scatter(out_.repeatability, spindle.subject, kLooks);
  if (looks == nullptr || spindle.nights.size() < 2) {
    lacks("gauge R&R of " + spindle.subject,
          looks == nullptr
              ? "no night has looked at its holes more than once: [coupon] approaches, and nights"
              : "there are fewer than two nights to compare");
    return;
  }
  GaugeStudy gauge;
  gauge.repeatability = *looks;
  put_over_nights(spindle.nights, gauge);
  if (out_.tolerance_mm) {
    gauge.percent_of_tolerance = 100 * 6 * gauge.both().sigma() / (2 * *out_.tolerance_mm);
  }
  spindle.gauge = gauge;
}

Expected<void> Maker::put_spindles() {
  std::size_t n_most = 0;
  for (const auto& [subject, all] : entries_.of_kind(LedgerKind::SpindleCamera)) {
    SpindleCertificate spindle;
    spindle.subject = subject;
    const LedgerKey key = all.front()->record.key;
    spindle.fresh_start = entries_.fresh_start_of(key);
    for (const LedgerEntry* const entry : all) {
      if (!entries_.is_since_fresh_start(*entry)) continue;
      if (entry->record.verdict == LedgerVerdict::Refused) ++spindle.n_refused;
      if (entries_.is_rolled_back(*entry)) ++spindle.n_rolled_back;
      if (!entries_.counts(*entry)) continue;
      if (const auto night = certified_night(*entry)) spindle.nights.push_back(*night);
    }
    PANELCAL_TRY(const auto in_force, ledger_.in_force(key));
    if (in_force) spindle.in_force = in_force->id;
    n_most = std::max(n_most, spindle.nights.size());
    put_gauge(spindle);
    PANELCAL_CHECK(put_reversal(spindle));
    out_.spindles.push_back(std::move(spindle));
  }
  if (n_most >= 2) return {};
  return failure({Code::LedgerEntryUnknown,
                  {input_.ledger_file, 0, 0},
                  fmt::format("{} of the spindle-camera offset of {} to certify",
                              amount(n_most, "installed calibration"),
                              quoted(out_.machine)),
                  "two or more: `panelcal nightly -m machine.toml`"});
}

/// Reversal value and unidirectional repeatability at the coupon, from what each night's fit has
/// told apart.
Expected<void> Maker::put_reversal(const SpindleCertificate& spindle) {
  std::array<std::vector<double>, 2> backlash_mm;
  std::array<std::vector<double>, 2> scatter_mm;
  for (const CertifiedNight& night : spindle.nights) {
    PANELCAL_TRY(const std::string result, ledger_.result(night.entry));
    const auto calibration =
        parse_spindle_calibration(result, fmt::format("ledger entry {}", night.entry));
    if (!calibration) continue;
    for (const auto& [at, record] : calibration->records) {
      if (!record.quality || subject(at) != spindle.subject) continue;
      for (std::size_t k = 0; k < 2; ++k) {
        if (const auto& um = record.quality->backlash_um[k]) backlash_mm[k].push_back(*um / 1e3);
        if (const auto& both = record.quality->repeatability_um) {
          scatter_mm[k].push_back((*both)[k] / 1e3);
        }
      }
    }
  }
  const std::string origin = "the coupon, " + spindle.subject;
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string axis = k == 0 ? "x" : "y";
    const auto n = static_cast<double>(backlash_mm[k].size());
    if (n < 2) {
      lacks(fmt::format("reversal value B of {} ({})", axis, spindle.subject),
            "fewer than two nights have looked from both sides: [coupon] approaches");
    } else {
      double mean = 0;
      double squares = 0;
      for (const double one : backlash_mm[k]) mean += one / n;
      for (const double one : backlash_mm[k]) squares += std::pow(one - mean, 2);
      out_.stage.push_back({axis,
                            "reversal",
                            mean,
                            std::sqrt(squares / (n - 1) / n),
                            "mm",
                            static_cast<int>(n),
                            origin});
    }
    const auto n_scatters = static_cast<double>(scatter_mm[k].size());
    if (n_scatters == 0) {
      lacks(fmt::format("repeatability of positioning of {} ({})", axis, spindle.subject),
            "no night has told looks and holes apart: look at each hole several times");
      continue;
    }
    double squares = 0;
    for (const double one : scatter_mm[k]) squares += one * one;
    out_.stage.push_back({axis,
                          "repeatability",
                          4 * std::sqrt(squares / n_scatters),
                          std::nullopt,
                          "mm",
                          static_cast<int>(n_scatters),
                          origin});
  }
  return {};
}

/// Range of the map's error along an axis, on the middle line of its rectangle.
double range_along(const TableMap& map, Eigen::Index axis) {
  constexpr int kSteps = 200;
  const TableGrid& grid = map.grid();
  Eigen::Vector2d at_mm = 0.5 * (grid.low_mm + grid.high_mm);
  double low = 0;
  double high = 0;
  for (int i = 0; i <= kSteps; ++i) {
    at_mm[axis] = grid.low_mm[axis] + (grid.high_mm[axis] - grid.low_mm[axis]) * i / kSteps;
    const double error = map.error_mm(position_mm<frame::Machine>(at_mm))[axis];
    low = i == 0 ? error : std::min(low, error);
    high = i == 0 ? error : std::max(high, error);
  }
  return high - low;
}

void Maker::put_table(const LedgerEntry& entry, const TableCalibration& table) {
  const std::string origin = fmt::format("entry {}", entry.id);
  for (const Eigen::Index axis : {0, 1}) {
    out_.stage.push_back({axis == 0 ? "x" : "y",
                          "range",
                          range_along(table.map, axis),
                          std::nullopt,
                          "mm",
                          1,
                          origin});
  }
  for (std::size_t i = 0; i < entry.record.parameters.size(); ++i) {
    const LedgerParameter& one = entry.record.parameters[i];
    const auto k = static_cast<Eigen::Index>(i);
    StageFigure figure;
    figure.quantity = one.name;
    figure.axis = "xy";
    for (const std::string_view axis : {"x", "y"}) {
      const std::size_t at = one.name.find("_" + std::string(axis));
      if (at == std::string::npos) continue;
      figure.axis = axis;
      figure.quantity.erase(at, 2);
    }
    figure.value = one.value;
    if (entry.record.covariance) figure.sigma = std::sqrt((*entry.record.covariance)(k, k));
    figure.unit = one.unit;
    figure.origin = origin;
    out_.stage.push_back(std::move(figure));
  }
  for (const std::string& open : table.undetermined) {
    lacks(open, origin + ": the looks at the plate leave it open");
  }
}

Expected<void> Maker::put_stage() {
  PANELCAL_TRY(table_, ledger_.in_force({out_.machine, LedgerKind::Table, "table"}));
  // What a machine tool's test has and this machine's routine has not.
  lacks("bidirectional accuracy A, systematic deviation E and repeatability R of positioning",
        "ISO 230-2 asks for five runs from each side to five positions or more of an axis; the "
        "ledger has scatter and reversal at the coupon alone");
  if (!table_) {
    lacks("deviation, straightness and squareness of the stage",
          "the ledger has no table in force: `panelcal calibrate table --install`");
    return {};
  }
  out_.table_entry = table_->id;
  PANELCAL_TRY(const std::string result, ledger_.result(table_->id));
  PANELCAL_TRY(const TableCalibration table,
               parse_table_calibration(result, fmt::format("ledger entry {}", table_->id)));
  put_table(*table_, table);
  return {};
}

Expected<void> Maker::check_table_in_use() {
  const std::filesystem::path& file = input_.config.table_file;
  if (!table_ || file.empty()) return {};
  PANELCAL_TRY(const LedgerInput used, input_of(file, kMaxTableCalibrationBytes));
  is_table_in_use_ = used.sha256 == table_->result_sha256;
  if (!is_table_in_use_) {
    lacks("traceability of the map in use",
          fmt::format("{} is not the table in force, entry {}",
                      quoted(file.filename().string()),
                      table_->id));
  }
  return {};
}

Expected<void> Maker::put_plate() {
  PANELCAL_CHECK(check_table_in_use());
  const std::string what = "traceability to the unit of length";
  if (!table_) {
    lacks(what, "no table in force was calibrated on a plate");
    return {};
  }
  if (input_.plate_file.empty()) {
    lacks(what,
          fmt::format("the plate of entry {} is not named: --plate, or [nightly.table] plate",
                      table_->id));
    return {};
  }
  PANELCAL_TRY(CalibrationPlate plate, read_plate(input_.plate_file));
  PANELCAL_TRY(const LedgerInput file, input_of(input_.plate_file, kMaxPlateBytes));
  const auto& inputs = table_->record.inputs;
  if (std::ranges::find(inputs, file.sha256, &LedgerInput::sha256) == inputs.end()) {
    lacks(what,
          fmt::format("{} is no input of entry {}: its SHA-256 is another one",
                      quoted(input_.plate_file),
                      table_->id));
    return {};
  }
  if (!plate.is_certified) {
    lacks(what, fmt::format("plate {} is not certified", quoted(plate.name)));
  } else if (!plate.expanded_uncertainty) {
    lacks("uncertainty of plate " + quoted(plate.name),
          quoted(input_.plate_file) + " does not state it: expanded_uncertainty_um");
  }
  out_.plate = PlateTrace{std::move(plate), file.sha256, table_->id};
  return {};
}

/// What the nights have observed of a spindle.
void Maker::put_observed(const SpindleCertificate& spindle, UncertaintyBudget& budget) {
  std::vector<BudgetRow>& rows = budget.rows;
  const std::string nights = amount(spindle.nights.size(), "night");
  const CertifiedNight& newest = spindle.nights.back();
  std::optional<double> degrees;
  entries_.for_each_companion([&](const LedgerEntry& calibration, const QualityNight& night) {
    if (calibration.id != newest.entry) return;
    for (const NightSpread& spread : night.spreads) {
      if (spread.name == kHoles && spread.degrees_of_freedom > 0) {
        degrees = spread.degrees_of_freedom;
      }
    }
  });
  rows.push_back({"offset", 'A', newest.sigma_mm, degrees, fmt::format("entry {}", newest.entry)});
  if (spindle.gauge) {
    const GaugeStudy& gauge = *spindle.gauge;
    const double between = gauge.reproducibility_variance();
    const double ratio = between / gauge.over_nights.variance;
    rows.push_back({"nights",
                    'A',
                    {std::sqrt(between), std::sqrt(between)},
                    between > 0
                        ? std::optional(gauge.over_nights.degrees_of_freedom * ratio * ratio)
                        : std::nullopt,
                    nights});
  }
  const MachineUncertainty& stated = input_.config.walk.uncertainty;
  const auto put = [&](std::string source,
                       std::string_view name,
                       bool is_stated,
                       Length sigma,
                       const std::string& key) {
    if (const Scatter* const seen = find_scatter(out_.repeatability, spindle.subject, name)) {
      const double sigma_mm = seen->sigma();
      rows.push_back(
          {std::move(source), 'A', {sigma_mm, sigma_mm}, seen->degrees_of_freedom, nights});
    } else if (is_stated) {
      rows.push_back({std::move(source), 'B', {sigma.in_mm(), sigma.in_mm()}, std::nullopt, key});
    } else {
      lacks(fmt::format("{} ({})", name, spindle.subject), "no night has seen it: " + key);
      budget.missing.push_back(std::move(source));
    }
  };
  put("look",
      kLooks,
      stated.states_stage,
      stated.stage_repeatability,
      "[uncertainty] stage_repeatability_um");
  put("drill", kHoles, stated.states_wander, stated.drill_wander, "[uncertainty] drill_wander_um");
}

/// What other knowledge says, the same for all spindles.
void Maker::put_stated(UncertaintyBudget& budget) {
  std::vector<BudgetRow>& rows = budget.rows;
  const MachineUncertainty& stated = input_.config.walk.uncertainty;
  const auto both = [](double sigma_mm) { return std::array<double, 2>{sigma_mm, sigma_mm}; };
  const bool has_map = !input_.config.table_file.empty();
  if (has_map) {
    rows.push_back({"map",
                    'A',
                    both(stated.table_map.in_mm()),
                    std::nullopt,
                    input_.config.table_file.filename().string()});
  }
  if (!has_map && !stated.states_table) budget.missing.emplace_back("table");
  if (stated.states_table) {
    rows.push_back({"table",
                    'B',
                    both(stated.table_residual.in_mm()),
                    std::nullopt,
                    "[uncertainty] table_residual_um"});
  }
  if (is_table_in_use_ && out_.plate && out_.plate->plate.expanded_uncertainty) {
    const CalibrationPlate& plate = out_.plate->plate;
    rows.push_back(
        {"plate",
         'B',
         both(plate.expanded_uncertainty->in_mm() / plate.coverage_factor),
         std::nullopt,
         plate.certificate.empty() ? "[plate] expanded_uncertainty_um" : plate.certificate});
  }
}

void Maker::put_budgets() {
  for (SpindleCertificate& spindle : out_.spindles) {
    if (spindle.nights.empty()) continue;
    UncertaintyBudget budget;
    put_observed(spindle, budget);
    put_stated(budget);
    spindle.budget = std::move(budget);
  }
  const MachineUncertainty& stated = input_.config.walk.uncertainty;
  if (input_.config.table_file.empty() && !stated.states_table) {
    lacks("error of the table in the budget",
          "machine.toml names no [table] calibration and states no [uncertainty] "
          "table_residual_um");
  }
  lacks("targets of a job, expansion of its board, drift since the newest night",
        "they are of the job and its day: `panelcal run --explain`, and the night's forecast");
}

}  // namespace

Expected<Certificate> certificate_of(const Ledger& ledger, const CertificateInput& input) {
  LedgerFilter filter;
  filter.machine = machine_name(input.config);
  filter.since = input.since;
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, ledger.list(filter));
  Maker maker(ledger, input, entries);
  PANELCAL_CHECK(maker.put_spindles());
  PANELCAL_CHECK(maker.put_stage());
  PANELCAL_CHECK(maker.put_plate());
  maker.put_budgets();
  return maker.take();
}

}  // namespace panelcal::history
