# A layer is a folder: takt_layer(<folder with / as _> <targets it may use...>) makes the static library takt_<name>
# from every .cc in the folder. Its tests lie in tests/<folder>, its benchmarks in bench/<folder>.

# One precompiled header for all code, one more for tests.
add_library(takt_pch OBJECT ${CMAKE_SOURCE_DIR}/cmake/pch.cc)
target_link_libraries(takt_pch PUBLIC Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
target_include_directories(takt_pch PUBLIC ${CMAKE_SOURCE_DIR})
target_precompile_headers(takt_pch PRIVATE ${CMAKE_SOURCE_DIR}/cmake/pch.h)

function(takt_layer name)
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cc)
  set(target takt_${name})
  if(NOT sources)
    add_library(${target} INTERFACE)
    target_link_libraries(${target} INTERFACE ${ARGN} Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
    target_include_directories(${target} INTERFACE ${CMAKE_SOURCE_DIR})
    return()
  endif()
  add_library(${target} STATIC ${sources})
  target_include_directories(${target} PUBLIC ${CMAKE_SOURCE_DIR})
  target_link_libraries(${target} PUBLIC ${ARGN} Eigen3::Eigen fmt::fmt nlohmann_json::nlohmann_json)
  target_precompile_headers(${target} REUSE_FROM takt_pch)
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
