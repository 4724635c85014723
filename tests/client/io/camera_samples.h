// Small camera files in memory.
#ifndef CAGEFIT_TESTS_CLIENT_IO_CAMERA_SAMPLES_H_
#define CAGEFIT_TESTS_CLIENT_IO_CAMERA_SAMPLES_H_

namespace cagefit::client {

constexpr char kCamerasJson[] = R"({"cameras": [
  {"name": "left", "width": 640, "height": 480,
   "K": [[500.5, 0, 319.5], [0, 510.25, 239.5], [0, 0, 1]],
   "R": [[0, -1, 0], [1, 0, 0], [0, 0, 1]], "t": [0.1, -0.2, 3],
   "distortion": {"k1": -0.28, "k2": 0.07, "p1": 0.0002, "p2": -0.0005, "k3": 0.01}},
  {"name": "right", "width": 320, "height": 200,
   "K": [[250, 0, 160], [0, 250, 100], [0, 0, 1]],
   "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 2]}
]})";

// The example of COLMAP's documentation, and a lens with all terms.
constexpr char kColmapCameras[] =
    "# Camera list with one line of data per camera:\n"
    "#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
    "# Number of cameras: 3\n"
    "1 SIMPLE_PINHOLE 3072 2304 2559.81 1536 1152\n"
    "2 PINHOLE 3072 2304 2560.56 2561.5 1536 1152\n"
    "3 SIMPLE_RADIAL 3072 2304 2559.69 1536 1152 -0.0218531\n"
    "7 OPENCV 640 480 500 510 320 240 -0.28 0.07 2e-4 -5e-4\n";

constexpr char kColmapImages[] =
    "# Image list with two lines of data per image:\n"
    "#   IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "#   POINTS2D[] as (X, Y, POINT3D_ID)\n"
    "1 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 1 P1180141.JPG\n"
    "2362.39 248.498 58396 1784.7 268.254 59027 1784.7 268.254 -1\n"
    "2 0.851773 0.0165051 0.503764 -0.142941 -0.737434 1.02973 3.74354 7 rig/left #2.png\n"
    "\n";

}  // namespace cagefit::client

#endif  // CAGEFIT_TESTS_CLIENT_IO_CAMERA_SAMPLES_H_
