// How much memory this process may count on.
#ifndef CAGEFIT_SERVER_MACHINE_MEMORY_H_
#define CAGEFIT_SERVER_MACHINE_MEMORY_H_

#include <cstdint>

namespace cagefit::server {

// Bytes of the machine, or of the container where that has less.
int64_t MachineMemoryBytes();

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_MACHINE_MEMORY_H_
