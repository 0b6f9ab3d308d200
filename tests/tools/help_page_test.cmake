# SPDX-License-Identifier: Apache-2.0
execute_process(COMMAND "${PANELCAL}" help "${TOPIC}" OUTPUT_VARIABLE page RESULT_VARIABLE result)
file(READ "${FILE}" written)
if(NOT result EQUAL 0 OR NOT page STREQUAL written)
  message(FATAL_ERROR "${FILE} is not what `panelcal help ${TOPIC}` prints; write it anew")
endif()
