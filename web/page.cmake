# palpate_page(TARGET WHAT OUTPUT_ARGUMENT FILES...) declares a page built from the current folder's src/ and from
# shared/, to be embedded in the program. TARGET makes FILES with `node build.mjs OUTPUT_ARGUMENT`; WHAT names it in
# messages.
#
# npm runs in the build tree on a copy of the sources with the same layout; the source tree is not changed.
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
  # esbuild comes as a prebuilt executable, so that no package has to run an install script.
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
