// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/command_table.h"

#include <array>
#include <variant>

#include "tools/cli/help/align_pages.h"
#include "tools/cli/help/apply_pages.h"
#include "tools/cli/help/batch_pages.h"
#include "tools/cli/help/calibrate_pages.h"
#include "tools/cli/help/history_pages.h"
#include "tools/cli/help/job_pages.h"
#include "tools/cli/help/serve_page.h"
#include "tools/cli/help/surface_pages.h"
#include "tools/cli/options/command_options.h"

namespace panelcal {
namespace {

/// Makes the options that a command fills, and hands them to what executes it.
template <class OptionsOf,
          void (*kAdd)(CLI::App&, OptionsOf&),
          Expected<Answer> (*kRun)(const OptionsOf&, CommandContext&) = run_command>
constexpr CommandRow row(std::string_view name, std::string_view summary, std::string_view page) {
  return {name,
          summary,
          page,
          [](CLI::App& command, CommandOptions& options) {
            kAdd(command, options.emplace<OptionsOf>());
          },
          [](CommandContext& context) {
            return kRun(std::get<OptionsOf>(context.options.command), context);
          }};
}

constexpr auto kCommands = std::to_array<CommandRow>({
    row<InitOptions, add_init_options>(
        "init", "Write a machine file with comments, for a start", pages::kInit),
    row<CheckOptions, add_check_options>(
        "check", "Read and verify a part program, a machine file, or both", pages::kCheck),
    row<DoctorOptions, add_doctor_options>(
        "doctor", "Say what of a machine is missing, assumed, stale or broken", pages::kDoctor),
    row<SurveyOptions, add_survey_options>(
        "survey", "List the measurements and probes a program asks for, in order", pages::kSurvey),
    row<PlanOptions, add_plan_options>(
        "plan",
        "Predict before the job how sure its targets make every hole, and what helps",
        pages::kPlan),
    row<RunOptions, add_run_options>(
        "run", "Measure, fit, gate, correct and write a program", pages::kRun),
    row<AlignOptions, add_align_options, align::measure>(
        "align", "Measure a panel once, for all of its programs", pages::kAlign),
    row<AlignOptions, add_align_verify_options, align::verify>(
        "align verify", "Look at two pads again: has the panel moved since?", pages::kAlignVerify),
    row<AlignOptions, add_align_show_options, align::show>(
        "align show", "Say what an alignment knows, and whether it is in force", pages::kAlignShow),
    row<ApplyOptions, add_align_apply_options, align::apply>(
        "align apply", "Move a G-code program to where the board lies", pages::kAlignApply),
    row<ApplyOptions, add_filter_options, align::filter>(
        "filter",
        "Write G-code for the aligned board: a filter program of LinuxCNC",
        pages::kFilter),
    row<TranslateOptions, add_translate_options>(
        "translate", "Write a program in the other language, patterns and all", pages::kTranslate),
    row<LocateCommandOptions, add_locate_options>(
        "locate", "Find a target in pictures", pages::kLocate),
    row<SynthOptions, add_synth_options>(
        "synth", "Render the pictures a program asks for, with their truth", pages::kSynth),
    row<BatchOptions, add_batch_options>(
        "batch", "Do many jobs on all cores, and go on where it was ended", pages::kBatch),
    row<BatchReportOptions, add_batch_merge_options, batch::merge>(
        "batch merge", "Put the shards of a batch together", pages::kBatchMerge),
    row<BatchReportOptions, add_batch_push_options, batch::push>(
        "batch push", "Bring the results of a batch into a database", pages::kBatchPush),
    row<BatchReportOptions, add_batch_report_options, batch::report>(
        "batch report", "Write a page of what a batch has found", pages::kBatchReport),
    row<BatchReportOptions, add_batch_show_options, batch::show>(
        "batch show", "Print what a batch has found", pages::kBatchShow),
    {"calibrate", "Calibrate a part of the machine", pages::kCalibrate},
    row<CalibrateOptions, add_calibrate_spindle_camera_options, calibrate::spindle_camera>(
        "calibrate spindle-camera",
        "Find where the camera looks against where the spindle drills, from holes in a coupon",
        pages::kCalibrateSpindleCamera),
    row<CalibrateOptions, add_calibrate_camera_options, calibrate::camera>(
        "calibrate camera",
        "Find scale, rotation, tilt and lens of the camera, from one mark seen all over the "
        "picture",
        pages::kCalibrateCamera),
    row<CalibrateOptions, add_calibrate_camera_import_options, calibrate::camera_import>(
        "calibrate camera-import",
        "Make a calibration of a camera model of OpenCV, ROS or mrcal",
        pages::kCalibrateCameraImport),
    row<CalibrateOptions, add_calibrate_camera_export_options, calibrate::camera_export>(
        "calibrate camera-export",
        "Write a calibration's lens as a camera model of OpenCV, ROS or mrcal",
        pages::kCalibrateCameraExport),
    row<CalibrateOptions, add_calibrate_table_options, calibrate::table>(
        "calibrate table",
        "Find scale, squareness, straightness and the error map of the table, from looks at a "
        "plate of dots",
        pages::kCalibrateTable),
    row<CalibrateOptions, add_calibrate_surface_options, calibrate::surface>(
        "calibrate surface",
        "Record a map of the table's own surface that was probed by hand",
        pages::kCalibrateSurface),
    row<CalibrateOptions, add_calibrate_focus_options, calibrate::focus>(
        "calibrate focus",
        "Find the height at which the camera is sharpest",
        pages::kCalibrateFocus),
    row<CalibrateOptions, add_calibrate_light_options, calibrate::light>(
        "calibrate light",
        "Find the lamp level of best contrast without clipping",
        pages::kCalibrateLight),
    row<CalibrateOptions, add_calibrate_settle_options, calibrate::settle>(
        "calibrate settle", "Find how long to wait after a move", pages::kCalibrateSettle),
    row<NightlyOptions, add_nightly_options>(
        "nightly", "Calibrate the machine at night without a person, and report", pages::kNightly),
    row<ServeOptions, add_serve_options>(
        "serve", "Show the machine in a browser, and let one person operate it", pages::kServe),
    {"history", "Ask a ledger of calibrations, or go back to an earlier one", pages::kHistory},
    row<HistoryOptions, add_history_list_options, history::list>(
        "history list", "Entries, one a line; * is in force", pages::kHistoryList),
    row<HistoryOptions, add_history_export_options, history::export_entries>(
        "history export", "Everything as JSON Lines", pages::kHistoryExport),
    row<HistoryOptions, add_history_show_options, history::show>(
        "history show", "One entry", pages::kHistoryShow),
    row<HistoryOptions, add_history_diff_options, history::diff>(
        "history diff", "What changed from one entry to another", pages::kHistoryDiff),
    row<HistoryOptions, add_history_rollback_options, history::roll_back>(
        "history rollback", "Put an earlier one in force", pages::kHistoryRollback),
    row<HistoryOptions, add_history_fresh_start_options, history::fresh_start>(
        "history fresh-start",
        "Record that later nights are not compared with earlier ones",
        pages::kHistoryFreshStart),
    row<HistoryOptions, add_history_plot_options, history::plot>(
        "history plot", "One parameter over time, a line an entry", pages::kHistoryPlot),
    row<HistoryOptions, add_history_verify_options, history::verify>(
        "history verify",
        "Check every hash of the ledger, and that it has what calibrations and reports note of it",
        pages::kHistoryVerify),
    row<HistoryOptions, add_history_push_options, history::push>(
        "history push", "Bring a ledger and its nights into a database", pages::kHistoryPush),
    row<HistoryOptions, add_history_fleet_options, history::show_fleet>(
        "history fleet", "Say which machines of a database may drill now", pages::kHistoryFleet),
    row<HistoryOptions, add_history_certificate_options, history::certify>(
        "history certificate",
        "State how good a machine is, for its quality file",
        pages::kHistoryCertificate),
    {"surface", "Map probed heights, ask the map, and plan where to probe", pages::kSurface},
    row<SurfaceOptions, add_surface_fit_options, surface::fit>(
        "surface fit", "Make a map of probed heights", pages::kSurfaceFit),
    row<SurfaceOptions, add_surface_query_options, surface::query>(
        "surface query", "Ask a map for heights", pages::kSurfaceQuery),
    row<SurfaceOptions, add_surface_diff_options, surface::diff>(
        "surface diff", "Compare one map with another", pages::kSurfaceDiff),
    row<SurfaceOptions, add_surface_plan_options, surface::plan>(
        "surface plan", "Plan where to probe, and where not to", pages::kSurfacePlan),
    row<SurfaceOptions, add_surface_apply_options, surface::apply>(
        "surface apply", "Make a G-code program follow a map", pages::kSurfaceApply),
    row<SurfaceOptions, add_surface_export_options, surface::export_map>(
        "surface export", "Write a map as the file of another program", pages::kSurfaceExport),
});

}  // namespace

std::span<const CommandRow> command_table() {
  return kCommands;
}

}  // namespace panelcal
