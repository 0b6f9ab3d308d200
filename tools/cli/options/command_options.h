// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/options/options.h"

namespace CLI {
class App;
}

// Registers the options of each command, which fill `o`; it must outlive `command`. The rows of
// tools/cli/command_table.cc name them.
namespace panelcal {

void add_init_options(CLI::App& command, InitOptions& o);
void add_doctor_options(CLI::App& command, DoctorOptions& o);
void add_check_options(CLI::App& command, CheckOptions& o);
void add_survey_options(CLI::App& command, SurveyOptions& o);
void add_plan_options(CLI::App& command, PlanOptions& o);
void add_align_options(CLI::App& command, AlignOptions& o);
void add_align_show_options(CLI::App& command, AlignOptions& o);
void add_align_verify_options(CLI::App& command, AlignOptions& o);
void add_run_options(CLI::App& command, RunOptions& o);
void add_translate_options(CLI::App& command, TranslateOptions& o);
void add_locate_options(CLI::App& command, LocateCommandOptions& o);
void add_synth_options(CLI::App& command, SynthOptions& o);
void add_batch_options(CLI::App& command, BatchOptions& o);
void add_batch_merge_options(CLI::App& command, BatchReportOptions& o);
void add_batch_push_options(CLI::App& command, BatchReportOptions& o);
void add_batch_report_options(CLI::App& command, BatchReportOptions& o);
void add_batch_show_options(CLI::App& command, BatchReportOptions& o);
void add_nightly_options(CLI::App& command, NightlyOptions& o);
void add_serve_options(CLI::App& command, ServeOptions& o);

void add_calibrate_spindle_camera_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_camera_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_camera_import_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_camera_export_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_table_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_surface_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_focus_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_light_options(CLI::App& command, CalibrateOptions& o);
void add_calibrate_settle_options(CLI::App& command, CalibrateOptions& o);

void add_history_list_options(CLI::App& command, HistoryOptions& o);
void add_history_export_options(CLI::App& command, HistoryOptions& o);
void add_history_show_options(CLI::App& command, HistoryOptions& o);
void add_history_diff_options(CLI::App& command, HistoryOptions& o);
void add_history_rollback_options(CLI::App& command, HistoryOptions& o);
void add_history_fresh_start_options(CLI::App& command, HistoryOptions& o);
void add_history_plot_options(CLI::App& command, HistoryOptions& o);
void add_history_verify_options(CLI::App& command, HistoryOptions& o);
void add_history_push_options(CLI::App& command, HistoryOptions& o);
void add_history_fleet_options(CLI::App& command, HistoryOptions& o);
void add_history_certificate_options(CLI::App& command, HistoryOptions& o);

void add_align_apply_options(CLI::App& command, ApplyOptions& o);
void add_filter_options(CLI::App& command, ApplyOptions& o);

void add_surface_fit_options(CLI::App& command, SurfaceOptions& o);
void add_surface_query_options(CLI::App& command, SurfaceOptions& o);
void add_surface_diff_options(CLI::App& command, SurfaceOptions& o);
void add_surface_plan_options(CLI::App& command, SurfaceOptions& o);
void add_surface_apply_options(CLI::App& command, SurfaceOptions& o);
void add_surface_export_options(CLI::App& command, SurfaceOptions& o);

}  // namespace panelcal
