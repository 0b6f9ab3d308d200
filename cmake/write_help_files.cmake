# SPDX-License-Identifier: Apache-2.0
# Writes manual pages and completion as `share/` of an installation holds them.
#
# In     PROGRAM: panelcal; FOLDER: what becomes share/
function(write_help topic file)
  execute_process(COMMAND "${PROGRAM}" help ${topic} OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE "${FOLDER}/${file}" "${text}")
endfunction()

file(REMOVE_RECURSE "${FOLDER}")
write_help(completion.bash bash-completion/completions/panelcal)
write_help(completion.fish fish/vendor_completions.d/panelcal.fish)
write_help(completion.zsh zsh/vendor-completions/_panelcal)
write_help(panelcal.1 man/man1/panelcal.1)
execute_process(COMMAND "${PROGRAM}" help topics OUTPUT_VARIABLE topics COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "\n\n.*" "" commands "${topics}")
string(REGEX MATCHALL "\n  [a-z-]+( [a-z-]+)?" commands "${commands}")
foreach(command ${commands})
  string(STRIP "${command}" command)
  string(REPLACE " " "-" page "panelcal-${command}.1")
  write_help(${page} man/man1/${page})
endforeach()
