# palpate_page(TARGET WHAT OUTPUT_ARGUMENT FILES...): a page that is built once from this folder's src/, then part of the
# program. TARGET makes FILES by `node build.mjs OUTPUT_ARGUMENT`; WHAT is for messages.
#
# npm works in the build tree on a copy of the sources; the source tree stays as it is.
find_program(PALPATE_NPM npm)
find_program(PALPATE_NODE NAMES node nodejs)
if(NOT PALPATE_NPM OR NOT PALPATE_NODE)
  message(FATAL_ERROR "npm is needed to build the pages: apt-get install npm, or configure with -DPALPATE_APPS=OFF")
endif()

function(palpate_page target what output)
  set(work ${CMAKE_CURRENT_BINARY_DIR})
  set(source ${CMAKE_CURRENT_SOURCE_DIR})
  set(stamp ${work}/packages.stamp)
  set(packages ${source}/package.json ${source}/package-lock.json)
  # esbuild comes as a ready program, so no package has to run an install script.
  add_custom_command(
    OUTPUT ${stamp}
    COMMAND ${CMAKE_COMMAND} -E copy ${packages} ${work}
    COMMAND ${PALPATE_NPM} ci --no-audit --no-fund --ignore-scripts
    COMMAND ${CMAKE_COMMAND} -E touch ${stamp}
    DEPENDS ${packages}
    WORKING_DIRECTORY ${work}
    COMMENT "Fetching the packages of the ${what}"
    VERBATIM)
  file(GLOB sources CONFIGURE_DEPENDS ${source}/src/*)
  add_custom_command(
    OUTPUT ${ARGN}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${work}/src
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${source}/src ${work}/src
    COMMAND ${CMAKE_COMMAND} -E copy ${source}/build.mjs ${work}
    COMMAND ${PALPATE_NODE} build.mjs ${output}
    DEPENDS ${stamp} ${sources} ${source}/build.mjs
    WORKING_DIRECTORY ${work}
    COMMENT "Bundling the ${what}"
    VERBATIM)
  add_custom_target(${target} DEPENDS ${ARGN})
endfunction()
