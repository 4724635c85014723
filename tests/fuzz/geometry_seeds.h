// Small good files of each format.
#ifndef CAGEFIT_TESTS_FUZZ_GEOMETRY_SEEDS_H_
#define CAGEFIT_TESTS_FUZZ_GEOMETRY_SEEDS_H_

#include <string>
#include <vector>

namespace cagefit::testing {

// `format` is the end of a name without its dot: "ply".
std::vector<std::string> GeometrySeeds(const std::string& format);

}  // namespace cagefit::testing

#endif  // CAGEFIT_TESTS_FUZZ_GEOMETRY_SEEDS_H_
