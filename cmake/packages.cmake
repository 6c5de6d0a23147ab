# Debian packages, one per component. Built by tools/packages.sh, or `cpack --config BUILD/CPackConfig.cmake`.
set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_STRIP_FILES ON)
if(BUILD_SHARED_LIBS)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CMAKE_BINARY_DIR}/src/palpate)
endif()
# Independent of the umask.
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/compress_documents.cmake)

# The maintainer is whoever builds the packages, from the environment variables of Debian's own tools.
set(maintainer "Palpate <maintainers@palpate.invalid>")
if(DEFINED ENV{DEBEMAIL} AND DEFINED ENV{DEBFULLNAME})
  set(maintainer "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_PACKAGE_CONTACT ${maintainer})
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${maintainer})

# palpate_package(COMPONENT PACKAGE SECTION SUMMARY TEXT [DEPENDS...]) declares the package of the files installed as
# COMPONENT, with the documents that Debian's policy requires in each package.
macro(palpate_package component package section summary text)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_DESCRIPTION "${summary}\n${text}")
  set(depends ${ARGN})
  list(JOIN depends ", " CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS)
  # With EXCLUDE_FROM_ALL, a plain `cmake --install` omits them.
  install(FILES ${documents}/copyright ${documents}/changelog CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package}
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endmacro()

# palpate_overrides(COMPONENT PACKAGE [LINES]...) writes the lintian overrides of a package, each with its reason.
function(palpate_overrides component package)
  list(JOIN ARGN "\n" lines)
  file(WRITE ${documents}/${package} "${lines}\n")
  install(FILES ${documents}/${package} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides
          COMPONENT ${component} EXCLUDE_FROM_ALL)
endfunction()

set(documents ${CMAKE_BINARY_DIR}/package_documents)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # time of SOURCE_DATE_EPOCH, if set
file(CONFIGURE OUTPUT ${documents}/changelog @ONLY CONTENT [[
palpate (@PROJECT_VERSION@) unstable; urgency=medium

  * Built from the sources of Palpate @PROJECT_VERSION@; CHANGELOG.md.gz says what is new.

 -- @maintainer@  @date@
]])
file(CONFIGURE OUTPUT ${documents}/copyright @ONLY CONTENT [[
Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: Palpate
Comment: The pages within the program hold libraries in JavaScript: three.js, uPlot, Spark, roslib and what
 these are made of. Their licences are served with the pages, as /licences.txt.

Files: *
Copyright: 2026 the Palpate authors
License: Apache-2.0

License: Apache-2.0
 On Debian systems, the full text of the Apache License, version 2.0, is in
 /usr/share/common-licenses/Apache-2.0.
]])

set(about "Palpate renders the forces of captured 3D Gaussian Splatting scenes on haptic
devices. Every Gaussian is an ellipsoid, the tool is one or more ellipsoids,
and a force model turns their contacts into a force.")

# Dependencies found by palpateConfig.cmake, and those linked by the libraries themselves.
set(needed libeigen3-dev libfmt-dev libtbb-dev libhwy-dev libtomlplusplus-dev liborocos-kdl-dev liburdfdom-dev
  libconsole-bridge-dev nlohmann-json3-dev libssl-dev)
if(TARGET palpate_mujoco)
  list(APPEND needed libmujoco-dev)
endif()
set(own)
if(BUILD_SHARED_LIBS)
  # Package name from the soname.
  set(libraries libpalpate${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  palpate_package(palpate_libraries ${libraries} libs "haptic rendering of 3D Gaussian Splatting scenes (libraries)" "${about}
.
This package contains the shared libraries.")
  set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
  file(WRITE ${documents}/triggers "activate-noawait ldconfig\n")
  set(CPACK_DEBIAN_PALPATE_LIBRARIES_PACKAGE_CONTROL_EXTRA ${documents}/triggers)
  palpate_overrides(palpate_libraries ${libraries}
    "# CPack calls it besides the trigger."
    "${libraries}: maintscript-calls-ldconfig *"
    "# They are of one version and need each other."
    "${libraries}: package-name-doesnt-match-sonames *"
    "# That of geometry holds little more than a symbol that says how Eigen is aligned."
    "${libraries}: shared-library-lacks-prerequisites *libpalpate_geometry*")
  set(own "${libraries} (= ${PROJECT_VERSION})")
endif()
palpate_package(palpate_dev libpalpate-dev libdevel "haptic rendering of 3D Gaussian Splatting scenes (development)" "${about}
.
This package contains the headers, libraries and CMake files for programs that
embed it." ${needed} ${own})

if(TARGET palpate_cli)
  palpate_package(palpate_program palpate science "haptic rendering of 3D Gaussian Splatting scenes" "${about}
.
This package contains the command line program and its web viewer." ${own})
endif()

if(TARGET device_ros1 OR TARGET device_ros2)
  palpate_package(palpate_ros palpate-ros science "haptic rendering of 3D Gaussian Splatting scenes (ROS)" "${about}
.
This package contains the nodes for ROS 1 and ROS 2, and the device drivers
that connect the program to any CRTK device." "palpate (= ${PROJECT_VERSION})" ${own})
  palpate_overrides(palpate_ros palpate-ros
    "# CPack calls it for every library in a folder of /usr/lib."
    "palpate-ros: maintscript-calls-ldconfig *")
  set(CPACK_DEBIAN_PALPATE_ROS_PACKAGE_SUGGESTS "python3-rosmaster, python3-roslaunch, rviz")
endif()

include(CPack)
