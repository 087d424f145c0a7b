# Language, flags and the one interface target that carries warnings and sanitizers.
option(EVOGRASP_TESTS "build the tests" ON)
option(EVOGRASP_BENCH "build the benchmarks" ON)
option(EVOGRASP_WERROR "treat warnings as errors (the checks do)" OFF)
option(EVOGRASP_FUZZ "make libFuzzer programs of tests/fuzz/ (clang); else they replay their corpus" OFF)
set(EVOGRASP_SANITIZE "" CACHE STRING "sanitizers, as for -fsanitize=, e.g. address,undefined or thread")

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release)
endif()
if(NOT CMAKE_CXX_COMPILER_LAUNCHER)
  find_program(CCACHE ccache)
  if(CCACHE)
    set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE})
  endif()
endif()

add_library(evograsp_flags INTERFACE)
target_include_directories(evograsp_flags INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR})
# -ffp-contract=off: a fused multiply-add rounds once where the baseline rounds twice, and would
# make a trial depend on the machine that runs it.
target_compile_options(evograsp_flags INTERFACE
  -ffp-contract=off -fno-fast-math
  -Wall -Wextra -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wcast-align -Wunused -Wpedantic
  $<$<CXX_COMPILER_ID:Clang>:-Wthread-safety>
  # GCC 12 warns falsely of overlap in "text" + std::string (GCC bug 105651).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
  $<$<BOOL:${EVOGRASP_WERROR}>:-Werror>)
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_definitions(evograsp_flags INTERFACE EIGEN_NO_DEBUG)
endif()
if(EVOGRASP_SANITIZE)
  target_compile_options(evograsp_flags INTERFACE
    -fsanitize=${EVOGRASP_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(evograsp_flags INTERFACE -fsanitize=${EVOGRASP_SANITIZE})
endif()
if(EVOGRASP_FUZZ)
  target_compile_options(evograsp_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
