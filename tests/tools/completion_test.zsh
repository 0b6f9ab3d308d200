#!/usr/bin/env zsh
# SPDX-License-Identifier: Apache-2.0
# What zsh offers behind a word of the command line, from `panelcal help completion.zsh`.
#
# usage: completion_test.zsh PANELCAL
panelcal=$1
integer n_failed=0
typeset -a reply_words

# What the completion system would do with the words that it is given.
compdef() { registered="$*" }
compadd() { shift; reply_words+=("$@") }
_files() { reply_words+=(*(N)) }
eval "$($panelcal help completion.zsh)" || exit 1
[[ $registered == "_panelcal panelcal" ]] || { print "not registered: $registered"; exit 1 }
cd "$(mktemp -d)" || exit 1
touch job.exc

# offered "LINE": fills reply_words; a line that ends with a blank asks for a new word.
offered() {
  words=(panelcal ${=1})
  [[ $1 == *" " || -z $1 ]] && words+=("")
  CURRENT=${#words}
  reply_words=()
  _panelcal
}

offers() {
  local line=$1 word
  shift
  offered "$line"
  for word in "$@"; do
    if (( ! ${reply_words[(Ie)$word]} )); then
      print "\"panelcal $line\" offers \"$reply_words\"; expected \"$word\" among them"
      n_failed=1
    fi
  done
}

refuses() {
  offered "$1"
  if (( ${reply_words[(Ie)$2]} )); then
    print "\"panelcal $1\" offers \"$2\", which does not belong there"
    n_failed=1
  fi
}

offers "" check run surface history help job.exc
offers "surface " fit query diff plan apply export
refuses "surface " run
offers "surface fit --mod" --model
offers "run --to " jsonl csv excellon sieb-meyer gcode svg
refuses "run --to " job.exc
offers "run job.exc -m " job.exc
refuses "plan --add " job.exc
for command in check survey plan run translate locate synth nightly "calibrate camera" "history list" "surface query"; do
  offers "$command --" --help
done
exit $n_failed
