#!/usr/bin/env fish
# SPDX-License-Identifier: Apache-2.0
# What fish offers behind a word of the command line, from `panelcal help completion.fish`.
#
# usage: completion_test.fish PANELCAL
set -g panelcal $argv[1]
set -g n_failed 0
$panelcal help completion.fish | source; or exit 1
cd (mktemp -d); or exit 1
touch job.exc

# offered "LINE": the words that fish offers behind it.
function offered
    complete -C "panelcal $argv[1]" | string split -f 1 \t
end

function offers
    set -l words (offered $argv[1])
    for word in $argv[2..-1]
        if not contains -- $word $words
            echo "\"panelcal $argv[1]\" offers \"$words\"; expected \"$word\" among them"
            set -g n_failed 1
        end
    end
end

function refuses
    if contains -- $argv[2] (offered $argv[1])
        echo "\"panelcal $argv[1]\" offers \"$argv[2]\", which does not belong there"
        set -g n_failed 1
    end
end

offers "" check run surface history help job.exc
offers ru run
offers "surface " fit query diff plan apply export
refuses "surface " run
offers "surface fit --mod" --model
offers "run --to " jsonl csv excellon sieb-meyer gcode svg
refuses "run --to " job.exc
offers "run job.exc -m " job.exc
offers "run --im" --images
refuses "plan --add " job.exc
for command in check survey plan run translate locate synth nightly "calibrate camera" "history list" "surface query"
    offers "$command --he" --help
end
exit $n_failed
