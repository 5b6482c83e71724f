include(CMakePackageConfigHelpers)

set(LCOR_CMAKEDIR ${CMAKE_INSTALL_LIBDIR}/cmake/lcor)
install(TARGETS lcor EXPORT lcorTargets FILE_SET HEADERS)
install(EXPORT lcorTargets NAMESPACE lcor:: DESTINATION ${LCOR_CMAKEDIR})
configure_package_config_file(cmake/lcorConfig.cmake.in lcorConfig.cmake
  INSTALL_DESTINATION ${LCOR_CMAKEDIR})
write_basic_package_version_file(lcorConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/lcorConfig.cmake ${PROJECT_BINARY_DIR}/lcorConfigVersion.cmake
  DESTINATION ${LCOR_CMAKEDIR})

# pkg-config finds its prefix from where the file lies, so an installed tree can be moved. A library
# folder outside the prefix cannot be relative to it and is written as it is.
if(IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}" OR IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
  set(LCOR_PC_PREFIX "${CMAKE_INSTALL_PREFIX}")
else()
  file(RELATIVE_PATH LCOR_PC_UP "/prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/prefix")
  string(REGEX REPLACE "/$" "" LCOR_PC_UP "${LCOR_PC_UP}")
  set(LCOR_PC_PREFIX "\${pcfiledir}/${LCOR_PC_UP}")
endif()
foreach(dir IN ITEMS LIBDIR INCLUDEDIR)
  if(IS_ABSOLUTE "${CMAKE_INSTALL_${dir}}")
    set(LCOR_PC_${dir} "${CMAKE_INSTALL_${dir}}")
  else()
    set(LCOR_PC_${dir} "\${prefix}/${CMAKE_INSTALL_${dir}}")
  endif()
endforeach()
configure_file(cmake/lcor.pc.in lcor.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/lcor.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
