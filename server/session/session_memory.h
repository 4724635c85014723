// How much memory a session takes, by formulas that tests/server/session/session_memory_test.cc
// holds against the heap: at least as much as was measured, and at most three times that.
#ifndef CAGEFIT_SERVER_SESSION_SESSION_MEMORY_H_
#define CAGEFIT_SERVER_SESSION_SESSION_MEMORY_H_

#include <cstdint>

#include "server/session/frame.h"
#include "server/session/session_config.h"

namespace cagefit::server {

// Of a session without its model: ledger, config, where the surface was.
//
//   32 KiB + 600 n + 1,000 cameras          n control vertices
int64_t IdleSessionBytes(const SessionConfig& config, int32_t vertices);

// Of the model, which a session gets with its first fit and keeps: what follows from connectivity,
// and buffers of the size of its largest frame.
//
//   16,000 n + 200 p + min(800 p, 9 MiB) + 150 pixels      p points of the frame, pixels of the
//                                                          images that are compared
//   with Ceres: 30,000 n more; in PYTORCH3D's mode: 16 bytes more a face and pixel
int64_t ModelBytes(const SessionConfig& config, int32_t vertices, int64_t points);

// Control vertices that the model for a first frame of `points` points may come to have.
int32_t MostFirstVertices(const SessionConfig& config, const SessionLimits& limits, int64_t points);

// Of a decoded frame: cloud, mesh and masks, and its bytes.
int64_t HeldBytes(const Frame& frame);

// For each byte that a Draco decoder takes, what it takes to make a cloud with normals of it.
inline constexpr int64_t kDecodeFactor = 4;

}  // namespace cagefit::server

#endif  // CAGEFIT_SERVER_SESSION_SESSION_MEMORY_H_
