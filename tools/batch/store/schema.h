// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

// The layout of store.sqlite, as docs/formats/store.md explains it.
namespace panelcal::batch {

/// "PCBA", in the file's header.
inline constexpr std::int64_t kStoreApplicationId = 0x50434241;
/// Grows when a column changes its meaning or goes.
inline constexpr std::int64_t kStoreVersion = 1;

struct StoreTable {
  std::string_view name;
  std::string_view columns;  ///< in the order of a StoredRow
  int n_columns;
};

/// In the order of JobTable.
inline constexpr std::array<StoreTable, 6> kStoreTables = {{
    {"job",
     "number, id, state, exit_code, program, machine_file, machine, images, measurements, "
     "source, clock, output, "
     "n_targets, n_found, n_pictures, code, message, factors",
     18},
    {"target",
     "job, seq, line, command, state, status, reason, nominal_x_mm, nominal_y_mm, measured_x_mm, "
     "measured_y_mm, cov_xx_um2, cov_xy_um2, cov_yy_um2, residual_x_um, residual_y_um, error_x_um, "
     "error_y_um, score, image",
     20},
    {"fit",
     "job, series, level, line, model, n_targets, chi_square, degrees_of_freedom, exceedance, "
     "worst_residual_um, shift_x_mm, shift_y_mm, rotation_rad, stretch_x_ppm, stretch_y_ppm, "
     "shear_ppm, is_accepted",
     17},
    {"hole_summary",
     "job, n_holes, n_slots, n_routs, max_shift_um, max_sigma_um, expected_broken, error_rms_um, "
     "error_max_um, uncorrected_rms_um, uncorrected_max_um, mean_normalized_square",
     12},
    {"diagnostic", "job, number, severity, code, text", 5},
    {"picture_quality",
     "job, number, seq, view, image, status, score, contrast, noise, blur_px, excluded, visible, "
     "sigma_px, n_candidates",
     14},
}};

inline constexpr std::string_view kStoreSchema = R"sql(
CREATE TABLE batch(
  panelcal TEXT NOT NULL, manifest TEXT NOT NULL, manifest_sha256 TEXT NOT NULL,
  terms TEXT NOT NULL, clock TEXT NOT NULL, n_jobs INTEGER NOT NULL
) STRICT;
CREATE TABLE session(
  number INTEGER PRIMARY KEY, started TEXT NOT NULL, threads INTEGER NOT NULL,
  n_jobs INTEGER NOT NULL, n_pictures INTEGER NOT NULL, seconds REAL NOT NULL
) STRICT;
CREATE TABLE job(
  number INTEGER PRIMARY KEY, id TEXT NOT NULL UNIQUE, state TEXT NOT NULL,
  exit_code INTEGER NOT NULL, program TEXT NOT NULL, machine_file TEXT NOT NULL, machine TEXT,
  images TEXT, measurements TEXT, source TEXT, clock TEXT NOT NULL, output TEXT, n_targets INTEGER, n_found INTEGER,
  n_pictures INTEGER NOT NULL, code TEXT, message TEXT, factors TEXT NOT NULL
) STRICT;
CREATE TABLE target(
  job INTEGER NOT NULL REFERENCES job, seq INTEGER NOT NULL, line INTEGER NOT NULL,
  command TEXT NOT NULL, state TEXT NOT NULL, status TEXT NOT NULL, reason TEXT NOT NULL,
  nominal_x_mm REAL, nominal_y_mm REAL, measured_x_mm REAL, measured_y_mm REAL,
  cov_xx_um2 REAL, cov_xy_um2 REAL, cov_yy_um2 REAL, residual_x_um REAL, residual_y_um REAL,
  error_x_um REAL, error_y_um REAL, score REAL, image TEXT NOT NULL,
  PRIMARY KEY(job, seq)
) STRICT, WITHOUT ROWID;
CREATE TABLE fit(
  job INTEGER NOT NULL REFERENCES job, series INTEGER NOT NULL, level TEXT NOT NULL,
  line INTEGER NOT NULL, model TEXT NOT NULL, n_targets INTEGER NOT NULL, chi_square REAL,
  degrees_of_freedom INTEGER NOT NULL, exceedance REAL, worst_residual_um REAL,
  shift_x_mm REAL, shift_y_mm REAL, rotation_rad REAL, stretch_x_ppm REAL, stretch_y_ppm REAL,
  shear_ppm REAL, is_accepted INTEGER NOT NULL,
  PRIMARY KEY(job, series)
) STRICT, WITHOUT ROWID;
CREATE TABLE hole_summary(
  job INTEGER PRIMARY KEY REFERENCES job, n_holes INTEGER NOT NULL, n_slots INTEGER NOT NULL,
  n_routs INTEGER NOT NULL, max_shift_um REAL, max_sigma_um REAL, expected_broken REAL,
  error_rms_um REAL, error_max_um REAL, uncorrected_rms_um REAL, uncorrected_max_um REAL,
  mean_normalized_square REAL
) STRICT;
CREATE TABLE diagnostic(
  job INTEGER NOT NULL REFERENCES job, number INTEGER NOT NULL, severity TEXT NOT NULL,
  code TEXT NOT NULL, text TEXT NOT NULL, PRIMARY KEY(job, number)
) STRICT, WITHOUT ROWID;
CREATE TABLE picture_quality(
  job INTEGER NOT NULL REFERENCES job, number INTEGER NOT NULL, seq INTEGER NOT NULL,
  view INTEGER NOT NULL, image TEXT NOT NULL, status TEXT NOT NULL, score REAL, contrast REAL,
  noise REAL, blur_px REAL, excluded REAL, visible REAL, sigma_px REAL,
  n_candidates INTEGER NOT NULL, PRIMARY KEY(job, number)
) STRICT, WITHOUT ROWID;
CREATE VIEW worst_targets AS
  SELECT job.id, target.seq, target.image, target.status, target.state,
    1e3 * sqrt(pow(measured_x_mm - nominal_x_mm, 2) + pow(measured_y_mm - nominal_y_mm, 2))
      AS deviation_um,
    sqrt(pow(residual_x_um, 2) + pow(residual_y_um, 2)) AS residual_um,
    sqrt(pow(error_x_um, 2) + pow(error_y_um, 2)) AS error_um,
    sqrt(cov_xx_um2 + cov_yy_um2) AS sigma_um
  FROM target JOIN job ON job.number = target.job
  ORDER BY coalesce(error_um, residual_um) DESC, job.number, seq;
CREATE VIEW refusals AS
  SELECT state, code, count(*) AS n_jobs, min(number) AS first_job, min(message) AS example
  FROM job WHERE state <> 'drilled' GROUP BY state, code ORDER BY n_jobs DESC, code;
CREATE VIEW drift AS
  SELECT job.machine, substr(job.clock, 1, 10) AS day, count(*) AS n_fits,
    avg(shift_x_mm) AS shift_x_mm, avg(shift_y_mm) AS shift_y_mm,
    avg(rotation_rad) AS rotation_rad, avg(stretch_x_ppm) AS stretch_x_ppm,
    avg(stretch_y_ppm) AS stretch_y_ppm, avg(chi_square / degrees_of_freedom) AS chi_square_ratio
  FROM fit JOIN job ON job.number = fit.job WHERE fit.level = 'base'
  GROUP BY job.machine, day ORDER BY job.machine, day;
CREATE VIEW error_by_condition AS
  SELECT factor.key AS factor, factor.value AS value, count(DISTINCT job.number) AS n_jobs,
    count(*) AS n_targets, avg(target.status = 'found') AS found_rate,
    sqrt(avg(pow(error_x_um, 2) + pow(error_y_um, 2))) AS error_rms_um,
    sqrt(avg(cov_xx_um2 + cov_yy_um2)) AS predicted_rms_um
  FROM job, json_each(job.factors) AS factor JOIN target ON target.job = job.number
  GROUP BY factor.key, factor.value ORDER BY factor.key, factor.value;
)sql";

}  // namespace panelcal::batch
