#include "tests/support/data.h"

#include <cstdlib>
#include <filesystem>

namespace cagefit::testing {

std::string DataDir() {
  const char* from_environment = std::getenv("CAGEFIT_DATA");
  const std::filesystem::path dir =
      from_environment != nullptr
          ? std::filesystem::path(from_environment)
          : std::filesystem::path(CAGEFIT_SOURCE_DIR) / ".." / "shared" / "data";
  std::error_code error;
  return std::filesystem::is_directory(dir, error) ? dir.lexically_normal().string()
                                                   : std::string();
}

bool DataRequired() {
  const char* value = std::getenv("CAGEFIT_REQUIRE_DATA");
  return value != nullptr && std::string(value) == "1";
}

}  // namespace cagefit::testing
