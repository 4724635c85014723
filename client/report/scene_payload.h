// A scene as numbers of a page (payload.h).
#ifndef CAGEFIT_CLIENT_REPORT_SCENE_PAYLOAD_H_
#define CAGEFIT_CLIENT_REPORT_SCENE_PAYLOAD_H_

#include <nlohmann/json.hpp>

#include "client/report/payload.h"
#include "client/report/scene.h"

namespace cagefit::client {

// Adds the arrays of `scene`, and returns what the page needs to read them:
//
//   control, points     2 bytes a coordinate: x = origin + quantum q, per frame x y z of each
//   vertex
//                       or point; origin and quantum stand in "control" and "points"
//   deviations,         1 byte a limit vertex or point: 0 unknown, otherwise c = q - 128 and the
//   point_deviations    deviation is sign(c) (c / 127)^2 "most_deviation", which larger ones become
//   row_sizes, columns, the stencils of the limit vertices, row by row; weights are in units of
//   weights             1 / 65535 and add up to 1
//   triangles, limit_vertices, creases, borders, cage_triangles, cage_creases   indices, as in
//   DisplayMesh
//
// "robust_deviation", where colours end at first, is what 99 % of all deviations are within. Each
// of "frames" has its number and how many points it has of how many; no points and deviations of 0
// where the target was not read.
nlohmann::ordered_json AddScene(const Scene& scene, const ControlMesh& cage, Payload* payload);

}  // namespace cagefit::client

#endif  // CAGEFIT_CLIENT_REPORT_SCENE_PAYLOAD_H_
