# Run by CPack on what it is about to pack: Debian's policy wants man pages and changelogs compressed.
file(GLOB_RECURSE documents ${CPACK_TEMPORARY_DIRECTORY}/palpate*.1 ${CPACK_TEMPORARY_DIRECTORY}/changelog
     ${CPACK_TEMPORARY_DIRECTORY}/CHANGELOG.md)
foreach(document IN LISTS documents)
  execute_process(COMMAND gzip -9nf ${document} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
