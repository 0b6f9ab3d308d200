// SPDX-License-Identifier: Apache-2.0
// All words of the front end, [English, German]. {name} stands for a value.

/** @typedef {"en" | "de"} Language */

const words = {
  // Every page.
  language_switch: ["Deutsch", "English"],
  made_by: ["made by panelcal {version}", "erzeugt von panelcal {version}"],
  unknown_facts: [
    "This page cannot show facts of the kind \u201c{kind}\u201d.",
    "Diese Seite kann Angaben der Art \u201e{kind}\u201c nicht zeigen.",
  ],
  // Charts and arrows.
  chart_entry: ["{state}, entry {entry}", "{state}, Eintrag {entry}"],
  chart_who: ["asked by {who}", "veranlasst von {who}"],
  chart_in_force_then: ["in force after it: {value}", "danach in Kraft: {value}"],
  chart_limit_line: ["limit \u00b1 {limit}", "Grenze \u00b1 {limit}"],
  chart_alarm_line: ["a chart of drift was out of its limit", "eine Driftkarte lag au\u00dfer ihrer Grenze"],
  chart_fresh_line: [
    "fresh start: later nights are not compared with earlier ones",
    "Neubeginn: sp\u00e4tere N\u00e4chte werden nicht mit fr\u00fcheren verglichen",
  ],
  chart_label: [
    "{name} of {title}: {n} values over time; arrow keys read them",
    "{name} von {title}: {n} Werte \u00fcber der Zeit; die Pfeiltasten lesen sie",
  ],
  chart_against: [
    "{name} against what is in force now ({zero}); times in UTC.",
    "{name} gegen\u00fcber dem, was jetzt in Kraft ist ({zero}); Zeiten in UTC.",
  ],
  chart_against_last: [
    "{name} against the last one ({zero}); times in UTC.",
    "{name} gegen\u00fcber dem letzten ({zero}); Zeiten in UTC.",
  ],
  chart_tolerance: ["It may be off by {limit} {unit}.", "Zul\u00e4ssige Abweichung: {limit} {unit}."],
  chart_filled: ["installed, one sigma to either side", "installiert, ein Sigma nach beiden Seiten"],
  chart_hollow: ["measured only", "nur gemessen"],
  chart_cross: ["refused", "abgelehnt"],
  chart_by_hand: ["installed by a person", "von einer Person installiert"],
  chart_ring: ["alarm of drift", "Driftalarm"],
  chart_ringed: ["in force", "in Kraft"],
  chart_step: ["in force", "in Kraft"],
  chart_event: ["fresh start", "Neubeginn"],
  chart_limit: ["limit of the one in force", "Grenze f\u00fcr das, was in Kraft ist"],
  chart_box: ["tonight as predicted, three sigma", "diese Nacht nach der Vorhersage, drei Sigma"],
  arrows_scale: [
    "{length} \u00b5m; arrows {times} times longer than true",
    "{length} \u00b5m; Pfeile {times}-mal l\u00e4nger als wahr",
  ],
  // Nights.
  night_title: ["Night of {night} on {machine}", "Nacht vom {night} an {machine}"],
  night_drill: ["DRILL", "BOHREN"],
  night_hold: ["HOLD", "HALT"],
  night_dry_run: ["DRY RUN", "PROBELAUF"],
  night_next: ["Next:", "Als N\u00e4chstes:"],
  night_next_dry: [
    "Nothing was moved, measured or written: this is what would be done.",
    "Nichts wurde bewegt, gemessen oder geschrieben: so w\u00fcrde verfahren.",
  ],
  night_next_failed: [
    "Repair the failed device or file, then run {command}: it goes on where it stopped.",
    "Das ausgefallene Ger\u00e4t oder die Datei instand setzen, dann {command} ausf\u00fchren: der Lauf setzt dort fort, wo er endete.",
  ],
  night_next_refused: [
    "Drill with the calibrations in force, and examine the refused one before they expire.",
    "Mit den geltenden Kalibrierungen bohren und die abgelehnte untersuchen, bevor sie ablaufen.",
  ],
  night_next_hold: [
    "The first red line names the part to inspect. After a repair, run {command}; after an intended change, record it with panelcal history fresh-start first.",
    "Die erste rote Zeile nennt das Teil, das zu pr\u00fcfen ist. Nach einer Reparatur {command} ausf\u00fchren; eine gewollte \u00c4nderung zuerst mit panelcal history fresh-start festhalten.",
  ],
  night_until: ["may drill until", "darf bohren bis"],
  night_until_hold: ["do not drill", "nicht bohren"],
  night_until_open: ["no end predicted", "kein Ende vorhergesagt"],
  night_until_report: ["or until the next report", "oder bis zum n\u00e4chsten Bericht"],
  night_until_confirmed: ["until an operator has confirmed", "bis eine Bedienperson zustimmt"],
  night_calibrations: ["calibrations", "Kalibrierungen"],
  night_calibrations_remark: ["what became of them", "was aus ihnen wurde"],
  night_none: ["none", "keine"],
  night_self_test: ["Self-test", "Selbsttest"],
  night_checks_of: ["{passed} of {all}", "{passed} von {all}"],
  night_checks_passed: ["checks passed", "Pr\u00fcfungen bestanden"],
  night_checks_failed: ["checks passed: see below", "Pr\u00fcfungen bestanden: siehe unten"],
  night_surface: ["table's surface", "Tischfl\u00e4che"],
  night_surface_mapped: ["mapped", "vermessen"],
  night_surface_first: ["for the first time", "zum ersten Mal"],
  night_surface_moved: ["{change} moved", "{change} bewegt"],
  night_surface_sigma: ["sigma {sigma}, by all its figures", "Sigma {sigma}, nach allen ihren Werten"],
  night_temperature: ["temperature", "Temperatur"],
  night_temperature_of: ["of the machine", "der Maschine"],
  night_not_known: ["not known", "nicht bekannt"],
  night_since_last_week: ["Since last week", "Seit letzter Woche"],
  night_nothing_to_compare: [
    "Nothing to compare with: no calibration of a week ago is known.",
    "Nichts zu vergleichen: keine Kalibrierung von vor einer Woche ist bekannt.",
  ],
  night_notes: ["Notes", "Hinweise"],
  night_state_installed: ["installed", "installiert"],
  night_state_kept_old: ["kept old", "alte beibehalten"],
  night_state_hold: ["hold", "Halt"],
  night_state_failed: ["failed", "gescheitert"],
  night_state_not_reached: ["not reached", "nicht erreicht"],
  night_state_would_run: ["would run", "w\u00fcrde laufen"],
  night_axis: ["axis", "Achse"],
  night_old: ["old", "alt"],
  night_new: ["new", "neu"],
  night_sigma: ["sigma", "Sigma"],
  night_change: ["change", "\u00c4nderung"],
  night_off: ["off the prediction", "neben der Vorhersage"],
  night_predicted_to: ["{off} (predicted to {sigma})", "{off} (vorhergesagt auf {sigma})"],
  night_gates: ["Gates", "Schranken"],
  night_passed: ["passed", "bestanden"],
  night_refused: ["refused", "abgelehnt"],
  night_failed: ["failed", "gescheitert"],
  night_qualities: ["How well it could measure", "Wie gut es messen konnte"],
  night_usual: ["usual", "\u00fcblich"],
  night_unusual: ["unusual", "un\u00fcblich"],
  night_last_nights: ["The last nights: {n}", "Die letzten N\u00e4chte: {n}"],
  night_may_it_be_used: ["May it be used?", "Darf sie benutzt werden?"],
  night_by_nights_before: ["By the nights before alone:", "Nach den N\u00e4chten davor allein:"],
  night_entry: ["entry {id} of the ledger", "Eintrag {id} des Registers"],
  night_in_force: ["in force: entry {id}", "in Kraft: Eintrag {id}"],
  night_file: ["file {file}", "Datei {file}"],
  night_earlier_run: [
    "measured by an earlier run of this night",
    "von einem fr\u00fcheren Lauf dieser Nacht gemessen",
  ],
  night_fit_in_full: ["The fit in full", "Die Anpassung im Einzelnen"],
  night_holes: [
    "Where the drill went: each hole about the fit. Red: left out.",
    "Wohin der Bohrer ging: jedes Loch um die Anpassung. Rot: ausgelassen.",
  ],
  night_holes_off: ["{length} \u00b5m off: ({x}, {y}) \u00b5m", "{length} \u00b5m daneben: ({x}, {y}) \u00b5m"],
  night_hole_outlier: ["left out of the fit", "aus der Anpassung ausgelassen"],
  night_warm_up: ["Warming up", "Warmlauf"],
  night_warm: ["warm", "warm gelaufen"],
  night_warm_up_at: ["after {minutes} min", "nach {minutes} min"],
  night_warm_up_axis: ["from warm, \u00b5m", "von warm aus, \u00b5m"],
  night_minutes: ["minutes", "Minuten"],
  night_warm_up_caption: [
    "The mark while the machine warmed up: x filled, y open, with the fit; the band is the limit, the dashed line where the fit is below it.",
    "Die Marke w\u00e4hrend des Warmlaufs: x gef\u00fcllt, y offen, mit der Anpassung; das Band ist die Grenze, die gestrichelte Linie die Stelle, ab der die Anpassung darunter liegt.",
  ],
  night_origin: ["Origin", "Herkunft"],
  night_started: ["started", "begonnen"],
  night_finished: ["finished", "beendet"],
  night_asked_by: ["asked by", "veranlasst von"],
  night_made_by: ["made by", "erzeugt von"],
  night_machine_file: ["machine file", "Maschinendatei"],
  night_ledger: ["ledger", "Register"],
  night_ledger_head: ["ledger head", "letzter Eintrag des Registers"],
  // Ledgers.
  history_title: ["History in {ledger}", "Verlauf in {ledger}"],
  history_verdict_installed: ["installed", "installiert"],
  history_verdict_refused: ["refused", "abgelehnt"],
  history_verdict_measured: ["measured only", "nur gemessen"],
  history_verdict_rolled_back: ["rolled back", "zur\u00fcckgenommen"],
  history_in_force: ["in force", "in Kraft"],
  history_timeline: ["Entries over time", "Eintr\u00e4ge \u00fcber der Zeit"],
  history_charts: ["Charts", "Verl\u00e4ufe"],
  history_entries: ["Entries", "Eintr\u00e4ge"],
  history_no_entries: ["The ledger has no such entry.", "Das Register hat keinen solchen Eintrag."],
  history_entry: ["entry", "Eintrag"],
  history_entry_of: ["Entry {id}: {subject}", "Eintrag {id}: {subject}"],
  history_time: ["time (UTC)", "Zeit (UTC)"],
  history_subject: ["calibration", "Kalibrierung"],
  history_verdict: ["verdict", "Urteil"],
  history_asked_by: ["asked by", "veranlasst von"],
  history_reason: ["reason", "Grund"],
  history_software: ["made by", "erzeugt von"],
  history_temperature: ["temperature", "Temperatur"],
  history_replaces: ["in place of entry", "anstelle von Eintrag"],
  history_restores: ["puts in force again entry", "setzt wieder in Kraft: Eintrag"],
  history_hash: ["hash", "Pr\u00fcfsumme"],
  history_result_digest: ["SHA-256 of the calibration", "SHA-256 der Kalibrierung"],
  history_parameter: ["parameter", "Parameter"],
  history_parameters: ["Parameters of {subject}", "Parameter von {subject}"],
  history_value: ["value", "Wert"],
  history_inputs: ["Inputs: {n}", "Eingaben: {n}"],
  history_file: ["file", "Datei"],
  history_bytes: ["bytes", "Bytes"],
  history_result: ["The calibration itself", "Die Kalibrierung selbst"],
  history_before: ["before (entry {id})", "vorher (Eintrag {id})"],
  history_after: ["after (entry {id})", "nachher (Eintrag {id})"],
  history_sigmas: ["sigmas", "Sigmas"],
  history_job: ["What it does to {program}", "Was es an {program} \u00e4ndert"],
  history_max: ["largest shift", "gr\u00f6\u00dfte Verschiebung"],
  history_uniform: ["all places move alike", "alle Orte bewegen sich gleich"],
  history_at: ["at {place}", "bei {place}"],
  history_p95: ["95 % move by no more than", "95 % bewegen sich h\u00f6chstens um"],
  history_rms: ["rms {rms}", "Effektivwert {rms}"],
  history_mean_shift: ["mean shift", "mittlere Verschiebung"],
  history_mean_remark: ["of all places", "aller Orte"],
  history_places: ["places", "Orte"],
  history_places_remark: ["{holes} holes; {targets} targets", "{holes} L\u00f6cher; {targets} Zielmarken"],
  history_still: ["not corrected", "nicht korrigiert"],
  history_still_remark: [
    "no target corrects them, so they do not move",
    "keine Zielmarke korrigiert sie, sie bewegen sich nicht",
  ],
  history_moves: [
    "moves by {length} \u00b5m: ({x}, {y}) \u00b5m",
    "bewegt sich um {length} \u00b5m: ({x}, {y}) \u00b5m",
  ],
  history_line: ["{file} line {line}, tool {tool}", "{file} Zeile {line}, Werkzeug {tool}"],
  history_arrows: [
    "{shown} of {all} places; dashes: the outline of all; crosses: targets.",
    "{shown} von {all} Orten; gestrichelt: der Umriss aller; Kreuze: Zielmarken.",
  ],
  history_arrows_worst: ["Red: the largest shift.", "Rot: die gr\u00f6\u00dfte Verschiebung."],
  history_no_routs: [
    "Rout moves are left out: with the other calibration they are cut differently.",
    "Fr\u00e4swege fehlen: mit der anderen Kalibrierung werden sie anders geteilt.",
  ],
  history_surface: ["How the two surfaces differ", "Wie sich die beiden Fl\u00e4chen unterscheiden"],
  history_changed: ["changed", "ver\u00e4ndert"],
  history_scatter: ["no more than scatter", "nicht mehr als Streuung"],
  history_chance: ["chance of as much by scatter alone", "Wahrscheinlichkeit allein durch Streuung"],
  history_offset: ["offset", "Versatz"],
  history_tilt: ["tilt along x; y", "Neigung l\u00e4ngs x; y"],
  history_bow: ["bow along x; y", "W\u00f6lbung l\u00e4ngs x; y"],
  history_greatest: ["greatest", "gr\u00f6\u00dfte"],
  history_verified: ["Every hash is right", "Jede Pr\u00fcfsumme stimmt"],
  history_undamaged: ["undamaged", "unbesch\u00e4digt"],
  history_without_head: ["files that note no entry", "Dateien, die keinen Eintrag nennen"],
};

/** @typedef {keyof typeof words} WordKey */

/** @type {Language} */
let spoken = startLanguage();

/** The language chosen on this page before, or else the browser's; English where it is neither. */
function startLanguage() {
  const asked = new URLSearchParams(location.search).get("language") ?? navigator.language;
  return asked.startsWith("de") ? "de" : "en";
}

/** @returns {Language} */
export function language() {
  return spoken;
}

/** @param {Language} wanted */
export function speak(wanted) {
  spoken = wanted;
  document.documentElement.lang = wanted;
}

/**
 * The words of a key in the language of the page.
 * @param {WordKey} key
 * @param {Record<string, string | number>} [values]
 * @returns {string}
 */
export function word(key, values = {}) {
  const text = words[key][spoken === "de" ? 1 : 0];
  return text.replace(/\{(\w+)\}/g, (whole, name) => String(values[name] ?? whole));
}

/**
 * The same for a word that facts name, such as a status; the fact itself where there is none.
 * @param {string} prefix
 * @param {string} name
 */
export function wordOf(prefix, name) {
  const key = `${prefix}_${name.replace(/[^a-z0-9]+/gi, "_")}`;
  return key in words ? word(/** @type {WordKey} */ (key)) : name;
}
