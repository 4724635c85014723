# Compiler settings shared by every target. Baseline instruction set only: Debian's Ceres and our code share Eigen
# objects, and a wider -march changes Eigen's allocator on one side of that boundary.
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# No contraction: results must be equal to the bit on every machine with the same instruction set.
add_compile_options(-Wall -Wextra -ffp-contract=off -fno-math-errno)

if(CAGEFIT_SANITIZE)
  add_compile_options(-fsanitize=${CAGEFIT_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  add_link_options(-fsanitize=${CAGEFIT_SANITIZE})
  # The sanitizer's allocator aligns to 16 bytes; Eigen must not add a second alignment scheme that Ceres lacks.
  add_compile_definitions(EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

if(CAGEFIT_FUZZ)
  add_compile_options(-fsanitize=fuzzer-no-link
    -fsanitize-coverage-ignorelist=${PROJECT_SOURCE_DIR}/tests/fuzz/coverage_ignorelist.txt)
  add_link_options(-fsanitize=fuzzer-no-link)
endif()
