#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Fails if a source file is not formatted, not ASCII, has no licence line, or if prose has a denied word.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
status=0
git ls-files -z '*.cc' '*.h' | xargs -0 clang-format --dry-run --Werror || status=1
if git ls-files -z '*.cc' '*.h' '*.def' '*.sh' '*.cmake' '*CMakeLists.txt' |
  xargs -0 grep -nP '[^\x00-\x7F]'; then
  echo "the lines above are not ASCII" >&2
  status=1
fi
if git ls-files -z '*.cc' '*.h' '*.def' '*.sh' '*.py' '*CMakeLists.txt' |
  xargs -0 grep -L 'SPDX-License-Identifier'| grep .; then
  echo "the files above have no SPDX line" >&2
  status=1
fi
python3 tools/check_words.py || status=1
exit $status
