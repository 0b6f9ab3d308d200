// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

// The tables that batches and ledgers are gathered in, as docs/formats/gathered.md explains them.
// SQLite and PostgreSQL both take these words.
namespace panelcal::gather {

/// The steps from one version to the next: the version of a database is the number of those that it
/// has had. A step is never changed, as there are databases that have had it.
inline constexpr std::array<std::string_view, 1> kMigrations = {
    R"sql(
CREATE TABLE batch(
  id TEXT PRIMARY KEY, panelcal TEXT NOT NULL, manifest TEXT NOT NULL,
  manifest_sha256 TEXT NOT NULL, terms TEXT NOT NULL, clock TEXT NOT NULL, n_jobs BIGINT NOT NULL
);
CREATE TABLE job(
  batch TEXT NOT NULL REFERENCES batch, number BIGINT NOT NULL, id TEXT NOT NULL,
  state TEXT NOT NULL, exit_code BIGINT NOT NULL, program TEXT NOT NULL,
  machine_file TEXT NOT NULL, machine TEXT, images TEXT, measurements TEXT, source TEXT,
  clock TEXT NOT NULL, output TEXT, n_targets BIGINT, n_found BIGINT, n_pictures BIGINT NOT NULL,
  code TEXT, message TEXT, factors TEXT NOT NULL, sha256 TEXT NOT NULL,
  PRIMARY KEY(batch, number)
);
CREATE TABLE target(
  batch TEXT NOT NULL, job BIGINT NOT NULL, seq BIGINT NOT NULL, line BIGINT NOT NULL,
  command TEXT NOT NULL, state TEXT NOT NULL, status TEXT NOT NULL, reason TEXT NOT NULL,
  nominal_x_mm DOUBLE PRECISION, nominal_y_mm DOUBLE PRECISION, measured_x_mm DOUBLE PRECISION,
  measured_y_mm DOUBLE PRECISION, cov_xx_um2 DOUBLE PRECISION, cov_xy_um2 DOUBLE PRECISION,
  cov_yy_um2 DOUBLE PRECISION, residual_x_um DOUBLE PRECISION, residual_y_um DOUBLE PRECISION,
  error_x_um DOUBLE PRECISION, error_y_um DOUBLE PRECISION, score DOUBLE PRECISION,
  image TEXT NOT NULL,
  PRIMARY KEY(batch, job, seq), FOREIGN KEY(batch, job) REFERENCES job(batch, number)
);
CREATE TABLE fit(
  batch TEXT NOT NULL, job BIGINT NOT NULL, series BIGINT NOT NULL, level TEXT NOT NULL,
  line BIGINT NOT NULL, model TEXT NOT NULL, n_targets BIGINT NOT NULL,
  chi_square DOUBLE PRECISION, degrees_of_freedom BIGINT NOT NULL, exceedance DOUBLE PRECISION,
  worst_residual_um DOUBLE PRECISION, shift_x_mm DOUBLE PRECISION, shift_y_mm DOUBLE PRECISION,
  rotation_rad DOUBLE PRECISION, stretch_x_ppm DOUBLE PRECISION, stretch_y_ppm DOUBLE PRECISION,
  shear_ppm DOUBLE PRECISION, is_accepted BIGINT NOT NULL,
  PRIMARY KEY(batch, job, series), FOREIGN KEY(batch, job) REFERENCES job(batch, number)
);
CREATE TABLE hole_summary(
  batch TEXT NOT NULL, job BIGINT NOT NULL, n_holes BIGINT NOT NULL, n_slots BIGINT NOT NULL,
  n_routs BIGINT NOT NULL, max_shift_um DOUBLE PRECISION, max_sigma_um DOUBLE PRECISION,
  expected_broken DOUBLE PRECISION, error_rms_um DOUBLE PRECISION, error_max_um DOUBLE PRECISION,
  uncorrected_rms_um DOUBLE PRECISION, uncorrected_max_um DOUBLE PRECISION,
  mean_normalized_square DOUBLE PRECISION,
  PRIMARY KEY(batch, job), FOREIGN KEY(batch, job) REFERENCES job(batch, number)
);
CREATE TABLE diagnostic(
  batch TEXT NOT NULL, job BIGINT NOT NULL, number BIGINT NOT NULL, severity TEXT NOT NULL,
  code TEXT NOT NULL, text TEXT NOT NULL,
  PRIMARY KEY(batch, job, number), FOREIGN KEY(batch, job) REFERENCES job(batch, number)
);
CREATE TABLE picture_quality(
  batch TEXT NOT NULL, job BIGINT NOT NULL, number BIGINT NOT NULL, seq BIGINT NOT NULL,
  view BIGINT NOT NULL, image TEXT NOT NULL, status TEXT NOT NULL, score DOUBLE PRECISION,
  contrast DOUBLE PRECISION, noise DOUBLE PRECISION, blur_px DOUBLE PRECISION,
  excluded DOUBLE PRECISION, visible DOUBLE PRECISION, sigma_px DOUBLE PRECISION,
  n_candidates BIGINT NOT NULL,
  PRIMARY KEY(batch, job, number), FOREIGN KEY(batch, job) REFERENCES job(batch, number)
);
CREATE TABLE factor(
  batch TEXT NOT NULL, job BIGINT NOT NULL, name TEXT NOT NULL, value TEXT NOT NULL,
  PRIMARY KEY(batch, job, name), FOREIGN KEY(batch, job) REFERENCES job(batch, number)
);
CREATE TABLE ledger(
  id TEXT PRIMARY KEY, file TEXT NOT NULL, n_entries BIGINT NOT NULL, head_sha256 TEXT NOT NULL,
  pushed TEXT NOT NULL
);
CREATE TABLE entry(
  ledger TEXT NOT NULL REFERENCES ledger, number BIGINT NOT NULL, sha256 TEXT NOT NULL,
  time TEXT NOT NULL, machine TEXT NOT NULL, kind TEXT NOT NULL, subject TEXT NOT NULL,
  verdict TEXT NOT NULL, reason TEXT NOT NULL, asked_by TEXT NOT NULL, software TEXT NOT NULL,
  temperature_degc DOUBLE PRECISION, restores BIGINT,
  PRIMARY KEY(ledger, number)
);
CREATE TABLE parameter(
  ledger TEXT NOT NULL, entry BIGINT NOT NULL, number BIGINT NOT NULL, name TEXT NOT NULL,
  value DOUBLE PRECISION, sigma DOUBLE PRECISION, unit TEXT NOT NULL,
  PRIMARY KEY(ledger, entry, number), FOREIGN KEY(ledger, entry) REFERENCES entry(ledger, number)
);
CREATE TABLE night(
  machine TEXT NOT NULL, started TEXT NOT NULL, night TEXT NOT NULL, finished TEXT NOT NULL,
  may_drill BIGINT NOT NULL, drill_until TEXT, outcome TEXT NOT NULL, exit_code BIGINT NOT NULL,
  verdict TEXT NOT NULL, asked_by TEXT NOT NULL, software TEXT NOT NULL,
  ledger_entry BIGINT NOT NULL, ledger_sha256 TEXT NOT NULL, document TEXT NOT NULL,
  pushed TEXT NOT NULL,
  PRIMARY KEY(machine, started, ledger_sha256)
);
CREATE VIEW worst_targets AS
  SELECT job.batch, job.id, target.seq, target.image, target.status, target.state,
    sqrt(residual_x_um * residual_x_um + residual_y_um * residual_y_um) AS residual_um,
    sqrt(error_x_um * error_x_um + error_y_um * error_y_um) AS error_um,
    sqrt(cov_xx_um2 + cov_yy_um2) AS sigma_um
  FROM target JOIN job ON job.batch = target.batch AND job.number = target.job
  ORDER BY coalesce(error_x_um * error_x_um + error_y_um * error_y_um,
                    residual_x_um * residual_x_um + residual_y_um * residual_y_um, 0) DESC;
CREATE VIEW refusals AS
  SELECT batch, state, code, count(*) AS n_jobs, min(number) AS first_job, min(message) AS example
  FROM job WHERE state <> 'drilled' GROUP BY batch, state, code ORDER BY n_jobs DESC;
CREATE VIEW drift AS
  SELECT job.machine, substr(job.clock, 1, 10) AS day, count(*) AS n_fits,
    avg(shift_x_mm) AS shift_x_mm, avg(shift_y_mm) AS shift_y_mm,
    avg(rotation_rad) AS rotation_rad, avg(stretch_x_ppm) AS stretch_x_ppm,
    avg(stretch_y_ppm) AS stretch_y_ppm,
    avg(chi_square / CASE degrees_of_freedom WHEN 0 THEN NULL ELSE degrees_of_freedom END)
      AS chi_square_ratio
  FROM fit JOIN job ON job.batch = fit.batch AND job.number = fit.job
  WHERE fit.level = 'base' GROUP BY job.machine, substr(job.clock, 1, 10);
CREATE VIEW error_by_condition AS
  SELECT factor.batch, factor.name AS factor, factor.value AS value,
    count(DISTINCT factor.job) AS n_jobs, count(*) AS n_targets,
    avg(CASE target.status WHEN 'found' THEN 1.0 ELSE 0.0 END) AS found_rate,
    sqrt(avg(error_x_um * error_x_um + error_y_um * error_y_um)) AS error_rms_um,
    sqrt(avg(cov_xx_um2 + cov_yy_um2)) AS predicted_rms_um
  FROM factor JOIN target ON target.batch = factor.batch AND target.job = factor.job
  GROUP BY factor.batch, factor.name, factor.value;
CREATE VIEW last_night AS
  SELECT * FROM night WHERE NOT EXISTS (
    SELECT 1 FROM night AS later WHERE later.machine = night.machine
      AND (later.finished > night.finished
           OR (later.finished = night.finished AND later.started > night.started)));
)sql"};

}  // namespace panelcal::gather
