# SPDX-License-Identifier: Apache-2.0
# Writes manual pages and completion as `share/` of an installation holds them.
#
# In     PROGRAM: panelcal; FOLDER: what becomes share/
function(write_help topic file)
  execute_process(COMMAND "${PROGRAM}" help ${topic} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE "${FOLDER}/${file}" "${text}")
endfunction()

# As Debian wants them: compressed, without a time in them.
function(write_manual_page topic)
  write_help(${topic} man/man1/${topic})
  execute_process(COMMAND gzip -9nf "${FOLDER}/man/man1/${topic}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()

file(REMOVE_RECURSE "${FOLDER}")
write_help(completion.bash bash-completion/completions/panelcal)
write_help(completion.fish fish/vendor_completions.d/panelcal.fish)
write_help(completion.zsh zsh/vendor-completions/_panelcal)
write_manual_page(panelcal.1)
execute_process(COMMAND "${PROGRAM}" help topics OUTPUT_VARIABLE topics COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n\n.*" "" commands "${topics}")
string(REGEX MATCHALL "\n  [a-z-]+( [a-z-]+)?" commands "${commands}")
foreach(command ${commands})
  string(STRIP "${command}" command)
  string(REPLACE " " "-" command "${command}")
  write_manual_page(panelcal-${command}.1)
endforeach()
