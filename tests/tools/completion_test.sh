#!/bin/bash
# SPDX-License-Identifier: Apache-2.0
# What bash offers behind a word of the command line, from `panelcal help completion.bash`.
#
# usage: completion_test.sh PANELCAL
set -u
panelcal=$1
script=$("$panelcal" help completion.bash) || exit 1
eval "$script" || exit 1
status=0

# offers "WORD..." "EXPECTED..."; the last of the words is being typed and may be empty.
offers() {
  local typed=$1 expected=$2
  COMP_WORDS=(panelcal)
  local word
  for word in $typed; do COMP_WORDS+=("$word"); done
  [[ $typed == *' ' || -z $typed ]] && COMP_WORDS+=("")
  COMP_CWORD=$((${#COMP_WORDS[@]} - 1))
  COMPREPLY=()
  _panelcal
  for word in $expected; do
    if [[ " ${COMPREPLY[*]} " != *" $word "* ]]; then
      echo "\"panelcal $typed\" offers \"${COMPREPLY[*]}\"; expected \"$word\" among them"
      status=1
    fi
  done
}

# refuses "WORD..." "WORD": what must not be offered.
refuses() {
  offers "$1" ""
  if [[ " ${COMPREPLY[*]} " == *" $2 "* ]]; then
    echo "\"panelcal $1\" offers \"$2\", which does not belong there"
    status=1
  fi
}

cd "$(mktemp -d)" || exit 1
touch job.exc
offers "" "check run surface history help job.exc"
offers "ru" "run"
offers "surface " "fit query diff plan apply export"
refuses "surface " "run"
offers "surface fit --mod" "--model"
offers "run --to " "jsonl csv excellon sieb-meyer gcode svg"
refuses "run --to " "job.exc"
offers "run job.exc -m " "job.exc"
offers "run --im" "--images"
refuses "plan --add " "job.exc"
# Every command of the table has its options in the script.
for command in check survey plan run translate locate synth nightly "calibrate camera" "history list" "surface query"; do
  offers "$command --" "--help"
done
exit $status
