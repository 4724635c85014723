#include "client/report/page_files.h"

#include <cstddef>

// What `ld -b binary` calls the bytes of a file.
#define CAGEFIT_PAGE_FILE(symbol)                   \
  extern "C" const char _binary_##symbol##_start[]; \
  extern "C" const char _binary_##symbol##_end[];

CAGEFIT_PAGE_FILE(page_html)
CAGEFIT_PAGE_FILE(page_css)
CAGEFIT_PAGE_FILE(data_js)
CAGEFIT_PAGE_FILE(text_js)
CAGEFIT_PAGE_FILE(surface_js)
CAGEFIT_PAGE_FILE(colors_js)
CAGEFIT_PAGE_FILE(view3d_js)
CAGEFIT_PAGE_FILE(panel_js)
CAGEFIT_PAGE_FILE(frame_facts_js)
CAGEFIT_PAGE_FILE(curves_js)
CAGEFIT_PAGE_FILE(table_js)
CAGEFIT_PAGE_FILE(player_js)
CAGEFIT_PAGE_FILE(page_js)
CAGEFIT_PAGE_FILE(three_licence_txt)
CAGEFIT_PAGE_FILE(three_min_js)
CAGEFIT_PAGE_FILE(OrbitControls_js)
CAGEFIT_PAGE_FILE(LineSegmentsGeometry_js)
CAGEFIT_PAGE_FILE(LineMaterial_js)
CAGEFIT_PAGE_FILE(LineSegments2_js)

#undef CAGEFIT_PAGE_FILE

namespace cagefit::client {
namespace {

struct File {
  absl::string_view name;
  const char *begin, *end;
};

#define CAGEFIT_PAGE_FILE(name, symbol) \
  { name, _binary_##symbol##_start, _binary_##symbol##_end }

constexpr File kFiles[] = {
    CAGEFIT_PAGE_FILE("page.html", page_html),
    CAGEFIT_PAGE_FILE("page.css", page_css),
    CAGEFIT_PAGE_FILE("data.js", data_js),
    CAGEFIT_PAGE_FILE("text.js", text_js),
    CAGEFIT_PAGE_FILE("surface.js", surface_js),
    CAGEFIT_PAGE_FILE("colors.js", colors_js),
    CAGEFIT_PAGE_FILE("view3d.js", view3d_js),
    CAGEFIT_PAGE_FILE("panel.js", panel_js),
    CAGEFIT_PAGE_FILE("frame_facts.js", frame_facts_js),
    CAGEFIT_PAGE_FILE("curves.js", curves_js),
    CAGEFIT_PAGE_FILE("table.js", table_js),
    CAGEFIT_PAGE_FILE("player.js", player_js),
    CAGEFIT_PAGE_FILE("page.js", page_js),
    CAGEFIT_PAGE_FILE("three_licence.txt", three_licence_txt),
    CAGEFIT_PAGE_FILE("three.min.js", three_min_js),
    CAGEFIT_PAGE_FILE("OrbitControls.js", OrbitControls_js),
    CAGEFIT_PAGE_FILE("LineSegmentsGeometry.js", LineSegmentsGeometry_js),
    CAGEFIT_PAGE_FILE("LineMaterial.js", LineMaterial_js),
    CAGEFIT_PAGE_FILE("LineSegments2.js", LineSegments2_js),
};

#undef CAGEFIT_PAGE_FILE

}  // namespace

absl::string_view PageFile(absl::string_view name) {
  for (const File& file : kFiles) {
    if (file.name == name) return {file.begin, static_cast<size_t>(file.end - file.begin)};
  }
  return {};
}

}  // namespace cagefit::client
