# `cmake --install`: the programs with their manual, and what a rig's own program links, for find_package(cagefit).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS cagefit cagefitd)
install(DIRECTORY ${CMAKE_BINARY_DIR}/manual/man/ DESTINATION ${CMAKE_INSTALL_MANDIR})
install(DIRECTORY ${CMAKE_BINARY_DIR}/manual/bash-completion/ DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion)

# Headers lie in a folder of their own, so that "client/fit_client.h" there meets no other project's.
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/cagefit)
set(libraries base mesh cloud image codec proto client)
foreach(library ${libraries})
  set_target_properties(cagefit_${library} PROPERTIES EXPORT_NAME ${library})
  target_include_directories(cagefit_${library} INTERFACE $<INSTALL_INTERFACE:${headers}>)
  install(TARGETS cagefit_${library} EXPORT cagefit)
endforeach()
foreach(folder core/base core/mesh core/cloud core/image core/codec client)
  install(DIRECTORY ${folder}/ DESTINATION ${headers}/${folder} FILES_MATCHING PATTERN "*.h"
    PATTERN commands EXCLUDE PATTERN io EXCLUDE PATTERN python EXCLUDE PATTERN report EXCLUDE PATTERN synth EXCLUDE
    PATTERN example EXCLUDE PATTERN embedded_server.h EXCLUDE PATTERN encode_frame.h EXCLUDE
    PATTERN limit_surface.h EXCLUDE)
endforeach()
install(FILES ${PROJECT_BINARY_DIR}/proto/cagefit/v1/fitting.pb.h ${PROJECT_BINARY_DIR}/proto/cagefit/v1/fitting.grpc.pb.h
  DESTINATION ${headers}/cagefit/v1)
install(FILES proto/cagefit/v1/fitting.proto DESTINATION ${CMAKE_INSTALL_DATADIR}/cagefit/cagefit/v1)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/cagefit)
install(EXPORT cagefit NAMESPACE cagefit:: FILE cagefitTargets.cmake DESTINATION ${package})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cagefitConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/cagefitConfig.cmake ${PROJECT_BINARY_DIR}/cagefitConfigVersion.cmake DESTINATION ${package})
