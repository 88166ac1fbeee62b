# A layer is a folder: takt_layer(<folder with / as _> <targets it may use...>) makes the static library takt_<name>
# from every .cc in the folder. Its tests lie in tests/<folder>, its benchmarks in bench/<folder>.

# What a precompiled header depends on, for ccache: the header itself, the compiler, the libraries in it.
function(takt_pch_checksum target header)
  file(SHA256 ${header} checksum)
  file(SHA256 ${CMAKE_SOURCE_DIR}/cmake/pch.h base)
  set(text "${checksum} ${base} ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION} ${CMAKE_CXX_FLAGS} ${CMAKE_BUILD_TYPE} \
${TAKT_SANITIZE} ${Eigen3_VERSION} ${fmt_VERSION} ${nlohmann_json_VERSION} ${GTest_VERSION}")
  foreach(system_header /usr/include/eigen3/Eigen/Core /usr/include/nlohmann/json.hpp /usr/include/fmt/format.h)
    if(EXISTS ${system_header})
      file(SHA256 ${system_header} checksum)
      string(APPEND text " ${checksum}")
    endif()
  endforeach()
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/${target}.dir/cmake_pch.hxx.gch.sum "${text}\n")
endfunction()

# One precompiled header for all code, one more for tests.
add_library(takt_pch OBJECT ${CMAKE_SOURCE_DIR}/cmake/pch.cc)
target_link_libraries(takt_pch PUBLIC Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
target_include_directories(takt_pch PUBLIC ${CMAKE_SOURCE_DIR})
target_precompile_headers(takt_pch PRIVATE ${CMAKE_SOURCE_DIR}/cmake/pch.h)
takt_pch_checksum(takt_pch ${CMAKE_SOURCE_DIR}/cmake/pch.h)

function(takt_layer name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  set(target takt_${name})
  if(NOT sources)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE ${ARGN} Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
    target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
    return()
  endif()
  add_library(${target} STATIC ${sources})
  target_include_directories(${target} PUBLIC $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}>)
  target_link_libraries(${target} PUBLIC ${ARGN} Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  target_precompile_headers(${target} REUSE_FROM takt_pch)
endfunction()

# takt_link_whole(<target> <libraries...>): all members of these static libraries, used or not. CMake's own
# $<LINK_LIBRARY:WHOLE_ARCHIVE,...> names a library twice where others need it too, and then every symbol is double.
function(takt_link_whole target)
  set(files)
  foreach(library ${ARGN})
    string(APPEND files " $<TARGET_FILE:${library}>")
  endforeach()
  target_link_options(${target} PRIVATE "SHELL:-Wl,--push-state,--whole-archive${files} -Wl,--pop-state")
  target_link_libraries(${target} PRIVATE ${ARGN})
endfunction()

# takt_tests(<folder with / as _> <libraries...>): one test program from every .cc in this folder.
function(takt_tests name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  if(NOT sources)
    return()
  endif()
  set(target test_${name})
  add_executable(${target} ${sources})
  target_link_libraries(${target} PRIVATE ${ARGN} takt_test_support GTest::gmock GTest::gtest_main)
  target_precompile_headers(${target} REUSE_FROM takt_test_pch)
  add_dependencies(${target} takt_meshes)  # a URDF whose meshes are missing is refused
  add_test(NAME ${name} COMMAND ${target} WORKING_DIRECTORY ${CMAKE_SOURCE_DIR})
endfunction()
