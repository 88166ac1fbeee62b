# Duktape, compiled from the sources of Debian's duktape-dev: its shared library has no limit of steps. What is changed
# here, by exact text, is checked: another version of the package is refused at configuration and not misbuilt.
find_path(DUKTAPE_SOURCE duktape.c PATHS /usr/share/duktape NO_DEFAULT_PATH REQUIRED)

function(takt_patch variable old new)
  string(FIND "${${variable}}" "${old}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "duktape-dev is not the expected version (2.7.0): '${old}' is not in its sources")
  endif()
  string(REPLACE "${old}" "${new}" text "${${variable}}")
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

function(takt_duktape)
  set(folder ${CMAKE_BINARY_DIR}/_deps/duktape)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${DUKTAPE_SOURCE}/duktape.c ${DUKTAPE_SOURCE}/duk_config.h)
  file(READ ${DUKTAPE_SOURCE}/duk_config.h config)
  # Asked each 262 144 instructions of a script.
  takt_patch(config "#undef DUK_USE_INTERRUPT_COUNTER" "#define DUK_USE_INTERRUPT_COUNTER")
  takt_patch(config "#undef DUK_USE_EXEC_TIMEOUT_CHECK"
    "#ifdef __cplusplus\nextern \"C\" {\n#endif\nint takt_script_interrupted(void *udata);\ndouble takt_script_random(void *udata);\n#ifdef __cplusplus\n}\n#endif\n#define DUK_USE_EXEC_TIMEOUT_CHECK(udata) takt_script_interrupted((udata))")
  takt_patch(config "#undef DUK_USE_GET_RANDOM_DOUBLE"
    "#define DUK_USE_GET_RANDOM_DOUBLE(udata) takt_script_random((udata))")
  takt_patch(config "#define DUK_USE_CALLSTACK_LIMIT 10000" "#define DUK_USE_CALLSTACK_LIMIT 1000")
  takt_patch(config "#define DUK_USE_NATIVE_CALL_RECLIMIT 1000" "#define DUK_USE_NATIVE_CALL_RECLIMIT 100")
  takt_patch(config "#define DUK_USE_COMPILER_RECLIMIT 2500" "#define DUK_USE_COMPILER_RECLIMIT 200")
  takt_patch(config "#define DUK_USE_REGEXP_COMPILER_RECLIMIT 10000" "#define DUK_USE_REGEXP_COMPILER_RECLIMIT 200")
  takt_patch(config "#define DUK_USE_REGEXP_EXECUTOR_RECLIMIT 10000" "#define DUK_USE_REGEXP_EXECUTOR_RECLIMIT 500")
  takt_patch(config "#define DUK_USE_JSON_DEC_RECLIMIT 1000" "#define DUK_USE_JSON_DEC_RECLIMIT 100")
  takt_patch(config "#define DUK_USE_JSON_ENC_RECLIMIT 1000" "#define DUK_USE_JSON_ENC_RECLIMIT 100")
  file(WRITE ${folder}/duk_config.h.new "${config}")
  file(COPY_FILE ${folder}/duk_config.h.new ${folder}/duk_config.h ONLY_IF_DIFFERENT)
  # What a built-in function does element by element counts too: a search in an array of 10^9 elements is one instruction.
  file(READ ${DUKTAPE_SOURCE}/duktape.c source)
  set(count "if (takt_script_accessed(thr->heap->heap_udata)) { thr->interrupt_counter = 0; DUK_ERROR_RANGE(thr, \"execution timeout\"); }")
  foreach(place getprop_all putprop_all getpropdesc_count)
    takt_patch(source "DUK_STATS_INC(thr->heap, stats_${place});" "${count}")
  endforeach()
  takt_patch(source "re_ctx.steps_limit = DUK_RE_EXECUTE_STEPS_LIMIT;"
    "re_ctx.steps_limit = takt_script_expression_steps(thr->heap->heap_udata);")
  file(WRITE ${folder}/takt_duktape.c.new
    "/* Made by the build (cmake/TaktDuktape.cmake) from ${DUKTAPE_SOURCE}/duktape.c. */\n"
    "extern int takt_script_accessed(void *udata);\nextern int takt_script_expression_steps(void *udata);\n" "${source}")
  file(COPY_FILE ${folder}/takt_duktape.c.new ${folder}/takt_duktape.c ONLY_IF_DIFFERENT)
  file(COPY_FILE ${DUKTAPE_SOURCE}/duktape.h ${folder}/duktape.h ONLY_IF_DIFFERENT)
  add_library(takt_duktape STATIC ${folder}/takt_duktape.c)
  target_include_directories(takt_duktape SYSTEM PUBLIC $<BUILD_INTERFACE:${folder}>)
  target_compile_options(takt_duktape PRIVATE -w -fno-sanitize=undefined)
endfunction()
takt_duktape()
