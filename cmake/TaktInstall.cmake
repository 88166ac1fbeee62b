# What `cmake --install` gives (docs/plugins.md): bin/takt, lib/ (static libraries and MuJoCo), include/takt as include
# root with the paths of the tree, share/takt with models, schemas and scenarios, and the CMake package takt.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Whoever loads plug-ins has to have all that they may ask for, and show it to them: takt_hosts_plugins(<target>). The
# libraries go in whole; a linker drops what the program itself does not use otherwise.
set(TAKT_HOSTED takt_core_base takt_core_net takt_core_plugin takt_core_kinematics takt_core_motion takt_core_world takt_core_collision
    takt_core_planning takt_core_device takt_core_emulation takt_core_primitives takt_core_rcc takt_core_expression takt_core_command takt_core_command_actions
    takt_core_activity takt_core_operations takt_app_interfaces takt_core_program_language takt_core_program_tree takt_languages_krl takt_languages_urscript takt_languages_scxml takt_languages takt_record)
if(TAKT_SIM)
  list(APPEND TAKT_HOSTED takt_sim takt_cell takt_app_remote takt_app)
endif()
function(takt_hosts_plugins target)
  takt_link_whole(${target} ${TAKT_HOSTED})
  set_target_properties(${target} PROPERTIES ENABLE_EXPORTS ON)
endfunction()

# What a plug-in is compiled with. It links none of takt's libraries: their symbols are those of the program that loads
# it, so that there is one registry and one of everything.
add_library(takt_plugin INTERFACE)
set_target_properties(takt_plugin PROPERTIES EXPORT_NAME plugin)
target_compile_features(takt_plugin INTERFACE cxx_std_23)
target_compile_definitions(takt_plugin INTERFACE TAKT_PLUGIN_BUILD)
target_compile_options(takt_plugin INTERFACE -ffp-contract=off -fno-math-errno)
target_link_libraries(takt_plugin INTERFACE Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
target_include_directories(takt_plugin INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/takt>
  $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<BUILD_INTERFACE:${CMAKE_BINARY_DIR}/generated>)

# Programs and libraries.
set(exported ${TAKT_HOSTED} takt_record_messages takt_duktape ruckig)
foreach(target ${exported})
  string(REGEX REPLACE "^takt_" "" name ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/takt>)
endforeach()
install(TARGETS ${exported} takt_plugin EXPORT taktTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/takt)
install(EXPORT taktTargets NAMESPACE takt:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/takt)

# Headers, by their paths in the tree.
set(folders core languages record)
if(TAKT_SIM)
  list(APPEND folders sim cell app)
endif()
install(DIRECTORY ${folders} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt FILES_MATCHING PATTERN "*.h")
if(TAKT_SIM)  # <takt/takt.h>: what programs of a cell include
  install(FILES app/takt.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt)
  target_include_directories(takt_app INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endif()
install(FILES ${CMAKE_BINARY_DIR}/generated/core/plugin/interface_hash.h
  DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt/core/plugin)

# Data.
set(data ${CMAKE_INSTALL_DATADIR}/takt)
install(DIRECTORY models DESTINATION ${data} PATTERN "CMakeLists.txt" EXCLUDE PATTERN "*.py" EXCLUDE
  PATTERN "made" EXCLUDE)
install(DIRECTORY scenarios schemas DESTINATION ${data})
install(FILES LICENSE README.md DESTINATION ${data})
if(TAKT_SIM)  # the page, if it was built; its licences are in it
  install(DIRECTORY panel/dist DESTINATION ${data}/panel OPTIONAL)
endif()

if(TAKT_SIM)
  set_target_properties(takt PROPERTIES INSTALL_RPATH "$ORIGIN/../${CMAKE_INSTALL_LIBDIR}/takt")
  install(TARGETS takt RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  get_target_property(mujoco_library mujoco IMPORTED_LOCATION)
  get_target_property(mujoco_headers mujoco INTERFACE_INCLUDE_DIRECTORIES)
  get_filename_component(mujoco_file ${mujoco_library} NAME)
  install(FILES ${mujoco_library} DESTINATION ${CMAKE_INSTALL_LIBDIR}/takt)
  install(DIRECTORY ${mujoco_headers}/mujoco DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/takt)
  install(DIRECTORY ${TAKT_COACD_ROOT}/coacd ${TAKT_COACD_ROOT}/coacd.libs DESTINATION ${CMAKE_INSTALL_LIBDIR}/takt
    FILES_MATCHING PATTERN "*.so*")
  install(DIRECTORY ${TAKT_XACRO_ROOT}/xacro DESTINATION ${CMAKE_INSTALL_LIBDIR}/takt/xacro FILES_MATCHING PATTERN "*.py")
endif()

# The licences of all that is in what is installed: MuJoCo is copied, Ruckig and headers are compiled in, the rest is linked.
set(licences ${data}/licenses)
install(FILES ${TAKT_RUCKIG_LICENCES} DESTINATION ${licences}/ruckig)
if(TAKT_SIM)
  install(FILES ${TAKT_MUJOCO_LICENCES} DESTINATION ${licences}/mujoco)
  install(FILES ${TAKT_COACD_ROOT}/coacd-1.0.14.dist-info/LICENSE DESTINATION ${licences}/coacd)
  install(FILES ${TAKT_XACRO_ROOT}/xacro-2.1.1.dist-info/licenses/LICENSE DESTINATION ${licences}/xacro)
  set(compiled_in)
  foreach(header eigen3/Eigen/Core nlohmann/json.hpp CLI/CLI.hpp boost/version.hpp duktape.h)
    find_file(found_header ${header} NO_CACHE)
    list(APPEND compiled_in ${found_header})
    unset(found_header)
  endforeach()
  string(REPLACE ";" " " compiled_in "${compiled_in}")
  install(CODE "execute_process(COMMAND ${Python3_EXECUTABLE} -B ${CMAKE_SOURCE_DIR}/third_party/collect_licences.py
    $<TARGET_FILE:takt> \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${licences}/debian ${compiled_in} COMMAND_ERROR_IS_FATAL ANY)")
endif()

# The package.
configure_package_config_file(cmake/taktConfig.cmake.in ${CMAKE_BINARY_DIR}/taktConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/takt)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/taktConfigVersion.cmake VERSION ${PROJECT_VERSION}
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/taktConfig.cmake ${CMAKE_BINARY_DIR}/taktConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/takt)
