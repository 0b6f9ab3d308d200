// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/surface/record.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::array<std::string_view, 4> kAreaNames = {"center_x", "center_y", "half_x", "half_y"};

/// Parameters with a variance each, as they are put together.
class Parameters {
 public:
  explicit Parameters(LedgerRecord& record) : record_(record) {}

  void add(std::string_view name, double value_mm, double sigma_mm = 0) {
    record_.parameters.push_back({std::string(name), value_mm, "mm"});
    variances_mm2_.push_back(sigma_mm * sigma_mm);
  }

  /// In     first: covariance of the first parameters
  void finish(const MatrixXd& first) {
    const auto n = static_cast<Index>(variances_mm2_.size());
    MatrixXd cov = Eigen::VectorXd::Map(variances_mm2_.data(), n).asDiagonal();
    cov.topLeftCorner(first.rows(), first.cols()) = first;
    record_.covariance = std::move(cov);
  }

 private:
  LedgerRecord& record_;
  std::vector<double> variances_mm2_;
};

void put_figures(const SurfaceFigures& figures,
                 const std::optional<SurfaceChange>& change,
                 LedgerRecord& record) {
  Parameters parameters(record);
  for (int i = 0; i < SurfaceFigures::kSize; ++i) {
    parameters.add(SurfaceFigures::kNames[static_cast<std::size_t>(i)], figures.value_mm[i]);
  }
  if (change) {
    parameters.add("change_rms", change->rms_mm.value, change->rms_mm.sigma);
    parameters.add("change_greatest", change->greatest_mm.value, change->greatest_mm.sigma);
    parameters.add("change_greatest_x", change->greatest_at_mm.x());
    parameters.add("change_greatest_y", change->greatest_at_mm.y());
  }
  parameters.add(kAreaNames[0], figures.area.center_mm.x());
  parameters.add(kAreaNames[1], figures.area.center_mm.y());
  parameters.add(kAreaNames[2], figures.area.half_mm.x());
  parameters.add(kAreaNames[3], figures.area.half_mm.y());
  parameters.finish(figures.cov_mm2);
}

}  // namespace

LedgerKey surface_key(const MachineConfig& config) {
  return {machine_name(config), LedgerKind::Surface, "table"};
}

Expected<LedgerDraft> surface_draft(const MachineConfig& config,
                                    const StoredMap& map,
                                    const SurfaceFigures& figures,
                                    const std::optional<SurfaceChange>& change,
                                    const RecordWords& words) {
  PANELCAL_TRY(LedgerDraft draft, draft_of(config, surface_key(config), words));
  LedgerRecord& record = draft.record;
  put_figures(figures, change, record);
  draft.result = map_file_text(map);
  if (draft.result.size() <= kMaxLedgerResultBytes) return draft;
  return failure({Code::LedgerEntryInvalid,
                  {},
                  fmt::format("the map's file has {} bytes", draft.result.size()),
                  fmt::format("{} or fewer", kMaxLedgerResultBytes)});
}

std::optional<SurfaceFigures> figures_of(const LedgerEntry& entry) {
  const std::vector<LedgerParameter>& all = entry.record.parameters;
  const auto& cov = entry.record.covariance;
  if (!cov || all.size() < SurfaceFigures::kSize) return std::nullopt;
  SurfaceFigures out;
  for (std::size_t i = 0; i < SurfaceFigures::kSize; ++i) {
    if (all[i].name != SurfaceFigures::kNames[i] || all[i].unit != "mm") return std::nullopt;
    out.value_mm[static_cast<Index>(i)] = all[i].value;
  }
  out.cov_mm2 = cov->topLeftCorner<SurfaceFigures::kSize, SurfaceFigures::kSize>();
  std::array<double, kAreaNames.size()> area = {};
  for (std::size_t i = 0; i < area.size(); ++i) {
    const auto found = entry.record.find(kAreaNames[i]);
    if (!found) return std::nullopt;
    area[i] = all[*found].value;
  }
  out.area = {{area[0], area[1]}, {area[2], area[3]}};
  return out;
}

}  // namespace panelcal
