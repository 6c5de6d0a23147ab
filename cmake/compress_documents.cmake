# Run by CPack before packing: compresses man pages and changelogs, as Debian's policy requires.
file(GLOB_RECURSE documents ${CPACK_TEMPORARY_DIRECTORY}/palpate*.1 ${CPACK_TEMPORARY_DIRECTORY}/changelog
     ${CPACK_TEMPORARY_DIRECTORY}/CHANGELOG.md)
foreach(document IN LISTS documents)
  execute_process(COMMAND gzip -9nf ${document} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
