# What `cpack` puts into Debian's package; scripts/build_shipped builds what is named here first.
# Of the component `server`, which `cmake --install` leaves out unless it is asked for it.
set(CPACK_GENERATOR DEB)

# The unit, with the paths and the user of a package.
set(unit ${CMAKE_BINARY_DIR}/debian/geodesicd.service)
file(READ ${CMAKE_SOURCE_DIR}/deploy/systemd/geodesicd.service unit_text)
foreach(change "/etc/systemd/system/|/usr/lib/systemd/system/" "/usr/local/bin/|/usr/bin/"
               "DynamicUser=yes|User=geodesicd")
  string(REPLACE "|" ";" change ${change})
  list(GET change 0 from)
  list(GET change 1 to)
  string(FIND "${unit_text}" ${from} place)
  if(place EQUAL -1)
    message(FATAL_ERROR "deploy/systemd/geodesicd.service has no ${from}, which a package changes")
  endif()
  string(REPLACE ${from} ${to} unit_text "${unit_text}")
endforeach()
file(CONFIGURE OUTPUT ${unit} CONTENT "${unit_text}" @ONLY)
set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
             ${CMAKE_SOURCE_DIR}/deploy/systemd/geodesicd.service)

set(in_server COMPONENT server EXCLUDE_FROM_ALL)
install(PROGRAMS ${CMAKE_BINARY_DIR}/program DESTINATION bin RENAME geodesicd ${in_server})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/clients/web/viewer/dist/ DESTINATION share/geodesicd/viewer ${in_server})
install(DIRECTORY ${CMAKE_SOURCE_DIR}/build/docs/ DESTINATION share/geodesicd/docs ${in_server})
install(DIRECTORY ${CMAKE_BINARY_DIR}/samples/ DESTINATION share/geodesicd/samples ${in_server})
install(DIRECTORY ${CMAKE_BINARY_DIR}/licences/ DESTINATION share/doc/geodesicd/licences ${in_server})
install(FILES ${CMAKE_SOURCE_DIR}/LICENSE DESTINATION share/doc/geodesicd RENAME copyright ${in_server})
install(FILES ${CMAKE_BINARY_DIR}/debian/changelog.gz DESTINATION share/doc/geodesicd ${in_server})
install(FILES ${CMAKE_BINARY_DIR}/debian/geodesicd.8.gz DESTINATION share/man/man8 ${in_server})
install(FILES ${unit} DESTINATION lib/systemd/system ${in_server})
install(FILES ${CMAKE_SOURCE_DIR}/deploy/debian/geodesicd.default DESTINATION /etc/default
        RENAME geodesicd ${in_server})

set(CPACK_PACKAGE_NAME geodesicd)
set(CPACK_PACKAGE_CONTACT "The authors of geodesicd <root@localhost>")
set(CPACK_PACKAGE_DESCRIPTION "An HTTP service: upload a mesh once, then ask for distance fields, paths,
isolines and more, as JSON, typed arrays, GLB or pictures. With a viewer for
the browser and its documentation.")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_CMAKE_PROJECTS "${CMAKE_BINARY_DIR};geodesicd;server;/")

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
# Each Debian has other libraries. The next one's package is the newer version.
cmake_host_system_information(RESULT debian QUERY DISTRIB_VERSION_ID)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
if(debian)
  string(APPEND CPACK_DEBIAN_PACKAGE_RELEASE "~deb${debian}")
endif()
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_DEPENDS adduser)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS ca-certificates)  # for a store in object storage
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(scripts ${CMAKE_SOURCE_DIR}/deploy/debian)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
    ${scripts}/postinst ${scripts}/prerm ${scripts}/postrm ${scripts}/conffiles)
include(CPack)
