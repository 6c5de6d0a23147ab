# palpate_page(TARGET WHAT OUTPUT_ARGUMENT FILES...): a page that is built once from this folder's src/ and from shared/, then
# part of the program. TARGET makes FILES by `node build.mjs OUTPUT_ARGUMENT`; WHAT is for messages.
#
# npm works in the build tree on a copy of the sources, which lie there as they do here; the source tree stays as it is.
find_program(PALPATE_NPM npm)
find_program(PALPATE_NODE NAMES node nodejs)
if(NOT PALPATE_NPM OR NOT PALPATE_NODE)
  message(FATAL_ERROR "npm is needed to build the pages: apt-get install npm, or configure with -DPALPATE_APPS=OFF")
endif()
set(PALPATE_SHARED_PAGE_SOURCES ${CMAKE_CURRENT_LIST_DIR}/shared)

function(palpate_page target what output)
  set(work ${CMAKE_CURRENT_BINARY_DIR})
  set(source ${CMAKE_CURRENT_SOURCE_DIR})
  set(shared ${PALPATE_SHARED_PAGE_SOURCES})
  get_filename_component(name ${source} NAME)
  set(copy ${work}/${name})
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
  file(GLOB sources CONFIGURE_DEPENDS ${source}/src/* ${shared}/*)
  add_custom_command(
    OUTPUT ${ARGN}
    COMMAND ${CMAKE_COMMAND} -E rm -rf ${copy} ${work}/shared
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${source}/src ${copy}/src
    COMMAND ${CMAKE_COMMAND} -E copy_directory ${shared} ${work}/shared
    COMMAND ${CMAKE_COMMAND} -E copy ${source}/build.mjs ${copy}
    COMMAND ${PALPATE_NODE} ${copy}/build.mjs ${output}
    DEPENDS ${stamp} ${sources} ${source}/build.mjs
    WORKING_DIRECTORY ${work}
    COMMENT "Bundling the ${what}"
    VERBATIM)
  add_custom_target(${target} DEPENDS ${ARGN})
endfunction()
