// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of `panelcal history`.
namespace panelcal::pages {

inline constexpr std::string_view kHistory = R"(Example
  $ panelcal history list -l drill1.ledger --kind spindle-camera --last 5

A ledger is a file that only grows: every calibration with its inputs, result, covariance and
verdict, each entry chained to the one before it by its hash (docs/decisions/ledger.md). The newest
installed entry is in force; `rollback` puts an earlier one in force, and deletes nothing. This
writes that calibration's file again:
  $ panelcal history show 12 --result -l drill1.ledger -o spindle1.cal.json

This shows how far every hole of a job would move, on a page with arrows:
  $ panelcal history diff 11 12 -l drill1.ledger --program job.exc -m machine.toml \
      --report shift.html

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryList = R"(Example
  $ panelcal history list -l drill1.ledger --kind spindle-camera --last 5

One line an entry, the newest last: number, time, machine, what was calibrated, verdict. * is in
force. --machine, --kind and --subject choose. --report writes a page with all entries over time
and the charts of their parameters, --json the same as facts (share/schema/history.schema.json).

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryExport = R"(Example
  $ panelcal history export -l drill1.ledger --since 2026-11-01 -o november.jsonl

Every entry with all its parameters, covariances, inputs and hashes, as JSON Lines for other
programs (docs/decisions/ledger.md). The ledger itself stays as it is.

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryShow = R"(Example
  $ panelcal history show 12 -l drill1.ledger
  $ panelcal history show 12 --result -l drill1.ledger -o spindle1.cal.json

The first prints parameters with sigmas, verdict, and inputs with their digests; the second writes
the calibration's file as it was installed, byte for byte.

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryDiff = R"(Example
  $ panelcal history diff 11 12 -l drill1.ledger
  $ panelcal history diff 11 12 -l drill1.ledger --program job.exc -m machine.toml \
      --report shift.html

The first prints each parameter before and after, and the change in sigmas; of two surfaces also how
their maps differ. The second says how far every hole of the job would move if 12 took the place of
11, and --report draws it; --measurements of a recorded job says where cameras saw its targets.

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryRollback = R"(Example
  $ panelcal history rollback -l drill1.ledger --machine "drill 1" --kind spindle-camera \
      --subject "spindle 1 station 1" --reason "holes are off since Tuesday"

Puts the entry before in force, or that of --to. Nothing is deleted: the rollback is an entry of its
own, with its reason. The next `panelcal nightly` writes the file of what is in force;
`panelcal history show ID --result -o FILE` writes it at once.

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryFreshStart = R"(Example
  $ panelcal history fresh-start -l drill1.ledger --machine "drill 1" --kind spindle-camera \
      --subject "spindle 1 station 1" --reason "camera mounted anew"

Records that a part was changed knowingly: the next result is compared with no night before it. What
is in force stays in force (docs/howto/nightly.md says when this is right).

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryPlot = R"(Example
  $ panelcal history plot -l drill1.ledger --machine "drill 1" --kind spindle-camera \
      --subject "spindle 1 station 1" --parameter offset_x --report offset.html

Prints one parameter over time, an entry a line: number, time, value, sigma, verdict. --report draws
it with what was in force. `panelcal history show` lists the parameters of an entry.

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or busy, or the disk failed)";

inline constexpr std::string_view kHistoryVerify = R"(Example
  $ panelcal history verify -l drill1.ledger -m machine.toml --against reports

Computes the hash of every entry again, and holds it against the one that the next entry has noted: a
byte that was changed, or an entry that was taken out, is found and named by its number. That the
newest entries were deleted, the hashes alone do not tell. Calibrations, job reports and nights note
the newest entry, and the ledger is held against those that machine.toml names, and those of
--against.

Exit codes
  0 every hash is right and no noted entry is missing; 2 bad input or usage; 3 the ledger is damaged,
  cut off or busy, or the disk failed)";

inline constexpr std::string_view kHistoryPush = R"(Example
  $ panelcal history push -l drill1.ledger --reports reports --store postgresql://drill@db/panelcal
  12 new entries, 3 new nights put into postgresql://drill@db/panelcal

Brings a ledger, and the nights that its reports tell of, into a database of many machines
(docs/formats/gathered.md): PostgreSQL, or a file of SQLite. Every hash of the ledger is checked
first. A ledger that lacks entries which the database has of it, or has them otherwise, was replaced:
it is refused, and nothing is put in. A second push changes nothing but its time. As the last line
of the timer's service it keeps the database as new as the night.

Exit codes
  0 done; 2 bad input or usage; 3 the ledger is damaged or was replaced, or the database cannot be
  reached)";

inline constexpr std::string_view kHistoryFleet = R"(Example
  $ panelcal history fleet --store postgresql://drill@db/panelcal --report fleet.html
  drill    drill 1  until 2026-12-01T11:51:00Z: drill, until 2026-12-01T11:51:00Z
  hold     drill 2  do not drill: spindle-camera spindle 1 station 1: hold: ...
  unknown  drill 3  no night since 2026-11-24T02:10:00Z
  1 of 3 may drill now

Says of every machine whose nights were pushed whether it may drill now: its last night says so, has
ended in the last 36 h (--max-age-h, for machines that do not calibrate every night), its forecast
has not ended, and its ledger has no calibration behind that night. Whatever else there is makes it
"unknown": also two machines of one name. A later night that held, and was not pushed, is not known.
--report is a page, --json the facts (share/schema/fleet.schema.json).

Exit codes
  0 all may drill; 1 some may not, or it is not known; 2 bad input or usage; 3 the database cannot be
  reached)";

inline constexpr std::string_view kHistoryCertificate = R"(Example
  $ panelcal history certificate -l drill1.ledger -m machine.toml --report certificate.html

States from the ledger of a machine, in the words of the GUM (JCGM 100:2008): the repeatability that
its nights have observed (type A, with degrees of freedom), a gauge R&R of its camera as a share of
the tolerance, figures of its stage after ISO 230-2, the plate by which they are traceable, and the
uncertainty budget of a hole with its expanded uncertainty. Refused nights, nights before a fresh
start and what was rolled back are left out and counted. The ledger lacks some of it for most
machines: the end of the page names what was not measured, and why. docs/howto/certificate.md
explains each figure.

The ledger is held against what machine.toml and --against name, as by `panelcal history verify`.

Exit codes
  0 done; 2 bad input, or fewer than two installed spindle-camera offsets; 3 the ledger is damaged,
  cut off or busy, or the disk failed)";

}  // namespace panelcal::pages
