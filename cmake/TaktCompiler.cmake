# One set of compiler flags for every target, so that the precompiled headers and the bits of a run are shared.
set(CMAKE_CXX_STANDARD 23)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# No contraction and no fast-math: the same source gives the same bits (row D5). -fPIC as an option and not as a
# property, so that libraries and programs can share one precompiled header.
add_compile_options(-fPIC -ffp-contract=off -fno-math-errno -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Werror)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12 reports uninitialised Eigen temporaries that are never read, and overflows in inlined std::string code.
  add_compile_options(-Wno-maybe-uninitialized -Wno-array-bounds -Wno-restrict -Wno-stringop-overflow -Wno-stringop-overread)
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess>)
  # A file that is compiled together with others (TAKT_BATCH) is a header to the compiler, which would warn of types in
  # its unnamed namespace.
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:-Wno-subobject-linkage>)
  # GCC collects its garbage only beyond 1 GB: a tenth of the time of a compiler, the same code.
  add_compile_options("SHELL:--param ggc-min-heapsize=1000000")
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  # Checks that must all speak are joined with '&' on purpose; GCC's own library calls what it has declared deprecated.
  add_compile_options(-Wno-bitwise-instead-of-logical -Wno-deprecated-declarations)
  # In batches an alias of one file shadows the same alias of another one; GCC looks for real shadows.
  add_compile_options(-Wno-shadow)
endif()
if(TAKT_SANITIZE)
  add_compile_options(-fsanitize=${TAKT_SANITIZE} -fno-omit-frame-pointer -g1)
  add_link_options(-fsanitize=${TAKT_SANITIZE})
endif()

find_program(TAKT_CCACHE ccache)
if(TAKT_CCACHE)
  # Paths below the source folder count as relative, and a precompiled header counts by the checksum file beside it, so
  # that every clone of the project shares the cache (cmake/TaktLayers.cmake writes that file).
  set(launcher ${CMAKE_COMMAND} -E env
    CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_PCH_EXTSUM=1
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${TAKT_CCACHE})
  set(CMAKE_C_COMPILER_LAUNCHER ${launcher})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${launcher})
endif()
